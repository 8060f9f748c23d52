//! Dead loads and pressure by themselves: derivatives, and forces against areas known otherwise.

use crate::finite_differences::{bind, compare, dense, patch};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use thinshell::load::{DeadLoad, Drag, Load, Pressure, Viewpoint};
use thinshell::math::quadrature::{linear_radon, linear_triangle, quadratic_triangle};
use thinshell::mesh::{Mesh, Topology};
use thinshell::sparse::{Curvature, Potential, System};

const PRESSURE: f64 = -1.7;
const FACTOR: f64 = 0.6;

/// A closed surface of eight faces, normals outward.
fn octahedron() -> Mesh {
    let vertices = [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|v| [v, -v]).collect();
    let faces = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    Mesh { vertices, faces, ..Mesh::default() }
}

/// Vertices, then midpoints away from the middles of the edges; and the six nodes of each face in the order of the shape functions.
fn curved(mesh: &Mesh) -> (Vec<Vector3<f64>>, Vec<[usize; 6]>, Topology) {
    let topology = Topology::new(&mesh.faces);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let mut shift = || Vector3::from_fn(|_, _| rng.random_range(-0.1..0.1));
    let middles = topology.edges.iter().map(|[a, b]| 1.2 * mesh.vertices[*a].lerp(&mesh.vertices[*b], 0.5) + shift());
    let nodes = mesh.vertices.iter().copied().chain(middles).collect();
    let node = |e: usize| mesh.vertices.len() + e;
    let faces = mesh.faces.iter().zip(&topology.face_edges).map(|([a, b, c], [d, e, f])| [*a, *b, *c, node(*d), node(*e), node(*f)]);
    (nodes, faces.collect(), topology)
}

fn flat_pressure(faces: &[[usize; 3]]) -> Pressure<3, 9> {
    let mut pressure = Pressure::new(faces.to_vec(), linear_triangle().to_vec(), PRESSURE);
    pressure.set_factor(FACTOR);
    pressure
}

fn curved_pressure(faces: &[[usize; 6]]) -> Pressure<6, 18> {
    let mut pressure = Pressure::new(faces.to_vec(), quadratic_triangle().to_vec(), PRESSURE);
    pressure.set_factor(FACTOR);
    pressure
}

/// Coordinates, each a little off.
fn shaken(nodes: &[Vector3<f64>]) -> Vec<f64> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(9);
    nodes.iter().flat_map(|v| [v.x, v.y, v.z]).map(|x| x + rng.random_range(-0.05..0.05)).collect()
}

fn at(x: &[f64], node: usize) -> Vector3<f64> {
    Vector3::new(x[3 * node], x[3 * node + 1], x[3 * node + 2])
}

#[test]
fn drag_has_the_derivatives_of_its_energy() {
    let nodes = patch().vertices;
    let start: Vec<f64> = nodes.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    let coefficients: Vec<f64> = (0..nodes.len()).map(|n| 0.3 + 0.1 * n as f64).collect();
    let mut drag = Drag::new(coefficients.clone());
    drag.start_step(&start, 0.02, FACTOR);
    let x = shaken(&nodes);
    compare(&mut drag, &x);
    // Against the way of each node, at the speed that it has in the step.
    let forces = forces(&mut drag, &x);
    for (n, (force, c)) in forces.iter().zip(coefficients).enumerate() {
        let expected = -(at(&x, n) - at(&start, n)) * (FACTOR * c / 0.02);
        assert!(expected.norm() > 1e-3 && (force - expected).norm() < 1e-12 * expected.norm(), "{n} {force} {expected}");
    }
}

/// Force of each node: the negative gradient.
fn forces(potential: &mut dyn Potential, x: &[f64]) -> Vec<Vector3<f64>> {
    let (_, mut system) = bind(potential, x.len());
    potential.gradient(x, &mut system);
    system.gradient.chunks_exact(3).map(|g| -Vector3::new(g[0], g[1], g[2])).collect()
}

