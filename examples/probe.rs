use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use thinshell::mesh::{Mesh, Topology};
use thinshell::model::*;
use thinshell::shell::rest::*;
use thinshell::shell::*;

fn strip(nx: usize, ny: usize, l: f64, w: f64, jitter: f64) -> Mesh {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(0);
    let mut mesh = Mesh::default();
    for i in 0..=nx {
        for j in 0..=ny {
            let inner = i > 0 && i < nx && j > 0 && j < ny;
            let mut s = || if inner && jitter > 0.0 { rng.random_range(-jitter..jitter) } else { 0.0 };
            mesh.vertices.push(Vector3::new((i as f64 + s()) * l / nx as f64, (j as f64 + s()) * w / ny as f64, 0.0));
        }
    }
    for i in 0..nx {
        for j in 0..ny {
            let (a, b) = (i * (ny + 1) + j, (i + 1) * (ny + 1) + j);
            mesh.faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}

fn main() {
    struct L;
    impl log::Log for L {
        fn enabled(&self, _: &log::Metadata) -> bool {
            true
        }
        fn log(&self, r: &log::Record) {
            eprintln!("{}", r.args())
        }
        fn flush(&self) {}
    }
    let args: Vec<String> = std::env::args().collect();
    let (nx, ny): (usize, usize) = (args[1].parse().unwrap(), args[2].parse().unwrap());
    let h: f64 = args[3].parse().unwrap();
    let steps: usize = args[4].parse().unwrap();
    let jitter: f64 = args[5].parse().unwrap();
    let kind = &args[6];
    if args.len() > 7 {
        log::set_logger(&L).unwrap();
        log::set_max_level(log::LevelFilter::Trace);
    }
    let (l, w) = (0.1, 0.02);
    let radius = 0.1 / std::f64::consts::PI;
    let mesh = strip(nx, ny, l, w, jitter);
    let topology = Topology::new(&mesh.faces);
    let free = vec![Director::Free; topology.edges.len()];
    let materials = vec![Material { thickness: h, youngs_modulus: 1e9, poissons_ratio: 0.3 }; mesh.faces.len()];
    let shell: Box<dyn Shell> = match kind.as_str() {
        "tan" => Box::new(Koiter::new(LinearFree::new(&mesh, &topology, Measure::Tan, &free), materials, None)),
        "sin" => Box::new(Koiter::new(LinearFree::new(&mesh, &topology, Measure::Sin, &free), materials, None)),
        _ => Box::new(Koiter::new(LinearAverage::new(&mesh, &topology, &free), materials, None)),
    };
    let mut x: Vec<f64> = mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    x.resize(shell.unknowns(), 0.0);
    let initial: Vec<Forms> = shell.forms(&x).iter().map(|e| Forms { a: [e[0], e[1], e[2]], b: [e[3], e[4], e[5]] }).collect();
    let c = |v: f64| -> ScalarField { Box::new(move |_, _| v) };
    let law = Pullback { abar: None, bbar: Some([c(1.0 / radius), c(0.0), c(0.0)]), polar: false };
    let driver = RestDriver::new(
        mesh.clone(),
        topology.clone(),
        Box::new(law),
        false,
        Sampling::Edges,
        Some(Box::new(|t| t)),
        vec![h; mesh.faces.len()],
        initial.clone(),
    );
    let at = |i: usize, j: usize| i * (ny + 1) + j;
    let (cc, a, d) = (at(nx / 2, ny / 2), at(nx / 2, 0), at(nx / 2 + 1, ny / 2));
    let held =
        [3 * cc, 3 * cc + 1, 3 * cc + 2, 3 * a, 3 * a + 2, 3 * d + 2].map(|u| HeldUnknown { unknown: u, start: x[u], motion: None }).into();
    let parts = Parts {
        shell,
        inertia: None,
        gravity: None,
        rest: Some(driver),
        initial_forms: initial,
        held,
        positions: mesh.vertices.clone(),
        velocities: vec![],
    };
    let t0 = std::time::Instant::now();
    let mut model = ShellModel::new(parts, mesh.diameter(), 1e-9, 25).unwrap();
    println!("setup {:?}", t0.elapsed());
    for s in 1..=steps {
        let r = model.advance(1.0 / steps as f64, s as f64 / steps as f64);
        println!("{r:?}");
    }
    let xs = model.unknowns();
    // radius by chord of the middle line: ends distance
    let p = |v: usize| Vector3::new(xs[3 * v], xs[3 * v + 1], xs[3 * v + 2]);
    println!(
        "{:?} {:?} chord {} exact {}",
        model.counters(),
        t0.elapsed(),
        (p(at(nx, ny / 2)) - p(at(0, ny / 2))).norm(),
        2.0 * radius * (l / 2.0 / radius).sin()
    );
}
