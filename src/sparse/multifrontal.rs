//! Numeric factorisation `L D L^T` by fronts: every supernode assembles its columns and what its children left behind, eliminates, and leaves
//! the rest to its parent. faer analyses and solves; the layout of the factor is faer's.
//!
//! Fronts of different branches do not know each other, so several threads factorise them at once. A front adds its children in their order,
//! so the factor has the same bits for any number of threads.

use super::Pattern;
use super::front::{Front, eliminate};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// No parent.
const NONE: u32 = u32::MAX;

/// Multiplications of a factorisation from which threads share it.
const SHARED: f64 = 2e7;

/// Parts of the work that branches are cut into.
const PARTS: f64 = 64.0;

/// Where everything goes, once for all factorisations of a pattern.
pub struct Fronts {
    /// First column of each supernode, and the number of columns.
    begin: Vec<u32>,
    /// First value of each supernode's panel, and the number of values.
    panel: Vec<usize>,
    /// First entry in `place` of each supernode, and the number of entries.
    rows: Vec<usize>,
    /// Row of each supernode's row below its own columns in the front of its parent.
    place: Vec<u32>,
    parent: Vec<u32>,
    /// Children of each supernode.
    children: Vec<u32>,
    /// First entry in `from` and `to` of each supernode, and the number of entries.
    entries: Vec<usize>,
    /// Entry of the matrix, and where in the panel it goes.
    from: Vec<u32>,
    to: Vec<u32>,
    /// Branches that one thread factorises as a whole: first and last supernode; then single supernodes above them.
    units: Vec<[u32; 2]>,
    /// Multiplications in all.
    work: f64,
    /// Memory of threads, from one factorisation to the next.
    memory: Mutex<Vec<Memory>>,
}

/// What a thread works in.
#[derive(Default)]
struct Memory {
    work: Vec<f64>,
    free: Vec<Vec<f64>>,
}

impl Memory {
    /// Room for at least `length` numbers, which may be any.
    fn take(&mut self, length: usize) -> Vec<f64> {
        match self.free.iter().rposition(|v| v.len() >= length) {
            Some(k) => self.free.swap_remove(k),
            None => vec![0.0; length],
        }
    }

    fn give(&mut self, v: Vec<f64>) {
        if self.free.len() < 8 {
            self.free.push(v);
        } else if let Some(least) = self.free.iter_mut().min_by_key(|v| v.len()).filter(|least| least.len() < v.len()) {
            *least = v;
        }
    }
}

impl Fronts {
    /// Looks up where the entries of `pattern` go. `inverse`: place of each unknown in the order of elimination.
    pub fn new(symbolic: &SymbolicSupernodalCholesky<u32>, pattern: &Pattern, inverse: Option<&[u32]>) -> Self {
        let count = symbolic.n_supernodes();
        let n = symbolic.nrows();
        let mut begin = symbolic.supernode_begin().to_vec();
        begin.push(n as u32);
        let panel: Vec<usize> = symbolic.col_ptr_for_val().iter().map(|v| *v as usize).collect();
        let mut supernode_of = vec![0u32; n];
        for s in 0..count {
            supernode_of[begin[s] as usize..begin[s + 1] as usize].fill(s as u32);
        }
        let mut rows = vec![0];
        let (mut parent, mut children, mut place) = (vec![NONE; count], vec![0u32; count], Vec::new());
        let pattern_of = |s: usize| symbolic.supernode(s).pattern();
        for s in 0..count {
            if let Some(first) = pattern_of(s).first() {
                let p = supernode_of[*first as usize] as usize;
                (parent[s], children[p]) = (p as u32, children[p] + 1);
                let (from, to) = (begin[p], begin[p + 1]);
                let above = pattern_of(p);
                let mut k = 0;
                for row in pattern_of(s) {
                    if *row < to {
                        place.push(row - from);
                    } else {
                        k += above[k..].partition_point(|r| r < row);
                        place.push((to - from) + k as u32);
                    }
                }
            }
            rows.push(place.len());
        }
        let (entries, from, to) = sort_entries(pattern, inverse, &supernode_of, &begin, pattern_of);
        let mut fronts = Fronts {
            begin,
            panel,
            rows,
            place,
            parent,
            children,
            entries,
            from,
            to,
            units: Vec::new(),
            work: 0.0,
            memory: Mutex::default(),
        };
        fronts.cut();
        fronts
    }