/// Half the integral of `r x dr` along a boundary edge in its own direction, over a quadratic arc where there is a midpoint: Simpson's rule
/// is exact for it.
fn sector(x: &[f64], [a, b]: [usize; 2], middle: Option<usize>) -> Vector3<f64> {
    let [p, q] = [a, b].map(|v| at(x, v));
    let m = middle.map_or(p.lerp(&q, 0.5), |m| at(x, m));
    let moment = p.cross(&(4.0 * m - 3.0 * p - q)) + 4.0 * m.cross(&(q - p)) + q.cross(&(p + 3.0 * q - 4.0 * m));
    moment / 12.0
}

/// Area vector of a patch by its rim alone.
fn area_by_rim(topology: &Topology, x: &[f64], midpoints_from: Option<usize>) -> Vector3<f64> {
    let rim = (0..topology.edges.len()).filter(|e| topology.is_boundary(*e));
    rim.map(|e| {
        let side = topology.edge_faces[e].iter().flatten().next().unwrap();
        sector(x, topology.edges[e], midpoints_from.map(|n| n + e)) * topology.face_edge_signs[side.face][side.local]
    })
    .sum()
}

#[test]
fn derivatives_of_pressure_on_closed_surfaces() {
    let mesh = octahedron();
    let (nodes, faces, topology) = curved(&mesh);
    assert!((0..topology.edges.len()).all(|e| !topology.is_boundary(e)));
    compare(&mut flat_pressure(&mesh.faces), &shaken(&mesh.vertices));
    compare(&mut curved_pressure(&faces), &shaken(&nodes));
}

/// The volume inside the octahedron is 4/3; its normals point outwards, so that a positive pressure gives energy up as it swells.
#[test]
fn the_energy_is_the_volume() {
    let mesh = octahedron();
    let x: Vec<f64> = mesh.vertices.iter().flat_map(|v| [v.x + 3.0, v.y - 2.0, v.z]).collect();
    let (flat, exact) = (flat_pressure(&mesh.faces).energy(&x), -PRESSURE * FACTOR * 4.0 / 3.0);
    assert!((flat - exact).abs() < 1e-13, "{flat} {exact}");
    // A curved surface of straight faces is the same, and a closed one does not care where the origin is.
    let (nodes, faces, topology) = curved(&mesh);
    let pressure = curved_pressure(&faces);
    let straight = [x.clone(), topology.edges.iter().flat_map(|[a, b]| (at(&x, *a).lerp(&at(&x, *b), 0.5)).data.0[0]).collect()].concat();
    assert!((pressure.energy(&straight) - exact).abs() < 1e-13);
    let here = shaken(&nodes);
    let there: Vec<f64> = here.iter().enumerate().map(|(i, x)| x + [5.0, -4.0, 3.0][i % 3]).collect();
    assert!(pressure.energy(&here) > 1.5 * exact && (pressure.energy(&here) - pressure.energy(&there)).abs() < 1e-12 * exact);
}

