//! The neighbour-corrected sweep of Kang, Choi and Cho (2000): implicit Euler without a linear
//! solve.
//!
//! builds-on: backward Euler → Baraff-Witkin → Desbrun → **Kang** → IMEX
//!
//! # What it is
//!
//! Desbrun's implicit step needs `A⁻¹`, `A = M + h² L_k + h L_c`. Kang, Choi and Cho replace the
//! inverse by one correction of each particle by its neighbours: nothing is factorised or iterated,
//! and a step costs `O(n)`. Take it where the cheapest implicit step is enough and a sheet may sag.
//!
//! # The mathematics
//!
//! `F̃` is the springs' force with an artificial viscosity, and
//! `D_i = m_i + h² Σ_j k_ij + h Σ_j c_ij` is the diagonal of `A`:
//!
//! ```text
//! F̃_i  = F_i + h Σ_j k_ij (v_j − v_i) + Σ_j c_ij (v_j − v_i)                           (K1)
//! Δv*_i = h F̃_i / D_i                                     each particle alone           (K2)
//! Δv_i  = (h F̃_i + Σ_j (h² k_ij + h c_ij) Δv*_j) / D_i    corrected by its neighbours   (K3)
//! v_{n+1} = v_n + Δv + h M⁻¹ f_external                                                 (K4)
//! x_{n+1} = x_n + h v_{n+1}                                                             (K5)
//! ```
//!
//! EEH call (K1)–(K3) a single Jacobi iteration. It is two sweeps of Jacobi's method from zero; the
//! first sweep is the division by the diagonal. The setting `sweeps` repeats (K3). Many sweeps
//! converge to the exact solve, which is IMEX Euler with unfiltered external forces.
//!
//! * **Matrix.** It is that of IMEX Euler ([`drape_integrator::LaplacianSolver`]), kept until the
//!   step size, a stiffness, a damping coefficient, a mass or a pin changes. Since
//!   `h F̃ = h F + (M − A) v_n`, the right-hand side takes one product with it, and each correction
//!   one more (module `sweep`).
//! * **Projected damping** enters as its linear part in the matrix and the remainder at level `n`.
//! * **Gravity** and all other effects that are no springs stay *outside* the sweep. If gravity
//!   were swept too, a sheet in free fall would accelerate at `(1 + 2S)/(1 + S)²` of `g`,
//!   `S = h² Σ k/m`, and would practically stand still.
//! * **Contacts** act on the resulting velocity, particle by particle, since there is no solve.
//!
//! An error that is an eigenvector of Jacobi's iteration matrix is multiplied by its eigenvalue `γ`
//! in each sweep. So `s` corrections make the fraction `φ = 1 − γ^{s+1}` of the exact update, and
//! (K3) makes `1 − γ²`. The order is 1 as `h → 0`. On springs of rest length 0 the method is stable
//! for every step.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `A` | [`drape_integrator::LaplacianSolver::matrix`] | kg | `n` × `n`, scalar |
//! | `D` | `diagonal` | kg | `n` |
//! | `h F̃` | [`drape_integrator::ViscousImpulse`] | kg m/s | `n` × 3 |
//! | `Δv` | `change` | m/s | `n` × 3 |
//! | `S = h² Σ k/m` of a particle | – | – | |
//! | `θ = h²κ`, `η = hδ`, with the eigenvalues `κ` of `M⁻¹L_k` and `δ` of `M⁻¹L_c` of a shape | – | – | |
//! | `γ`, its eigenvalue of Jacobi's iteration | – | – | |
//!
//! # Where it failed here
//!
//! Rough shapes are solved well, but smooth shapes, `γ → 1`, hardly at all. The sheet behaves like
//! a sheet that is softer by about `(1 + S)/(2(1 + θ))`, sags like rubber, and needs Provot's
//! correction in addition. On springs with a rest length energy may rise. Momentum is conserved
//! only if all `D_i` are equal; angular momentum is not conserved.
//!
//! *More corrections are not always better.* If springs join only black to white fields of a
//! chequerboard, as warp and weft do, shapes with `γ → −1` exist. An even number of corrections
//! overshoots them, `φ > 1`, and is unstable once `φ (3θ + 2η) > 4 (1 + θ + η)`; an odd number is
//! safe. More sweeps approach IMEX Euler at a rate of `γ`: conjugate gradients are cheaper long
//! before 64 sweeps.
//!
//! Measured on the hanging sheet of 400 particles of 1 g with shear springs of 0.1 k, k/m = 1e6, h
//! = 0.01 s:
//!
//! | | time a step | free edge hangs low after 1 s | energy gained |
//! |---|---|---|---|
//! | `sweeps=1` | 26 µs | 2.9 m | 1400 J |
//! | `sweeps=8` | 61 µs | 1.1 m | 69 J |
//! | IMEX Euler, conjugate gradients | 88 µs | | none |
//!
//! A smaller step does not help at first: at k/m = 1e6 the error grows from 0.31 to 0.70 of the
//! motion between h = 0.01 and 0.00125 s.
//!
//! Plots: error against the step in `results/figures/order-smooth.svg` and `order-stiff.svg`, spin
//! in `momentum-spin.svg`, hard cases in `hard-cases.svg`.
//!
//! To try next: Provot's correction against the sag, or a solve (IMEX Euler).

mod ledger;
mod settings;
mod step;
mod sweep;

pub use settings::{KANG, KangSettings};
pub use step::{Kang, REGISTRATION};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
