//! Extended position-based dynamics by lines (XPBD with line relaxation): each warp, weft and
//! diagonal line of a cloth is one system with three diagonals, solved at once.
//!
//! builds-on: symplectic Euler → Provot → backward Euler → XPBD → **XPBD by lines**
//!
//! # What it is
//!
//! XPBD takes springs one after the other, so a sweep carries a pull from a particle to its
//! neighbours only. Springs that it has not seen yet stay stretched, and in a stiff sheet that
//! stretch holds far more energy than the motion does. Here a sweep takes whole lines. The springs
//! of a line hang together like a chain, and a chain of constraints has a matrix with three
//! diagonals, which elimination solves in time proportional to its length. So one solve carries a
//! pull through the whole sheet. Lines that cross it hardly disturb it, since they stand at right
//! angles. A sweep goes from the softest family of lines to the stiffest, so that the error that it
//! leaves sits in soft springs.
//!
//! A sweep this accurate allows two-step backward differentiation between substeps, with which the
//! sweeps of XPBD explode. Take the method for stiff cloth that must gain hardly any energy without
//! a global solve. Do not take it for undamped cloth far beyond k/m = 1e8 s⁻², and not where
//! stiff cloth slides over obstacles: see below.
//!
//! # The mathematics
//!
//! A spring is a constraint `C = |p_i − p_j| − ℓ` that yields by the compliance `1/k`. A substep of
//! `h_s = h/substeps` seconds predicts positions `p = x* + q`:
//!
//! ```text
//! x* = ((1+ω)² x_n − ω² x_{n−1})/(1+2ω),   v* likewise,
//! τ = h_s (1+ω)/(1+2ω),   ω = h_s/h_{n−1}                                               (L1)
//! q = τ (v* + τ M⁻¹ f_explicit(x_n, v_n)),   λ = 0                                      (L2)
//! ```
//!
//! The first substep, and each with `order=1`, has `x* = x_n`, `v* = v_n`, `τ = h_s`. A line
//! `q_0, …, q_L` has the springs `s` from `q_s` to `q_{s+1}`, with the directions `u_s`. With
//! `a = kτ²`, `g = cτ`, `w = 1/m` and `r_s = q_s − q_{s+1}` each sweep solves in turn
//!
//! ```text
//! full damping, each line:   D_s + g_s (δq_s − δq_{s+1}) = −(Λ_s + g_s (r_s + r⁻_s))
//!                            δq_s = w_s (D_s − D_{s−1})     Λ_s += D_s                  (L3)
//! angles, one by one:        Δλ = −(λ + b C)/(1 + b Σ w |∇C|²)     δq = w ∇C Δλ         (L4)
//! springs, each line:        d_s + b_s u_s·(δq_s − δq_{s+1}) = −(λ_s + a_s C_s + g_s u_s·r_s)  (L5)
//!                            δq_s = w_s (u_s d_s − u_{s−1} d_{s−1})     λ_s += d_s      (L6)
//! ```
//!
//! and then contacts (L7), as XPBD does. `b` is `a`, or `a + g` where damping acts along the
//! springs; only then `g` stands in (L5). At the end of the substep
//!
//! ```text
//! v_{n+1} = q/τ     x_{n+1} = x* + q                                                    (L8)
//! ```
//!
//! * **Lines.** Two springs of an effect follow each other if the line turns by less than 60°
//!   where they meet, by the angles of their rest lengths; the straightest pair comes first (module
//!   `cover`). So each spring of any graph stands in one line. On a grid the lines are rows,
//!   columns and diagonals; bending springs have an even and an odd line in each row.
//! * **Families.** The lines of a family share no particle: their order does not matter. Families
//!   follow each other by the stiffness of their stiffest spring.
//! * **A line** is one Newton step of (L1) on the chain alone. Its matrix has more on its diagonal
//!   than beside it, so elimination needs no pivots.
//! * **Full damping** is solved before the springs, so it does not know their corrections. It
//!   therefore assumes the corrections of the previous substep, `r⁻`, and starts from the `Λ` of
//!   that substep. On one spring this is the factored matrix `(1 + θ)(1 + η)` in place of
//!   `1 + θ + η` (`drape_oracle::recurrence::factored_bdf2`), as in alternating-direction methods.
//!   No motion grows at any `θ` and `η`. Where both are large, the spring comes to rest more slowly
//!   than it should.
//! * **Order.** 2 with full damping or none. One sweep leaves an error of `O(h)` in damping along
//!   the springs: order 1, and 2 with `iterations=2`.
//! * **Conservation.** Impulses act in pairs: momentum is conserved. Energy may rise, see below.
//! * **Registers and threads.** A sweep solves four lines of a family side by side in the registers
//!   of a processor that has them (module `abreast`). Threads share these groups of four. Both give
//!   the bits of one line after the other.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `x*`, `q` | `base`, `way` | m | `n` × 3 |
//! | `τ`, `h_s` | `tau`, `h` | s | |
//! | `a = kτ²`, `g = cτ` | `pull`, `brake` of `Spring` | kg | per spring |
//! | `λ`, `Λ` | `pull`, `brake` of `Multiplier` | kg m | per spring; × 3 |
//! | `d`, `D` | `step`, `brakes` | kg m | per spring of a line; × 3 |
//! | `u_{s−1}·u_s` | `cosine` | – | per spring of a line |
//! | `r⁻` | `pending` | m | `n` × 3, as differences |
//! | `θ = h_s²κ`, `η = h_s δ` of a mode | – | – | |
//!
//! # Where it failed here, and what it cost
//!
//! *The hanging sheet*: 400 particles, two pins, shear springs of 0.1 k, frames of 0.01 s. Greatest
//! rise of the energy in 2 s, J (the sheet weighs 3.9 N), and error of the positions at 0.3 and 1 s
//! over how far the sheet moved, against leapfrog at 0.4 of its limit:
//!
//! | substeps | 1e8, d/m = 40: rise, errors | 1e8 undamped: rise, error | 1e10, d/m = 40: rise, errors | 1e10 undamped: rise, error |
//! |---|---|---|---|---|
//! | 5 | 0.022, 6.6e-3 2.3e-3 | | 2.5, 8.3e-3 2.0e-3 | 164, 7.5e-3 |
//! | 10 | 0.0017, 2.8e-3 0.95e-3 | 0.33 | 0.31, 3.8e-3 0.97e-3 | 20, 4.1e-3 |
//! | 15 | none, 1.6e-3 0.51e-3 | 0.020, 2.5e-3 | 0.080, 2.5e-3 0.61e-3 | 33, 2.5e-3 |
//! | 20 | none, 0.97e-3 0.31e-3 | 0.0033, 2.0e-3 | 0.026, 1.8e-3 0.46e-3 | 13, 1.7e-3 |
//! | 30 | | 0.0052, 1.4e-3 | 0.0055, 1.1e-3 0.31e-3 | 6.1, 1.2e-3 |
//! | 40 | | 0.0003, 1.1e-3 | 0.0013, 0.79e-3 0.22e-3 | 2.4, 0.94e-3 |
//! | 100 | | 0.0001, 0.45e-3 | 2e-5, 0.25e-3 0.06e-3 | 0.21, 0.49e-3 |
//! | 20, `order=1` | | 0.0028, 3.0e-3 | 0.12, 2.9e-3 4.7e-3 | 6.8, 3.3e-3 |
//!
//! Undamped motion is chaotic, so errors at 1 s are left out, and rises are samples: starts that
//! differ by some 1e-12 m gain 0.003 to 0.025 J at 1e8 with 20 substeps, and at 1e10 12 to 15 J
//! with 20 and 2.1 to 4.4 J with 40. XPBD with 20 substeps of one sweep gains 0.31 J at 1e8 with
//! damping, and needs 300 at 1e10.
//!
//! *The same fabric on finer meshes*, whose stiffness and damping over mass grow with the square of
//! the number along an edge: from so many substeps on, energy rises by at most 2 % of what the sheet
//! sets free (1.96 J). `results/frontier.md` has the rises and a figure.
//!
//! | particles | 1e8, d/m = 40 | 1e8 undamped | 1e10, d/m = 40 | 1e10 undamped |
//! |---|---|---|---|---|
//! | 20 × 20 | 5 | 20 | 20 | more than 160 |
//! | 40 × 40 | 10 | 40 | 30 | more than 160 |
//! | 100 × 100 | 30 | 80 | 80 | more than 160 |
//! | 20 × 20, `xpbd` | 80 | 80 | more than 160 | more than 160 |
//!
//! *A free sheet falls on a sphere* of 0.3 m. Rise in J:
//!
//! | substeps | 1e8, d/m = 40 | 1e8 undamped | 1e10, d/m = 40 | 1e10 undamped |
//! |---|---|---|---|---|
//! | 20 | none | 0.34 | 46 | 14 |
//! | 40 | none | 0.0049 | 8.3 | 11 |
//! | 100 | none | 5e-5 | 1.0 | 1.4 |
//!
//! * *Undamped at 1e10* the sheet crumples after 1.3 s. Lines kink, families couple, and energy
//!   rises by several times what the motion holds. Substeps help slowly. This is not solved.
//! * *On the sphere at 1e10* the contacts that follow a sweep stretch stiff springs again.
//! * *Meshes.* A tablecloth of triangles with 2070 springs has 89 lines in 4 families; a skirt of
//!   2928 springs has 530 in 12. With stiffnesses a thousand times theirs 20 substeps gain 1.2 and
//!   2.6 J in 1 s: long lines alone do not hold a stiff mesh that meets an obstacle.
//! * *Bending springs* of 0.01 k change the hanging sheet little: none, and 0.020 J at 1e10 with
//!   damping, 0.0039 and 1.6 J without.
//! * *A second sweep* helps less than a second substep: at 1e10 with damping, 14 substeps of two
//!   sweeps gain 0.027 J, and 30 of one gain 0.0055 J. Without damping, two sweeps in 20 substeps
//!   gain 12 J.
//! * *Repeats.* Repeating the stiff families, or each line, within a sweep changes nothing with
//!   damping at 1e10, and gains more energy without it (19 and 23 J). Swapping warp and weft in
//!   every other substep gains 8.8 J instead of 13 J at 1e10, and twice as much at 1e8.
//! * *Cost*, on one core of a shared machine. A substep of the 1482 springs takes 10 µs, and 18 µs
//!   with full damping. Line after line, without registers of four, it takes 22 and 32 µs, since
//!   each spring of a line waits for the one before. All forces together take 2.1 µs. So a substep
//!   costs five to nine forces by time, and about three by counted operations.
//!
//! # References
//!
//! * M. Macklin, M. Müller, N. Chentanez: XPBD: position-based simulation of compliant constrained
//!   dynamics. Motion in Games 2016. doi:10.1145/2994258.2994272
//! * J. Bender, D. Bayer: Parallel simulation of inextensible cloth. Workshop on virtual reality
//!   interaction and physical simulation 2008. doi:10.2312/PE/vriphys/vriphys08/047-056. Strips of
//!   constraints, each solved in linear time, as impulses without compliance.
//! * R. Goldenthal, D. Harmon, R. Fattal, M. Bercovier, E. Grinspun: Efficient simulation of
//!   inextensible cloth. ACM Transactions on Graphics 26 (2007). doi:10.1145/1276377.1276438. All
//!   warp and weft constraints in one global solve (fast projection).
//! * D. Han, T. Harada: Tridiagonal matrix formulation for inextensible hair strand simulation.
//!   Workshop on virtual reality interaction and physical simulation 2013.
//!   doi:10.2312/PE.vriphys.vriphys13.011-016
//! * C. Deul, T. Kugelstadt, M. Weiler, J. Bender: Direct position-based solver for stiff rods.
//!   Computer Graphics Forum 37 (2018). doi:10.1111/cgf.13326. XPBD on trees of rods.
//! * E. English, R. Bridson: Animating developable surfaces using nonconforming elements. ACM
//!   Transactions on Graphics 27 (2008). doi:10.1145/1360612.1360665. Two-step backward
//!   differentiation around a projection.
//! * D. Peaceman, H. Rachford: The numerical solution of parabolic and elliptic differential
//!   equations. Journal of the SIAM 3 (1955). doi:10.1137/0103003. One direction of a grid at a
//!   time.

mod abreast;
mod chains;
mod cover;
mod net;
mod settings;
mod step;

pub use settings::{Formula, XPBD_LINES, XpbdLinesSettings};
pub use step::{REGISTRATION, XpbdLines};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
