//! Predicts how much of a cloth's motion a method keeps, before it runs.
//!
//! Springs at their rest length do not resist a motion across them. A method whose matrix holds the
//! whole Laplacian `L_k` of its springs resists it all the same. Its sheets fall at the terminal
//! speed `v = a u/h`, where `L_k u = M 1` (the law of the study `locking`). The *lever* is the mean
//! of `u`, weighted by mass, over the particles that hang on a pin by springs. It replaces the
//! sheet by one spring with `k/m = 1/u` that is loaded across itself. The method moves this spring,
//! with the settings and the step of the user. The predicted share of motion is the way of the
//! spring's free end over the way of a free fall.
//!
//! | symbol | meaning |
//! |---|---|
//! | `a` | acceleration by effects that are no springs or angles, such as gravity and wind, m/s² |
//! | `T` | time `√(2 L/a)` of a free fall over the cloth's size `L`, at most that of the run |
//! | `φ` | share of a free motion that the springs allow, from `(M + (T/2)² K) w = M a` |
//!
//! Where `φ` is below a tenth, the springs hold the load, and theory predicts nothing.

use crate::methods::Choice;
use crate::run::{Runner, Simulation};
use drape_integrator::Implicit;
use drape_model::{Effect, GravitySpec, Part, SpringEffect, State, System, TimeSpan, Vec3};
use drape_oracle::scenes::{particles, pin, spring};

/// Less than this share of the motion counts as locked, in every study and command.
pub const LOCKED: f64 = 0.5;
/// Most visits of a spring that the two linear systems may take.
const WORK: f64 = 1e7;
/// Relative residuals to which the two systems are solved.
const LEVER_TOLERANCE: f64 = 1e-4;
const HOLD_TOLERANCE: f64 = 1e-2;
/// Springs that allow less than this share of a free motion hold the load.
const HELD: f64 = 0.1;
/// A prediction needs pins that hold at least this share of the free mass.
const MOST: f64 = 0.5;
/// Most steps of the single spring.
const STEPS: u64 = 1000;
/// Deflection of the single spring at the end of a free fall, in its lengths, and a lever, s². For
/// greater levers the deflection is smaller, so that the spring's pull stays small beside the load.
const DEFLECTION: f64 = 1e-4;
const SHORT_LEVER: f64 = 1e-8;

/// Why theory predicts nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unforeseen {
    /// The method takes no spring with a free end into its matrix.
    NoSprings,
    /// More than half of the mass hangs on no pin.
    Free,
    /// Nothing but springs accelerates the cloth at the start.
    NoLoad,
    /// The springs hold the load at the start.
    Held,
    /// The estimate would take too much work.
    TooLarge,
}

impl std::fmt::Display for Unforeseen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::NoSprings => "no spring moves",
            Self::Free => "no pin holds the cloth, or most of it",
            Self::NoLoad => "neither gravity nor air accelerates the cloth at the start",
            Self::Held => "the springs hold the load at the start",
            Self::TooLarge => "the cloth is too large for the estimate",
        })
    }
}

/// The numbers of a scene that decide how much motion a method keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lever {
    /// Mean of `u`, s²: a sheet falls like one spring with `k/m = 1/u`.
    pub lever: f64,
    /// `T`, s.
    pub time: f64,
    /// `φ`.
    pub freedom: f64,
}

/// A spring: its ends, unit direction, stiffness and secant stiffness (0 if compressed), N/m.
struct Link {
    ends: (usize, usize),
    along: Vec3,
    stiffness: f64,
    secant: f64,
}

fn links(system: &System, x: &[Vec3], implicit: Implicit) -> Vec<Link> {
    let mut links = Vec::new();
    for split in implicit.effects(system).filter_map(Effect::split) {
        let first = links.len();
        split.visit_weights(&mut |i, j, stiffness, _| {
            let along = (x[i] - x[j]).try_normalize(0.0).unwrap_or_default();
            links.push(Link { ends: (i, j), along, stiffness, secant: 0.0 });
        });
        let mut place = first;
        split.visit_secants(x, &mut |_, _, secant| {
            if let Some(link) = links.get_mut(place) {
                link.secant = secant.clamp(0.0, link.stiffness);
            }
            place += 1;
        });
    }
    links
}

/// Which free particles hang on a pin by springs.
fn hanging(system: &System, links: &[Link]) -> Vec<bool> {
    let mut parent: Vec<usize> = (0..system.len()).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    for &Link { ends: (i, j), .. } in links {
        let (a, b) = (root(&mut parent, i), root(&mut parent, j));
        parent[a.max(b)] = a.min(b);
    }
    let mut is_held = vec![false; system.len()];
    for i in 0..system.len() {
        if system.pinned()[i] {
            is_held[root(&mut parent, i)] = true;
        }
    }
    (0..system.len()).map(|i| is_held[root(&mut parent, i)] && !system.pinned()[i]).collect()
}

