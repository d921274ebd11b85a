//! The least time of a step, from the arithmetic and the memory traffic of its kernels.
//!
//! A kernel takes at least the longest of three times: its square roots and quotients at their
//! throughput, its flops at the throughput of sums and products, and its bytes at the speed of the
//! second-level cache. The table counts for a regular sheet, as the step's report counts its
//! kernels. A vector of three coordinates is 24 bytes. A second read of the same bytes is free,
//! because it comes from a nearer cache.
//!
//! | kernel, as a step's report counts it | a spring | a particle |
//! |---|---|---|
//! | sweep over the springs for forces, with damping | a root and a quotient, 33 flops | mass, x, v read, sum read and written: 104 bytes |
//! | iteration of conjugate gradients, one scalar a spring | | 72 flops, 280 bytes |
//! | product besides, one scalar a spring | | 27 flops, 72 bytes |
//! | iteration of conjugate gradients, one symmetric block a spring | 33 flops, 48 bytes | 63 flops, 336 bytes |
//! | product besides, one block a spring | 33 flops, 48 bytes | 15 flops, 96 bytes |
//! | blocks of all springs, once for each Newton iteration or linearised step | a root and a quotient, 60 flops, 48 bytes written | 48 bytes written |
//! | update of velocities and positions, once a step | | 12 flops, 120 bytes |
//!
//! A sweep over constraints or particles that corrects positions counts as a sweep for forces: it
//! takes a root and a quotient a spring, or more. Orthogonalising a Krylov subspace counts as the
//! products that the step reports for it.
//!
//! The bound leaves out factorisations, solves with factors, and preconditioners other than a
//! division by a diagonal. These depend on the order of elimination, and a method may choose among
//! them. A step that uses them exceeds its bound by their time.

use crate::{Counts, Profile};
use drape_benches::Machine;
use drape_harness::methods;
use drape_integrator::{Method, Supports, Treatment};
use drape_model::{EffectClass, EffectKind};

/// What a kernel does on a sheet of so many springs and particles.
#[derive(Clone, Copy, Debug)]
struct Kernel {
    roots: f64,
    flops: f64,
    bytes: f64,
}

impl Kernel {
    fn seconds(self, machine: &Machine) -> f64 {
        let Self { roots, flops, bytes } = self;
        let times = [flops / machine.flops_per_s, bytes / machine.bytes_per_s];
        times.into_iter().fold(roots * machine.root_and_quotient_s, f64::max)
    }
}

fn find(id: &str) -> Option<&'static Method> {
    methods::all().find(|method| method.id == id.split(':').next().unwrap_or(id))
}

/// Whether a method is explicit in all springs, and its step therefore short.
pub(crate) fn is_explicit(id: &str) -> bool {
    find(id).is_some_and(|method| {
        method.treatment(EffectKind::Tension, EffectClass::Springs) == Treatment::Explicit
    })
}

/// Whether a method's matrix has a block of 3 × 3 numbers for each spring.
fn has_blocks(id: &str) -> bool {
    let own = find(id).is_some_and(|method| method.supports == Supports::Blocks);
    own || id == "terzopoulos-fleischer"
}

/// The least time of a step, s.
pub(crate) fn seconds(machine: &Machine, profile: &Profile) -> f64 {
    let Profile { method, side, springs, counts, .. } = profile;
    let (n, m) = (f64::from(side * side), *springs as f64);
    let Counts { force_evaluations, products, iterations, newton, .. } = *counts;
    let kernel = |roots, flops, bytes| Kernel { roots, flops, bytes }.seconds(machine);
    let forces = kernel(m, 33.0 * m, 104.0 * n);
    let update = kernel(0.0, 12.0 * n, 120.0 * n);
    let (iteration, product, linearised) = if has_blocks(method) {
        let iteration = kernel(0.0, 33.0 * m + 63.0 * n, 48.0 * m + 336.0 * n);
        let product = kernel(0.0, 33.0 * m + 15.0 * n, 48.0 * m + 96.0 * n);
        (iteration, product, kernel(m, 60.0 * m, 48.0 * (m + n)) * newton.max(1.0))
    } else {
        (kernel(0.0, 72.0 * n, 280.0 * n), kernel(0.0, 27.0 * n, 72.0 * n), 0.0)
    };
    let besides = (products - iterations).max(0.0);
    force_evaluations * forces + iterations * iteration + besides * product + linearised + update
}