    /// Rows and columns of a front.
    fn size(&self, s: usize) -> (usize, usize) {
        let columns = (self.begin[s + 1] - self.begin[s]) as usize;
        (columns + self.rows[s + 1] - self.rows[s], columns)
    }

    /// Cuts the tree into units.
    fn cut(&mut self) {
        let count = self.parent.len();
        // Work of each branch, and its first supernode.
        let mut branch: Vec<(f64, u32)> = (0..count)
            .map(|s| {
                let (r, c) = self.size(s);
                (500.0 + (c * r * r) as f64, s as u32)
            })
            .collect();
        let mut members = vec![1usize; count];
        for s in 0..count {
            let p = self.parent[s];
            if p != NONE {
                let (work, first) = branch[s];
                branch[p as usize].0 += work;
                branch[p as usize].1 = branch[p as usize].1.min(first);
                members[p as usize] += members[s];
            }
        }
        let whole = |s: usize| members[s] == s + 1 - branch[s].1 as usize;
        let roots = (0..count).filter(|s| self.parent[*s] == NONE);
        self.work = roots.map(|s| branch[s].0).sum();
        if !(0..count).all(whole) {
            // Not in postorder: one unit.
            self.units = vec![[0, count as u32 - 1]];
            return;
        }
        let grain = self.work / PARTS;
        let small = |s: usize| branch[s].0 <= grain;
        for s in 0..count {
            let p = self.parent[s];
            if !small(s) {
                self.units.push([s as u32; 2]);
            } else if p == NONE || !small(p as usize) {
                self.units.push([branch[s].1, s as u32]);
            }
        }
    }

    /// Multiplications of a factorisation.
    pub fn work(&self) -> f64 {
        self.work
    }

    /// Whether several threads share a factorisation.
    pub fn is_shared(&self) -> bool {
        self.units.len() > 1 && self.work >= SHARED && rayon::current_num_threads() > 1
    }

    /// Factorises `matrix` into `values`; the first column that fails, in the order of elimination, as an error.
    pub fn factorize(&self, matrix: &[f64], values: &mut [f64], positive: bool) -> Result<(), usize> {
        if self.is_shared() {
            return self.factorize_together(matrix, values, positive);
        }
        let mut memory = self.borrow();
        let mut left = Vec::new();
        let mut outcome = Ok(());
        for s in 0..self.parent.len() {
            let panel = &mut values[self.panel[s]..self.panel[s + 1]];
            outcome = self.front(s, matrix, panel, &mut left, &mut memory, positive);
            if outcome.is_err() {
                break;
            }
        }
        self.memory.lock().unwrap_or_else(|e| e.into_inner()).push(memory);
        outcome
    }

    /// Shows each pivot of a factor, in the order of elimination.
    pub fn each_pivot(&self, values: &[f64], mut visit: impl FnMut(usize, f64)) {
        for s in 0..self.parent.len() {
            let (r, c) = self.size(s);
            for k in 0..c {
                visit(self.begin[s] as usize + k, values[self.panel[s] + k * (r + 1)]);
            }
        }
    }

    fn borrow(&self) -> Memory {
        self.memory.lock().unwrap_or_else(|e| e.into_inner()).pop().unwrap_or_default()
    }