/// Accelerations by effects that are neither springs nor angles, m/s²; 0 for pinned particles.
pub(crate) fn loads(system: &System, state: &State) -> Vec<Vec3> {
    let mut load = vec![Vec3::zeros(); system.len()];
    let is_load = |e: &&dyn Effect| e.is_drag() || !e.has_jacobian();
    for effect in system.effects().filter(is_load) {
        effect.add_part(Part::All, system.mass(), state.level(), &mut load);
    }
    load.iter_mut().zip(system.mass()).for_each(|(a, m)| *a /= *m);
    system.clear_pinned(&mut load);
    load
}

/// Solves `A w = b` by conjugate gradients from 0 on vectors that are 0 where `b` must be; `None`
/// after `most` products. `multiply` keeps these zeros.
fn solve(
    b: &[Vec3],
    tolerance: f64,
    most: usize,
    multiply: impl Fn(&[Vec3], &mut [Vec3]),
) -> Option<Vec<Vec3>> {
    let dot = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
    let mut w = vec![Vec3::zeros(); b.len()];
    let mut r = b.to_vec();
    let mut p = r.clone();
    let mut q = w.clone();
    let mut rr = dot(&r, &r);
    let target = tolerance * tolerance * rr;
    for _ in 0..most {
        if rr <= target {
            return Some(w);
        }
        multiply(&p, &mut q);
        let curvature = dot(&p, &q);
        if !(curvature > 0.0 && curvature.is_finite()) {
            return None;
        }
        let step = rr / curvature;
        for i in 0..b.len() {
            w[i] += p[i] * step;
            r[i] -= q[i] * step;
        }
        let next = dot(&r, &r);
        for i in 0..b.len() {
            p[i] = r[i] + p[i] * (next / rr);
        }
        rr = next;
    }
    (rr <= target).then_some(w)
}

impl Lever {
    /// The lever of a system in a state, over a run of `duration` seconds, for a method that takes
    /// the springs of `implicit` into its matrix.
    ///
    /// # Errors
    /// [`Unforeseen`], the reason why theory predicts nothing.
    pub fn of(
        system: &System,
        state: &State,
        implicit: Implicit,
        duration: f64,
    ) -> Result<Self, Unforeseen> {
        let mut links = links(system, &state.x, implicit);
        let pinned = system.pinned();
        links.retain(|link| !(pinned[link.ends.0] && pinned[link.ends.1]));
        if links.is_empty() {
            return Err(Unforeseen::NoSprings);
        }
        let mass = system.mass();
        let hanging = hanging(system, &links);
        let total = |is_meant: &dyn Fn(usize) -> bool| {
            mass.iter().enumerate().filter(|(i, _)| is_meant(*i)).map(|(_, m)| m).sum::<f64>()
        };
        let hung = total(&|i| hanging[i]);
        if hung < MOST * total(&|i| !pinned[i]) || hung == 0.0 {
            return Err(Unforeseen::Free);
        }
        let load = loads(system, state);
        let squares = (0..load.len()).filter(|&i| hanging[i]);
        let square: f64 = squares.map(|i| mass[i] * load[i].norm_squared()).sum::<f64>() / hung;
        if square == 0.0 {
            return Err(Unforeseen::NoLoad);
        }
        let size = size(&state.x);
        let time = (2.0 * size / square.sqrt()).sqrt().min(duration);
        let most = (WORK / (links.len() + 4 * system.len()) as f64) as usize;
        // The systems are scaled by √m, so that unequal masses do not slow the iteration down.
        let roots: Vec<f64> =
            (0..mass.len()).map(|i| if hanging[i] { mass[i].sqrt() } else { 0.0 }).collect();
        let scaled =
            |p: &[Vec3], i: usize| if hanging[i] { p[i] / roots[i] } else { Vec3::zeros() };
        let laplacian = |p: &[Vec3], out: &mut [Vec3]| {
            out.fill(Vec3::zeros());
            for link in &links {
                let (i, j) = link.ends;
                let pull = (scaled(p, i) - scaled(p, j)) * link.stiffness;
                out[i] += pull;
                out[j] -= pull;
            }
            for i in 0..out.len() {
                out[i] = if hanging[i] { out[i] / roots[i] } else { Vec3::zeros() };
            }
        };
        let ones: Vec<Vec3> = roots.iter().map(|root| Vec3::new(*root, 0.0, 0.0)).collect();
        let levers = solve(&ones, LEVER_TOLERANCE, most, laplacian).ok_or(Unforeseen::TooLarge)?;
        let lever = levers.iter().zip(&roots).map(|(u, root)| u.x * root).sum::<f64>() / hung;
        let scale = 0.25 * time * time;
        let tangent = |p: &[Vec3], out: &mut [Vec3]| {
            out.fill(Vec3::zeros());
            for link in &links {
                let (i, j) = link.ends;
                let way = scaled(p, i) - scaled(p, j);
                let across = link.stiffness - link.secant;
                let pull = way * link.secant + link.along * (across * link.along.dot(&way));
                out[i] += pull;
                out[j] -= pull;
            }
            for i in 0..out.len() {
                out[i] =
                    if hanging[i] { p[i] + out[i] * (scale / roots[i]) } else { Vec3::zeros() };
            }
        };
        let pushed: Vec<Vec3> = (0..load.len()).map(|i| load[i] * roots[i]).collect();
        let free = solve(&pushed, HOLD_TOLERANCE, most, tangent).ok_or(Unforeseen::TooLarge)?;
        let freedom =
            free.iter().zip(&pushed).map(|(w, a)| w.dot(a)).sum::<f64>() / (square * hung);
        if freedom < HELD {
            return Err(Unforeseen::Held);
        }
        Ok(Self { lever, time, freedom })
    }

