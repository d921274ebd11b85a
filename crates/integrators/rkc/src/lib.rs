//! Runge–Kutta–Chebyshev (Sommeijer, Shampine and Verwer 1998): an explicit method for heavy
//! damping.
//!
//! builds-on: explicit Euler → leapfrog → **Runge–Kutta–Chebyshev**
//!
//! # What it is
//!
//! Most Runge–Kutta methods spend their stages on a high order. This method spends them on
//! stability: with `s` stages its stability region reaches `0.65 (s² − 1)` along the negative real
//! axis, where heavily damped modes lie, and its order stays 2. Take it for heavy damping and small
//! errors: it needs no matrix. Do not take it for light damping: along the imaginary axis, where
//! vibrations lie, more stages reach no further.
//!
//! # The mathematics
//!
//! The unknown is `y = (x, v)`, `y' = F(t, y) = (v, M⁻¹ f(t, x, v))`. With Chebyshev polynomials
//! `T_j` and `ε = 2/13`:
//!
//! ```text
//! w₀ = 1 + ε/s²      w₁ = T_s'(w₀)/T_s''(w₀)                                            (R1)
//! b_j = T_j''(w₀)/T_j'(w₀)²,  b₀ = b₁ = b₂      a_j = 1 − b_j T_j(w₀)                   (R2)
//! y₁ = y_n + μ̃₁ h F₀      μ̃₁ = b₁ w₁                                                    (R3)
//! y_j = (1 − μ_j − ν_j) y_n + μ_j y_{j−1} + ν_j y_{j−2} + μ̃_j h F_{j−1} + γ̃_j h F₀      (R4)
//! μ_j = 2 b_j w₀/b_{j−1}   ν_j = −b_j/b_{j−2}   μ̃_j = 2 b_j w₁/b_{j−1}   γ̃_j = −a_{j−1} μ̃_j
//! P_s(z) = a_s + b_s T_s(w₀ + w₁ z)                                                     (R5)
//! ϱ = safety · max(δ, √λ)      s = ⌈√(1 + 1.54 h ϱ)⌉, at least 2                        (R6)
//! ```
//!
//! `y_s` is the new state, (R5) the factor of a mode with the eigenvalue `z/h`. The code keeps
//! `y_j − y_n` in place of `y_j`, so `y_n` drops out of (R4).
//!
//! **The limit that (R6) hides.** A vibration with the stiffness `κ` and the damping ratio
//! `ζ = δ/(2√κ) < 1` is stable for `h√κ` up to a radius that hardly depends on `s`:
//!
//! | `ζ` | 0.9 | 0.7 | 0.5 | 0.3 | 0.1 |
//! |---|---|---|---|---|---|
//! | radius, `s = 6` | 4.24 | 3.50 | 2.99 | 2.39 | 1.52 |
//! | radius, `s ≥ 20` | 4.7 | 3.78 | 3.17 | 2.53 | 1.6 |
//!
//! If the damping of springs is proportional to their stiffness, a sheet has modes of all damping
//! ratios from nearly 0 up. So the step is limited by `h ≤ 2.34 d/k` with six stages, and by
//! `h ≤ 2.58 d/k` with any number. Without damping no step is stable: `|P_s(i)|` is 1.062, 1.040
//! and 1.035 for `s` = 3, 6 and 20.
//!
//! With `step=auto` the method therefore divides a step. It tests 64 modes, `κ` from `λ/1000` to
//! `λ` in geometric progression and `δ` in proportion, and takes more substeps while one of these
//! modes is unstable.
//!
//! * **Order 2**; the damping may be full or projected, and drag may depend on the speed. Forces
//!   belong to the times of their stages.
//! * **Conservation.** Momentum is exact, angular momentum is not. Free fall is exact.
//! * **`λ` and `δ`** are bounds for all positions where only springs are stiff
//!   ([`drape_integrator::StabilityLimit`], [`drape_integrator::DampingBound`]). Otherwise `λ`
//!   follows the cloth as leapfrog's does, and half of the bound `δ` belongs to it. Drag is in
//!   neither.
//! * **Refusals.** Springs without damping are refused by name, and so is a step of more than 100
//!   000 substeps. Undamped modes beside damped springs, such as modes of angles, grow slowly, like
//!   `(h√κ)⁴`.
//! * **Pins and contacts** act at the end of a substep, particle by particle, as with
//!   Adams–Bashforth: an impact is a jump of `v_n`, and a particle that stays in contact has no
//!   lead over `h v_n` along the normals.
//! * **No energy ledger:** positions do not move by one velocity.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `h` | `h` | s | |
//! | `y_j − y_n` | `Workspace::last` after stage `j` | m, m/s | 2 × `n` × 3 |
//! | `F_{j−1}` | `v`, `acceleration` | m/s, m/s² | 2 × `n` × 3 |
//! | `μ_j`, `ν_j`, `μ̃_j`, `γ̃_j` | `Stage` | – | `s − 1` |
//! | `λ` | `Divider::limit` | 1/s² | |
//! | `δ` | `Divider::damping` | 1/s | |
//!
//! # Where it failed here, and what it cost
//!
//! The hanging sheet: 20 × 20 particles, shear springs of 0.1 k, two pins, 0.3 s. Errors are
//! relative to the motion. The energy never rose.
//!
//! | `k/m`, 1/s² | `d/m`, 1/s | step, s | substeps | force evaluations | error |
//! |---|---|---|---|---|---|
//! | 1e6 | 1e3 | 0.01 | 150 | 900 | 9.6e-6 |
//! | 1e6 | 1e3 | 0.002 | 150 | 900 | 9.6e-6 |
//! | 1e6 | 1e3 | 0.0005 | 600 | 1800 | 8.1e-7 |
//! | 1e8 | 1e4 | 0.01 | 1440 | 8640 | 5.5e-9 |
//! | 1e6 | 40 | 0.01 | 1140 | 2280 | 9.3e-7 |
//!
//! * *Six stages gain a factor of two.* At `d/m = √(k/m)` the limit `h ≤ 2.34 d/k` has use for six
//!   stages and no more. They reach twice as far as six steps of one force with `hδ < 2`.
//! * *Light damping* (last row) leaves two stages a substep: 2280 forces, where leapfrog takes 330
//!   for an error of 3e-6.
//! * *The step as given.* With `step=fixed` the method is stable at 0.002 s on the first row and
//!   blows up at 0.005 s.
//!
//! To try next: ROCK2 (Abdulle and Medovikov 2001, doi:10.1007/s002110100292), which reaches 0.81
//! s² along the real axis. It has the same limit on vibrations.
//!
//! # References
//!
//! B. P. Sommeijer, L. F. Shampine, J. G. Verwer: *RKC: an explicit solver for parabolic PDEs*.
//! Journal of Computational and Applied Mathematics 88 (1998) 315–326,
//! doi:10.1016/S0377-0427(97)00219-7.

mod coefficients;
mod division;
mod settings;
mod step;

pub use settings::{Division, RKC, RkcSettings};
pub use step::{REGISTRATION, Rkc};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
