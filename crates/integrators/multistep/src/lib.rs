//! Linear multistep methods: Adams–Bashforth and backward differentiation (BDF) of one to three
//! steps, the methods (1) to (5) of Eberhardt, Etzmuß and Hauth (2000), "EEH".
//!
//! builds-on: explicit Euler → **Adams–Bashforth**; backward Euler → **BDF** → IMEX of two steps
//!
//! # What they are
//!
//! The Euler methods use one level and are of order 1: half the error costs twice the steps. A
//! `k`-step method reuses earlier levels and gets order `k` for the same one force, or one
//! nonlinear system, a step. `steps` is `k`, 2 by default; `steps=1` gives explicit and backward
//! Euler. Take BDF of two steps in place of backward Euler: it costs the same and keeps more
//! motion. Take Adams–Bashforth of three steps for smooth explicit motion. BDF of three steps is
//! for damped cloth and for comparison.
//!
//! # The mathematics
//!
//! ```text
//! Σ_{j=0}^{k} α_j y_{n+j} = h Σ_{j=0}^{k} β_j f_{n+j}                                        (1)
//! y_{n+k} = y_{n+k−1} + h Σ_{j<k} β_j f_{n+j}                explicit Adams                   (2)
//! Σ_{j=0}^{k} α_j y_{n+j} = h β_k f_{n+k}                    backward differentiation         (3)
//! ```
//!
//! For `y = (x, v)`, `f = (v, M⁻¹ f)` Adams–Bashforth is explicit. BDF is a nonlinear system (4).
//! The stage
//!
//! ```text
//! M (v − v*) = τ f(x, v)    x = x* + τ v                                               (4)
//! τ = h β_k/α_k             x* = −Σ_{j<k} α_j x_{n+j}/α_k             v* likewise
//! ```
//!
//! halves its size (section 2.3), and Newton's method (5) solves it, just as it solves backward
//! Euler.
//!
//! * **Coefficients.** [`LinearMultistep`] computes them in each step from the sizes of the last
//!   ones: integrals of the interpolating polynomials for Adams, slopes at the new node for BDF. So
//!   the order survives changes of the step size.
//! * **Means.** Sums over levels have weights of sum 1. They are summed as the present level and
//!   weighted differences to it ([`drape_integrator::History::mean`]): so a particle at rest keeps
//!   its bits.
//! * **Explicit parts** of BDF are the directions of projected damping and forces without a
//!   Jacobian. They are taken at positions `x̂` extrapolated to the new time from `k` levels; at
//!   `x_n` they would cost the order. Newton starts at `v_n`, the extrapolation or the inertial
//!   target, whichever has the lowest potential.
//! * **Start.** At first the past levels are missing. Adams begins with Heun's method (H), of order
//!   2. BDF of two steps begins with backward Euler, whose single error of `h²` does not reduce the
//!   order below 2. BDF of three steps begins with the L-stable Runge–Kutta method of two stages by
//!   Alexander (1977), `γ = 1 − 1/√2`:
//!
//!   ```text
//!   x̃ = x_n + h v_n   ṽ = v_n + h a_n   ã = M⁻¹ f(x̃, ṽ)   ½ (v_n + ṽ)   ½ (a_n + ã)     (H)
//!   τ = γ h   x* = x_n                    v* = v_n                    solution v₁           (A1)
//!   τ = γ h   x* = x_n + (1 − γ) h v₁     v* = v_n + (1 − γ) h a₁     a₁ = (v₁ − v_n)/(γ h) (A2)
//!   ```
//!
//!   Its last stage ends at the new time, so pins and contacts hold there as in any other step.
//!   With a midpoint stage they would hold at the middle, and the end would overshoot them by the
//!   same amount. In its second step, BDF of three steps uses the method of two steps.
//! * **Change.** Step sizes may change by ratios of 1/2 to 2, in BDF of three steps to 1.5. Outside
//!   of these ratios, or if stiffness, damping, masses or pins change, the past is dropped. Sums of
//!   old slopes are stable at any ratio. BDF forgets its errors while every ratio is below `1 + √2`
//!   (two steps, Grigorieff 1983) or about 1.6 (three steps). Steady growth is unstable from the
//!   golden ratio on, and no mixture of ratios tried here is worse; the bounds that Calvo, Grande
//!   and Grigorieff 1990 prove are smaller; both cited from memory.
//! * **Contacts.** Adams treats an impact as a jump of `v_n`, as explicit Euler does, and at the
//!   end of the step it releases contacts that would pull. Its *lead* `Σ β_j v_{n−j} − v_n` has no
//!   part along the normals while a particle stays in contact. BDF constrains its stage so that
//!   `x* + τ v` lies where [`drape_integrator::ContactSet`] wants it. In both, a particle whose
//!   contact begins or ends gets a past of constant acceleration. For Adams it is the acceleration
//!   of all forces. For BDF it is the former acceleration, and along the normals that of the
//!   explicit forces. So the flight after a bounce follows its parabola at once, and an elastic
//!   bounce does not change the energy. If a particle slides off an edge, BDF notices one step
//!   late, and loses a third of the first `h g`.
//!
//! On the oscillator `x'' = −κx − δx'`, `θ = h²κ`, `η = hδ`, the factors of a step are the roots of
//! `ρ² + ηρσ + θσ² = 0` with `ρ(ζ) = Σ α_j ζ^j`, `σ(ζ) = Σ β_j ζ^j`:
//!
//! | | without damping | all damping (`θ = 0`) |
//! |---|---|---|
//! | Adams–Bashforth, 2 steps | grows at every `hω`, by `(hω)⁴/4` a step | stable for `η ≤ 1` |
//! | Adams–Bashforth, 3 steps | stable for `hω < 0.7236` | stable for `η ≤ 6/11` |
//! | BDF, 2 steps | stable always, stiff modes vanish | stable always |
//! | BDF, 3 steps | **grows for `0 < hω < √15/2 = 1.936`**, by 4.56 % a step at worst (`hω = 1.14`) | stable always |
//!
//! BDF of three steps is not A-stable. It needs about 7 % of critical damping, `η > 0.138 √θ`.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `k` | [`Steps`] | – | |
//! | `h` | `h` | s | |
//! | `α_j`, `β_j` | [`LinearMultistep::alpha`], [`LinearMultistep::beta`] | – | `k + 1` |
//! | `τ = h β_k/α_k` | [`LinearMultistep::tau`] | s | |
//! | `−α_j/α_k` | [`LinearMultistep::past_weights`] | – | `k` |
//! | `x*`, `v*` | `mean` | m, m/s | `n` × 3 |
//! | `x̂`, `v̂` | `extrapolated` | m, m/s | `n` × 3 |
//! | `a_n = M⁻¹ f(x_n, v_n)` | `acceleration` | m/s² | `n` × 3 |
//! | `Σ β_j v_{n−j} − v_n` | `lead` | m/s | `n` × 3 |
//! | `ω = h_n/h_{n−1}` | `ratios` | – | |
//!
//! # Where they failed here, and what they cost
//!
//! *Order.* Four particles on six springs, slopes of the errors at 0.5 s with 80 to 640 steps:
//!
//! | | 1 step | 2 steps | 3 steps |
//! |---|---|---|---|
//! | Adams, full damping | 1.04 | 2.01 | 2.96 |
//! | BDF, full damping | 0.97 | 2.02 | 2.95 |
//! | Adams, projected damping | 1.04 | 2.00 | 2.98 |
//! | BDF, projected damping | 0.96 | 2.02 | 2.98 |
//!
//! *The hanging sheet* of 20 × 20 particles, `d/m` = 40 1/s, for 1 s at `h` = 0.01 s (`√θ` from 1
//! to 100). Path of the middle of its free edge, m, and Newton iterations per step of BDF:
//!
//! | `k/m`, 1/s² | 1 step | 2 steps | 3 steps |
//! |---|---|---|---|
//! | 1e4 | 3.321, 2.4 | 3.367, 2.0 | 3.365, 2.0 |
//! | 1e6 | 2.903, 3.6 | 3.033, 2.8 | 3.038, 2.7 |
//! | 1e8 | 2.718, 4.7 | 2.860, 3.8 | 2.862, 3.7 |
//!
//! At 1e4, 3.365 is right. Two steps lose no motion. They cost as much as backward Euler with
//! Newton started at the extrapolation (22), which one step has not: 2.0, 2.9 and 3.9 iterations.
//! Undamped they take more, 3.0, 4.8 and 5.9 against 2.9, 4.1 and 5.1. None of these runs gained
//! energy.
//!
//! *Undamped*, 2 s, BDF of two steps had steps that gained energy (2 of 200 at 1e4; 17, 45, 65 at
//! 1e6, 1e8, 1e10), and its energy never rose above the start. BDF of three steps gained 530 times
//! the weight times 1 m at 1e4, 380 times at 1e6 and 19 times at 1e8. There Newton needed more than
//! its 100 iterations in 36 steps.
//!
//! *Linearised steps.* One Newton iteration by conjugate gradients (Choi and Ko 2002) is
//! `max_iterations=1,solver=cg,cg_tolerance=0.01`. On a stiff sheet it gains energy: it leaves
//! springs stretched that turned in the step, and the work of this residual goes into the motion.
//! `safeguard=work` iterates again only where that work is [too
//! large](drape_integrator::Safeguard). The measure is known already, so a step in which nothing is
//! wrong costs what it cost before. The sheet is a square metre of 0.2 kg/m² held by two corners:
//! 2000 N/m, shear 40 N/m, hinges of 3.3e-6 N m, `c = 1e-5 s · k`, for 5 s with N × N particles and
//! some steps in each frame of 1/60 s. The *gain* is the greatest rise of the energy above its
//! start. The *work* counts force sweeps and twice the products, a step. The *error* is the root of
//! the mean square distance of the particles after 0.3 s, N = 20, from 128 steps a frame. Full
//! Newton is `residual=1e-3,solver=cg,forcing=eisenstat-walker`.
//!
//! | N, steps a frame | gain of one iteration | gain, safeguarded | Newton iterations | work, safeguarded | work, full Newton | error, safeguarded | error, full Newton |
//! |---|---|---|---|---|---|---|---|
//! | 20, 1 | 2900 J | none | 2.5 | 272 | 359 | 7.6e-3 m | 4.7e-3 m |
//! | 20, 2 | 2.9 J | none | 2.1 | 150 | 172 | 3.8e-3 m | 2.4e-3 m |
//! | 20, 4 | 4.9 J | none | 1.8 | 86 | 103 | 1.1e-3 m | 1.0e-3 m |
//! | 20, 8 | 3.5e-4 J | none | 1.04 | 36 | 68 | 3.6e-4 m | 3.6e-4 m |
//! | 50, 1 | | none | 2.8 | 556 | | | |
//! | 50, 2 | 600 J in 1 s | none | 2.4 | 338 | | | |
//! | 50, 4 | | none | 2.1 | 183 | | | |
//! | 50, 8 | | none | 1.9 | 107 | | | |
//!
//! A step still rises above the one before it now and then, by some mJ, as solved steps do: the
//! highest climb above the lowest energy so far was 12 mJ at N = 20 (15 mJ at 50), that of full
//! Newton 11 mJ. Two other rules failed in the same runs at N = 20: to iterate again while the
//! residual had fallen by less than a factor of 5, or the potential by less than 0.9 of what the
//! quadratic model promised. They gained 0.6 to 38 J at 1.0 to 1.5 iterations per step: neither
//! number tells which way the residual pushes. Where the settings also name a loose `residual`,
//! steps that begin below it are not iterated at all.
//!
//! *Adams–Bashforth* follows its table. On the damped sheet at `k/m` = 1e4, two steps hold up to
//! `h` = 3 ms and three up to 1.7 ms. There the damping sets the limit (`8 d/m = 320` 1/s).
//! Undamped over 2 s, three steps hold up to 2.5 ms. Two steps gain 3 % of the weight times 1 m at
//! 1 ms and blow up at 2 ms.
//!
//! Both conserve momentum: Adams to round-off, BDF to the tolerance of its solves, which is
//! round-off with `solver=cholesky`. Neither conserves angular momentum. To try next: a step size
//! from the difference of two orders, which the coefficients allow.

mod coefficients;
mod settings;
mod step;
#[cfg(test)]
mod tests;
mod workspace;

pub use coefficients::{LinearMultistep, MAX_STEPS, extrapolation};
pub use settings::{ADAMS_BASHFORTH2, AdamsBashforthSettings, BDF2, BdfSettings, Steps};
pub use step::{AdamsBashforth, BACKWARD_DIFFERENTIATION, Bdf, EXPLICIT_ADAMS};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] = &[
    ("src/lib.rs", include_str!("lib.rs")),
    ("src/step/adams_bashforth.rs", include_str!("step/adams_bashforth.rs")),
    ("src/step/bdf.rs", include_str!("step/bdf.rs")),
];
