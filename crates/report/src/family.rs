//! Which methods share a panel, and how each of their curves looks.

use crate::plot::Look;
use std::collections::BTreeMap;

/// Which panel a method belongs to, in the order of the panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kin {
    /// The stiffness limits the step, of one or two force evaluations.
    Explicit,
    /// Explicit steps of many force evaluations: stabilised, of order 4, or of several lengths.
    ExplicitStages,
    /// All springs stand in the matrix with their tangents.
    Implicit,
    /// The same, of second order and more.
    ImplicitStages,
    /// The tangent at the start of the step is all that it knows of the new level.
    Linearised,
    /// Springs or particles are solved one by one, or by a constant matrix, over and over.
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
    const ALL: [Self; 11] = [
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
    /// Title of its panel.
    pub title: &'static str,
    /// Labels of its curves, in the record's order, each with the look of its method.
    pub members: Vec<(&'a str, Look)>,
}

/// Sorts labels into families, and leaves out families without members. `rows` are the kin, the place
/// of the method in the registry and the label of a record's rows.
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
        .map(|(kin, members)| Family { title: kin.title(), members })
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
