//! Rest positions: Newton's method on the energy, with a line search.
//!
//! The matrix is stored in envelope form, with the particles in the order of their x. A strip along
//! x of `r` rows and `c` columns takes `O(r³ c)` operations per iteration.

use drape_model::{BlockSink, Effect, Mat3, System, Tangent, Vec3};

/// The result of a search for a rest position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Greatest conservative force on a free particle over the greatest weight of a particle, as
    /// [`residual`] computes it.
    pub residual: f64,
    /// Number of iterations.
    pub iterations: usize,
}

/// Scalar product in four sums side by side, which a processor adds at once.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, rest_a) = a.as_chunks::<4>();
    let (b, rest_b) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// The lower half of a symmetric matrix: each row from its first entry to the diagonal.
#[derive(Clone, Debug)]
struct Envelope {
    first: Vec<usize>,
    rows: Vec<Vec<f64>>,
}

impl Envelope {
    /// The pattern of the effects between particles with these first rows.
    fn new(system: &System, rows: &[Option<usize>], size: usize) -> Self {
        let mut first: Vec<usize> = (0..size).map(|row| row - row % 3).collect();
        for effect in elastic(system) {
            effect.visit_pairs(&mut |i, j| {
                if let (Some(a), Some(b)) = (rows[i], rows[j]) {
                    for row in a.max(b)..a.max(b) + 3 {
                        first[row] = first[row].min(a.min(b));
                    }
                }
            });
        }
        let rows = first.iter().enumerate().map(|(row, first)| vec![0.0; row + 1 - first]);
        Self { rows: rows.collect(), first }
    }

    fn clear(&mut self) {
        self.rows.iter_mut().for_each(|row| row.fill(0.0));
    }

    fn mean_of_diagonal(&self) -> f64 {
        let sum: f64 = self.rows.iter().filter_map(|row| row.last()).map(|d| d.abs()).sum();
        sum / self.rows.len().max(1) as f64
    }

    fn shift(&mut self, by: f64) {
        self.rows.iter_mut().filter_map(|row| row.last_mut()).for_each(|d| *d += by);
    }

    /// Cholesky's factor in place; `false` if the matrix is not positive definite.
    fn factor(&mut self) -> bool {
        for i in 0..self.rows.len() {
            let (before, rest) = self.rows.split_at_mut(i);
            let (row, start) = (&mut rest[0], self.first[i]);
            for j in start..i {
                let (other, from) = (&before[j], self.first[j]);
                let low = start.max(from);
                let sum = dot(&row[low - start..j - start], &other[low - from..j - from]);
                row[j - start] = (row[j - start] - sum) / other[j - from];
            }
            let square = dot(&row[..i - start], &row[..i - start]);
            let pivot = row[i - start] - square;
            if pivot.is_nan() || pivot <= 1e-14 * row[i - start].abs() {
                return false;
            }
            row[i - start] = pivot.sqrt();
        }
        true
    }

    /// Solves with the factor.
    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = right.to_vec();
        for i in 0..x.len() {
            let (row, start) = (&self.rows[i], self.first[i]);
            let sum: f64 = row[..i - start].iter().zip(&x[start..i]).map(|(a, b)| a * b).sum();
            x[i] = (x[i] - sum) / row[i - start];
        }
        for i in (0..x.len()).rev() {
            let (row, start) = (&self.rows[i], self.first[i]);
            x[i] /= row[i - start];
            let value = x[i];
            for (x, a) in x[start..i].iter_mut().zip(row) {
                *x -= a * value;
            }
        }
        x
    }
}

/// Blocks of the free particles.
struct Sink<'a> {
    matrix: &'a mut Envelope,
    /// First row of each particle; none if it is pinned.
    rows: &'a [Option<usize>],
}

impl Sink<'_> {
    fn add(&mut self, i: usize, j: usize, block: &Mat3, sign: f64) {
        let (Some(row), Some(column)) = (self.rows[i], self.rows[j]) else { return };
        for a in 0..3 {
            for b in 0..3 {
                if column + b <= row + a {
                    let start = self.matrix.first[row + a];
                    self.matrix.rows[row + a][column + b - start] += sign * block[(a, b)];
                }
            }
        }
    }
}

impl BlockSink for Sink<'_> {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_general_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        let turned = block.transpose();
        self.add(i, i, block, 1.0);
        self.add(j, j, &turned, 1.0);
        self.add(i, j, block, -1.0);
        self.add(j, i, &turned, -1.0);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.add(i, i, block, 1.0);
    }
}

/// Effects with a stiffness.
fn elastic(system: &System) -> impl Iterator<Item = &dyn Effect> {
    system.effects().filter(|effect| effect.has_jacobian() && !effect.is_drag())
}

fn forces(system: &System, x: &[Vec3]) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); x.len()];
    for effect in system.effects().filter(|effect| !effect.is_drag()) {
        effect.add_force(system.mass(), x, &mut out);
    }
    system.clear_pinned(&mut out);
    out
}

fn energy(system: &System, x: &[Vec3]) -> f64 {
    let effects = system.effects().filter(|effect| !effect.is_drag());
    effects.map(|effect| effect.energy(system.mass(), x)).sum()
}

