//! Cost of assembling energy, gradient and Hessian into the fixed pattern, per face and on one thread.
//!
//! Times depend on the machine, so each is also given as the number of dense operations (f64 matrix products of faer) that the same
//! machine does meanwhile: "dense-equivalent kflop". Rounds alternate between the two and the best of each counts, which makes the ratio
//! robust against a busy machine. `cargo bench --bench assembly` prints the table, `... -- quadratic` the rows with this word.
//!
//! A table says how much faster assembly and factorisation are by all threads than by one.
//!
//! A further table compares a step of moisture, its factor reused, with an iteration of Newton's method on the same mesh, and with a whole
//! step of motion: so many iterations as the strip of paper in `configs/paper/wetted_strip.toml` takes a step in its first two seconds, with
//! the same element.

use nalgebra::Vector3;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;
use thinshell::case::history::History;
use thinshell::mesh::generate::{Pattern as Cells, rectangle};
use thinshell::mesh::{Mesh, Topology};
use thinshell::moisture::{Condition, Diffusion, Law, Mass, Scheme, Side, Slab, Where, cosine_levels, in_plane_tensor};
use thinshell::report::DenseProduct;
use thinshell::shell::rest::Forms;
use thinshell::shell::{
    Bilayer, Constitution, Director, Koiter, LinearAverage, LinearFree, Material, Measure, QuadraticFree, Shell, koiter,
};
use thinshell::sparse::{Cholesky, Curvature, Kind, Numbering, Pattern, System};
use thinshell::stage::{Job, all, run};

/// Rounds of which the best counts.
const ROUNDS: usize = 30;
/// The same for steps of moisture.
const STEPS: usize = 8;

/// Laws that are evaluated point by point, on the linear element.
const GENERAL: &[(&str, Constitution)] = &[
    ("linear bilayer", {
        let layers = Bilayer { top_thickness: 4e-4, youngs_moduli: [2e9, 1e9], poissons_ratios: [0.3, 0.4] };
        Constitution::Bilayer(layers)
    }),
    ("linear neo-hookean", Constitution::NeoHookean),
    ("linear tension-field", Constitution::TensionField { compression: 1e-3 }),
];

/// A shell bound to its matrix, at a state away from rest.
struct Case {
    name: &'static str,
    shell: Box<dyn Shell>,
    x: Vec<f64>,
    pattern: Pattern,
    system: System,
    /// Best times of assembly and of extrapolating the stresses [s].
    best: [f64; 2],
}

impl Case {
    fn new(name: &'static str, mut shell: Box<dyn Shell>, nodes: &[Vector3<f64>]) -> Self {
        let unknowns = shell.unknowns();
        let mut x: Vec<f64> = nodes.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        x.resize(unknowns, 0.0);
        let rest: Vec<Forms> = shell.forms(&x).iter().map(|e| Forms { a: [e[0], e[1], e[2]], b: [0.0; 3] }).collect();
        shell.set_rest(&rest);
        x.iter_mut().enumerate().for_each(|(i, x)| *x += 1e-3 * (i as f64).sin());
        let numbering = Numbering::new(&vec![false; unknowns]);
        let pattern = Pattern::new(&numbering, &mut |visit| shell.stencils(visit)).expect("a pattern within 2^32 entries");
        shell.bind(&numbering, &pattern);
        shell.restart(&x);
        Case { name, shell, x, system: System::new(&pattern), pattern, best: [f64::INFINITY; 2] }
    }

    fn round(&mut self) {
        self.system.clear();
        let start = Instant::now();
        black_box(self.shell.assemble(&self.x, Curvature::Mixed, &mut self.system));
        self.best[0] = self.best[0].min(start.elapsed().as_secs_f64());
        let (dx, start) = (vec![1e-6; self.x.len()], Instant::now());
        self.shell.extrapolate(&self.x, &dx);
        self.best[1] = self.best[1].min(start.elapsed().as_secs_f64());
    }
}