    /// The same by all threads.
    fn factorize_together(&self, matrix: &[f64], values: &mut [f64], positive: bool) -> Result<(), usize> {
        let mut rest = values;
        let mut panels = Vec::with_capacity(self.units.len());
        for [first, last] in &self.units {
            let length = self.panel[*last as usize + 1] - self.panel[*first as usize];
            let (panel, more) = rest.split_at_mut(length);
            panels.push(Mutex::new(Some(panel)));
            rest = more;
        }
        let unit_of = |s: u32| self.units.partition_point(|[_, last]| *last < s);
        let mut waiting: Vec<usize> = vec![0; self.units.len()];
        for [_, last] in &self.units {
            let p = self.parent[*last as usize];
            if p != NONE {
                waiting[unit_of(p)] += 1;
            }
        }
        let ready: Vec<usize> = (0..waiting.len()).filter(|u| waiting[*u] == 0).collect();
        let team = Team {
            fronts: self,
            matrix,
            positive,
            panels,
            left: waiting.iter().map(|n| Mutex::new(Vec::with_capacity(*n))).collect(),
            waiting: waiting.into_iter().map(AtomicUsize::new).collect(),
            failed: AtomicUsize::new(usize::MAX),
        };
        let shared = &team;
        rayon::scope(|scope| {
            for unit in ready {
                scope.spawn(move |scope| shared.run(scope, unit));
            }
        });
        match team.failed.into_inner() {
            usize::MAX => Ok(()),
            column => Err(column),
        }
    }

    /// Takes what the children of `s` left, in their order.
    fn take_children(&self, s: usize, left: &mut Vec<Left>) -> Vec<Left> {
        let is_child = |left: &Left| self.parent[left.supernode] as usize == s;
        let last = left.len() - self.children[s] as usize;
        // Where supernodes are in postorder, as they are but for orderings of one's own, children are the last.
        if left[last..].iter().all(is_child) {
            return left.split_off(last);
        }
        let (children, others) = std::mem::take(left).into_iter().partition(is_child);
        *left = others;
        children
    }

    /// Assembles and eliminates supernode `s`. `left`: what is left behind by supernodes whose parents have not come yet; that of its children
    /// is taken away, and its own is put there.
    fn front(
        &self,
        s: usize,
        matrix: &[f64],
        panel: &mut [f64],
        left: &mut Vec<Left>,
        memory: &mut Memory,
        positive: bool,
    ) -> Result<(), usize> {
        let (r, c) = self.size(s);
        panel.fill(0.0);
        let entries = self.entries[s]..self.entries[s + 1];
        for (from, to) in self.from[entries.clone()].iter().zip(&self.to[entries]) {
            panel[*to as usize] = matrix[*from as usize];
        }
        let p = r - c;
        let mut rest = memory.take(p * p);
        (0..p).for_each(|j| rest[j * (p + 1)..(j + 1) * p].fill(0.0));
        for child in self.take_children(s, left) {
            let place = &self.place[self.rows[child.supernode]..self.rows[child.supernode + 1]];
            let m = place.len();
            for (j, to) in place.iter().enumerate() {
                let to = *to as usize;
                let column = &child.values[j * m + j..(j + 1) * m];
                let (target, shift) =
                    if to < c { (&mut panel[to * r..(to + 1) * r], 0) } else { (&mut rest[(to - c) * p..(to - c + 1) * p], c) };
                for (i, v) in place[j..].iter().zip(column) {
                    target[*i as usize - shift] += v;
                }
            }
            memory.give(child.values);
        }
        if memory.work.len() < r * c {
            memory.work = vec![0.0; r * c];
        }
        let work = &mut memory.work[..r * c];
        eliminate(Front { rows: r, columns: c, panel, rest: &mut rest[..p * p], work }, positive)
            .map_err(|column| self.begin[s] as usize + column)?;
        if self.parent[s] == NONE {
            memory.give(rest);
        } else {
            left.push(Left { supernode: s, values: rest });
        }
        Ok(())
    }
}

/// What a supernode leaves to its parent.
struct Left {
    supernode: usize,
    values: Vec<f64>,
}

