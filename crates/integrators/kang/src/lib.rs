//! The neighbour-corrected sweep of Kang, Choi and Cho (2000): implicit Euler without solving a
//! linear system.
//!
//! builds-on: backward Euler → Baraff-Witkin → Desbrun → **Kang** → IMEX
//!
//! # Why
//!
//! Desbrun's implicit step needs `A⁻¹`, `A = M + h² L_k + h L_c`. Kang, Choi and Cho replace it by one correction of
//! each particle by its neighbours. With the internal force and its artificial viscosity
//! `F̃_i = F_i + h Σ_j k_ij (v_j − v_i)` (and the scene's damping), and the diagonal
//! `D_i = m_i + h² Σ_j k_ij + h Σ_j c_ij` of `A`,
//!
//! ```text
//! Δv*_i = h F̃_i / D_i                                        every particle by itself
//! Δv_i  = (h F̃_i + Σ_j (h² k_ij + h c_ij) Δv*_j) / D_i        corrected once by its neighbours
//! v_{n+1} = v_n + Δv + h M⁻¹ f_external          x_{n+1} = x_n + h v_{n+1}
//! ```
//!
//! Nothing is factorised and nothing iterated: `O(n)` a step. EEH call it a single Jacobi iteration; it is two
//! sweeps of Jacobi's method from zero, the first of which is the division by the diagonal. Setting `sweeps` adds
//! more corrections of the same kind, which tend to the exact solve, that is IMEX Euler with
//! unfiltered external forces.
//!
//! # How the code does it
//!
//! The matrix is that of IMEX Euler ([`drape_integrator::LaplacianSolver`]), kept until the step, a
//! stiffness, a damping coefficient, a mass or a pin changes. Since `h F̃ = h F + (M − A) v_n`, the right-hand side
//! takes one product with it, and each correction one more (`sweep`). Projected damping enters as its linear part in
//! the matrix and the remainder at level `n`. Gravity and everything else that is no spring stays *outside*: were it
//! swept too, a sheet in free fall would accelerate at `(1 + 2S)/(1 + S)²` of `g`, `S = h² Σ k/m`, and practically stand
//! still. Contacts act on the resulting velocity, particle by particle, since there is no solve that they
//! could take part in.
//!
//! # What it cost and where it failed here
//!
//! An error of the shape of an eigenvector of Jacobi's iteration matrix with eigenvalue `γ` is multiplied by
//! `γ` per sweep, so that `s` corrections do `φ = 1 − γ^{s+1}` of the exact update, and Kang's formula `1 − γ²`. Rough
//! shapes are solved well; of smooth ones, `γ → 1`, hardly anything is: the sheet behaves like one that is softer by
//! about `(1 + S)/(2(1 + θ))`, sags like rubber, and needs Provot's correction beside it. On springs of rest length 0 it is
//! stable for every step, on others energy may rise. As `h → 0` it is of order 1 like any other. Momentum is
//! conserved only where all `D_i` are equal, angular momentum is not.
//!
//! *Not every number of corrections is better than one.* Where springs join only black to white fields of a
//! chequerboard, as warp and weft do, shapes with `γ → −1` exist. An even number of corrections overshoots
//! them, `φ > 1`, and is unstable once `φ (3θ + 2η) > 4 (1 + θ + η)`; an odd number is safe. More sweeps approach IMEX Euler,
//! but at a rate of `γ`: conjugate gradients are cheaper long before 64 sweeps.
//!
//! Measured on the hanging sheet of 400 particles with shear springs of 0.1 k, k/m = 1e6, h = 0.01 s: 26 µs a step, and after a second the
//! free edge of a sheet of 1 m hangs 2.9 m low, having gained 1400 J on the way; with 8 sweeps, 61 µs, it is 1.1 m and
//! 69 J. IMEX Euler solved by conjugate gradients costs 88 µs there and gains nothing. A smaller step does not help at
//! first: at k/m = 1e6 the error grows from 0.31 to 0.70 of the motion between h = 0.01 and 0.00125 s.
//!
//! Plots: error against the step in `results/figures/order-smooth.svg` and `order-stiff.svg`, spin in
//! `momentum-spin.svg`, hard cases in `hard-cases.svg`.
//! What to try next: Provot's correction against the sag, or a solve (IMEX Euler).
//!
//! # Symbols
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

mod ledger;
mod settings;
mod step;
mod sweep;

pub use settings::{KANG, KangSettings};
pub use step::{Kang, REGISTRATION};
