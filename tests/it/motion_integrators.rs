//! Time integration: orders on smooth motion, exact free fall, conservation, and dissipation against the methods' own formulas.

use crate::physics_case::{Case, points, rate, run, set_up};
use nalgebra::Vector3;

const SECOND_ORDER: [&str; 4] = [
    "integrator = \"bdf2\"\n",
    "integrator = \"generalised-alpha\"\nspectral_radius = 1.0\n",
    "integrator = \"generalised-alpha\"\n",
    "integrator = \"generalised-alpha\"\nspectral_radius = 0.0\n",
];

/// A curved patch without supports that flies, turns and vibrates. It is so soft that its fastest vibration, of some 600 1/s, is resolved by all
/// steps taken here: orders show once `omega dt` is well below 1 for every frequency that moves.
fn patch(parts: &str, dynamics: &str) -> String {
    format!(
        "[mesh.cylinder]\nradius = 0.05\nlength = 0.06\nangle = 100.0\ncells = [4, 3]\n[solver]\ntolerance = 1e-13\n\
         [shell]\nelement = \"linear\"\nthickness = 1e-3\ndensity = 900.0\nyoungs_modulus = 1e4\npoissons_ratio = 0.3\nmass = \"lumped\"\n{parts}\
         [dynamics]\n{dynamics}"
    )
}

const FLYING: &str = "velocity = [\"0.1 - 5*y\", \"5*x\", \"0.2*cos(TAU*x/0.1) + 3*y\"]\n";

/// Largest distances of nodes at the end between runs by `steps`, twice and four times as many steps.
fn differences(scene: impl Fn(f64) -> String, end: f64, steps: f64) -> Vec<f64> {
    let ends = [1.0, 2.0, 4.0].map(|k| run(&scene(end / steps / k)).end);
    ends.windows(2).map(|pair| pair[0].iter().zip(&pair[1]).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)).collect()
}

#[test]
fn methods_of_second_order_have_it_from_the_first_steps_on() {
    for integrator in SECOND_ORDER {
        for viscosity in ["", "viscosity = 2e-3\n"] {
            let scene = |dt: f64| patch(viscosity, &format!("dt = {dt:?}\nend = 0.004\n{integrator}{FLYING}"));
            let found = differences(scene, 0.004, 16.0);
            let rate = rate(&found);
            println!("{integrator}{viscosity}{found:?} rate {rate}");
            assert!((rate - 2.0).abs() < 0.1 && found[1] > 1e-9, "{integrator}{viscosity}{found:?} rate {rate}");
        }
    }
}

/// Loads, growth and pins that move and turn are all taken at the right time.
#[test]
fn what_is_prescribed_in_time_keeps_the_order() {
    let parts = "viscosity = 1e-3\n[rest]\nramp = \"sin(100*t)\"\n[rest.pullback]\nabar = [\"1 + 0.1*t\", 0, 1]\nbbar = [20, 0, 0]\n\
                 [gravity]\nfactor = \"cos(300*t)\"\n\
                 [[pin]]\nregion = \"left\"\nmotion = { z = \"0.002*sin(200*t)\" }\ndirector = { rotation = { axis = [0, 1, 0], angle = \"10*sin(150*t)\" } }\n";
    for integrator in SECOND_ORDER {
        let scene = |dt: f64| {
            format!(
                "[mesh.rectangle]\nsize = [0.06, 0.02]\ncells = [4, 2]\n[solver]\ntolerance = 1e-13\n[shell]\nelement = \"linear\"\n\
                 thickness = 1e-3\nyoungs_modulus = 1e4\npoissons_ratio = 0.3\ndensity = 1000.0\n{parts}\
                 [dynamics]\ndt = {dt:?}\nend = 0.01\n{integrator}"
            )
        };
        let found = differences(scene, 0.01, 20.0);
        let rate = rate(&found);
        println!("{integrator}{found:?} rate {rate}");
        assert!((rate - 2.0).abs() < 0.1 && found[1] > 1e-8, "{integrator}{found:?} rate {rate}");
    }
}