/// First row of each free particle in a matrix, in the order of their x; and the number of rows.
fn rows(system: &System, x: &[Vec3]) -> (Vec<Option<usize>>, usize) {
    let mut order: Vec<usize> = (0..x.len()).filter(|&i| !system.pinned()[i]).collect();
    order.sort_by(|&a, &b| x[a].x.total_cmp(&x[b].x).then(x[a].y.total_cmp(&x[b].y)));
    let mut rows = vec![None; x.len()];
    order.iter().enumerate().for_each(|(place, &i)| rows[i] = Some(3 * place));
    (rows, 3 * order.len())
}

/// Whether the exact tangent of the conservative forces at `x` is positive definite. If so, a rest
/// position is a minimum of the energy. If not, it is a saddle, from which the cloth buckles.
/// Obstacles are ignored.
pub fn is_minimum(system: &System, x: &[Vec3]) -> bool {
    let (rows, size) = rows(system, x);
    let mut matrix = Envelope::new(system, &rows, size);
    for effect in elastic(system) {
        effect.add_stiffness(
            x,
            1.0,
            Tangent::Exact,
            &mut Sink { matrix: &mut matrix, rows: &rows },
        );
    }
    matrix.factor()
}

/// Greatest conservative force on a free particle at `x` over the greatest weight of a particle at
/// 9.81 m/s². Obstacles are ignored.
pub fn residual(system: &System, x: &[Vec3]) -> f64 {
    greatest(&forces(system, x)) / scale(system)
}

/// Greatest weight of a particle at 9.81 m/s², N.
fn scale(system: &System) -> f64 {
    9.81 * system.mass().iter().fold(0.0, |most: f64, mass| most.max(*mass))
}

/// Greatest length; NaN, which no comparison would find, counts as infinite.
fn greatest(forces: &[Vec3]) -> f64 {
    let length = |f: &Vec3| Some(f.norm()).filter(|norm| !norm.is_nan()).unwrap_or(f64::INFINITY);
    forces.iter().map(length).fold(0.0, f64::max)
}

/// Moves `x` to positions at which all conservative forces on the free particles balance. It stops
/// when the greatest force is below `tolerance` times the greatest weight of a particle at
/// 9.81 m/s², or after `most` iterations. Obstacles are ignored.
///
/// The matrix is the exact tangent. If that is not positive definite, it is the projected tangent
/// with a growing diagonal.
pub fn rest(system: &System, x: &mut [Vec3], tolerance: f64, most: usize) -> Rest {
    let (rows, size) = rows(system, x);
    let mut matrix = Envelope::new(system, &rows, size);
    let scale = scale(system);
    let residual = |force: &[Vec3]| greatest(force) / scale;
    let mut force = forces(system, x);
    for iteration in 0..most {
        let found = residual(&force);
        if found < tolerance {
            return Rest { residual: found, iterations: iteration };
        }
        let mut right = vec![0.0; size];
        for (row, force) in rows.iter().zip(&force).filter_map(|(row, f)| Some(((*row)?, f))) {
            right[row..row + 3].copy_from_slice(force.as_slice());
        }
        let Some(step) = direction(system, x, &rows, &mut matrix, &right) else { break };
        let before = energy(system, x);
        let slope: f64 = right.iter().zip(&step).map(|(a, b)| a * b).sum();
        let start = x.to_vec();
        let mut length = 1.0;
        loop {
            for (i, row) in rows.iter().enumerate() {
                if let Some(row) = row {
                    x[i] = start[i] + Vec3::from_row_slice(&step[*row..*row + 3]) * length;
                }
            }
            let descent = before - energy(system, x);
            // Near the end the energy is flat to round-off, and the force decides.
            let next = forces(system, x);
            let round_off = 1e-12 * before.abs();
            if descent >= 1e-4 * length * slope - round_off
                && (descent > round_off || residual(&next) < found)
            {
                force = next;
                break;
            }
            length *= 0.5;
            if length < 1e-10 {
                x.copy_from_slice(&start);
                return Rest { residual: found, iterations: iteration };
            }
        }
    }
    Rest { residual: residual(&force), iterations: most }
}

fn direction(
    system: &System,
    x: &[Vec3],
    rows: &[Option<usize>],
    matrix: &mut Envelope,
    right: &[f64],
) -> Option<Vec<f64>> {
    for tangent in [Tangent::Exact, Tangent::Projected] {
        matrix.clear();
        for effect in elastic(system) {
            effect.add_stiffness(x, 1.0, tangent, &mut Sink { matrix: &mut *matrix, rows });
        }
        let mean = matrix.mean_of_diagonal();
        let shifts: &[f64] = match tangent {
            Tangent::Exact => &[0.0],
            Tangent::Projected => &[1e-10, 1e-8, 1e-6, 1e-4, 1e-2],
        };
        for shift in shifts {
            let mut factor = matrix.clone();
            factor.shift(shift * mean);
            if factor.factor() {
                return Some(factor.solve(right));
            }
        }
    }
    None
}
