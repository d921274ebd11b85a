//! Methods that users add to the registry: in Rust when their program starts, or as programs in any
//! language. Studies run them at their defaults. No theory of them is known.

use super::runs::Runs;
use super::{Entry, MethodError, REGISTRY, find};
use crate::need::Matrix;
use crate::sha256;
use crate::theory::{Theory, no_theorem};
use drape_integrator::Registration;
use drape_report::family::Kin;
use std::sync::{PoisonError, RwLock};

/// Methods that studies run beside those of drape.
static ADDED: RwLock<Vec<&'static Entry>> = RwLock::new(Vec::new());
/// Programs that were called by name.
static CALLED: RwLock<Vec<&'static Entry>> = RwLock::new(Vec::new());
/// The ids of the methods to which the user restricts studies; `None` without a restriction.
static CHOSEN: RwLock<Option<Vec<&'static str>>> = RwLock::new(None);

fn copied<T: Clone>(lock: &RwLock<T>) -> T {
    lock.read().unwrap_or_else(PoisonError::into_inner).clone()
}

fn push(lock: &RwLock<Vec<&'static Entry>>, entry: &'static Entry) {
    lock.write().unwrap_or_else(PoisonError::into_inner).push(entry);
}

/// The methods of drape, then the methods that were added.
pub(super) fn entries() -> impl Iterator<Item = &'static Entry> {
    REGISTRY.iter().copied().chain(copied(&ADDED))
}

/// The program of that id, if it was called before.
pub(super) fn called(id: &str) -> Option<&'static Entry> {
    copied(&CALLED).into_iter().find(|entry| entry.registration.method.id == id)
}

fn entry(registration: Registration) -> &'static Entry {
    let theory = Theory {
        case: |_| no_theorem("no theorem is known of a method that a user added"),
        kin: Kin::Other,
        matrix: |_| Matrix::None,
        divides: false,
        is_limited: false,
        forms: &[],
    };
    let registration = Box::leak(Box::new(registration));
    Box::leak(Box::new(Entry { registration, lesson: None, theory, runs: Runs::DEFAULTS }))
}

/// Adds a method to the registry. From then on every command and every study knows it by its id.
///
/// # Errors
/// [`MethodError::Taken`] for an id that the registry has already, [`MethodError::BadId`] for an id
/// that no command line could name.
///
/// ```
/// use drape_harness::methods;
/// let again = methods::add(drape_backward_euler_registration());
/// assert!(again.is_err_and(|error| error.to_string().contains("`backward-euler`")));
/// # fn drape_backward_euler_registration() -> drape_integrator::Registration {
/// #     methods::registration("backward-euler").expect("one of ours")
/// # }
/// ```
pub fn add(registration: Registration) -> Result<(), MethodError> {
    let id = registration.method.id;
    let is_sound = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if id.is_empty() || !id.chars().all(is_sound) {
        return Err(MethodError::BadId { id: id.to_owned() });
    }
    if find(id).is_some() {
        return Err(MethodError::Taken { id: id.to_owned() });
    }
    push(&ADDED, entry(registration));
    Ok(())
}

/// The registration of the method of that id, from which integrators are built; `None` for an
/// unknown id.
pub fn registration(id: &str) -> Option<Registration> {
    find(id).map(|entry| *entry.registration)
}

/// The entry of a program. Starts the program, which describes its method.
pub(super) fn program(command: &str) -> Result<&'static Entry, MethodError> {
    let registration = drape_program::load(command).map_err(MethodError::Program)?;
    let id = registration.method.id;
    Ok(find(id).unwrap_or_else(|| {
        let entry = entry(*registration);
        push(&CALLED, entry);
        entry
    }))
}

/// Restricts studies that compare all methods to these ids. An id may be `program:COMMAND`; such
/// programs are added to the registry. Methods with which a study computes its references still
/// run.
///
/// # Errors
/// [`MethodError`] for an unknown id, or for a program that does not describe its method.
pub fn choose<'a>(ids: impl IntoIterator<Item = &'a str>) -> Result<(), MethodError> {
    let mut chosen = Vec::new();
    for id in ids {
        let entry = match id.strip_prefix(drape_program::PREFIX) {
            Some(command) => {
                let entry = program(command)?;
                if !entries().any(|known| std::ptr::eq(known, entry)) {
                    push(&ADDED, entry);
                }
                entry
            }
            None => find(id).ok_or_else(|| MethodError::unknown(id))?,
        };
        let id = entry.registration.method.id;
        if !chosen.contains(&id) {
            chosen.push(id);
        }
    }
    *CHOSEN.write().unwrap_or_else(PoisonError::into_inner) = Some(chosen);
    Ok(())
}

/// Whether studies that compare all methods compare this one.
pub(crate) fn is_chosen(id: &str) -> bool {
    copied(&CHOSEN).is_none_or(|chosen| chosen.contains(&id))
}

/// Whether a user added the method of that id. Then no theory of it is known.
pub(crate) fn is_added(id: &str) -> bool {
    copied(&ADDED).iter().any(|entry| entry.registration.method.id == id)
}

/// Whether studies compare all methods of drape and no others. Otherwise their records do not
/// belong beside the committed ones.
pub fn are_ours_alone() -> bool {
    copied(&ADDED).is_empty() && copied(&CHOSEN).is_none()
}

/// The options that choose the same methods on a command line; empty if none were chosen.
pub(crate) fn options() -> String {
    let chosen = copied(&CHOSEN).unwrap_or_default();
    let option = |id: &&str| {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=".contains(c);
        match id.chars().all(is_plain) {
            true => format!(" --methods {id}"),
            false => format!(" --methods '{}'", id.replace('\'', "'\\''")),
        }
    };
    chosen.iter().map(option).collect()
}

/// The identity of a set of methods, for journals: ids, and the SHA-256 of each file that the
/// command of a program names.
pub(crate) fn identity() -> Vec<String> {
    let added = copied(&ADDED).into_iter().map(|entry| entry.registration.method.id);
    let mut identity: Vec<String> = added
        .map(|id| {
            let command = id.strip_prefix(drape_program::PREFIX).unwrap_or_default();
            let files = command.split(|c: char| c.is_whitespace() || "'\"".contains(c));
            let sums = files.filter_map(|file| std::fs::read(file).ok()).map(|text| sha256(&text));
            std::iter::once(format!("added {id}")).chain(sums).collect::<Vec<_>>().join(" ")
        })
        .collect();
    let chosen = copied(&CHOSEN).unwrap_or_default();
    identity.extend(chosen.into_iter().map(|id| format!("chosen {id}")));
    identity
}

/// Limits the time of programs for each answer, for as long as the returned value lives.
pub(crate) fn programs_answer_within(limit: std::time::Duration) -> drape_program::AnswerLimit {
    drape_program::answer_within(limit)
}

/// Kills all running programs. A process that ends at once calls it.
pub fn kill_programs() {
    drape_program::kill_all();
}

/// The failures of programs in this process: sentences, each with the number of its occurrences.
pub fn program_failures() -> Vec<(String, u64)> {
    drape_program::failures()
}
