//! Methods that users add to ours: in Rust when their program starts, or as programs in any
//! language. Studies run them at their defaults, and nothing is known of them without running them.

use super::runs::Runs;
use super::{Entry, MethodError, REGISTRY, find};
use crate::need::Matrix;
use crate::sha256;
use crate::theory::{Theory, no_theorem};
use drape_integrator::Registration;
use drape_report::family::Kin;
use std::sync::{PoisonError, RwLock};

/// Methods that studies run beside ours.
static ADDED: RwLock<Vec<&'static Entry>> = RwLock::new(Vec::new());
/// Programs that were called by name.
static CALLED: RwLock<Vec<&'static Entry>> = RwLock::new(Vec::new());
/// The ids of the only methods that studies compare.
static CHOSEN: RwLock<Option<Vec<&'static str>>> = RwLock::new(None);

fn copied<T: Clone>(lock: &RwLock<T>) -> T {
    lock.read().unwrap_or_else(PoisonError::into_inner).clone()
}

fn push(lock: &RwLock<Vec<&'static Entry>>, entry: &'static Entry) {
    lock.write().unwrap_or_else(PoisonError::into_inner).push(entry);
}

/// Ours, then those that were added.
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

/// Adds a method to the registry: from now on every command and every study knows it by its id.
///
/// # Errors
/// [`MethodError::Taken`] for an id that is there already, [`MethodError::BadId`] for one that no
/// command line could name.
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

/// How the method of that id is built.
pub fn registration(id: &str) -> Option<Registration> {
    find(id).map(|entry| *entry.registration)
}

/// The entry of a program, which is started to say what it is.
pub(super) fn program(command: &str) -> Result<&'static Entry, MethodError> {
    let registration = drape_program::load(command).map_err(MethodError::Program)?;
    let id = registration.method.id;
    Ok(find(id).unwrap_or_else(|| {
        let entry = entry(*registration);
        push(&CALLED, entry);
        entry
    }))
}

/// Restricts studies that compare all methods to these: ids, or `program:COMMAND`. Programs are
/// added to the registry. Methods with which a study computes its references still run.
///
/// # Errors
/// [`MethodError`] for an unknown id, or for a program that does not say what it is.
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

/// Whether a user added the method of that id: then no theory of it is known.
pub(crate) fn is_added(id: &str) -> bool {
    copied(&ADDED).iter().any(|entry| entry.registration.method.id == id)
}

/// Whether the methods that studies compare are all of ours and no others. Their records do not
/// belong beside the committed ones otherwise.
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

/// What tells one set of methods from another, for journals: ids, and the SHA-256 of each file that
/// the command of a program names.
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

/// Gives programs at most so long for each answer while the limit lives.
pub(crate) fn programs_answer_within(limit: std::time::Duration) -> drape_program::AnswerLimit {
    drape_program::answer_within(limit)
}

/// Kills all programs that run: for a process that ends at once.
pub fn kill_programs() {
    drape_program::kill_all();
}

/// What programs did wrong in this process, each sentence with how often it came.
pub fn program_failures() -> Vec<(String, u64)> {
    drape_program::failures()
}
