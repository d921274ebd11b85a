//! Memory per particle: bytes that the allocator holds for the system, the state and the method.

use super::STEP;
use crate::HarnessError;
use crate::methods::{Choice, MethodError};
use crate::studies::Allocated;
use crate::studies::scaling::facts::Memory;
use crate::studies::sheet::Sheet;
use drape_integrator::TimeStep;
use drape_model::SystemSpec;
use std::time::Instant;

/// Particles along each edge of the sheets whose memory is measured.
pub(super) const SIZES: [u32; 5] = [10, 32, 100, 316, 1000];

/// The method that is measured.
pub(super) const METHOD: &str = "imex-euler";

/// The system of the sheet with additional bending springs.
pub(super) fn system(sheet: &Sheet) -> Result<SystemSpec, HarnessError> {
    let mut scene = sheet.scene();
    scene.effects.bending = scene.effects.shear.clone();
    Ok(scene.discretise()?)
}

/// Builds the sheet with bending springs, prepares the method, and measures the bytes that each
/// part holds. `allocated` gives the bytes that the allocator holds.
pub(super) fn measure(sheet: &Sheet, allocated: Allocated) -> Result<Memory, HarnessError> {
    let spec = system(sheet)?;
    let springs = spec.springs.len();
    let mut choice = Choice::parse(METHOD, &[])?.build().map_err(MethodError::from)?;
    let start = allocated();
    let begin = Instant::now();
    let (system, state) = spec.build()?;
    let build_s = begin.elapsed().as_secs_f64();
    let built = allocated();
    drop(state);
    let with_system = allocated();
    let begin = Instant::now();
    choice.prepare(&system, TimeStep::new(STEP)?)?;
    let prepare_s = begin.elapsed().as_secs_f64();
    let prepared = allocated();
    Ok(Memory {
        particles: system.len(),
        springs,
        label: METHOD.to_owned(),
        system_bytes: with_system.saturating_sub(start) as u64,
        state_bytes: built.saturating_sub(with_system) as u64,
        integrator_bytes: prepared.saturating_sub(with_system) as u64,
        build_s,
        prepare_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::scaling::run::{FIXED_QUOTIENT, Mesh};
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Returns 1, 2, 4, … bytes, as if each of the four moments held twice as much as the one
    /// before.
    fn doubling() -> usize {
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        1 << CALLS.fetch_add(1, Ordering::Relaxed)
    }

    #[test]
    fn bytes_are_told_apart_by_what_was_alive_between_two_looks() {
        let sheet = Mesh::new(FIXED_QUOTIENT, 10, 1).expect("a valid sheet").sheet;
        let memory = measure(&sheet, doubling).expect("a sheet");
        // 1 at the start, 2 after building, 4 after dropping the state, 8 at the end.
        assert_eq!((memory.system_bytes, memory.integrator_bytes), (3, 4));
        assert_eq!(memory.state_bytes, 0, "what shrinks the wrong way is nothing");
        // Tension along both edges, then shear and bending.
        assert_eq!((memory.particles, memory.springs), (100, 180 + 162 + 160));
    }
}
