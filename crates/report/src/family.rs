//! Assignment of methods to panels, and the look of their curves.

use crate::plot::Look;
use std::collections::BTreeMap;

/// The panel that a method belongs to, in the order of the panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kin {
    /// Explicit steps of one or two force evaluations. The stiffness limits the step.
    Explicit,
    /// Explicit steps of many force evaluations: stabilised, of order 4, or of several lengths.
    ExplicitStages,
    /// All springs are in the matrix, with their tangents.
    Implicit,
    /// As [`Implicit`](Self::Implicit), of order two or higher.
    ImplicitStages,
    /// One linearisation at the start of the step; no further iteration.
    Linearised,
    /// Springs or particles are solved one by one, or repeatedly with a constant matrix.
    Local,
    /// One step, a constant matrix.
    ImplicitExplicit,
    /// Two steps, a constant matrix.
    TwoSteps,
    /// A solution that is filtered or corrected.
    Corrected,
    /// The method chooses its steps itself.
    Adaptive,
    /// Any other method.
    Other,
}

impl Kin {
    /// All panels, in order.
    pub const ALL: [Self; 11] = [
        Self::Explicit,
        Self::ExplicitStages,
        Self::Implicit,
        Self::ImplicitStages,
        Self::Linearised,
        Self::Local,
        Self::ImplicitExplicit,
        Self::TwoSteps,
        Self::Corrected,
        Self::Adaptive,
        Self::Other,
    ];

    fn title(self) -> &'static str {
        match self {
            Self::Explicit => "Explicit",
            Self::ExplicitStages => "Explicit, in stages",
            Self::Implicit => "Implicit",
            Self::ImplicitStages => "Implicit, of higher order",
            Self::Linearised => "Linearised at the start",
            Self::Local => "Local solves",
            Self::ImplicitExplicit => "Implicit-explicit, one step",
            Self::TwoSteps => "Implicit-explicit, two steps",
            Self::Corrected => "Filtered or corrected",
            Self::Adaptive => "Adaptive steps",
            Self::Other => "Other methods",
        }
    }
}

/// The members of a family that a record has.
pub struct Family<'a> {
    /// The kind of its methods.
    pub kin: Kin,
    /// Title of the panel.
    pub title: &'static str,
    /// Labels of its curves, in the record's order, each with the look of its method.
    pub members: Vec<(&'a str, Look)>,
}

/// Sorts labels into families and leaves out families without members. Each of `rows` holds the
/// kin, the place of the method in the registry and the label in the record.
pub fn families<'a>(rows: impl Iterator<Item = (Kin, usize, &'a str)>) -> Vec<Family<'a>> {
    let mut forms: BTreeMap<usize, usize> = BTreeMap::new();
    let mut labels: [Vec<(&str, Look)>; Kin::ALL.len()] = Default::default();
    for (kin, place, label) in rows {
        let known = &mut labels[kin as usize];
        if !known.iter().any(|(other, _)| *other == label) {
            let form = forms.entry(place).or_default();
            known.push((label, Look::of_method(place, *form)));
            *form += 1;
        }
    }
    Kin::ALL
        .into_iter()
        .zip(labels)
        .map(|(kin, members)| Family { kin, title: kin.title(), members })
        .filter(|family| !family.members.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_sorted_by_kin_and_stand_once() {
        let rows = [
            (Kin::Other, 40, "new"),
            (Kin::Corrected, 1, "b"),
            (Kin::ImplicitExplicit, 2, "c"),
            (Kin::Corrected, 0, "a"),
            (Kin::Corrected, 1, "b"),
        ];
        let families = families(rows.into_iter());
        let titles: Vec<_> = families.iter().map(|family| family.title).collect();
        assert_eq!(
            titles,
            ["Implicit-explicit, one step", "Filtered or corrected", "Other methods"]
        );
        let labels: Vec<_> = families[1].members.iter().map(|(label, _)| *label).collect();
        assert_eq!(labels, ["b", "a"]);
    }

    /// Colour and marker mean one method in every figure; dashes tell its forms apart.
    #[test]
    fn a_method_has_one_look_whatever_stands_beside_it() {
        let of = |rows: &[(Kin, usize, &'static str)]| -> Vec<(&'static str, Look)> {
            let families = families(rows.iter().copied());
            families.into_iter().flat_map(|family| family.members).collect()
        };
        let few = of(&[(Kin::Corrected, 22, "filtered")]);
        let many = of(&[
            (Kin::Corrected, 21, "desbrun"),
            (Kin::Corrected, 21, "desbrun, no correction"),
            (Kin::Corrected, 22, "filtered"),
        ]);
        assert_eq!(few[0], many[2]);
        assert!(many[0].1 != many[1].1, "forms differ");
    }

    #[test]
    fn no_two_methods_look_alike() {
        let marks: Vec<_> = (0..49).map(|place| Look::of_method(place, 0).mark()).collect();
        for (n, mark) in marks.iter().enumerate() {
            assert!(!marks[..n].contains(mark), "{n}");
        }
    }
}
