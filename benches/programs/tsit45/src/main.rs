//! drape's adaptive Runge-Kutta methods, DOP853 and Tsit5, beside `tsit45` of the library `diffsol`:
//! seconds and error on the same forces, for tolerances from coarse to fine, by turns, the least of
//! five runs.
//!
//!     cargo run --release --manifest-path benches/programs/tsit45/Cargo.toml

use diffsol::{NalgebraMat, OdeBuilder, OdeSolverMethod};
use drape_model::{Level, State, System, Vec3};
use drape_oracle::adaptive::{AdaptiveSettings, Pair, adaptive};
use drape_oracle::reference::reference;
use std::cell::RefCell;
use std::error::Error;
use std::time::Instant;

const SCENES: [&str; 2] = ["hanging-textile-sheared-1e4", "hanging-textile-sheared-1e6"];
const SPAN_S: f64 = 0.25;
const TOLERANCES: [f64; 6] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10];
const ROUNDS: usize = 5;

/// A run: seconds, evaluations of the forces, and the largest distance of a particle from its true
/// place, m.
struct Run {
    seconds: f64,
    evaluations: u64,
    error: f64,
}

fn error(x: &[Vec3], exact: &State) -> f64 {
    x.iter().zip(&exact.x).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn ours(
    pair: Pair,
    system: &System,
    start: &State,
    exact: &State,
    tolerance: f64,
) -> Result<Run, Box<dyn Error>> {
    let settings = AdaptiveSettings { tolerance, ..AdaptiveSettings::default() };
    let begin = Instant::now();
    let run = adaptive(pair, system, start, SPAN_S, settings)?;
    let seconds = begin.elapsed().as_secs_f64();
    Ok(Run { seconds, evaluations: run.evaluations, error: error(&run.state.x, exact) })
}

fn tsit45(
    system: &System,
    start: &State,
    exact: &State,
    tolerance: f64,
) -> Result<Run, Box<dyn Error>> {
    let n = start.x.len();
    let zeros = || vec![Vec3::zeros(); n];
    let scratch = RefCell::new((zeros(), zeros(), zeros(), 0_u64));
    let begin = Instant::now();
    let rhs = |y: &[f64], _p: &[f64], t: f64, dy: &mut [f64]| {
        let (x, v, force, evaluations) = &mut *scratch.borrow_mut();
        *evaluations += 1;
        let (positions, velocities) = y.split_at(3 * n);
        x.iter_mut().zip(positions.chunks_exact(3)).for_each(|(to, from)| to.copy_from_slice(from));
        v.iter_mut()
            .zip(velocities.chunks_exact(3))
            .for_each(|(to, from)| to.copy_from_slice(from));
        system.forces(Level { t, x, v }, force);
        let (dx, dv) = dy.split_at_mut(3 * n);
        for i in 0..n {
            let is_free = if system.pinned()[i] { 0.0 } else { 1.0 };
            let acceleration = force[i] * (is_free / system.mass()[i]);
            dx[3 * i..3 * i + 3].copy_from_slice((v[i] * is_free).as_slice());
            dv[3 * i..3 * i + 3].copy_from_slice(acceleration.as_slice());
        }
    };
    let init = |_p: &[f64], _t: f64, y: &mut [f64]| {
        let numbers = start.x.iter().chain(&start.v).flat_map(|a| a.iter());
        y.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
    };
    let problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(tolerance)
        .atol([tolerance])
        .rhs(rhs)
        .init(init, 6 * n)
        .build()?;
    let mut solver = problem.tsit45()?;
    solver.set_stop_time(SPAN_S)?;
    while solver.step()? != diffsol::OdeSolverStopReason::TstopReached {}
    let y = solver.state().y.clone();
    let seconds = begin.elapsed().as_secs_f64();
    let x: Vec<Vec3> = (0..n).map(|i| Vec3::new(y[3 * i], y[3 * i + 1], y[3 * i + 2])).collect();
    let evaluations = scratch.borrow().3;
    Ok(Run { seconds, evaluations, error: error(&x, exact) })
}

/// Seconds for an error, by interpolation of the logarithms; `None` outside the runs.
fn seconds_for(runs: &[Run], error: f64) -> Option<f64> {
    runs.windows(2).find_map(|pair| {
        let (a, b) = (&pair[0], &pair[1]);
        let share = (a.error / error).ln() / (a.error / b.error).ln();
        (0.0..=1.0).contains(&share).then(|| a.seconds * (b.seconds / a.seconds).powf(share))
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    type Solve = fn(&System, &State, &State, f64) -> Result<Run, Box<dyn Error>>;
    let solvers: [(&str, Solve); 3] = [
        ("dop853", |system, start, exact, tol| ours(Pair::Dop853, system, start, exact, tol)),
        ("tsit5", |system, start, exact, tol| ours(Pair::Tsit5, system, start, exact, tol)),
        ("diffsol", tsit45),
    ];
    for name in SCENES {
        let scene = drape_model::load(name)?;
        let (system, start) = scene.spec().build()?;
        let exact = reference(&system, &start, &[SPAN_S], AdaptiveSettings::default())?;
        let exact = &exact.states[0];
        println!("{name}: {} particles, {SPAN_S} s", start.x.len());
        let mut all: [Vec<Run>; 3] = Default::default();
        for tolerance in TOLERANCES {
            let mut best: [Option<Run>; 3] = Default::default();
            for _ in 0..ROUNDS {
                for ((_, solve), best) in solvers.iter().zip(&mut best) {
                    let run = solve(&system, &start, exact, tolerance)?;
                    if best.as_ref().is_none_or(|best| run.seconds < best.seconds) {
                        *best = Some(run);
                    }
                }
            }
            for (((id, _), best), all) in solvers.iter().zip(best).zip(&mut all) {
                let Some(run) = best else { continue };
                let Run { seconds, evaluations, error } = &run;
                println!(
                    "  {id} at {tolerance:e}: {:.3} ms, {evaluations} evaluations, error {error:.2e} m",
                    1e3 * seconds
                );
                all.push(run);
            }
        }
        for error in [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11] {
            let Some(other) = seconds_for(&all[2], error) else { continue };
            for ((id, _), runs) in solvers.iter().zip(&all[..2]) {
                if let Some(ours) = seconds_for(runs, error) {
                    println!(
                        "  at {error:e} m: diffsol takes {:.2} times as long as {id}",
                        other / ours
                    );
                }
            }
        }
    }
    Ok(())
}