/// Best times of an iteration of Newton's method, of which [factorisation and solve], and of a step of moisture with 8 layers [s].
fn moisture(case: &mut Case, mesh: &Mesh) -> [f64; 3] {
    let dot = |a: usize, b: usize| mesh.vertices[a].dot(&mesh.vertices[b]);
    let metric = |[a, b, c]: &[usize; 3]| {
        let product = |p: usize, q: usize| dot(p, q) - dot(p, *a) - dot(*a, q) + dot(*a, *a);
        [product(*b, *b), product(*b, *c), product(*c, *c)]
    };
    let metrics: Vec<[f64; 3]> = mesh.faces.iter().map(metric).collect();
    let slab = Slab {
        vertices: mesh.vertices.len(),
        faces: mesh.faces.clone(),
        in_plane: metrics.iter().map(|g| in_plane_tensor(*g, [1.0, 0.0], 2e-8, 5e-9)).collect(),
        metric: metrics,
        thickness: vec![1e-4; mesh.faces.len()],
        through: vec![1e-9; mesh.faces.len()],
        levels: cosine_levels(8),
    };
    let place = Where::Side { side: Side::Bottom, faces: (0..mesh.faces.len()).collect() };
    let wet = Condition { place, law: Law::Value(Box::new(|_, _| 1.0)), window: [0.0, f64::INFINITY], below: None };
    let mut diffusion = Diffusion::new(slab, vec![wet], None, Mass::Lumped, Scheme::BackwardEuler, None).expect("a valid slab");
    let mut cholesky = Cholesky::new(&case.pattern).expect("enough memory");
    let mut best = [f64::INFINITY; 3];
    for step in 0..STEPS {
        let start = Instant::now();
        case.system.clear();
        case.shell.assemble(&case.x, Curvature::Mixed, &mut case.system);
        let middle = Instant::now();
        // The shell is free, so that its pivots may vanish; they cost the same.
        black_box(cholesky.refactor(&case.pattern, &case.system.matrix, Kind::Ldlt).is_ok());
        cholesky.solve(&mut case.system.gradient);
        let (newton, factor) = (start.elapsed().as_secs_f64(), middle.elapsed().as_secs_f64());
        let start = Instant::now();
        diffusion.advance(step as f64, step as f64 + 1.0, &[]).expect("finite data");
        let times = [newton, factor, start.elapsed().as_secs_f64()];
        best.iter_mut().zip(times).for_each(|(best, time)| *best = best.min(time));
    }
    assert_eq!(diffusion.factorizations(), 1);
    best
}

/// Newton iterations of a step of the wetted strip, on average; steps that were halved count as one.
fn iterations(element: &str) -> f64 {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/paper/wetted_strip.toml");
    let folder = tempfile::tempdir().expect("a temporary folder");
    // What it expects of its result is expected later.
    let overrides = [format!("shell.element={element}"), "dynamics.end=2".to_owned(), "report.expect=[]".to_owned()];
    let job = Job::read(&scene, Some(folder.path()), &overrides, true).expect("a valid scene");
    all::until_run(&job).expect("equations that can be solved");
    let history = History::read(&run::history_path(&job)).expect("a history");
    history.last("newton_iterations").expect("a column") / 100.0
}

fn square(cells: usize) -> (Mesh, Topology, Vec<Director>, Vec<Material>) {
    let mesh = rectangle([1.0, 1.0], [cells, cells], Cells::Diagonal, 0.25, 1).expect("a valid rectangle");
    let topology = Topology::new(&mesh.faces);
    let free = vec![Director::Free; topology.edges.len()];
    let materials = vec![Material { thickness: 1e-3, youngs_modulus: 1e9, poissons_ratio: 0.3 }; mesh.faces.len()];
    (mesh, topology, free, materials)
}