    /// The share of the motion that a method keeps with steps of `h` seconds: from 0 to 1. `None`
    /// where the method refuses a spring, or where it blows up.
    pub fn share(&self, choice: &Choice, h: f64) -> Option<f64> {
        let steps = ((self.time / h).round() as u64).clamp(1, STEPS);
        let duration_s = steps as f64 * h;
        let deflection = DEFLECTION * (self.lever / SHORT_LEVER).sqrt().min(1.0);
        let load = 2.0 * deflection / (duration_s * duration_s);
        let ends = [Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0)];
        let mut spec = particles(&[1e-3; 2], &ends, &[Vec3::zeros(); 2]);
        let stiffness = 1e-3 / self.lever;
        spec.springs = vec![spring(SpringEffect::Tension, (0, 1), 1.0, stiffness, 0.0)];
        spec.pins = vec![pin(0)];
        spec.effects.gravity = Some(GravitySpec { m_s2: [0.0, 0.0, -load] });
        let (system, state) = spec.build().ok()?;
        let mut simulation = Simulation { system, state };
        let time = TimeSpan { step_s: h, duration_s };
        let outcome = Runner::new(choice, time).go(&mut simulation).ok()?;
        let fallen = -simulation.state.x[1].z / deflection;
        let is_sound = outcome.divergence.is_none() && fallen.is_finite();
        is_sound.then(|| (fallen.max(0.0) / self.freedom).min(1.0))
    }

    /// The longest step below `h` with which the method keeps half of the motion, s. The step is 1,
    /// 2 or 5 times a power of ten. `None` if no such step above a thousandth of `h` keeps it.
    pub fn step_that_keeps_half(&self, choice: &Choice, h: f64) -> Option<f64> {
        let keeps = |h: &f64| self.share(choice, *h).is_some_and(|share| share >= LOCKED);
        round_steps(h).take_while(|step| *step >= 1e-3 * h).find(keeps)
    }
}

/// Steps below `h` of the form 1, 2 or 5 times a power of ten, longest first.
fn round_steps(h: f64) -> impl Iterator<Item = f64> {
    let decade = h.log10().floor() as i32;
    let steps = (0..).flat_map(move |down: i32| {
        [5.0, 2.0, 1.0].map(|digit: f64| {
            // A parsed number prints with one digit.
            format!("{digit}e{}", decade - down).parse::<f64>().unwrap_or(digit)
        })
    });
    steps.filter(move |step| *step < h * (1.0 - 1e-9))
}

/// Diagonal of the box around all particles, m; 1 m if they are in one place.
pub(crate) fn size(x: &[Vec3]) -> f64 {
    let Some(first) = x.first() else { return 1.0 };
    let (low, high) = x.iter().fold((*first, *first), |(low, high), x| (low.inf(x), high.sup(x)));
    let size = (high - low).norm();
    if size > 0.0 { size } else { 1.0 }
}

/// Which springs the matrix of a choice holds.
pub(crate) fn implicit_springs(choice: &Choice) -> Implicit {
    match choice.settings().get("implicit") {
        Some("tension") => Implicit::Tension,
        _ => Implicit::Springs,
    }
}

/// Methods that keep the motion of stiff sheets, the best known first.
const LIVELY: [&str; 3] = ["imex-updated", "baraff-witkin", "backward-euler"];
/// A method is recommended if theory predicts at least this share of the motion.
const KEEPS: f64 = 0.9;

