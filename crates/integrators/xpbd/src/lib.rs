//! Extended position-based dynamics with small steps (XPBD): one sweep over the springs in each of
//! many substeps, without a matrix.
//!
//! builds-on: symplectic Euler → Provot → backward Euler → **XPBD**
//!
//! # What it is
//!
//! An implicit step solves for all springs at once. XPBD takes them one after the other. It moves
//! the two ends of a spring to where backward Euler would leave them if there were no other spring,
//! and goes on to the next. The step is divided into substeps, and one sweep in each is enough:
//! work goes into shorter steps, not into more sweeps. Nothing is assembled or factorised, and the
//! cost of a sweep does not depend on the stiffness. Most games and many production tools move
//! cloth this way. Take it for stiff, lightly damped cloth where errors of 1 to 10 % will do. Do
//! not take it where the energy of the stiff modes matters, or for small errors.
//!
//! # The mathematics
//!
//! A spring is a constraint `C = |p_i − p_j| − ℓ` that yields: its energy is `C²/(2α)` with the
//! compliance `α = 1/k`. A substep of `h_s = h/substeps` seconds predicts positions `p = x* + q`:
//!
//! ```text
//! order 1:  x* = x_n,   v* = v_n,   τ = h_s                                             (X1)
//! order 2:  x* = ((1+ω)² x_n − ω² x_{n−1})/(1+2ω),   v* likewise,
//!           τ = h_s (1+ω)/(1+2ω),   ω = h_s/h_{n−1}                                     (X2)
//! q = τ (v* + τ M⁻¹ f_explicit(x_n, v_n)),   λ = 0                                      (X3)
//! ```
//!
//! Then each sweep visits every spring (`α̃ = α/τ²`, `γ = c/(kτ)`, `w = 1/m`, `u` the direction):
//!
//! ```text
//! Δλ = −(C + α̃ λ + γ u·(q_i − q_j)) / ((1 + γ)(w_i + w_j) + α̃)                         (X4)
//! q_i += w_i Δλ u     q_j −= w_j Δλ u     λ += Δλ
//! ```
//!
//! `λ` starts from 0 in every substep and *not* in every sweep, or the stiffness would grow with
//! the number of sweeps. After the last sweep
//!
//! ```text
//! v_{n+1} = q/τ     x_{n+1} = x* + q                                                    (X8)
//! ```
//!
//! * **Damping.** (X4) is damping *along* the spring (`damping: projected`). Full damping is a
//!   second constraint, `q_i = q_j` with the compliance `1/(cτ)`. It is solved together with the
//!   spring, (X5) in module `springs`. So it limits no substep. Published codes apply it as an
//!   explicit kick, which is unstable beyond `h_s δ_max = 2`.
//! * **Angles and hinges** have `C = θ − θ₀` and the compliance `1/K`, (X6) in
//!   [`CompliantAngles`](drape_integrator::CompliantAngles).
//! * **Curves.** A spring of several slopes is, at each visit, the linear spring of its present
//!   piece: its slope, and the rest length at which the piece would have no tension.
//! * **Obstacles** act after each sweep, on particles that it would leave inside (X7). The impulse
//!   of each contact is found anew from the sweep's result: it only pushes, and friction is at most
//!   `μ` times as large. Restitution, recovery and resting contacts follow
//!   [`drape_integrator::ContactSet`].
//! * **Gravity and air** stay at the old level of each substep.
//! * **One spring** in one sweep is backward Euler, or BDF2 with `order=2`. A sweep multiplies its
//!   spin by `len_{n+1}/len_predicted`.
//! * **A net** in many sweeps is *not* backward Euler. The sweeps converge to
//!   `M (p − y) = Σ ∇C(p⁽ⁱ⁾) Δλ⁽ⁱ⁾` with the directions of earlier sweeps, `y` the prediction. The
//!   difference vanishes with `h_s`.
//! * **Order.** One sweep leaves an error of `O(h²)` in the force of a spring and of `O(h)` in its
//!   damping. So the order is 1; with `order=2` it is 2 without damping, 1 with damping and one
//!   sweep, and 2 with `iterations=2`.
//! * **Conservation.** Impulses act in pairs: momentum is conserved. Energy may rise, see below.
//! * **Order of the springs.** It decides the result. `sweep=list` takes the order of the scene;
//!   `sweep=coloured` gives each constraint, effect by effect, the first colour that no neighbour
//!   has, and goes colour by colour. The bits do not depend on the number of threads.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `x*` | `base` | m | `n` × 3 |
//! | `q` | `way` | m | `n` × 3 |
//! | `τ`, `h_s` | `tau`, `h` | s | |
//! | `1/α̃ = kτ²` | `pull` | kg | per spring |
//! | `cτ` | `brake` | kg | per spring |
//! | `λ` | `Multiplier` | kg m | per spring |
//! | `w_i + w_j` | `mobility` | 1/kg | per spring |
//! | `θ = h_s²κ`, with the stiffness `κ` over mass of a mode | – | – | |
//!
//! # Where it failed here, and what it cost
//!
//! *The hanging sheet*: 400 particles, two pins, shear springs of 0.1 k, d/m = 40, 0.3 s in frames
//! of 0.01 s. Error of the positions over how far the sheet moved:
//!
//! | substeps × sweeps | `k/m` = 1e4 | 1e6 | 1e8 |
//! |---|---|---|---|
//! | 1 × 10 | 0.028 | 0.12 | 0.14 |
//! | 10 × 1 | 0.0038 | 0.020 | 0.027 |
//! | 20 × 1 | 0.0018 | 0.0053 | 0.020 |
//! | 50 × 1 | 0.00073 | 0.0010 | 0.0039 |
//! | 100 × 1 | 0.00036 | 0.00035 | 0.0023 |
//! | 20 × 1, coloured | 0.0019 | 0.0056 | 0.021 |
//! | 20 × 1, `order=2` | 0.00072 | 0.0021 | unstable |
//! | 50 × 1, `order=2` | 0.00028 | 0.00033 | 0.0028 |
//!
//! *Energy.* A sweep that stops early sets energy free: stiff springs that it has not seen are
//! still stretched. Greatest rise above the start over 2 s (1e6) or 1 s, in J; the sheet weighs 3.9
//! N:
//!
//! | substeps × sweeps | 1e6, undamped | 1e6 | 1e8 | 1e10 |
//! |---|---|---|---|---|
//! | 1 × 1 | 129 | 119 | | |
//! | 1 × 20 | 0.29 | 0.10 | | |
//! | 5 × 1 | | 0.25 | | |
//! | 10 × 1 | 0.068 | 0.0084 | 2.4 | |
//! | 20 × 1 | 0.0030 | none | 0.31 | |
//! | 20 × 3 | | | 0.054 | |
//! | 50 × 1 | | | 0.019 | 2.3 |
//! | 100 × 1 | | | 0.0010 | 0.32 |
//! | 300 × 1 | | | none | 0.014 |
//! | 10 × 1, `order=2` | 0.065 | none | unstable | |
//! | 20 × 1, `order=2` | 0.012 | none | unstable | |
//! | 50 × 1, `order=2` | | | 0.0048 | |
//! | 100 × 1, `order=2` | | | none | |
//!
//! * About 10, 50 and 300 substeps in 0.01 s hold the energy at 1e6, 1e8 and 1e10. Positions are
//!   good to 2 % long before.
//! * `order=2` is 1.4 to 3 times as accurate for the same work where it is stable. Its sweeps may
//!   not stop too early: with one sweep the sheet blew up at `h_s² k/m` = 25, and not at 11.
//! * Ten sweeps in one substep cost as much as one sweep in each of ten substeps, and are 5 to 7
//!   times less accurate.
//! * *Not backward Euler.* A step of 0.01 s from a moving state, distance to the solution of
//!   backward Euler over that of the prediction: 0.082 after 10, 30 and 1600 sweeps at
//!   `h²k/m` = 1; 0.79, 0.49, 0.15 and 0.081 after 10, 30, 100 and 400 at 100; 0.34 after 1600 at
//!   1e4. Sweeps carry stiffness one spring at a time.
//! * *Rest.* Springs that pull against each other balance at a place that depends on their order.
//!   Two equal springs rest `β C/(2 − β)` off the middle, `β = θ/(1+θ)`, with their stretch `C`.
//! * *Order* on a smooth sheet with damping: 1.00. With `order=2`: 2.00 without damping, 1.01 with
//!   it, 2.00 with `iterations=2`.
//! * *Cost*, on one core of an AMD EPYC (family 25, model 1), beside other work. A sweep over tension, shear and bending springs with damping
//!   along them, in groups (module `lanes`), and by `SolverXPBD` of Newton 1.8.0 on the same sheet
//!   (`results/sweeps.md`, which the bench `sweeps` makes):
//!
//!   | sheet | springs | as listed | by colours | Newton |
//!   |---|---|---|---|---|
//!   | 20 × 20 | 2202 | 22 µs | 16 µs | 115 µs |
//!   | 52 × 52 | 15 706 | 141 µs | 122 µs | 463 µs |
//!   | 100 × 100 | 59 002 | 501 µs | 496 µs | 1624 µs |
//!
//!   Full damping takes a tenth more. Counted by operations a sweep is 1.5 forces. As listed
//!   it takes 0.7 to 0.9 times as long as a sweep for forces with the same damping, and about twice as
//!   long as one with full damping on a grid.
//! * *Public code.* `SolverXPBD` of the physics engine Newton 1.8.0 (warp-lang 1.19.0) has the same
//!   (X4), with `λ` from 0 in each step, in single precision. It adds up the corrections of all
//!   springs in a sweep, as Jacobi's method does. Where springs share no particle that is the same
//!   sweep, and the positions agree to 5e-7 m after a step. On a net of 16 particles its positions
//!   are those of Jacobi's form of (X4) up to 2e-7 m, and ours are those of Gauss-Seidel's form up
//!   to round-off. So the order of the corrections is the whole difference: 7e-5 m after four steps
//!   (`drape_oracle::published`). Full damping, angles,
//!   contacts and `order=2` do not map.
//!
//! # References
//!
//! * M. Macklin, M. Müller, N. Chentanez: XPBD: position-based simulation of compliant constrained
//!   dynamics. Motion in Games 2016. doi:10.1145/2994258.2994272
//! * M. Macklin, K. Storey, M. Lu, P. Terdiman, N. Chentanez, S. Jeschke, M. Müller: Small steps in
//!   physics simulation. Symposium on Computer Animation 2019. doi:10.1145/3309486.3340247
//! * M. Müller, B. Heidelberger, M. Hennix, J. Ratcliff: Position based dynamics. Journal of Visual
//!   Communication and Image Representation 18 (2007). doi:10.1016/j.jvcir.2007.01.005

mod lanes;
mod net;
#[cfg(test)]
mod published_tests;
mod settings;
mod springs;
mod step;

pub use settings::{Formula, Sweep, XPBD, XpbdSettings};
pub use step::{REGISTRATION, Xpbd};

/// Source texts of this crate, by file name. Lessons show excerpts of them.
pub const SOURCES: &[(&str, &str)] =
    &[("src/lib.rs", include_str!("lib.rs")), ("src/step.rs", include_str!("step.rs"))];