/// A parabola in time is within both methods, from the first step on and for steps of any size.
#[test]
fn free_fall_is_exact() {
    for integrator in SECOND_ORDER {
        // The last two steps share the rest before the output time.
        let case = run(&patch("[gravity]\n", &format!("dt = 0.01\nend = 0.1\n{integrator}[output]\ninterval = 0.035\n")));
        for state in case.states() {
            let fall = Vector3::z() * (-0.5 * 9.80665 * state.time * state.time);
            for (p, q) in points(&state, "position").iter().zip(&case.mesh.vertices) {
                assert!((p - q - fall).norm() < 1e-12, "{integrator} t = {}: {:e}", state.time, (p - q - fall).norm());
            }
        }
        assert!(case.states().len() == 5);
    }
}

fn spin(case: &Case) -> Vec<[Vector3<f64>; 2]> {
    let masses: Vec<f64> = thinshell::report::vertex_areas(&case.mesh.vertices, &case.mesh.faces).iter().map(|a| a * 0.9).collect();
    let of = |x: &[Vector3<f64>], v: &[Vector3<f64>]| {
        let sum = |f: &dyn Fn(usize) -> Vector3<f64>| (0..x.len()).map(|i| masses[i] * f(i)).sum::<Vector3<f64>>();
        [sum(&|i| v[i]), sum(&|i| x[i].cross(&v[i]))]
    };
    case.states().iter().map(|s| of(&points(s, "position"), &points(s, "velocity"))).collect()
}

fn energy(case: &Case) -> Vec<f64> {
    let parts = ["kinetic_energy_J", "membrane_energy_J", "bending_energy_J"].map(|name| case.column(name));
    (0..parts[0].len()).map(|i| parts[0][i] + parts[1][i] + parts[2][i]).collect()
}

/// All keep the momentum of a free body, the midpoint rule the angular momentum too; its energy does not drift.
#[test]
fn what_a_free_body_keeps() {
    for integrator in SECOND_ORDER {
        let mut drifts = Vec::new();
        for dt in [4e-4, 2e-4] {
            let case = run(&patch("", &format!("dt = {dt:?}\nend = 0.032\n{integrator}{FLYING}")));
            let moments = spin(&case);
            let [first, turn] = moments[0];
            for [momentum, _] in &moments {
                assert!((momentum - first).norm() < 1e-9 * first.norm(), "{integrator}{:e}", (momentum - first).norm());
            }
            let drift = moments.iter().map(|[_, l]| (l - turn).norm() / turn.norm()).fold(0.0, f64::max);
            let energy = energy(&case);
            let last = energy[energy.len() - 1];
            println!("{integrator}dt {dt}: angular momentum drifts by {drift:e}, energy from {:e} to {last:e}", energy[0]);
            if integrator.contains("1.0") {
                assert!(drift < 1e-9, "{drift:e}");
                let (least, most) = energy.iter().fold((f64::INFINITY, 0.0f64), |(a, b), e| (a.min(*e), b.max(*e)));
                assert!(most / least - 1.0 < 5e-6 * (dt / 4e-4f64).powi(2), "{least:e} {most:e}");
            } else {
                // What these methods do not let grow is another energy, which differs by the second power of the step.
                assert!(last < energy[0] * (1.0 + 5e-5 * (dt / 4e-4f64).powi(2)));
                drifts.push(drift);
            }
        }
        assert!(drifts.is_empty() || (drifts[1] > 0.0 && rate(&drifts) > 1.7), "{integrator}{drifts:?}");
    }
}

