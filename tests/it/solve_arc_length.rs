//! Paths through limit points, on a truss of two bars in line with a spring, whose path is known exactly.

use thinshell::report::path::limit_point;
use thinshell::solve::{ArcControl, Family, Newton, Reach, Settings, Stop};
use thinshell::sparse::{Curvature, HELD, Numbering, Pattern, Potential, System};

/// Two bars from `(-b, 0)` and `(b, 0)` to an apex at the height `z`, of springs `k`; a spring from the apex to the point that a load `t` pulls
/// down. Unknowns 2 and 5 are the heights of apex and point; the others are held.
struct Truss {
    half_width: f64,
    height: f64,
    bars: f64,
    spring: f64,
    load: f64,
    numbers: [u32; 2],
    slots: [usize; 3],
}

impl Truss {
    fn new(spring: f64) -> Self {
        Truss { half_width: 1.0, height: 0.3, bars: 2.0, spring, load: 0.0, numbers: [HELD; 2], slots: [0; 3] }
    }

    fn lengths(&self, z: f64) -> (f64, f64) {
        (self.half_width.hypot(z), self.half_width.hypot(self.height))
    }

    /// What the bars push the apex upwards with, its sign turned, at the height `z`.
    fn force(&self, z: f64) -> f64 {
        let (l, rest) = self.lengths(z);
        2.0 * self.bars * (l - rest) * z / l
    }

    fn stiffness(&self, z: f64) -> [f64; 2] {
        let (l, rest) = self.lengths(z);
        let along = 2.0 * self.bars * (z / l) * (z / l);
        [along, 2.0 * self.bars * (l - rest) / l * (1.0 - (z / l) * (z / l))]
    }
}

impl Potential for Truss {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        visit(&[2, 5]);
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        self.numbers = [numbering.of(2), numbering.of(5)];
        self.slots = [pattern.column_start[0] as usize, pattern.column_start[0] as usize + 1, pattern.column_start[1] as usize];
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let (l, rest) = self.lengths(x[2]);
        let stretch = x[5] - x[2];
        self.bars * (l - rest) * (l - rest) + 0.5 * self.spring * stretch * stretch + self.load * x[5]
    }

    fn assemble(&mut self, x: &[f64], _: Curvature, into: &mut System) -> f64 {
        let values = [self.stiffness(x[2]).iter().sum::<f64>() + self.spring, -self.spring, self.spring];
        self.slots.iter().zip(values).for_each(|(slot, value)| into.matrix[*slot] += value);
        self.gradient(x, into)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        let pull = self.spring * (x[5] - x[2]);
        for (number, g) in self.numbers.into_iter().zip([self.force(x[2]) - pull, pull + self.load]) {
            into.gradient[number as usize] += g;
        }
        self.energy(x)
    }

    fn stiffness_along(&self, x: &[f64], y: &[f64]) -> f64 {
        let stretch = y[5] - y[2];
        self.stiffness(x[2])[0] * y[2] * y[2] + self.spring * stretch * stretch
    }
}

/// The truss under a load that is `factor` of `t`.
struct Loaded {
    truss: Truss,
    factor: fn(f64) -> f64,
}

impl Family for Loaded {
    type Refusal = String;

    fn potentials(&mut self) -> Vec<&mut dyn Potential> {
        vec![&mut self.truss]
    }

    fn set(&mut self, t: f64) -> Result<(), String> {
        self.truss.load = (self.factor)(t);
        if self.truss.load.is_finite() { Ok(()) } else { Err(format!("no load at {t}")) }
    }

    fn moved(&self, _: f64) -> Result<Vec<(usize, f64)>, String> {
        Ok(Vec::new())
    }

    fn add_rate(&mut self, t: f64, _: &[f64], into: &mut System) -> Result<(), String> {
        let step = 1e-4;
        into.gradient[self.truss.numbers[1] as usize] += ((self.factor)(t + step) - (self.factor)(t - step)) / (2.0 * step);
        Ok(())
    }
}

/// Heights of apex and point, load factor and way at each step, until the point has sunk by twice the height and more.
fn follow(loaded: &mut Loaded, first: f64, longest: f64) -> (Vec<[f64; 2]>, Vec<f64>, Vec<f64>) {
    let held = [true, true, false, true, true, false];
    let settings = Settings { lengths: 6, diameter: 2.0, tolerance: 1e-12, max_iterations: 25 };
    let mut newton = Newton::new(&mut loaded.potentials(), &held, settings).unwrap();
    let height = loaded.truss.height;
    let mut x = vec![0.0, 0.0, height, 0.0, 0.0, height];
    let (mut t, mut heading) = (0.0, None);
    let (mut heights, mut factors, mut ways) = (vec![[height; 2]], vec![t], vec![0.0]);
    let mut control = ArcControl::new(first, 4.0, longest, 10);
    while x[5] > -1.5 * height && heights.len() < 2000 {
        let before = x.clone();
        match newton.advance_along(loaded, &mut x, t, control.reach(), heading.as_deref()) {
            Ok(advance) => {
                control.succeed(advance.solved.iterations, advance.length);
                t = advance.t;
                let way: Vec<f64> = x.iter().zip(&before).map(|(now, before)| now - before).collect();
                ways.push(ways[ways.len() - 1] + newton.path_length(&way));
                heading = Some(way);
                heights.push([x[2], x[5]]);
                factors.push(t);
            }
            Err(stop) => {
                assert!(control.fail(), "{stop:?} at {t}");
                assert_eq!(x, before);
                loaded.set(t).unwrap();
            }
        }
    }
    (heights, factors, ways)
}