/// A quarter of a sleeve between planes of symmetry, two of them parallel and none of these through the origin: the force is the gradient of the
/// energy once that is seen from the right place, and is not from the origin. So it is where one end is held instead.
#[test]
fn energy_between_planes_of_symmetry() {
    let (around, along) = (4, 2);
    let node = |i: usize, j: usize| i * (along + 1) + j;
    let mut mesh = Mesh::default();
    for i in 0..=around {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * i as f64 / around as f64).sin_cos();
        mesh.vertices.extend((0..=along).map(|j| Vector3::new(cos, sin, 0.3 + 0.1 * j as f64)));
        let cells = (0..along).filter(|_| i < around);
        mesh.faces.extend(cells.flat_map(|j| {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            [[a, b, c], [a, c, d]]
        }));
    }
    let topology = Topology::new(&mesh.faces);
    let middles = topology.edges.iter().map(|[a, b]| mesh.vertices[*a].lerp(&mesh.vertices[*b], 0.5));
    let nodes: Vec<Vector3<f64>> = mesh.vertices.iter().copied().chain(middles).collect();
    let middle = |e: usize| mesh.vertices.len() + e;
    let six = mesh.faces.iter().zip(&topology.face_edges).map(|([a, b, c], [d, e, f])| [*a, *b, *c, middle(*d), middle(*e), middle(*f)]);
    let six: Vec<[usize; 6]> = six.collect();
    // The rate of the energy along a movement that the planes allow, and that by the forces, at a place to which such a movement leads.
    let rates = |pressure: &mut dyn Potential, nodes: &[Vector3<f64>], held_end: bool| {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut movement = || -> Vec<Vector3<f64>> {
            let of = |p: &Vector3<f64>| {
                let free = |c: f64| f64::from(u8::from(c.abs() > 1e-9));
                let end = if held_end { free(p.z - 0.5) } else { 1.0 };
                let [x, y, z] = [free(p.x), free(p.y), free(p.z - 0.3) * free(p.z - 0.5)];
                Vector3::new(x, y, z).map(|free| free * end * rng.random_range(-0.05..0.05))
            };
            nodes.iter().map(of).collect()
        };
        let (way, d) = (movement(), movement());
        let at = |h: f64| -> Vec<f64> { (0..nodes.len()).flat_map(|n| (nodes[n] + way[n] + d[n] * h).data.0[0]).collect() };
        let change = (pressure.energy(&at(1e-3)) - pressure.energy(&at(-1e-3))) / 2e-3;
        let work: f64 = forces(pressure, &at(0.0)).iter().zip(&d).map(|(f, d)| -f.dot(d)).sum();
        assert!(work.abs() > 1e-4, "{work}");
        change / work
    };
    let slice = Viewpoint { origin: Vector3::zeros(), axes: [true, true, false] };
    let sector = Viewpoint { origin: Vector3::new(0.0, 0.0, 0.3), axes: [true; 3] };
    let value = |p: &Vector3<f64>, t: f64| 1.0 + t + p.x - 2.0 * p.z * p.y;
    let vertices = &mesh.vertices;
    for (view, held_end, right) in
        [(slice, false, true), (sector, true, true), (Viewpoint::ORIGIN, false, false), (Viewpoint::ORIGIN, true, false)]
    {
        let linear = rates(&mut flat_pressure(&mesh.faces).seen_from(Some(view)), vertices, held_end);
        let quadratic = rates(&mut curved_pressure(&six).seen_from(Some(view)), &nodes, held_end);
        let field = Pressure::<3, 9>::varying(mesh.faces.clone(), linear_radon().to_vec(), Box::new(value), vertices, 1.0);
        let varying = rates(&mut field.seen_from(Some(view)), vertices, held_end);
        for ratio in [linear, quadratic, varying] {
            assert!(if right { (ratio - 1.0).abs() < 1e-6 } else { (ratio - 1.0).abs() > 1e-3 }, "{view:?} {held_end}: {ratio}");
        }
    }
    // Without an energy a line search gets the work, to second order.
    let mut open = flat_pressure(&mesh.faces).seen_from(None);
    let (pattern, _) = bind(&mut open, 3 * vertices.len());
    let (start, end) =
        (shaken(vertices), shaken(&shaken(vertices).chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect::<Vec<_>>()));
    assert_eq!(open.energy(&start), 0.0);
    open.assemble(&start, Curvature::Projected, &mut System::new(&pattern));
    let work = |n: usize| -> f64 {
        let between = |s: f64| -> Vec<f64> { start.iter().zip(&end).map(|(a, b)| a + s * (b - a)).collect() };
        let mut open = flat_pressure(&mesh.faces).seen_from(None);
        let step = |k: usize| {
            let force = forces(&mut open, &between((k as f64 + 0.5) / n as f64));
            (0..end.len()).map(|i| -force[i / 3][i % 3] * (end[i] - start[i])).sum::<f64>() / n as f64
        };
        (0..n).map(step).sum()
    };
    let exact = work(100);
    assert!(exact.abs() > 1e-3 && (open.energy(&end) - exact).abs() < 0.05 * exact.abs(), "{} {exact}", open.energy(&end));
}

