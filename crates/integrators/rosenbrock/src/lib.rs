//! Rosenbrock methods: linearly implicit Runge–Kutta methods with one Jacobian a step.
//!
//! builds-on: backward Euler → Baraff-Witkin → **Rosenbrock**
//!
//! # What it is
//!
//! An implicit Runge–Kutta method solves a nonlinear system in each stage. A *Rosenbrock method*
//! takes one Newton step instead, and corrects the coefficients so that the order stays: a step is
//! one factorisation and one linear solve per stage, without any iteration or stop test. Baraff and
//! Witkin's step is the member of one stage and order 1.
//!
//! Take it to see how far one linearisation per step suffices. With damping and `h²k/m` up to 100,
//! `rodas4` is very accurate for a single factorisation. It fails on undamped or stiffer cloth,
//! where a method that iterates does not: take TR-BDF2 or backward Euler there.
//!
//! # The mathematics
//!
//! For `y' = F(y)` with the Jacobian `J` at `y_n`, coefficients `α`, `Γ` (diagonal `γ`) and `b`:
//!
//! ```text
//! k_i = h F(y_n + Σ_{j<i} α_ij k_j) + h J Σ_{j≤i} γ_ij k_j        y_{n+1} = y_n + Σ_i b_i k_i  (1)
//! ```
//!
//! With `u = Γ k` products with `J` fall out. `a = αΓ⁻¹`, `c = diag(1/γ) − Γ⁻¹`, `m = bΓ⁻¹`, `τ =
//! γh` and `F = (v, M⁻¹ f)` give for stage `i`
//!
//! ```text
//! x = x_n + Σ a_ij u^x_j          v = v_n + Σ a_ij u^v_j
//! r_x = v + (1/h) Σ c_ij u^x_j    M r_v = f(x, v) + (1/h) M Σ c_ij u^v_j                       (2)
//! A u^v_i = τ (M r_v − τ K_n r_x)    u^x_i = τ (u^v_i + r_x)      A = M + τ² K_n + τ D_n       (3)
//! x_{n+1} = x_n + Σ m_i u^x_i     v_{n+1} = v_n + Σ m_i u^v_i                                  (4)
//! ```
//!
//! (3) is equivalent to `A u^x_i = τ² M r_v + τ M r_x + τ² D_n r_x`, `u^v_i = u^x_i/τ − r_x`. As
//! written it solves for a change of velocity: `K_n` gives exactly 0 for a sheet that moves as a
//! whole, so the result does not depend on the frame.
//!
//! `K_n` is exact and indefinite where springs are compressed. A sparse `L D Lᵀ` without exchanges
//! of rows factorises `A`. Each solve is checked by its residual and, if necessary, refined once.
//! If a pivot vanishes, that step uses the clamped matrix, and the report says `Indefinite`.
//!
//! | `tableau` | order | any matrix | stages | forces | modulus of `R(∞)` |
//! |---|---|---|---|---|---|
//! | `ros2` (default) | 2 | 2 | 2 | 2 | 0 |
//! | `ros3p` | 3 | 1 | 3 | 2 | 0.732 |
//! | `rodas3` | 3 | 1 | 4 | 3 | 0 |
//! | `ros34pw2` | 3 | 3 | 4 | 4 | 0 |
//! | `rodas4` | 4 | 1 | 6 | 6 | 0 |
//!
//! * *Order.* Tableaux with an order for any matrix are *W-methods*. With `jacobian=clamped`, which
//!   leaves out the negative stiffness and is factorised by Cholesky, all others have order 1. The
//!   matrix also leaves out how the direction of projected damping, and of the damping of angles,
//!   turns with the cloth; all but W-methods refuse such damping. Quadratic drag stands in the
//!   matrix with its lagged coefficient, and the derivative by the time is left out: with air only
//!   W-methods have an order above 1.
//! * *Stability.* A-stable, and L-stable but for `ros3p`, where forces are linear.
//! * *Conservation.* Momentum is conserved; angular momentum and energy are not. Free fall is
//!   exact.
//! * Contacts, friction and moving pins are refused: a stage would need constraints of its own.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `A` | [`drape_integrator::Linearisation`] | kg | 3n × 3n, 3 × 3 blocks |
//! | `u^x_i`, `u^v_i` | `increments` | m, m/s | `n` × 3 |
//! | `r_x` | `drift` | m/s | `n` × 3 |
//! | `(1/h) Σ c_ij u^v_j` | `carried` | m/s² | `n` × 3 |
//! | `a`, `c`, `m`, `γ`, `α_i` | [`Tableau`] | – | 6 × 6, 6 |
//! | `α`, `Γ`, `b` | [`Tableau::definition`] | – | 6 × 6, 6 |
//!
//! # Where it failed here, and what it cost
//!
//! *A spring that turns.* One linearisation moves the ends of a turning spring along the tangent.
//! That stretches it by the square of the angle, times `k`. Two particles that turn by 2 rad in 1 s
//! with `h` = 0.01 s, share of the angular momentum that is left:
//!
//! | | `θ` = 1 | `θ` = 100 |
//! |---|---|---|
//! | `ros2` | 0.9976 | 0.528 |
//! | `ros3p` | 0.9998 | 0.658 |
//! | `rodas3` | 1.0014 | 1.522 |
//! | `ros34pw2`, clamped | 0.9999 | 1.860 |
//! | `rodas4` | 1.0000 | 0.991 |
//!
//! *The hanging sheet*: 20 × 20 particles, shear springs of 0.1 k, d/m = 40/s, 0.3 s. Error of
//! positions over the motion:
//!
//! | | k/m = 1e4: `h` = 0.01 | 0.0025 | 1e6: 0.03 | 0.01 | 0.0025 | 1e8: 0.005 | 0.0025 |
//! |---|---|---|---|---|---|---|---|
//! | `ros2` | 1.5e-4 | 9.5e-6 | diverges | 2.5e-3 | 3.9e-5 | diverges | 9.5e-3 |
//! | `ros2`, clamped | 1.5e-4 | 9.5e-6 | diverges | 2.5e-3 | 4.3e-5 | diverges | 9.4e-3 |
//! | `ros3p` | 2.4e-5 | 4.0e-7 | diverges | 2.1e-3 | 6.0e-6 | diverges | 5.0e-3 |
//! | `rodas3` | 7.5e-6 | 1.3e-7 | diverges | 1.2e-3 | 7.5e-6 | diverges | 2.7e-3 |
//! | `ros34pw2` | 6.8e-6 | 1.1e-7 | diverges | 1.0e-3 | 2.6e-6 | diverges | 3.2e-3 |
//! | `rodas4` | 7.4e-8 | 2.1e-10 | diverges | 3.0e-5 | 2.3e-7 | diverges | 4.7e-5 |
//!
//! *Energy* of the same sheet at k/m = 1e6, `h` = 0.01 s, over 2 s. The sheet could fall by 3.9 J,
//! and the rise above the start should be 0 J:
//!
//! | | d/m = 40/s | undamped |
//! |---|---|---|
//! | `ros2` | 0 | 4e15 |
//! | `ros2`, clamped | 0 | 7e5 |
//! | `ros3p` | 0 | 9e18 |
//! | `rodas3` | 1e15 | 1e18 |
//! | `ros34pw2` | 5e25 | 2e24 |
//! | `ros34pw2`, clamped | 0 | 1e13 |
//! | `rodas4` | 0 | 1e44 |
//!
//! With light damping the clamped matrix saves `ros34pw2`, which diverges after the first 0.3 s
//! with the exact Jacobian. Without damping nothing saves it. No step here met a vanishing pivot.
//!
//! *Order* on a smooth sheet of 6 × 6 particles, last halving of `h`: 1.99, 2.95, 2.98, 2.98, 4.00.
//! *Cost*: one factorisation of `3n` unknowns a step, and a solve, a product with `K` and a product
//! with the matrix a stage.
//!
//! # References
//!
//! H. H. Rosenbrock, *Some general implicit processes for the numerical solution of
//! differential equations*, Comput. J. 5 (1963), doi 10.1093/comjnl/5.4.329. E. Hairer, G. Wanner,
//! *Solving Ordinary Differential Equations II*, IV.7 (RODAS), doi 10.1007/978-3-642-05221-7. J. G.
//! Verwer, E. J. Spee, J. G. Blom, W. Hundsdorfer, *A second-order Rosenbrock method applied to
//! photochemical dispersion problems*, SIAM J. Sci. Comput. 20 (1999),
//! doi 10.1137/S1064827597326651 (ROS2). J. Lang, J. Verwer, *ROS3P: an accurate third-order
//! Rosenbrock solver designed for parabolic problems*, BIT 41 (2001), doi 10.1023/A:1021900219772.
//! A. Sandu et al., *Benchmarking stiff ODE solvers for atmospheric chemistry problems II*, Atmos.
//! Environ. 31 (1997), doi 10.1016/S1352-2310(97)83212-8 (RODAS3). J. Rang, L. Angermann, *New
//! Rosenbrock W-methods of order 3 for partial differential algebraic equations of index 1*, BIT 45
//! (2005), doi 10.1007/s10543-005-0035-y (ROS34PW2). D. Baraff, A. Witkin, *Large steps in cloth
//! simulation*, SIGGRAPH 98, doi 10.1145/280814.280821.

mod linear_system;
mod settings;
mod step;
mod tableau;

pub use settings::{JacobianForm, ROSENBROCK, RosenbrockSettings};
pub use step::{REGISTRATION, Rosenbrock};
pub use tableau::{RODAS3, RODAS4, ROS2, ROS3P, ROS34PW2, STAGES, Scheme, Tableau};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];

#[cfg(test)]
mod tests;