/// Largest force of the bars, by its own formula: at `l = (rest b^2)^(1/3)`.
fn limit(truss: &Truss) -> f64 {
    let (_, rest) = truss.lengths(0.0);
    let l = (rest * truss.half_width * truss.half_width).cbrt();
    -truss.force((l * l - truss.half_width * truss.half_width).sqrt())
}

#[test]
fn snap_through_and_snap_back_are_followed() {
    // A stiff spring: the point snaps through. A soft one: it snaps back too.
    for (spring, snaps_back) in [(10.0, false), (0.15, true)] {
        let mut loaded = Loaded { truss: Truss::new(spring), factor: |t| 0.05 * t };
        let (heights, factors, ways) = follow(&mut loaded, 0.05, 1.0);
        for ([apex, point], t) in heights.iter().zip(&factors) {
            let load = 0.05 * t;
            assert!((loaded.truss.force(*apex) + load).abs() < 1e-12, "{apex} {t}");
            assert!((point - apex + load / spring).abs() < 1e-12);
        }
        assert!(heights.windows(2).all(|h| h[1][0] < h[0][0]), "the apex only sinks");
        let back = heights.windows(2).filter(|h| h[1][1] > h[0][1]).count();
        assert_eq!(back > 0, snaps_back, "{back} of {} steps go back", heights.len());
        let exact = limit(&loaded.truss) / 0.05;
        for (number, exact) in [(1, exact), (2, -exact)] {
            let found = limit_point(&ways, &factors, number).unwrap().of(&factors);
            println!("spring {spring}: {} steps, limit load {found} exact {exact}", heights.len());
            assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
        }
        assert!(limit_point(&ways, &factors, 3).is_none());
    }
}

/// Steps grow where the path is easy and shrink where it is not; a load that is not linear in `t` gives the same states.
#[test]
fn steps_follow_the_iterations_and_any_load_factor() {
    let mut linear = Loaded { truss: Truss::new(10.0), factor: |t| 0.05 * t };
    let mut curved = Loaded { truss: Truss::new(10.0), factor: |t| 0.02 * (t * t * t + 2.0 * t) };
    let short = follow(&mut linear, 0.02, 1.0).0.len();
    let (heights, factors, _) = follow(&mut linear, 0.02, 50.0);
    println!("{short} steps of one length, {} of many", heights.len());
    assert!(heights.len() < short / 2 && factors.iter().any(|t| *t < 0.0));
    let (heights, factors, _) = follow(&mut curved, 0.02, 50.0);
    for ([apex, _], t) in heights.iter().zip(&factors) {
        assert!((curved.truss.force(*apex) + 0.02 * (t * t * t + 2.0 * t)).abs() < 1e-12, "{apex} {t}");
    }
    assert!(factors.iter().any(|t| *t < 0.0));
}

#[test]
fn what_does_not_follow_the_factor_has_no_path() {
    let settings = Settings { lengths: 6, diameter: 2.0, tolerance: 1e-12, max_iterations: 25 };
    let mut still = Loaded { truss: Truss::new(10.0), factor: |_| 0.0 };
    let mut newton = Newton::new(&mut still.potentials(), &[true, true, false, true, true, false], settings).unwrap();
    let mut x = vec![0.0, 0.0, 0.3, 0.0, 0.0, 0.3];
    let stop = newton.advance_along(&mut still, &mut x, 0.0, Reach::Factor(0.1), None).unwrap_err();
    assert_eq!(stop, Stop::Still);
    assert_eq!(x[5], 0.3);
    let mut impossible = Loaded { truss: Truss::new(10.0), factor: |t| if t > 0.05 { f64::NAN } else { t } };
    let mut newton = Newton::new(&mut impossible.potentials(), &[true, true, false, true, true, false], settings).unwrap();
    let stop = newton.advance_along(&mut impossible, &mut x, 0.0, Reach::Factor(0.1), None).unwrap_err();
    assert!(matches!(stop, Stop::Refused(_) | Stop::Equations(_)), "{stop:?}");
    assert_eq!(x[5], 0.3);
}