#[test]
fn force_is_pressure_times_area() {
    let mesh = patch();
    let (nodes, faces, topology) = curved(&mesh);
    let p = PRESSURE * FACTOR;
    let close = |force: Vector3<f64>, area: Vector3<f64>| {
        assert!(area.norm() > 0.1 && (force - p * area).norm() < 1e-13 * area.norm(), "{force:?} {area:?}");
    };
    let x = shaken(&mesh.vertices);
    for face in &mesh.faces {
        let [a, b, c] = face.map(|v| at(&x, v));
        let of_nodes = forces(&mut flat_pressure(&[*face]), &x);
        close(of_nodes.iter().sum(), 0.5 * (b - a).cross(&(c - a)));
        // A constant load goes to the corners in equal parts.
        face.iter().for_each(|v| close(3.0 * of_nodes[*v], 0.5 * (b - a).cross(&(c - a))));
    }
    close(forces(&mut flat_pressure(&mesh.faces), &x).iter().sum(), area_by_rim(&topology, &x, None));
    let (vertices, x) = (mesh.vertices.len(), shaken(&nodes));
    for (face, nodes) in mesh.faces.iter().zip(&faces) {
        let area = (0..3).map(|i| {
            // Edge i runs from vertex i + 1 to vertex i + 2.
            sector(&x, [face[(i + 1) % 3], face[(i + 2) % 3]], Some(nodes[3 + i]))
        });
        close(forces(&mut curved_pressure(&[*nodes]), &x).iter().sum(), area.sum());
    }
    close(forces(&mut curved_pressure(&faces), &x).iter().sum(), area_by_rim(&topology, &x, Some(vertices)));
}

/// A constant load on a straight face goes to the middles of its edges alone.
#[test]
fn pressure_on_a_straight_quadratic_face() {
    let [a, b, c] = [Vector3::new(0.2, 0.1, 0.3), Vector3::new(1.1, 0.2, -0.1), Vector3::new(0.3, 0.9, 0.4)];
    let x: Vec<f64> = [a, b, c, b.lerp(&c, 0.5), c.lerp(&a, 0.5), a.lerp(&b, 0.5)].iter().flat_map(|v| v.data.0[0]).collect();
    let area = 0.5 * (b - a).cross(&(c - a));
    let of_nodes = forces(&mut curved_pressure(&[[0, 1, 2, 3, 4, 5]]), &x);
    for (node, force) in of_nodes.iter().enumerate() {
        let share = if node < 3 { 0.0 } else { 1.0 / 3.0 };
        assert!((force - PRESSURE * FACTOR * share * area).norm() < 1e-14, "{node}: {force:?}");
    }
}