/// Best times of assembly and factorisation of a quadratic mesh by so many threads [s], made where they work.
fn times_by(threads: usize) -> [f64; 2] {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let (mesh, topology, free, materials) = square(70);
        let midpoints: Vec<_> = topology.edges.iter().map(|[a, b]| 0.5 * (mesh.vertices[*a] + mesh.vertices[*b])).collect();
        let element = QuadraticFree::new(&mesh, &topology, &midpoints, Measure::Tan, &free);
        let mut case = Case::new("", Box::new(Koiter::new(element, materials, None)), &[&mesh.vertices[..], &midpoints].concat());
        let mut cholesky = Cholesky::new(&case.pattern).expect("enough memory");
        let mut best = f64::INFINITY;
        for _ in 0..STEPS {
            case.round();
            let start = Instant::now();
            black_box(cholesky.refactor(&case.pattern, &case.system.matrix, Kind::Ldlt).is_ok());
            best = best.min(start.elapsed().as_secs_f64());
        }
        [case.best[0], best]
    })
}

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("one thread");
    let (mesh, topology, free, materials) = square(100);
    let tan = LinearFree::new(&mesh, &topology, Measure::Tan, &free);
    let average = LinearAverage::new(&mesh, &topology, &free);
    let mut cases = vec![
        Case::new("linear free-tan", Box::new(Koiter::new(tan, materials.clone(), None)), &mesh.vertices),
        Case::new("linear average", Box::new(Koiter::new(average, materials.clone(), None)), &mesh.vertices),
    ];
    for (name, constitution) in GENERAL {
        let element = LinearFree::new(&mesh, &topology, Measure::Tan, &free);
        let laws = vec![*constitution; mesh.faces.len()];
        cases.push(Case::new(name, koiter(element, materials.clone(), laws, None), &mesh.vertices));
    }
    let fine = mesh;
    let (mesh, topology, free, materials) = square(50);
    let midpoints: Vec<_> = topology.edges.iter().map(|[a, b]| 0.5 * (mesh.vertices[*a] + mesh.vertices[*b])).collect();
    let element = QuadraticFree::new(&mesh, &topology, &midpoints, Measure::Tan, &free);
    let nodes = [&mesh.vertices[..], &midpoints].concat();
    cases.push(Case::new("quadratic free-tan", Box::new(Koiter::new(element, materials.clone(), None)), &nodes));
    let element = QuadraticFree::new(&mesh, &topology, &nodes[mesh.vertices.len()..], Measure::Tan, &free);
    let rubber = vec![Constitution::NeoHookean; mesh.faces.len()];
    cases.push(Case::new("quadratic neo-hookean", koiter(element, materials, rubber, None), &nodes));

    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    cases.retain(|case| wanted.iter().all(|w| case.name.contains(w.as_str())));

    let mut dense = DenseProduct::default();
    for _ in 0..ROUNDS {
        dense.round();
        cases.iter_mut().for_each(Case::round);
    }
    let rate = dense.rate();
    println!("dense product: {:.1} Gflop/s", rate * 1e-9);
    println!("{:<22} {:>8} {:>26} {:>30}", "", "", "us per face", "dense-equivalent kflop");
    println!("{:<22} {:>8} {:>12} {:>14} {:>14} {:>14}", "element", "faces", "assemble", "extrapolate", "assemble", "extrapolate");
    for case in &cases {
        let [a, e] = case.best.map(|t| t / case.shell.faces() as f64);
        let [fa, fe] = [a, e].map(|t| t * rate * 1e-3);
        println!("{:<22} {:>8} {:>12.3} {:>14.3} {:>14.1} {:>14.1}", case.name, case.shell.faces(), a * 1e6, e * 1e6, fa, fe);
    }
    println!();
    let titles = ["faces", "Newton iteration", "of which factor", "moisture step", "ratio", "iterations a step", "ratio to step"];
    print!("{:<20}", "ms");
    titles.iter().for_each(|title| print!(" {title:>17}"));
    println!();
    for case in cases.iter_mut().filter(|case| case.name.contains("free-tan")) {
        let mesh = if case.name.starts_with("linear") { &fine } else { &mesh };
        let [newton, factor, step] = moisture(case, mesh).map(|t| 1e3 * t);
        let element = case.name.split(' ').next().unwrap_or_default();
        let (faces, ratio, iterations) = (case.shell.faces(), step / newton, iterations(element));
        print!("{:<20} {faces:>17} {newton:>17.1} {factor:>17.1} {step:>17.1} {ratio:>17.2}", case.name);
        println!(" {iterations:>17.1} {:>17.3}", ratio / iterations);
    }
    println!();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (one, all) = (times_by(1), times_by(threads));
    println!("{:<22} {:>12} {:>18} {:>14}", "quadratic, ms", "one thread", format!("{threads} threads"), "speed-up");
    for (what, (one, all)) in ["assembly", "factorisation"].iter().zip(one.iter().zip(all)) {
        println!("{what:<22} {:>12.1} {:>18.1} {:>14.2}", 1e3 * one, 1e3 * all, one / all);
    }
}
