//! The forms of methods that take part, and the steps a frame with which each is tried.

use crate::HarnessError;
use crate::methods::runs::{Film, Inside, Substeps, Variant};
use crate::methods::{self, Choice};
use crate::studies::variant::{is_explicit, or_defaults};
use drape_model::Violation;

/// Most steps a frame of a form that stiffness does not limit.
const MOST: u32 = 256;
/// Most steps a frame of a form that stiffness limits, over the number at the limit of stability.
const MOST_LIMITED: f64 = 16.0;
/// Fewest steps a frame of such a form, over that number.
const LEAST_LIMITED: f64 = 0.7;

/// A form that takes part.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) label: String,
    pub(super) choice: Choice,
    pub(super) substeps: Substeps,
}

impl Entry {
    /// The entry of a choice, labelled with all its settings.
    pub(super) fn of(choice: &Choice) -> Self {
        let substeps =
            if is_explicit(choice.method()) { Substeps::Limit } else { Substeps::Ladder };
        Self { label: choice.full_id(), choice: choice.clone(), substeps }
    }
}

/// All forms of the registry: those of the study `animation`, and each method at its defaults.
fn registered() -> impl Iterator<Item = Film> {
    methods::runs().flat_map(|(method, runs)| {
        let substeps = if is_explicit(method) { Substeps::Limit } else { Substeps::Ladder };
        let mut films = or_defaults(method, runs.animation, |form| Film { form, substeps });
        if films.iter().all(|film| film.form.method != method.id) {
            // A form under the bare id has settings that this label hides: write them out.
            for film in films.iter_mut().filter(|film| film.form.label == method.id) {
                film.form.label = film.form.method;
            }
            films.push(Film { form: Variant::new(method.id, method.id), substeps });
        }
        films
    })
}

/// A form; if a setting fixes its work in a call, also the form with the second least work that the
/// study `animation` tries with one call a frame. More calls a frame fill the gap between the two.
fn entries(film: &Film) -> Result<Vec<Entry>, HarnessError> {
    let Variant { label, method } = film.form;
    let mut entries = Vec::new();
    let mut add = |label: String, method: &str| {
        let choice = Choice::parse(method, &[])?;
        entries.push(Entry { label, choice, substeps: film.substeps });
        Ok::<(), HarnessError>(())
    };
    add(label.to_owned(), method)?;
    if let Some(inside) = Inside::of(method, label) {
        let in_one_call = inside.rungs.iter().filter(|(calls, _)| *calls == 1);
        if let Some(&(_, value)) = in_one_call.take(2).last() {
            add(format!("{label}, {value} {}", inside.setting), &inside.with(method, value))?;
        }
    }
    Ok(entries)
}

/// The forms that `text` names, or all of the registry. Commas separate methods, and also the
/// settings of one method: a part with `=` and without a colon before it belongs to the method
/// before. A bare id stands for all registered forms of the method.
pub(super) fn chosen(text: Option<&str>) -> Result<Vec<Entry>, HarnessError> {
    let Some(text) = text else {
        let all: Result<Vec<_>, _> = registered().map(|film| entries(&film)).collect();
        return all.map(|all| distinct(all.into_iter().flatten()));
    };
    let mut named: Vec<String> = Vec::new();
    for part in text.split(',').map(str::trim) {
        let continues = part.find('=').is_some_and(|at| !part[..at].contains(':'));
        match named.last_mut() {
            Some(method) if continues => {
                let mark = if method.contains(':') { "," } else { ":" };
                *method = format!("{method}{mark}{part}");
            }
            _ => named.push(part.to_owned()),
        }
    }
    let mut chosen: Vec<Entry> = Vec::new();
    for method in named {
        if method.is_empty() {
            let expected = "ids of methods between commas, such as `imex-euler,xpbd:order=2`";
            return Err(Violation {
                path: "--methods".to_owned(),
                value: format!("`{text}`"),
                expected: expected.to_owned(),
            }
            .into());
        }
        let choice = Choice::parse(&method, &[])?;
        let id = choice.method().id;
        let own = |film: &Film| method == id && film.form.method.split(':').next() == Some(id);
        let known = chosen.len();
        for film in registered().filter(own) {
            chosen.extend(entries(&film)?);
        }
        // The user's own settings, or a program: the registry does not know such a form.
        if chosen.len() == known {
            chosen.push(Entry { label: method, ..Entry::of(&choice) });
        }
    }
    Ok(distinct(chosen))
}

