use thinshell::mesh::Quality;
use thinshell::mesh::generate::*;
#[test]
fn probe() {
    for seed in 0..5 {
        let m = rectangle_delaunay([1.0, 0.5], [40, 20], None, seed).unwrap();
        println!("{}\n", Quality::of(&m));
    }
    let t = std::time::Instant::now();
    let m = rectangle_delaunay([1.0, 1.0], [200, 200], None, 1).unwrap();
    println!("{:?} {}\n", t.elapsed(), Quality::of(&m));
    let m = outline(
        &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.3], [0.0, 1.0]],
        &[vec![[0.2, 0.1], [0.3, 0.1], [0.25, 0.2]]],
        Triangulation { size: 0.05, min_angle: 25.0 },
    )
    .unwrap();
    println!("{}\n", Quality::of(&m));
    for (n, r) in &m.regions {
        println!("{n} {}", r.edges.len());
    }
    println!("{}\n", Quality::of(&rectangle([1.0, 1.0], [10, 10], Pattern::Diagonal, 0.45, 1).unwrap()));
    for n in [10, 20, 40] {
        println!("{}\n", Quality::of(&disc(1.0, n).unwrap()));
    }
    println!("{}\n", Quality::of(&sphere_cap(1.0, 90.0, 40).unwrap()));
    println!("{}\n", Quality::of(&cylinder(1.0, 2.0, 360.0, [40, 10], Pattern::Diagonal).unwrap()));
}