/// The motion along x of one vertex between held ones: a linear oscillator at small amplitudes. Returns its displacements.
fn oscillator(dt: f64, steps: u32, integrator: &str) -> Vec<f64> {
    let case = run(&format!(
        "[mesh.rectangle]\nsize = [0.1, 0.1]\ncells = [2, 2]\n[[region]]\nname = \"middle\"\nnearest = [0.05, 0.05, 0.0]\n[solver]\ntolerance = 1e-14\n\
         [shell]\nelement = \"linear\"\nthickness = 1e-3\ndensity = 1000.0\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\nmass = \"lumped\"\n\
         [[pin]]\nregion = \"boundary\"\n[[pin]]\nregion = \"middle\"\ncomponents = [\"y\", \"z\"]\n\
         [dynamics]\ndt = {dt:?}\nend = {:?}\nvelocity = [{:?}, 0, 0]\n{integrator}",
        dt * f64::from(steps),
        1e-7 / dt
    ));
    let middle = case.mesh.region_nearest(Vector3::new(0.05, 0.05, 0.0)).vertices[0];
    case.states().iter().map(|s| points(s, "position")[middle].x - 0.05).collect()
}

/// Displacements by the formulas of Chung and Hulbert for `x'' + omega^2 x = 0`, `w = omega dt`, in units of `dt`, after a step of the
/// midpoint rule.
fn chung_hulbert(w: f64, radius: f64, speed: f64, steps: usize) -> Vec<f64> {
    let (am, af) = ((2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0));
    let (gamma, beta) = (0.5 - am + af, 0.25 * (1.0 - am + af) * (1.0 - am + af));
    let (mut x, mut v) = (0.0, speed);
    let middle = (x + 0.5 * v) / (1.0 + 0.25 * w * w);
    let mut a = -w * w * middle;
    let mut all = vec![x];
    (x, v) = (2.0 * middle - x, v + a);
    all.push(x);
    for _ in 1..steps {
        // (1 - am) a' + am a + w^2 ((1 - af) x' + af x) = 0, x' = x + v + (1/2 - beta) a + beta a'
        let drift = x + v + (0.5 - beta) * a;
        let next = -(am * a + w * w * ((1.0 - af) * drift + af * x)) / (1.0 - am + w * w * (1.0 - af) * beta);
        (x, v, a) = (drift + beta * next, v + (1.0 - gamma) * a + gamma * next, next);
        all.push(x);
    }
    all
}

/// Dissipation is what the formulas say, at frequencies that the step resolves and at such that it does not, where the spectral radius is
/// left of each step.
#[test]
fn dissipation_is_the_stated_one() {
    // The frequency from the midpoint rule: 2 z = dt v / (1 + w^2 / 4).
    let small = oscillator(1e-4, 1, SECOND_ORDER[1]);
    let omega = (4.0 * (1e-7 / small[1] - 1.0)).sqrt() / 1e-4;
    assert!((100.0..1e5).contains(&omega), "{omega}");
    for radius in [1.0, 0.8, 0.5, 0.0] {
        let integrator = format!("integrator = \"generalised-alpha\"\nspectral_radius = {radius:?}\n");
        for w in [0.3, 3.0, 300.0] {
            let (now, exact) = (oscillator(w / omega, 20, &integrator), chung_hulbert(w, radius, 1e-7, 20));
            let largest = exact.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            for (n, (x, y)) in now.iter().zip(&exact).enumerate() {
                assert!((x - y).abs() < 2e-4 * largest, "radius {radius}, w {w}, step {n}: {x:e} {y:e}");
            }
        }
        // Twice the eigenvalue -radius, or at radius 1 one at -1: ratios of displacements go to the radius like 1 + 1/n.
        let far = chung_hulbert(1e6, radius, 1.0, 400);
        let ratio = (far[400] / far[399]).abs();
        assert!(if radius > 0.0 { (ratio / radius - 1.0).abs() < 0.02 } else { far[400].abs() < 1e-9 }, "{radius}: {ratio}");
    }
    // BDF2 by its own recurrence: twice D applied, (a0 x' + a1 x + a2 x_prev)/dt = v', the same of v' is -omega^2 x'.
    for w in [0.3, 3.0, 300.0] {
        let now = oscillator(w / omega, 20, SECOND_ORDER[0]);
        let start = chung_hulbert(w, 1.0, 1e-7, 1);
        let (mut x, mut v) = ([0.0, start[1]], [1e-7, 2.0 * start[1] - 1e-7]);
        let largest = now.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        for (n, found) in now.iter().enumerate().skip(2) {
            let (p, q) = (2.0 * x[1] - 0.5 * x[0], 2.0 * v[1] - 0.5 * v[0]);
            // 3/2 x' = p + v', 3/2 v' = q - w^2 x'
            let next = (p + q / 1.5) / (1.5 + w * w / 1.5);
            (x, v) = ([x[1], next], [v[1], 1.5 * next - p]);
            assert!((found - next).abs() < 2e-4 * largest, "w {w}, step {n}: {found:e} {next:e}");
        }
    }
}