/// On an open patch the matrix is the symmetric part of the derivative of the forces, and the energy's gradient is the force except at
/// the rim.
fn compare_open(potential: &mut dyn Potential, x: &[f64], inner: &[usize]) {
    let (pattern, mut system) = bind(potential, x.len());
    potential.assemble(x, Curvature::Mixed, &mut system);
    let (gradient, hessian) = (system.gradient.clone(), dense(&pattern, &system.matrix));
    let stiff = hessian.iter().flatten().fold(0.0f64, |m, h| m.max(h.abs()));
    let scale = gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
    let step = 1e-5;
    let mut columns = Vec::new();
    let mut rim_differs = false;
    for i in 0..x.len() {
        let mut at = |d: f64| {
            let mut shifted = x.to_vec();
            shifted[i] += d;
            system.clear();
            let energy = potential.gradient(&shifted, &mut system);
            (energy, system.gradient.clone())
        };
        let ((e1, g1), (e2, g2)) = (at(step), at(-step));
        let agrees = ((e1 - e2) / (2.0 * step) - gradient[i]).abs() < 1e-8 * scale;
        assert!(agrees || !inner.contains(&(i / 3)), "gradient {i}");
        rim_differs |= !agrees;
        columns.push(g1.iter().zip(&g2).map(|(a, b)| (a - b) / (2.0 * step)).collect::<Vec<_>>());
    }
    assert!(rim_differs);
    let mut asymmetry = 0.0f64;
    for i in 0..x.len() {
        for j in 0..=i {
            let symmetric = 0.5 * (columns[i][j] + columns[j][i]);
            assert!((symmetric - hessian[i][j]).abs() < 1e-8 * stiff, "Hessian {i} {j}: {symmetric} {}", hessian[i][j]);
            asymmetry = asymmetry.max((columns[i][j] - columns[j][i]).abs());
        }
    }
    assert!(asymmetry > 0.1 * stiff);
    // Descent has no matrix of a pressure.
    let mut projected = System::new(&pattern);
    potential.assemble(x, Curvature::Projected, &mut projected);
    assert!(projected.matrix.iter().all(|h| *h == 0.0) && projected.gradient == gradient);
}

#[test]
fn pressure_on_an_open_patch() {
    let mesh = patch();
    let (nodes, faces, topology) = curved(&mesh);
    compare_open(&mut flat_pressure(&mesh.faces), &shaken(&mesh.vertices), &[4]);
    let inner: Vec<usize> = (0..topology.edges.len()).filter(|e| !topology.is_boundary(*e)).map(|e| 9 + e).chain([4]).collect();
    assert_eq!(inner.len(), 9);
    compare_open(&mut curved_pressure(&faces), &shaken(&nodes), &inner);
}

#[test]
fn dead_loads_add_up_and_keep_their_direction() {
    let pairs = vec![(2, Vector3::new(1.0, -2.0, 3.0)), (0, Vector3::new(0.5, 0.25, -1.0)), (2, Vector3::new(4.0, 5.0, -6.5))];
    let mut load = DeadLoad::new(pairs.clone());
    let x = [0.3, -0.2, 0.7, 9.0, 9.0, 9.0, 1.1, 0.4, -0.8, 9.0];
    for factor in [1.0, -0.4, 0.0] {
        load.set_factor(factor);
        let (pattern, mut system) = bind(&mut load, x.len());
        let energy = load.assemble(&x, Curvature::Mixed, &mut system);
        let exact = -factor * pairs.iter().map(|(node, f)| f.dot(&at(&x, *node))).sum::<f64>();
        assert!((energy - exact).abs() < 1e-14 && energy == load.energy(&x), "{energy} {exact}");
        let sums = [0.5, 0.25, -1.0, 0.0, 0.0, 0.0, 5.0, 3.0, -3.5, 0.0];
        for (g, f) in system.gradient.iter().zip(sums) {
            assert!((g + factor * f).abs() < 1e-15, "{g} {f}");
        }
        assert!(system.matrix.iter().all(|h| *h == 0.0) && pattern.row.len() == x.len());
        // Held unknowns take nothing.
        let held: Vec<bool> = (0..x.len()).map(|i| i == 6).collect();
        let numbering = thinshell::sparse::Numbering::new(&held);
        let pattern = thinshell::sparse::Pattern::new(&numbering, &mut |visit| load.stencils(visit)).unwrap();
        load.bind(&numbering, &pattern);
        let mut fewer = System::new(&pattern);
        assert_eq!(load.gradient(&x, &mut fewer), energy);
        let rest: Vec<f64> = system.gradient.iter().zip(&held).filter(|(_, h)| !**h).map(|(g, _)| *g).collect();
        assert_eq!(fewer.gradient, rest);
    }
}