/// The reason why a method is more than twice above its bound, apart from [`SPRINGS`].
pub(crate) fn reason(id: &str) -> Option<&'static str> {
    Some(match id {
        "explicit-euler" | "symplectic-euler" => {
            "the springs; then passes over the vectors for pins, velocities and positions."
        }
        "leapfrog:damping=explicit" => {
            "the springs once, and their damping four times: each half kick is a step of Heun's method, with two sweeps for \
             damping and four passes over the vectors."
        }
        "adams-bashforth2" => {
            "the springs; then a division and five vectors of history a particle, in loops of one particle after the other."
        }
        "leapfrog" => {
            "damping is a sweep of its own at the start and a solve with a kept factor at the end, whose residual is checked; \
             neither is in the bound."
        }
        "provot" => {
            "the limit on elongation visits the springs one after the other, each from where the last one left its ends: \
             a chain that no register can widen, and not in the bound."
        }
        "rkc" => {
            "the springs, once a stage; then each stage mixes eight vectors, four of positions and four of velocities, in passes \
             that leave the second-level cache."
        }
        "srkn4" => {
            "each of the seven kicks takes five products with the damping matrix one after the other, with a copy of the velocities \
             to and from one array a coordinate; the bound has products without copies."
        }
        "multirate" => {
            "slow and fast springs are swept apart, so that coordinates are copied for both; the damping of each short half kick is a \
             product of its own."
        }
        "energy-momentum" => {
            "each Newton iteration assembles and factorises an unsymmetric matrix of 3n rows, and discrete gradients are summed \
             spring by spring; neither is in the bound. The columns `set-up` and `solve` have their shares."
        }
        "backward-euler" | "bdf2" | "midpoint" | "generalized-alpha" | "dirk" => {
            "the six numbers of each block, 7 blocks a particle, do not stay in the second-level cache; they are made in double \
             precision and copied to single for conjugate gradients; residuals, starts and the line search are loops of one particle \
             after the other. The table of converged steps has other ways to solve."
        }
        "terzopoulos-fleischer" => {
            "each step assembles and factorises a matrix of 3n rows, which is not in the bound."
        }
        "rosenbrock" => {
            "each step factorises a matrix of 3n rows, which may be indefinite, and solves with it once a stage; neither is in the bound."
        }
        "exponential" => {
            "each new vector of the subspace is made orthogonal to all before it. A step counts that as products; the vectors of a \
             large sheet come from memory and not from the second-level cache, whose speed the bound has."
        }
        "projective" => {
            "each of ten iterations solves with the kept factor, which is not in the bound; then the loops of the gradient, particle by \
             particle."
        }
        "vbd" => {
            "a sweep meets each spring from both of its ends, builds a block of 3 × 3 numbers a particle and solves with it: about \
             four times the operations of a sweep for forces. Neighbours are gathered from where they are, four particles at a time."
        }
        "xpbd" => {
            "a spring sees what the springs before it have moved: springs without a common particle go four or eight at a time, with \
             gathers and scatters in place of loads, a second quotient, and the multiplier and the damping of each spring read and written."
        }
        "xpbd-lines" => {
            "elimination goes along a line and back, and each spring waits for the one before it; four lines go side by side. \
             The damping of each line is a second elimination."
        }
        "imex-rk" => {
            "two stages a step, each with explicit and linear forces apart and a solve with the kept factor, which is not in the bound."
        }
        "baraff-witkin" => {
            "the six numbers of each block, 7 blocks a particle, are 0.9 MB on 52 × 52 particles and 3.4 MB on 100 × 100: they do not \
             stay in a second-level cache of 1 MB, whose speed the bound has."
        }
        "desbrun" => {
            "the application of the kept factor is not in the bound, nor are the damping forces for the correction of the \
             torque, a sweep of their own, nor the copies of a vector to and from the layout of the product by diagonals."
        }
        "kang" => {
            "the springs; then for each of two products the copies of a vector to and from the layout by diagonals, and \
             quotients and sums in loops of one particle after the other."
        }
        "imex-euler" => {
            "IC(0), the preconditioner of the paper, is not in the bound: it goes through rows that wait for the rows before \
             them. `peers.md` has the step with other preconditioners."
        }
        "imex-updated" => {
            "of force evaluations half are energies, whose springs are added one after the other; then IC(0), which is not in \
             the bound."
        }
        "imex-sbdf2" | "imex-cnab2" | "imex-mcnab2" | "imex-cnlf" => {
            "explicit and linear forces are evaluated apart, and the linear ones once more at the extrapolated positions; the reference \
             of the stop test and the right-hand side are loops of one particle after the other; then as imex-euler."
        }
        _ => return None,
    })
}

/// What all methods pay, after what a sweep takes here.
pub(crate) const SPRINGS: &str = "\
the other 33 flops of a spring, reads at the distance of a diagonal, and a fifth for copying coordinates to one array each and back \
(the docs of the springs' sweep have what was tried). No step that sweeps comes nearer to its bound than that.";

/// The method whose forces are one sweep over the springs and nothing else.
pub(crate) const SWEEP: &str = "symplectic-euler";