/// What supports hold starts with the velocity of the support, whatever velocity the scene gives the rest.
#[test]
fn supports_say_the_velocity_of_what_they_hold() {
    let scene = |random: &str| {
        format!(
            "[mesh.rectangle]\nsize = [0.1, 0.02]\ncells = [4, 1]\n[shell]\nthickness = 1e-3\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n\
             density = 1000.0\n[[pin]]\nregion = \"left\"\n[[pin]]\nregion = \"right\"\ncomponents = [\"z\"]\nmotion = {{ z = \"(1 + y) * sin(3*t)\" }}\n\
             [dynamics]\ndt = 1e-3\nend = 0.01\nvelocity = [1, 2, \"3 + x\"]\n{random}"
        )
    };
    for random in ["", "random_velocity = { speed = 0.5, seed = 2 }\n"] {
        let (mesh, _, first) = set_up(&scene(random)).unwrap();
        for (p, v) in mesh.vertices.iter().zip(points(&first, "velocity")) {
            let free = Vector3::new(1.0, 2.0, 3.0 + p.x);
            let moved = |found: Vector3<f64>, wanted: Vector3<f64>| (found - wanted).norm();
            if p.x == 0.0 {
                assert_eq!(v, Vector3::zeros());
            } else if p.x > 0.0999 {
                assert!((v.z - 3.0 * (1.0 + p.y)).abs() < 1e-5 && moved(v, Vector3::new(1.0, 2.0, v.z)) <= 0.5, "{p:?} {v:?}");
            } else {
                assert!(moved(v, free) <= if random.is_empty() { 0.0 } else { 0.5 }, "{p:?} {v:?}");
            }
        }
    }
}

/// Reactions of methods that balance forces within a step are told to be of that time.
#[test]
fn reactions_tell_their_time() {
    for (integrator, share) in [
        ("integrator = \"bdf2\"", 1.0),
        ("spectral_radius = 1.0\nintegrator = \"generalised-alpha\"", 0.5),
        ("spectral_radius = 0.5\nintegrator = \"generalised-alpha\"", 2.0 / 3.0),
    ] {
        let case = run(&format!(
            "[mesh.rectangle]\nsize = [0.1, 0.1]\ncells = [2, 2]\n[shell]\nelement = \"linear\"\nthickness = 1e-3\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n\
             density = 1000.0\n[[pin]]\nregion = \"boundary\"\n[gravity]\nfactor = \"1 + 1000*t\"\n[output]\nreactions = true\n\
             [dynamics]\ndt = 1e-3\nend = 3e-3\n{integrator}\n"
        ));
        let last = case.states().pop().unwrap();
        let told = last.number("reaction_time");
        assert!(
            if share == 1.0 { told.is_none() } else { told.is_some_and(|time| (time - (2.0 + share) * 1e-3).abs() < 1e-15) },
            "{integrator}: {told:?}"
        );
    }
}
