//! Which methods share a panel, and how each of their curves looks.

use crate::plot::Look;

/// Families in the order of their panels: title and method ids.
const FAMILIES: [(&str, &[&str]); 6] = [
    ("Explicit", &["explicit-euler", "symplectic-euler", "leapfrog", "adams-bashforth2"]),
    ("Implicit", &["backward-euler", "baraff-witkin", "terzopoulos-fleischer", "bdf2"]),
    ("Implicit-explicit, one step", &["imex-euler", "imex-updated"]),
    ("Implicit-explicit, two steps", &["imex-sbdf2", "imex-cnab2", "imex-mcnab2", "imex-cnlf"]),
    ("Filtered or corrected", &["provot", "desbrun", "kang"]),
    ("Adaptive steps", &["dop853"]),
];
const OTHERS: &str = "Other methods";
/// Place of the family of methods that choose their steps themselves, and how their labels end.
const ADAPTIVE: (usize, &str) = (5, ", adaptive");

/// The members of a family that a record has.
pub struct Family<'a> {
    /// Title of its panel.
    pub title: &'static str,
    /// Labels of its curves, in the record's order, each with a look that no other family's curve
    /// has, as long as there are at most seven.
    pub members: Vec<(&'a str, Look)>,
}

/// Sorts labels into families; `rows` are the method ids (with or without settings) and labels of a
/// record's rows. Families without members are left out.
pub fn families<'a>(rows: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<Family<'a>> {
    let mut labels: Vec<Vec<&str>> = vec![Vec::new(); FAMILIES.len() + 1];
    for (method, label) in rows {
        let id = method.split(':').next().unwrap_or(method);
        let place = FAMILIES.iter().position(|(_, ids)| ids.contains(&id));
        let place = if label.ends_with(ADAPTIVE.1) { Some(ADAPTIVE.0) } else { place };
        let place = place.unwrap_or(FAMILIES.len());
        if !labels[place].contains(&label) {
            labels[place].push(label);
        }
    }
    let titles = FAMILIES.iter().map(|(title, _)| *title).chain([OTHERS]);
    let members = |(family, labels): (usize, Vec<&'a str>)| {
        let look = |n| Look::pair(n, n + family);
        labels.into_iter().enumerate().map(|(n, label)| (label, look(n))).collect()
    };
    titles
        .zip(labels.into_iter().enumerate().map(members))
        .map(|(title, members): (_, Vec<_>)| Family { title, members })
        .filter(|family| !family.members.is_empty())
        .collect()
}

/// All labels, family by family.
pub fn labels<'a>(rows: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<String> {
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
            ("kang:sweeps=8", "kang, 8 sweeps"),
            ("imex-euler:forcing_term=1e-10", "imex-euler"),
            ("kang", "kang"),
            ("kang:sweeps=8", "kang, 8 sweeps"),
            ("imex-euler:tolerance=0.1", "imex-euler, adaptive"),
        ];
        let families = families(rows.into_iter());
        let titles: Vec<_> = families.iter().map(|family| family.title).collect();
        assert_eq!(
            titles,
            ["Implicit-explicit, one step", "Filtered or corrected", "Adaptive steps", OTHERS]
        );
        let labels: Vec<_> = families[1].members.iter().map(|(label, _)| *label).collect();
        assert_eq!(labels, ["kang, 8 sweeps", "kang"]);
    }

    #[test]
    fn no_two_curves_look_alike() {
        let ids: Vec<String> = FAMILIES
            .iter()
            .flat_map(|(_, ids)| (0..7).map(move |n| format!("{}:variant={n}", ids[0])))
            .collect();
        let families = families(ids.iter().map(|id| (id.as_str(), id.as_str())));
        let looks: Vec<Look> =
            families.iter().flat_map(|family| &family.members).map(|(_, look)| *look).collect();
        assert_eq!(looks.len(), 42);
        for (n, look) in looks.iter().enumerate() {
            assert!(!looks[..n].contains(look), "{n}");
        }
    }
}
