//! The families of methods, as figures and tables group them.

use crate::methods;
pub(crate) use drape_report::family::Family;
use drape_report::family::Kin;

/// How the label of a form that controls its step ends.
const ADAPTIVE: &str = ", adaptive";
/// The adaptive method of a library, beside which the methods are compared.
const LIBRARY: &str = "dop853";

fn kin(method: &str, label: &str) -> Kin {
    let id = method.split(':').next().unwrap_or(method);
    match methods::theory_of(id) {
        _ if label.ends_with(ADAPTIVE) || id == LIBRARY => Kin::Adaptive,
        Some(theory) => theory.kin,
        None => Kin::Other,
    }
}

/// Sorts labels into families; `rows` are the methods (id, with or without settings) and labels of
/// a record's rows.
pub(crate) fn families<'a>(rows: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<Family<'a>> {
    drape_report::family::families(rows.map(|(method, label)| (kin(method, label), label)))
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
