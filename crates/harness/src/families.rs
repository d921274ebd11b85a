//! The families of methods, as figures and tables group them.

use crate::methods;
pub(crate) use drape_report::family::Family;
use drape_report::family::Kin;
use drape_report::plot::Look;

/// How the label of a form that controls its step ends.
const ADAPTIVE: &str = ", adaptive";
/// The adaptive method of the references, with which the methods are compared.
const DOP853: &str = "dop853";
/// Place of a method outside the registry.
const UNKNOWN: usize = 46;

fn kin(method: &str, label: &str) -> Kin {
    let id = method.split(':').next().unwrap_or(method);
    match methods::theory_of(id) {
        _ if label.ends_with(ADAPTIVE) || id == DOP853 => Kin::Adaptive,
        Some(theory) => theory.kin,
        None => Kin::Other,
    }
}

/// The place of a method in the registry, by its id, with or without settings, or by the label of a
/// form. Users' methods come after the registry.
fn place(name: &str) -> usize {
    let id = name.split([':', ',', ' ']).next().unwrap_or(name);
    let place = methods::all().position(|method| method.id == id);
    place.unwrap_or(if id == DOP853 { UNKNOWN + 1 } else { UNKNOWN })
}

/// Whether a method solves springs or particles one by one, or repeatedly with a constant matrix.
pub(crate) fn is_local(id: &str) -> bool {
    methods::theory_of(id).is_some_and(|theory| theory.kin == Kin::Local)
}

/// The looks of forms, in the order given. A method has one colour and marker in all figures;
/// dashes tell its forms apart.
pub(crate) fn looks(labels: &[&str]) -> Vec<Look> {
    let places: Vec<usize> = labels.iter().map(|label| place(label)).collect();
    let form = |n: usize| places[..n].iter().filter(|place| **place == places[n]).count();
    (0..labels.len()).map(|n| Look::of_method(places[n], form(n))).collect()
}

/// The look of a form among others, some of which may belong to the same method.
pub(crate) fn look_among(label: &str, known: &[&str]) -> Look {
    let place = known.iter().position(|other| *other == label);
    place.map_or_else(|| looks(&[label])[0], |place| looks(known)[place])
}

/// Sorts the rows of a record into families. Each row is a method, by its id with or without
/// settings, and a label.
pub(crate) fn families<'a>(rows: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<Family<'a>> {
    let of = |(method, label)| (kin(method, label), place(method), label);
    drape_report::family::families(rows.map(of))
}

/// All labels, family by family.
pub(crate) fn labels<'a>(rows: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<String> {
    let families = families(rows);
    let members = families.iter().flat_map(|family| &family.members);
    members.map(|(label, _)| (*label).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_has_one_look_in_all_figures() {
        assert!(methods::all().count() < UNKNOWN, "more methods than looks");
        let alone = looks(&["xpbd"]);
        let beside = looks(&["leapfrog", "xpbd:order=2", "xpbd, order 2", "xpbd-lines"]);
        assert_eq!(alone[0], beside[1]);
        assert!(beside[1] != beside[2] && beside[2] != beside[3] && beside[0] != beside[3]);
        assert_eq!(look_among("xpbd", &["leapfrog"]), alone[0]);
        assert_eq!(look_among("xpbd, order 2", &["xpbd", "xpbd, order 2"]), beside[2]);
        let rows = [("xpbd", "a curve"), ("leapfrog", "another")];
        let families = families(rows.into_iter());
        let members: Vec<_> = families.iter().flat_map(|family| &family.members).collect();
        assert!(members.contains(&&("a curve", alone[0])), "{members:?}");
    }

    #[test]
    fn labels_are_sorted_by_method_and_unknown_methods_come_last() {
        let rows = [
            ("new-method", "new"),
            ("desbrun:torque=none", "desbrun, no correction"),
            ("imex-euler:forcing_term=1e-10", "imex-euler"),
            ("desbrun", "desbrun"),
            ("imex-euler:tolerance=0.1", "imex-euler, adaptive"),
        ];
        let families = families(rows.into_iter());
        let titles: Vec<_> = families.iter().map(|family| family.title).collect();
        assert_eq!(
            titles,
            [
                "Implicit-explicit, one step",
                "Filtered or corrected",
                "Adaptive steps",
                "Other methods"
            ]
        );
        assert_eq!(labels(rows.into_iter())[1..3], ["desbrun, no correction", "desbrun"]);
    }
}
