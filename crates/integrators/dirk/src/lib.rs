//! Diagonally implicit Runge–Kutta methods: TR-BDF2 and four others, of order 2 to 4, all L-stable.
//!
//! builds-on: explicit Euler → backward Euler → **DIRK** → Rosenbrock, implicit-explicit
//! Runge–Kutta
//!
//! # What it is
//!
//! A step of a Runge–Kutta method has stages inside the step. If a stage depends only on itself and
//! on earlier stages, it is a step of backward Euler from another start, with the same solver. Two
//! such solves give order 2 and damp stiff vibrations as backward Euler does. Prefer TR-BDF2, the
//! default, to backward Euler. Take `esdirk3` or `sdirk4` for errors below 1e-4 where the springs
//! are damped.
//!
//! # The mathematics
//!
//! For `y' = F(y)` with `y = (x, v)`, coefficients `a_ij`, and the same `a_ii = γ` in each implicit
//! stage, so that one matrix serves all:
//!
//! ```text
//! w₁ = v_n,  a₁ = M⁻¹f(x_n, v_n)                          if the first stage is explicit   (1)
//! X* = x_n + h Σ_{j<i} a_ij w_j          V* = v_n + h Σ_{j<i} a_ij a_j                     (2)
//! M (w_i − V*) = τ f(X* + τ w_i, w_i)          τ = γh                                      (3)
//! a_i = (w_i − V*)/τ                                                                       (4)
//! x_{n+1} = X* + τ w_s          v_{n+1} = w_s                                              (5)
//! ```
//!
//! (5) holds because the last row of `a` is `b`: the last stage is the new level.
//!
//! | `tableau` | order | implicit stages | stage order | source |
//! |---|---|---|---|---|
//! | `tr-bdf2` | 2 | 2 | 2 | Bank et al. 1985; Hosea and Shampine 1996 |
//! | `sdirk2` | 2 | 2 | 1 | Alexander 1977 |
//! | `sdirk3` | 3 | 3 | 1 | Alexander 1977 |
//! | `esdirk3` | 3 | 3 | 2 | Kværnø 2004 |
//! | `sdirk4` | 4 | 5 | 1 | Hairer and Wanner, table 6.5 |
//!
//! * **The derivative of a stage** is (4), never a new evaluation of the force. An evaluation would
//!   multiply the residual of the solve by `h²k/m`. For the same reason (1) takes `a_s` of the last
//!   step. After a restart or a change of the system it evaluates the force. Where impacts or led
//!   pins change velocities, it adds the change of the damping force.
//! * **Order and stability.** L-stable on linear problems. `tr-bdf2` and `sdirk2` share one
//!   stability function, `sdirk3` and `esdirk3` another. The *stage order* decides where stiff
//!   springs turn, see below.
//! * **Conservation.** Momentum, to round-off with `solver=cholesky` and to the tolerance of the
//!   solve with the default solver: the remaining residual is a momentum. Angular momentum is
//!   conserved only to the order of the method.
//! * **Contact.** Contacts are found once per step. Along its normals a particle in contact has the
//!   same velocity in every stage, namely the one that leads `x_{n+1}` to the surface. Each stage
//!   finds the impulses of contacts and friction anew, so `a_i` omits them. With them the
//!   coefficients, some of which exceed 1, would reverse an impact. Constant sliding is exact.
//! * **Damping.** Full damping keeps the order. Projected damping and air take directions and
//!   coefficients at a prediction within `O(h²)`; at order 3 and 4 each stage is solved a second
//!   time with those of the first solution.
//! * **Settings.** `residual=0` stands for 1e-9, 1e-11, 1e-13 at order 2, 3, 4. `jacobian`,
//!   `solver` as in backward Euler; `jacobian=saved` keeps one factor over stages and steps. One
//!   Newton iteration by conjugate gradients a stage
//!   (`max_iterations=1,solver=cg,cg_tolerance=0.01`) keeps order 2 with `tr-bdf2` and `sdirk2`;
//!   such a step reports `IterationLimit`. `tolerance` puts both under [step size
//!   control](drape_integrator::Adaptive).
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h`, `τ` | `h`, `tau` | s | |
//! | `w_i`, `a_i` | `w`, `a` | m/s, m/s² | `n` × 3 a stage |
//! | `X*`, `V*` | `x_star`, `v_star` | m, m/s | `n` × 3 |
//!
//! # Where it failed here, and what it cost
//!
//! *The hanging sheet.* 400 particles, shear springs of 0.1 k, d/m = 40/s, 0.3 s. Error of the
//! positions over the way, against a reference of order 8:
//!
//! | `tableau` | 1e4, h = 0.01 | 0.0025 | 1e6, h = 0.01 | 0.0025 | Newton a step (1e6, 0.01) |
//! |---|---|---|---|---|---|
//! | backward Euler | 2.79e-2 | 7.06e-3 | 2.13e-2 | 5.75e-3 | 3.0 |
//! | `tr-bdf2` | 1.04e-4 | 6.53e-6 | 3.29e-4 | 2.04e-5 | 4.1 |
//! | `sdirk2` | 7.41e-5 | 4.63e-6 | 3.75e-4 | 2.10e-5 | 4.8 |
//! | `sdirk3` | 7.98e-6 | 1.34e-7 | 3.57e-4 | 1.25e-5 | 8.0 |
//! | `esdirk3` | 6.94e-6 | 1.15e-7 | 6.23e-5 | 1.08e-6 | 6.9 |
//! | `sdirk4` | 1.67e-7 | 7.3e-10 | 3.18e-5 | 1.87e-7 | 10.6 |
//!
//! * At k/m = 1e6 TR-BDF2 takes 1.4 times the iterations of backward Euler and is 65 times as
//!   accurate. At 1e8 the errors are 3.2e-4 and 1.9e-2.
//! * At 1e6 and h = 0.01 s, where the springs vibrate within a step, `sdirk3` is no better than the
//!   methods of order 2: its stage order is 1.
//! * `jacobian=saved` takes 27 factorisations for 30 steps at 1e6, 68 at 1e8, and 5 with heavy
//!   damping (d/m = 1000/s at 1e6), where `solver=cholesky` takes 123, 185 and 120. The time is
//!   half.
//! * One CG solve per stage: 3.36e-4 for 26 CG iterations per step at 1e6, 0.01 s; 8.7e-5 for 14 at
//!   0.005 s. That is the error of full Newton at a seventh of its time.
//! * [`safeguard=work`](drape_integrator::Safeguard) iterates again in a stage whose residual adds
//!   energy. On the sheet of 20 × 20 particles in the docs of `drape-multistep`, over 5 s with one
//!   step a frame, it needs 2.0 iterations per stage and gains nothing; one iteration a stage gains
//!   260 J.
//! * Over 2 s at h = 0.01 s, one CG solve per stage never raises the energy: not at k/m = 1e4, 1e6
//!   and 1e8 with d/m = 40/s (120 CG iterations per step at 1e8), not at 1e6 without damping.
//!   Undamped at h = 0.0025 s it rises by 2e-4 J once, of 4 J. Midpoint and generalized-α with one
//!   solve gain energy without bound in two of these four cases.
//!
//! *A stiff spring that turns.* Two undamped particles, `h²κ = 100`, 2 rad in 100 steps; angular
//! momentum after over before:
//!
//! | `tr-bdf2` | `sdirk2` | `sdirk3` | `esdirk3` | `sdirk4` |
//! |---|---|---|---|---|
//! | 0.99999976 | 0.99162 | 0.98978 | 0.99999897 | 1.02100 |
//!
//! `sdirk4` gains. L-stability guarantees nothing here; the schemes with an explicit first stage do
//! better. On the undamped sheet at k/m = 1e6, h = 0.01 s `sdirk4` gains 1.3e5 J in 2 s from 4 J.
//! The other four lose energy: 0.31 J with `tr-bdf2`, 1.13 J with backward Euler.
//!
//! # References
//!
//! R. Bank et al., *Transient simulation of silicon devices and circuits*, IEEE Trans. ED 32
//! (1985), doi 10.1109/T-ED.1985.22232. M. Hosea, L. Shampine, *Analysis and implementation of
//! TR-BDF2*, Appl. Numer. Math. 20 (1996), doi 10.1016/0168-9274(95)00115-8. R. Alexander,
//! *Diagonally implicit Runge–Kutta methods for stiff O.D.E.'s*, SIAM J. Numer. Anal. 14 (1977),
//! doi 10.1137/0714068. A. Kværnø, *Singly diagonally implicit Runge–Kutta methods with an explicit
//! first stage*, BIT 44 (2004), doi 10.1023/B:BITN.0000046811.70614.38. E. Hairer, G. Wanner,
//! *Solving Ordinary Differential Equations II* (1996), doi 10.1007/978-3-642-05221-7. M. Hauth, O.
//! Etzmuß, *A high performance solver for the animation of deformable objects using advanced
//! numerical methods*, Computer Graphics Forum 20 (2001), doi 10.1111/1467-8659.00524.

mod settings;
mod step;
mod tableau;
mod workspace;

pub use settings::{DIRK, DirkSettings};
pub use step::{Dirk, REGISTRATION};
pub use tableau::Tableau;
pub use workspace::{Past, Workspace};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
