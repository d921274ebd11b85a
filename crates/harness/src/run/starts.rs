//! Records the systems from which runs start, while [`watch`] is at work.

use super::Simulation;
use crate::system_hash;
use drape_model::SystemSpec;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// The recorded systems, by hash; `None` while nothing is recorded.
static SEEN: Mutex<Option<BTreeMap<String, SystemSpec>>> = Mutex::new(None);

/// Whether systems are recorded. A run that is not watched reads only this flag.
static IS_ASKED: AtomicBool = AtomicBool::new(false);

/// Records the system from which a run starts. Leaves out systems that cannot be frozen.
pub(crate) fn starts_from(simulation: &Simulation) {
    if !IS_ASKED.load(Ordering::Relaxed) {
        return;
    }
    let Ok(spec) = simulation.system.freeze(&simulation.state) else { return };
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(seen) = seen.as_mut() {
        seen.entry(system_hash(&spec)).or_insert(spec);
    }
}

/// Does some work, and returns the systems from which runs started meanwhile on any thread, the
/// smallest first. A system in another order of its particles counts as another system.
pub(crate) fn watch<T>(work: impl FnOnce() -> T) -> (T, Vec<SystemSpec>) {
    let set = |seen| {
        let is_asked = Option::is_some(&seen);
        let before =
            std::mem::replace(&mut *SEEN.lock().unwrap_or_else(PoisonError::into_inner), seen);
        IS_ASKED.store(is_asked, Ordering::Relaxed);
        before
    };
    set(Some(BTreeMap::new()));
    let done = work();
    let mut systems: Vec<SystemSpec> = set(None).into_iter().flatten().map(|(_, s)| s).collect();
    systems.sort_by_key(|spec| spec.particles.mass_kg.len());
    (done, systems)
}