/// The entries without those whose settings an earlier one has.
fn distinct(entries: impl IntoIterator<Item = Entry>) -> Vec<Entry> {
    let mut seen = Vec::new();
    let mut is_new = |entry: &Entry| {
        let id = entry.choice.full_id();
        let is_new = !seen.contains(&id);
        seen.push(id);
        is_new
    };
    entries.into_iter().filter(|entry| is_new(entry)).collect()
}

/// The numbers of steps a frame with which a form is tried, coarse to fine. `limit` is the number
/// at the limit of symplectic Euler.
pub(super) fn ladder(substeps: Substeps, limit: u32) -> Vec<u32> {
    match substeps {
        Substeps::Ladder => {
            std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n <= MOST).collect()
        }
        Substeps::Limit => {
            let limit = f64::from(limit.max(1));
            let mut rungs: Vec<u32> = (0..)
                .map(|k| LEAST_LIMITED * limit * 2.0_f64.powf(0.5 * f64::from(k)))
                .take_while(|n| *n <= MOST_LIMITED * limit)
                .map(|n| n.ceil() as u32)
                .collect();
            rungs.dedup();
            rungs
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(text: &str) -> Vec<String> {
        let entries = chosen(Some(text)).unwrap_or_else(|error| panic!("{error}"));
        entries.into_iter().map(|entry| entry.choice.full_id()).collect()
    }

    #[test]
    fn every_method_takes_part_at_its_defaults_under_its_id() {
        let all = chosen(None).expect("the registry is valid");
        for method in methods::all() {
            let defaults = Choice::parse(method.id, &[]).expect("a method").full_id();
            let of_defaults = all.iter().filter(|entry| entry.choice.full_id() == defaults);
            let labels: Vec<_> = of_defaults.map(|entry| entry.label.as_str()).collect();
            assert_eq!(labels, [method.id]);
        }
    }

    #[test]
    fn commas_part_methods_and_settings() {
        let full = |text: &str| Choice::parse(text, &[]).expect("a method").full_id();
        assert_eq!(
            labels("imex-euler:forcing_term=0.05,start=last, xpbd:order=2"),
            [full("imex-euler:forcing_term=0.05,start=last"), full("xpbd:order=2")]
        );
        assert_eq!(
            labels("imex-euler:paper,norm=velocity,vbd:sweeps=7"),
            [full("imex-euler:paper,norm=velocity"), full("vbd:sweeps=7")]
        );
        // A bare id stands for its registered forms, once each.
        assert!(labels("xpbd,xpbd").len() >= 2);
        assert_eq!(labels("xpbd"), labels("xpbd,xpbd"));
        for wrong in ["", "xpbd,,vbd", "no-such-method", "xpbd:order=9"] {
            assert!(chosen(Some(wrong)).is_err(), "{wrong}");
        }
    }

    #[test]
    fn ladders_rise_and_begin_below_the_limit() {
        assert_eq!(ladder(Substeps::Ladder, 100)[..4], [1, 2, 4, 8]);
        for limit in [1, 3, 40, 1000] {
            let rungs = ladder(Substeps::Limit, limit);
            assert!(rungs.is_sorted() && rungs[0] <= limit, "{rungs:?}");
            assert!(rungs.last().is_some_and(|most| *most >= 8 * limit), "{rungs:?}");
        }
    }

    #[test]
    fn a_sweeping_method_takes_part_with_two_amounts_of_work_and_no_form_twice() {
        let all = chosen(None).expect("all forms parse");
        for label in ["xpbd-lines", "xpbd-lines, 6 substeps", "vbd", "vbd, 10 sweeps"] {
            assert_eq!(all.iter().filter(|entry| entry.label == label).count(), 1, "{label}");
        }
        let mut ids: Vec<_> = all.iter().map(|entry| entry.choice.full_id()).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), all.len());
    }
}
