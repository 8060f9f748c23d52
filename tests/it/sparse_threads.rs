//! Assembly and factorisation by several threads: the same bits as by one, and a factor that solves.

use std::collections::HashSet;
use std::sync::Mutex;
use thinshell::sparse::{Cholesky, Contribution, Kind, Numbering, Pattern, Scatter, System};

/// Blocks of three unknowns on a grid, coupled with their eight neighbours: a matrix with as many negative eigenvalues as `negative` says.
fn grid(n: usize, negative: &dyn Fn(usize) -> bool) -> (Pattern, Vec<f64>) {
    let node = |i: usize, j: usize| 3 * (i * n + j);
    let numbering = Numbering::new(&vec![false; 3 * n * n]);
    let pattern = Pattern::new(&numbering, &mut |show| {
        for i in 0..n - 1 {
            for j in 0..n - 1 {
                let corners = [node(i, j), node(i + 1, j), node(i, j + 1), node(i + 1, j + 1)];
                show(&std::array::from_fn::<usize, 12, _>(|k| corners[k / 3] + k % 3));
            }
        }
    });
    let pattern = pattern.unwrap();
    let mut matrix: Vec<f64> = (0..pattern.row.len()).map(|k| (0.7 * k as f64).sin()).collect();
    for j in 0..pattern.len() {
        // Larger than all others of a row together.
        matrix[pattern.column_start[j] as usize] = if negative(j) { -30.0 } else { 30.0 + (j % 7) as f64 };
    }
    (pattern, matrix)
}

fn product(pattern: &Pattern, matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    for j in 0..x.len() {
        for k in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
            let i = pattern.row[k] as usize;
            y[i] += matrix[k] * x[j];
            if i != j {
                y[j] += matrix[k] * x[i];
            }
        }
    }
    y
}

fn with_threads<T: Send>(number: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(number).build().unwrap().install(work)
}

/// Solves in one thread and in several; small matrices, which one thread does, and large ones.
#[test]
fn solves_with_the_same_bits_for_any_number_of_threads() {
    for n in [2, 3, 7, 20, 60] {
        let (pattern, matrix) = grid(n, &|j| j % 11 == 4);
        let right: Vec<f64> = (0..pattern.len()).map(|i| (i as f64).cos()).collect();
        let solve = |threads| {
            with_threads(threads, || {
                let mut cholesky = Cholesky::new(&pattern).unwrap();
                let shared = cholesky.is_shared();
                // Twice: memory is used again.
                let mut x = Vec::new();
                for _ in 0..2 {
                    let done = cholesky.refactor(&pattern, &matrix, Kind::Ldlt).unwrap();
                    assert_eq!(done.negative_pivots, (0..pattern.len()).filter(|j| j % 11 == 4).count());
                    x = right.clone();
                    cholesky.solve(&mut x);
                }
                (x, shared)
            })
        };
        let (one, shared) = solve(1);
        assert!(!shared);
        let error = product(&pattern, &matrix, &one).iter().zip(&right).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{n}: {error}");
        for threads in [2, 5] {
            let (several, shared) = solve(threads);
            assert_eq!(shared, n == 60);
            assert!(one.iter().zip(&several).all(|(a, b)| a.to_bits() == b.to_bits()), "{n} {threads}");
        }
    }
}

/// The first column that fails is the same one.
#[test]
fn fails_at_the_same_unknown_for_any_number_of_threads() {
    let (pattern, matrix) = grid(60, &|j| j % 1000 == 321);
    let fail = |threads| with_threads(threads, || Cholesky::new(&pattern).unwrap().refactor(&pattern, &matrix, Kind::Llt));
    let failed = fail(1).unwrap_err();
    assert_eq!(failed.unknown % 1000, 321);
    for _ in 0..5 {
        assert_eq!(fail(3).unwrap_err(), failed);
    }
}

/// A chain of elements of two unknowns whose contributions only add up to the same bits in one order.
#[test]
fn adds_in_the_order_of_the_elements() {
    let elements = 1543;
    let numbering = Numbering::new(&[false; 5]);
    let stencil = |e: usize| [e % 5, (e + 1 + e / 5 % 4) % 5];
    let pattern = Pattern::new(&numbering, &mut |show| (0..elements).for_each(|e| show(&stencil(e)))).unwrap();
    let scatter: Scatter<2> = Scatter::new((0..elements).map(stencil), &numbering, &pattern);
    let sum = |threads| {
        let seen = Mutex::new(HashSet::new());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut system = System::new(&pattern);
        let energy = pool.install(|| {
            scatter.add_all(&mut system, |range, parts| {
                seen.lock().unwrap().insert(rayon::current_thread_index());
                // Long enough for others to wake up.
                std::thread::sleep(std::time::Duration::from_micros(20));
                for (e, part) in range.zip(parts) {
                    let v = 1.0 / (e + 1) as f64;
                    *part = Contribution { energy: v, gradient: [v, -v.sqrt()], hessian: [[v * v, 0.0], [v.sin(), v.cos()]] };
                }
            })
        });
        let numbers: Vec<u64> = system.matrix.iter().chain(&system.gradient).chain([&energy]).map(|v| v.to_bits()).collect();
        (numbers, seen.into_inner().unwrap().len())
    };
    let (one, alone) = sum(1);
    assert_eq!(alone, 1);
    for threads in [2, 3] {
        let (several, seen) = sum(threads);
        assert!(seen > 1, "only one thread of {threads} worked");
        assert_eq!(one, several);
    }
}