/// A method that supports a system and keeps its motion at a step of `h` seconds, by theory.
pub(crate) fn lively_method(system: &System, lever: &Lever, h: f64) -> Option<&'static str> {
    LIVELY.into_iter().find(|id| {
        Choice::parse(id, &[]).is_ok_and(|choice| {
            choice.method().check(system).is_ok()
                && lever.share(&choice, h).is_some_and(|share| share >= KEEPS)
        })
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::studies::sheet::Sheet;
    use drape_model::DampingLaw;

    fn sheet(tension: f64, gravity: [f64; 3]) -> (System, State) {
        let (damping, law) = (40.0, DampingLaw::Full);
        let (side, shear, is_pinned) = (20, 0.1 * tension, true);
        let sheet = Sheet { side, tension, shear, damping, law, gravity, is_pinned };
        sheet.spec().unwrap().build().unwrap()
    }

    const DOWN: [f64; 3] = [0.0, 0.0, -9.81];

    fn share(tension: f64, method: &str, h: f64) -> f64 {
        let (system, state) = sheet(tension, DOWN);
        let lever = Lever::of(&system, &state, Implicit::Springs, 1.0).unwrap();
        lever.share(&Choice::parse(method, &[]).unwrap(), h).unwrap()
    }

    /// The shares are near those that the study `locking` measures on this sheet for IMEX Euler.
    #[test]
    fn the_share_is_near_what_the_study_of_locking_measures() {
        let exact = "imex-euler:forcing_term=1e-8,implicit=springs";
        for (tension, measured) in [(1e4, 0.89), (1e6, 0.0805), (1e7, 0.0122)] {
            let ratio = share(tension, exact, 0.01) / measured;
            assert!((0.5..2.0).contains(&ratio), "{tension:e}: {ratio}");
        }
        for method in ["imex-updated", "backward-euler", "baraff-witkin", "xpbd"] {
            assert!(share(1e6, method, 0.01) > 0.9, "{method}");
        }
        assert!(share(1e6, exact, 2e-4) > 0.7);
    }

    #[test]
    fn a_step_that_keeps_half_keeps_half_and_the_next_longer_one_does_not() {
        let (system, state) = sheet(1e6, DOWN);
        let lever = Lever::of(&system, &state, Implicit::Springs, 1.0).unwrap();
        let choice = Choice::parse("imex-euler", &[]).unwrap();
        let step = lever.step_that_keeps_half(&choice, 0.01).unwrap();
        assert!(lever.share(&choice, step).unwrap() >= LOCKED);
        let longer = round_steps(0.01).take_while(|longer| *longer > step).last();
        assert!(longer.is_none_or(|longer| lever.share(&choice, longer).unwrap() < LOCKED));
        assert_eq!(lively_method(&system, &lever, 0.01), Some("imex-updated"));
    }

    #[test]
    fn steps_are_round_and_fall() {
        let steps: Vec<_> = round_steps(0.01).take(4).collect();
        assert_eq!(steps, [0.005, 0.002, 0.001, 0.0005]);
        assert_eq!(round_steps(1.0 / 60.0).next(), Some(0.01));
    }

    #[test]
    fn nothing_is_expected_where_springs_hold_the_load_or_nothing_loads_them() {
        // Gravity lies in the plane of the sheet and points from the pinned row to the last.
        let (_, state) = sheet(1e8, DOWN);
        let down = (state.x[19 * 20] - state.x[0]) * 9.81;
        let (system, state) = sheet(1e8, down.into());
        let of = |system: &System| Lever::of(system, &state, Implicit::Springs, 1.0);
        assert_eq!(of(&system), Err(Unforeseen::Held));
        assert_eq!(of(&sheet(1e8, [0.0; 3]).0), Err(Unforeseen::NoLoad));
        let mut free = sheet(1e8, DOWN).0;
        for pin in free.pins().to_vec() {
            assert!(free.set_pinned(pin as usize, false));
        }
        assert_eq!(of(&free), Err(Unforeseen::Free));
    }

    /// Along a spring the load moves freely but for `¼ t² k/m`.
    #[test]
    fn the_freedom_of_a_load_along_a_spring_follows_from_its_frequency() {
        let mut spec = particles(&[1.0; 2], &[Vec3::zeros(), -Vec3::z()], &[Vec3::zeros(); 2]);
        spec.springs = vec![spring(SpringEffect::Tension, (0, 1), 1.0, 400.0, 0.0)];
        spec.pins = vec![pin(0)];
        spec.effects.gravity = Some(GravitySpec { m_s2: DOWN });
        let (system, state) = spec.build().unwrap();
        let lever = Lever::of(&system, &state, Implicit::Springs, 0.1).unwrap();
        assert_eq!(lever.time, 0.1);
        assert!((lever.freedom - 0.5).abs() < 1e-12, "{lever:?}");
        assert!((lever.lever - 1.0 / 400.0).abs() < 1e-12, "{lever:?}");
    }
}
