//! What crosses the surface, when and where, and what a resumed run needs.

use crate::moisture_support::{MASSES, SCHEMES, always, cell, constant, isotropic, random, rim, side, slab, uniform};
use nalgebra::Vector3;
use thinshell::mesh::Mesh;
use thinshell::mesh::generate::{Pattern, rectangle};
use thinshell::moisture::{Balance, Condition, Diffusion, Law, Mass, Scheme, Side, Slab, Source, Where, cosine_levels};

fn square() -> Mesh {
    rectangle([1.0; 2], [5, 5], Pattern::Diagonal, 0.25, 4).unwrap()
}

#[test]
fn fluxes_and_sources_bring_what_they_say() {
    let mesh = square();
    for mass in MASSES {
        for scheme in SCHEMES {
            let conditions = vec![
                always(side(&mesh, Side::Top), Law::Flux(constant(3.0))),
                Condition { window: [0.5, 2.0], ..always(side(&mesh, Side::Bottom), Law::Flux(constant(-1.0))) },
                always(rim(&mesh, |v| v.x < 1e-9), Law::Flux(Box::new(|_, t| 2.0 * t))),
            ];
            let source = Source { rate: Box::new(|_, height, _| 5.0 * height) };
            let slab = isotropic(&mesh, 0.1, 0.3, cosine_levels(3));
            let mut diffusion = Diffusion::new(slab, conditions, Some(source), mass, scheme, Some(0.01)).unwrap();
            diffusion.advance(0.0, 1.0, &[]).unwrap();
            let b = diffusion.balance();
            // The rim's mean flux over the steps; backward Euler takes it at their ends.
            let rim = if scheme == Scheme::Sdirk2 { 0.1 } else { 0.1 * 1.01 };
            let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
            assert!(near(b.top, 3.0) && near(b.bottom, -0.5) && near(b.rim, rim) && near(b.sources, 0.25), "{mass:?} {scheme:?}: {b:?}");
            assert!(near(b.content, b.top + b.bottom + b.rim + b.sources), "{b:?}");
            assert_eq!(diffusion.overshoot(), 0.0);
        }
    }
}

/// Steady flow through air, sheet and air: resistances add up, and linear elements are exact.
#[test]
fn exchange_on_both_sides_becomes_steady() {
    let (h, d, k, air) = (0.1, 0.3, [2.0, 5.0], [1.0, -3.0]);
    let flow = (air[0] - air[1]) / (1.0 / k[0] + h / d + 1.0 / k[1]);
    for mass in MASSES {
        for scheme in SCHEMES {
            let exchange = |s, i: usize| always(side(&cell(), s), Law::Exchange { coefficient: k[i], outside: constant(air[i]) });
            let conditions = vec![exchange(Side::Bottom, 0), exchange(Side::Top, 1)];
            let mut diffusion =
                Diffusion::new(isotropic(&cell(), h, d, cosine_levels(4)), conditions, None, mass, scheme, Some(0.1)).unwrap();
            diffusion.set(random(20, 2));
            diffusion.advance(0.0, 10.0, &[]).unwrap();
            let before = diffusion.balance();
            diffusion.advance(10.0, 11.0, &[]).unwrap();
            let after = diffusion.balance();
            assert!((after.bottom - before.bottom - flow).abs() < 1e-11 && (after.top - before.top + flow).abs() < 1e-11, "{after:?}");
            for (k, u) in diffusion.values().iter().enumerate() {
                let exact = air[0] - flow / 2.0 - flow / d * h * diffusion.levels()[k % 5];
                assert!((u - exact).abs() < 1e-12, "{mass:?} {scheme:?}: {u} {exact}");
            }
        }
    }
}