/// One factorisation by several threads.
struct Team<'a> {
    fronts: &'a Fronts,
    matrix: &'a [f64],
    positive: bool,
    /// Panels of each unit, until it is done.
    panels: Vec<Mutex<Option<&'a mut [f64]>>>,
    /// What units leave to each unit.
    left: Vec<Mutex<Vec<Left>>>,
    /// Units that each unit waits for.
    waiting: Vec<AtomicUsize>,
    /// The first column that failed so far.
    failed: AtomicUsize,
}

impl<'a> Team<'a> {
    fn run<'s>(&'s self, scope: &rayon::Scope<'s>, unit: usize) {
        let fronts = self.fronts;
        let [first, last] = fronts.units[unit].map(|s| s as usize);
        let lock = |mutex: &Mutex<Vec<Left>>| std::mem::take(&mut *mutex.lock().unwrap_or_else(|e| e.into_inner()));
        let Some(panels) = self.panels[unit].lock().unwrap_or_else(|e| e.into_inner()).take() else { return };
        let mut left = lock(&self.left[unit]);
        left.sort_unstable_by_key(|left| left.supernode);
        let mut memory = fronts.borrow();
        let start = fronts.panel[first];
        for s in first..=last {
            let panel = &mut panels[fronts.panel[s] - start..fronts.panel[s + 1] - start];
            if let Err(column) = fronts.front(s, self.matrix, panel, &mut left, &mut memory, self.positive) {
                // No ancestor is factorised, so that the first of all that fail is found by whatever thread.
                self.failed.fetch_min(column, Ordering::Relaxed);
                return;
            }
        }
        fronts.memory.lock().unwrap_or_else(|e| e.into_inner()).push(memory);
        let Some(mine) = left.pop() else { return };
        let parent = fronts.units.partition_point(|[_, end]| *end < fronts.parent[last]);
        self.left[parent].lock().unwrap_or_else(|e| e.into_inner()).push(mine);
        if self.waiting[parent].fetch_sub(1, Ordering::AcqRel) == 1 {
            scope.spawn(move |scope| self.run(scope, parent));
        }
    }
}

/// Entries of the matrix by supernode: where each supernode's begin, entry of the matrix, and place in the panel.
fn sort_entries<'a>(
    pattern: &Pattern,
    inverse: Option<&[u32]>,
    supernode_of: &[u32],
    begin: &[u32],
    pattern_of: impl Fn(usize) -> &'a [u32],
) -> (Vec<usize>, Vec<u32>, Vec<u32>) {
    let place = |unknown: u32| inverse.map_or(unknown, |inverse| inverse[unknown as usize]);
    let column_of = |j: usize, row: u32| {
        let (a, b) = (place(j as u32), place(row));
        (a.min(b), a.max(b))
    };
    let each = |visit: &mut dyn FnMut(usize, u32, u32)| {
        for j in 0..pattern.len() {
            for k in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
                let (column, row) = column_of(j, pattern.row[k]);
                visit(k, column, row);
            }
        }
    };
    let mut entries = vec![0usize; begin.len()];
    each(&mut |_, column, _| entries[supernode_of[column as usize] as usize + 1] += 1);
    for s in 1..entries.len() {
        entries[s] += entries[s - 1];
    }
    let (mut from, mut to) = (vec![0u32; pattern.row.len()], vec![0u32; pattern.row.len()]);
    let mut next = entries.clone();
    each(&mut |k, column, row| {
        let s = supernode_of[column as usize] as usize;
        let below = pattern_of(s);
        let (first, end) = (begin[s], begin[s + 1]);
        let (c, r) = (end - first, (end - first) as usize + below.len());
        let local = if row < end { row - first } else { c + below.partition_point(|b| *b < row) as u32 };
        from[next[s]] = k as u32;
        to[next[s]] = (column - first) * r as u32 + local;
        next[s] += 1;
    });
    (entries, from, to)
}
