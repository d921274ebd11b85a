//! IMEX Runge–Kutta: additive Runge–Kutta methods of Ascher, Ruuth and Spiteri (1997) and of
//! Kennedy and Carpenter (2003) on the split of Eberhardt, Etzmuß and Hauth (2000), "EEH".
//!
//! builds-on: IMEX Euler → IMEX of two steps → **IMEX Runge–Kutta**
//!
//! # What it is
//!
//! The force of a spring is a stiff linear part and a remainder of constant size, `f = −L_k x +
//! F2(x)` with `F2_i = +k ℓ û`. IMEX Euler takes the first part implicitly and the second
//! explicitly: a step is one linear system with a constant matrix, but it has order 1 and a stiff
//! sheet stands still. An *additive Runge–Kutta method* keeps the split and the constant matrix. It
//! takes two to five such stages a step, has order 2 to 4, and needs no start and no history.
//!
//! Take it for errors of a few per cent on moderate stiffness (`h²k/m` up to 100) or heavy damping.
//! Take the default `ars222` where energy matters. `ark4` is the most accurate tableau at small
//! steps, and the first to gain energy. None of them follows a very stiff sheet at large steps.
//!
//! # The mathematics
//!
//! With `F` for all explicit forces (the `F2` of the implicit springs, all other springs, angles,
//! gravity, air, the remainder of projected damping) the motion is
//!
//! ```text
//! x' = v      v' = g(x, v) + e(t, x, v)      g = −M⁻¹ (L_k x + L_d v)      e = M⁻¹ F          (1)
//! ```
//!
//! `x' = v` belongs to the implicit part. Two tableaux `a^I` (diagonally implicit) and `a^E`
//! (explicit) share the stages, which are at the times `t_n + c_i h`. Stage `i`, with `τ = γh`, `γ
//! = a^I_ii`:
//!
//! ```text
//! X* = x_n + h Σ_{j<i} a^I_ij v_j      V* = v_n + h Σ_{j<i} (a^I_ij g_j + a^E_ij e_j)         (2)
//! (M + τ² L_k + τ L_d) v_i = M V* − τ L_k X*                      x_i = X* + τ v_i            (3)
//! g_i = (v_i − V*)/τ                       e_i = M⁻¹ F(t_n + c_i h, x_i, v_i)                 (4)
//! x_{n+1} = x_s      v_{n+1} = v_s + h Σ_i (b^E_i − a^E_si) e_i                               (5)
//! ```
//!
//! The first stage is explicit: `x_1 = x_n`, `v_1 = v_n`. All others have the same `γ`, so one
//! scalar matrix and one factor serve all of them, until `h`, the masses, a stiffness, a damping or
//! the pins change. (4) takes `g_i` from the solve, because an evaluation at `x_i` would contain
//! the residual of the solve times the stiffness. (5) holds because the implicit weights of all
//! four tableaux are their last row; `ars222` and `ars443` end at the last stage altogether.
//!
//! | `tableau` | order | implicit stages | sweeps over the springs | stable for `θ_E = r θ_I`, every `θ_I` |
//! |---|---|---|---|---|
//! | `ars222` (default) | 2 | 2 | 4 | −1 ≤ `r` ≤ 0.17 |
//! | `ars443` | 3 | 4 | 8 | −0.49 ≤ `r` ≤ 0.57 |
//! | `ark3` | 3 | 3 | 8 | −1 ≤ `r` ≤ 0.25 |
//! | `ark4` | 4 | 5 | 12 | −0.08 ≤ `r` ≤ 0.05 |
//!
//! * *Order.* The conditions of coupled trees hold to 1e-14 ([`Tableau`]). They need `θ = h²k/m`
//!   below 1: at larger `θ` the observed order falls to between 1 and 2. Air and gusts are
//!   evaluated at the stages and keep the order.
//! * *Stability.* The implicit parts are L-stable. The last column of the table is for explicit
//!   springs beside stiff implicit ones (`r > 0`) and for compressed springs (`r < −1`, beyond
//!   every tableau). Motion across a stretched spring has `−1 < r < 0`, which `ars443` and `ark4`
//!   do not cover.
//! * *Conservation.* Momentum is conserved; angular momentum and energy are not. The stages pull
//!   along different directions, so neither a law of spin nor an energy ledger exists in closed
//!   form.
//! * *Free fall* is exact, and an equilibrium is a fixed point.
//! * *Settings.* `solver=cholesky` (default) solves to round-off, so that every order shows. With
//!   `solver=cg` the tolerance `forcing_term` refers to the change of velocity that the forces at
//!   the start make in `τ`. `implicit=tension` leaves shear and bending springs explicit. For
//!   springs of several slopes the matrix contains the steepest one. Contacts, friction and moving
//!   pins are refused: a stage would need constraints of its own.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `M + τ² L_k + τ L_d` | [`drape_integrator::LaplacianSolver::matrix`] | kg | `n` × `n`, scalar |
//! | `X*`, `x_i` | `position` | m | `n` × 3 |
//! | `V*` | `start` | m/s | `n` × 3 |
//! | `v_i` | `velocity` | m/s | `n` × 3 |
//! | `g_i`, `e_i` | `implicit`, `explicit` of a `Stage` | m/s² | `n` × 3 |
//! | `a^I`, `a^E`, `b^I`, `b^E`, `c` | [`Tableau`] | – | 6 × 6, 6 |
//! | `b^E_i − a^E_si` | [`Tableau::corrections`] | – | 6 |
//!
//! # Where it failed here, and what it cost
//!
//! *Locking, of two kinds.* Across a spring at its rest length `θ_E = −θ_I`, and a step is
//! `[[1, c], [0, g]]` on `(x, hv)`: it keeps the share `g` of the velocity and moves by `c h v`.
//! The exact motion has `c = g = 1`:
//!
//! | | `c(100)` | `c(10⁴)` | `θ c`, `θ → ∞` | `g(100)` | `g`, `θ → ∞` |
//! |---|---|---|---|---|---|
//! | `ars222` | 0.13178 | 0.00150 | 15.07 | 0.19790 | 23.3/θ |
//! | `ars443` | 0.06864 | 0.00070 | 7.00 | 0.04209 | 3.78/θ |
//! | `ark3` | 0.04888 | 0.00049 | 4.86 | 1 | 1 |
//! | `ark4` | 0.27567 | 0.00279 | 27.9 | 1 | 1 |
//!
//! `ars222` and `ars443` lose velocity and displacement, as IMEX Euler does. `ark3` and `ark4` keep
//! the velocity and still do not move: **`x` is no longer the integral of `v`**. Two particles that
//! turn by 2 rad in 1 s at `θ = 100` turn by 0.0978 rad with `ark3`, while their angular momentum
//! is kept to 2e-4. Locking must be measured by displacement, never by energy or momentum.
//!
//! *The hanging sheet*: 20 × 20 particles, shear springs of 0.1 k, d/m = 40/s, 0.3 s. Error of
//! positions over the motion, and at `h` = 0.01 s the height lost by the free edge over that of the
//! exact motion (IMEX Euler at k/m = 1e6: 0.19):
//!
//! | | 1e4: `h` = 0.01 | 0.0025 | 1e6: 0.01 | 0.0025 | fall | 1e8: 0.01 | 0.0025 | fall |
//! |---|---|---|---|---|---|---|---|---|
//! | `ars222` | 8.7e-4 | 5.4e-5 | 1.6e-1 | 1.6e-2 | 0.960 | 9.8e-1 | 8.8e-1 | 0.024 |
//! | `ars443` | 2.6e-4 | 1.4e-5 | 1.3e-1 | 1.5e-2 | 1.012 | 9.9e-1 | 9.0e-1 | 0.016 |
//! | `ark3` | 2.3e-4 | 3.1e-6 | 6.5e-2 | 3.0e-3 | 0.993 | 8.8e-1 | 4.0e-1 | 0.134 |
//! | `ark4` | 1.4e-5 | 7.9e-8 | 9.4e-3 | 3.1e-4 | 1.009 | 6.6e-1 | diverges | 0.413 |
//!
//! Heavy damping, d/m = 1000/s at k/m = 1e6, error:
//!
//! | | `h` = 0.03 | 0.01 | 0.005 |
//! |---|---|---|---|
//! | `ars222` | 3.1e-1 | 6.6e-2 | 1.8e-2 |
//! | `ars443` | 3.3e-1 | 3.4e-2 | 1.4e-2 |
//! | `ark3` | 2.1e-1 | 1.8e-2 | 2.4e-3 |
//! | `ark4` | 9.6e-3 | 1.1e-3 | 1.7e-4 |
//!
//! *Energy* of the same sheet at k/m = 1e6, `h` = 0.01 s, over 2 s: greatest rise above the start,
//! J. The sheet could fall by 3.9 J:
//!
//! | | d/m = 40/s | undamped |
//! |---|---|---|
//! | `ars222` | 0 | 0 |
//! | `ars443` | 4.9e-4 | 2.4e-3 |
//! | `ark3` | 0.73 | 14 |
//! | `ark4` | 2.6e4 | 6.8e4 |
//!
//! So the accuracy of `ark4` after 0.3 s says nothing about 2 s. *Order* on a smooth sheet of 6 × 6
//! particles, last halving of `h`: 2.00, 2.94, 3.05, 3.97.
//!
//! # References
//!
//! B. Eberhardt, O. Etzmuß, M. Hauth, *Implicit-explicit schemes for fast animation with particle
//! systems*, Computer Animation and Simulation 2000 (the split). U. M. Ascher, S. J. Ruuth, R. J.
//! Spiteri, *Implicit-explicit Runge–Kutta methods for time-dependent partial differential
//! equations*, Appl. Numer. Math. 25 (1997), doi 10.1016/S0168-9274(97)00056-1. C. A. Kennedy, M.
//! H. Carpenter, *Additive Runge–Kutta schemes for convection–diffusion–reaction equations*, Appl.
//! Numer. Math. 44 (2003), doi 10.1016/S0168-9274(02)00138-1. E. Boxerman, U. Ascher, *Decomposing
//! cloth*, SCA 2004, use an adaptive split in cloth.

mod settings;
mod stages;
mod step;
mod tableau;

pub use settings::{IMEX_RK, ImexRkSettings};
pub use step::{ImexRk, REGISTRATION};
pub use tableau::{ARK3, ARK4, ARS222, ARS443, Pair, STAGES, Tableau};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];

#[cfg(test)]
mod tests;