#[test]
fn without_vapour_in_the_air_all_dries() {
    let exchange = always(side(&cell(), Side::Top), Law::Exchange { coefficient: 2.0, outside: constant(0.25) });
    let rim = always(rim(&cell(), |v| v.x > 0.5), Law::Exchange { coefficient: 1.0, outside: constant(0.25) });
    let slab = isotropic(&cell(), 0.1, 0.3, cosine_levels(4));
    let mut diffusion = Diffusion::new(slab, vec![exchange, rim], None, Mass::Lumped, Scheme::BackwardEuler, Some(0.1)).unwrap();
    diffusion.set(vec![1.0; 20]);
    diffusion.advance(0.0, 20.0, &[]).unwrap();
    assert!(diffusion.values().iter().all(|u| (u - 0.25).abs() < 1e-12) && diffusion.overshoot() < 1e-15);
    let Balance { top, rim, bottom, .. } = diffusion.balance();
    assert!((top + rim + 0.075).abs() < 1e-13 && rim < -1e-3 && bottom == 0.0, "{top} {rim}");
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn conditions_switch_at_their_own_times() {
    let mesh = square();
    let new = |scheme| {
        let wet = Condition { window: [0.3, 0.7], ..always(side(&mesh, Side::Top), Law::Value(constant(1.0))) };
        Diffusion::new(isotropic(&mesh, 0.1, 0.01, cosine_levels(4)), vec![wet], None, Mass::Lumped, scheme, Some(0.02)).unwrap()
    };
    for scheme in SCHEMES {
        let (mut whole, mut parts) = (new(scheme), new(scheme));
        whole.advance(0.0, 1.0, &[]).unwrap();
        parts.advance(0.0, 0.3, &[]).unwrap();
        assert!(parts.values().iter().all(|u| *u == 0.0));
        parts.advance(0.3, 0.7, &[]).unwrap();
        let soaked = parts.balance();
        assert!(soaked.top > 0.05 && (soaked.top - soaked.content).abs() < 1e-14, "{soaked:?}");
        parts.advance(0.7, 1.0, &[]).unwrap();
        assert!((parts.balance().content - soaked.content).abs() < 1e-14 && parts.balance().top == soaked.top);
        assert!(parts.values().iter().all(|u| *u > 0.1 && *u < 1.0));
        assert_eq!(bits(whole.values()), bits(parts.values()));
        assert_eq!(whole.factorizations(), 3);
    }
}

#[test]
fn equal_steps_share_one_factorisation() {
    let mesh = square();
    for dt in [None, Some(0.03), Some(0.1)] {
        let wet = always(side(&mesh, Side::Top), Law::Exchange { coefficient: 1.0, outside: constant(1.0) });
        let slab = isotropic(&mesh, 0.1, 0.01, cosine_levels(2));
        let mut diffusion = Diffusion::new(slab, vec![wet], None, Mass::Lumped, Scheme::Sdirk2, dt).unwrap();
        let mut t = 0.0f64;
        // Sums of 0.1 are not multiples of it.
        for _ in 0..3000 {
            diffusion.advance(t, t + 0.1, &[]).unwrap();
            t += 0.1;
        }
        assert!(t != 300.0);
        assert_eq!(diffusion.factorizations(), 1, "{dt:?}");
        diffusion.advance(t, t + 0.07, &[]).unwrap();
        assert_eq!(diffusion.factorizations(), 2, "{dt:?}");
    }
}

#[test]
fn wet_ground_wets_what_is_below() {
    let mesh = square();
    let ground = |law| Condition { below: Some(0.25), ..always(side(&mesh, Side::Bottom), law) };
    for law in [Law::Value(constant(1.0)), Law::Flux(constant(1.0)), Law::Exchange { coefficient: 1.0, outside: constant(1.0) }] {
        // Nothing moves in the sheet.
        let slab = slab(&mesh, 0.1, [0.0, 0.0, 0.01], Vector3::x(), cosine_levels(4));
        let mut diffusion = Diffusion::new(slab, vec![ground(law)], None, Mass::Lumped, Scheme::BackwardEuler, Some(0.1)).unwrap();
        let heights: Vec<f64> = mesh.vertices.iter().map(|v| v.x).collect();
        diffusion.advance(0.0, 0.5, &heights).unwrap();
        for (v, height) in heights.iter().enumerate() {
            let wet = diffusion.values()[5 * v..5 * v + 5].iter().all(|u| *u > 1e-4);
            let dry = diffusion.values()[5 * v..5 * v + 5].iter().all(|u| *u == 0.0);
            assert!(if *height < 0.25 { wet } else { dry }, "vertex {v} at {height}");
        }
        let b = diffusion.balance();
        assert!((b.bottom - b.content).abs() < 1e-14 && b.content > 1e-3);
        let error = diffusion.advance(0.5, 1.0, &[]).unwrap_err();
        assert!(error.contains("0 heights for 36 vertices"), "{error}");
    }
}

#[test]
fn where_given_values_meet_the_later_one_holds() {
    let mesh = cell();
    let conditions =
        vec![always(side(&mesh, Side::Top), Law::Value(constant(1.0))), always(rim(&mesh, |_| true), Law::Value(constant(2.0)))];
    let slab = isotropic(&mesh, 0.1, 0.01, uniform(2));
    let mut diffusion = Diffusion::new(slab, conditions, None, Mass::Consistent, Scheme::Sdirk2, None).unwrap();
    diffusion.advance(0.0, 1.0, &[]).unwrap();
    assert!(diffusion.values().iter().all(|u| *u == 2.0));
    let b = diffusion.balance();
    assert!((b.content - 0.2).abs() < 1e-15 && (b.rim - 0.2).abs() < 1e-15 && b.top == 0.0, "{b:?}");
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    let mesh = square();
    for mass in MASSES {
        for scheme in SCHEMES {
            let new = || {
                let conditions = vec![
                    Condition { below: Some(0.4), ..always(side(&mesh, Side::Bottom), Law::Value(Box::new(|v, t| v as f64 + t))) },
                    Condition {
                        window: [0.3, 1.5],
                        ..always(side(&mesh, Side::Top), Law::Exchange { coefficient: 0.1, outside: constant(9.0) })
                    },
                ];
                let slab = isotropic(&mesh, 0.1, 0.01, cosine_levels(4));
                let mut diffusion = Diffusion::new(slab, conditions, None, mass, scheme, Some(0.03)).unwrap();
                diffusion.set(random(180, 8));
                diffusion
            };
            let steps = |diffusion: &mut Diffusion, from: usize, to: usize| {
                let mut t = 0.0f64;
                for k in 0..to {
                    let heights: Vec<f64> = mesh.vertices.iter().map(|v| v.x * (2.0 * t).cos().abs()).collect();
                    if k >= from {
                        diffusion.advance(t, t + 0.1, &heights).unwrap();
                    }
                    t += 0.1;
                }
            };
            let mut whole = new();
            steps(&mut whole, 0, 20);
            let mut first = new();
            steps(&mut first, 0, 9);
            let mut second = new();
            second.set(first.values().to_vec());
            second.restore(&first.state()).unwrap();
            steps(&mut second, 9, 20);
            assert_eq!(bits(whole.values()), bits(second.values()), "{mass:?} {scheme:?}");
            assert_eq!(bits(&whole.state()), bits(&second.state()));
            assert!(whole.balance().bottom != 0.0 && whole.balance().top != 0.0);
            assert_eq!(second.restore(&[1.0]).unwrap_err(), "the state of the moisture has 1 numbers, not 7");
        }
    }
}

#[test]
fn data_that_are_not_numbers_are_named() {
    let bad = || Box::new(|v: usize, t: f64| if v == 2 && t > 0.55 { f64::NAN } else { 1.0 });
    let air = Law::Exchange { coefficient: 1.0, outside: bad() };
    for (law, name) in [(Law::Value(bad()), "given value"), (Law::Flux(bad()), "flux"), (air, "outside value")] {
        let slab = isotropic(&cell(), 0.1, 0.01, uniform(1));
        let conditions = vec![always(side(&cell(), Side::Top), law)];
        let mut diffusion = Diffusion::new(slab, conditions, None, Mass::Lumped, Scheme::BackwardEuler, Some(0.1)).unwrap();
        let error = diffusion.advance(0.0, 1.0, &[]).unwrap_err();
        assert!(error.contains(&format!("the {name} at vertex 2 is NaN at 0.6")), "{error}");
        assert!(diffusion.values().iter().all(|u| u.is_finite()) && diffusion.balance().content > 0.0);
    }
    let source = Source { rate: Box::new(|v, _, _| if v == 3 { f64::INFINITY } else { 0.0 }) };
    let slab = isotropic(&cell(), 0.1, 0.01, uniform(1));
    let mut diffusion = Diffusion::new(slab, Vec::new(), Some(source), Mass::Lumped, Scheme::BackwardEuler, None).unwrap();
    assert!(diffusion.advance(0.0, 1.0, &[]).unwrap_err().contains("the source at vertex 3 is inf at 1 s"));
    assert!(diffusion.advance(1.0, 0.0, &[]).unwrap_err().contains("no time passes"));
}

#[test]
fn slabs_and_conditions_without_meaning_are_refused() {
    let good = || isotropic(&cell(), 0.1, 0.01, uniform(2));
    let error = |slab: Slab, conditions: Vec<Condition>, dt: Option<f64>| {
        Diffusion::new(slab, conditions, None, Mass::Lumped, Scheme::BackwardEuler, dt).err().map(|e| e.to_string()).unwrap_or_default()
    };
    assert_eq!(error(good(), Vec::new(), Some(1.0)), "");
    type Spoil = fn(&mut Slab);
    let slabs: [(&str, Spoil); 9] = [
        ("2 faces, but [1, 2, 2, 2]", |s| s.metric.truncate(1)),
        ("face 1 has vertex 9", |s| s.faces[1][2] = 9),
        ("vertex 4 belongs to no face", |s| s.vertices = 5),
        ("not positive definite", |s| s.metric[1] = [1.0, 2.0, 1.0]),
        ("NaN is not a thickness", |s| s.thickness[0] = f64::NAN),
        ("are not diffusivities", |s| s.in_plane[0] = [1.0, 2.0, 1.0]),
        ("are not diffusivities", |s| s.through[1] = -1.0),
        ("do not ascend", |s| s.levels = vec![0.0, 0.5, 0.5, 1.0]),
        ("do not ascend", |s| s.levels = vec![0.0]),
    ];
    for (message, spoil) in slabs {
        let mut slab = good();
        spoil(&mut slab);
        let found = error(slab, Vec::new(), None);
        assert!(found.contains(message), "{message}: {found}");
    }
    let top = || side(&cell(), Side::Top);
    let value = || Law::Value(constant(1.0));
    for (message, condition) in [
        ("has no duration", Condition { window: [1.0, 1.0], ..always(top(), value()) }),
        ("has no duration", Condition { window: [f64::NAN, 1.0], ..always(top(), value()) }),
        ("wet ground is not a number", Condition { below: Some(f64::NAN), ..always(top(), value()) }),
        ("-1 is not a coefficient", always(top(), Law::Exchange { coefficient: -1.0, outside: constant(0.0) })),
        ("there is no face 7", always(Where::Side { side: Side::Top, faces: vec![7] }, value())),
        ("there is no face 8", always(Where::Rim { edges: vec![(8, 0)] }, value())),
        ("face 1 has no edge 3", always(Where::Rim { edges: vec![(1, 3)] }, value())),
    ] {
        let found = error(good(), vec![condition], None);
        assert!(found.contains(message), "{message}: {found}");
    }
    assert!(error(good(), Vec::new(), Some(0.0)).contains("0 s is not a step of time"));
}
