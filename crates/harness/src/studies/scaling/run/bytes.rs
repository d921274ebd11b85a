//! The least bytes that a step must move through memory once its arrays have left the caches.
//!
//! Bytes are counted a particle, for a grid whose couplings need no storage of their own. A vector
//! of three coordinates has 24 bytes. Data that one kernel reads twice come from the caches the
//! second time. Data that the next kernel reads again come from memory again.
//!
//! | kernel | reads | writes | bytes |
//! |---|---|---|---|
//! | explicit step: force and update fused | mass, x, v | x, v | 104 |
//! | forces and right-hand side | mass, x, v | b | 80 |
//! | start `2v_n − v_{n−1}` | both | start | 72 |
//! | first residual `r = b − A v` | diagonal, v, b | r | 80 |
//! | IC(0), once for each residual: two sweeps | diagonal and two entries twice, r, y | y, z | 144 |
//! | CG: `q = A p` with `p·q` | diagonal, p | q | 56 |
//! | CG: `v += α p`, `r −= α q` with `‖r‖` | v, r, p, q | v, r | 144 |
//! | CG: `p = z + β p` | z, p | p | 72 |
//! | end: positions; vectors of velocities change places | v, x | x | 72 |
//!
//! With Jacobi's preconditioner two sweeps an iteration do everything:
//!
//! | sweep | reads | writes | bytes |
//! |---|---|---|---|
//! | start `2v_n − v_{n−1}` and first residual, with `rᵀD⁻¹r` | diagonal twice, v_n, v_{n−1}, b | v, r | 136 |
//! | `v += α p` of before, `p = D⁻¹ r + β p`, `q = A p`, `p·q` | diagonal twice, v, r, p | v, p, q | 160 |
//! | `r −= α q`, `‖r‖`, `rᵀD⁻¹r` | diagonal, r, q | r | 80 |
//! | `v += α p` of the last iteration | v, p | v | 72 |

const EXPLICIT: f64 = 104.0;
const FORCES: f64 = 80.0;
const START: f64 = 72.0;
const RESIDUAL: f64 = 80.0;
const PRECONDITIONER: f64 = 144.0;
const ITERATION: f64 = 56.0 + 144.0 + 72.0;
const END: f64 = 72.0;
const JACOBI_START: f64 = 136.0;
const JACOBI_ITERATION: f64 = 160.0 + 80.0;
const JACOBI_LAST: f64 = 72.0;

/// Label of IMEX Euler with Jacobi's preconditioner.
pub(super) const JACOBI: &str = "imex-euler, Jacobi";

/// Bytes a particle and step of a method; `None` if the method's bytes have not been counted.
pub(super) fn least(label: &str, iterations_per_step: f64) -> Option<f64> {
    match label {
        "symplectic-euler" => Some(EXPLICIT),
        "imex-euler" => {
            let solve =
                RESIDUAL + PRECONDITIONER + iterations_per_step * (PRECONDITIONER + ITERATION);
            Some(FORCES + START + solve + END)
        }
        JACOBI => {
            let solve = JACOBI_START + iterations_per_step * JACOBI_ITERATION + JACOBI_LAST;
            Some(FORCES + solve + END)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_iteration_more_moves_what_its_kernels_move() {
        assert_eq!(least("imex-euler", 0.0), Some(448.0));
        assert_eq!(least("imex-euler", 2.0), Some(448.0 + 2.0 * 416.0));
        assert_eq!(least(JACOBI, 2.0), Some(360.0 + 2.0 * 240.0));
        assert_eq!(least("symplectic-euler", 0.0), Some(104.0));
        assert_eq!(least("desbrun", 0.0), None);
    }
}
