//! Which methods share a panel, and how each of their curves looks.

use crate::plot::Look;

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
    /// Labels of its curves, in the record's order, each with a look that no other family's curve
    /// has, as long as there are at most seven.
    pub members: Vec<(&'a str, Look)>,
}

/// Sorts labels into families, and leaves out families without members. `rows` are the kin and the
/// label of a record's rows.
pub fn families<'a>(rows: impl Iterator<Item = (Kin, &'a str)>) -> Vec<Family<'a>> {
    let mut labels: [Vec<&str>; Kin::ALL.len()] = Default::default();
    for (kin, label) in rows {
        let place = &mut labels[kin as usize];
        if !place.contains(&label) {
            place.push(label);
        }
    }
    let members = |(family, labels): (usize, Vec<&'a str>)| {
        let look = |n| Look::of_family(n, family);
        labels.into_iter().enumerate().map(|(n, label)| (label, look(n))).collect()
    };
    Kin::ALL
        .into_iter()
        .zip(labels.into_iter().enumerate().map(members))
        .map(|(kin, members): (_, Vec<_>)| Family { title: kin.title(), members })
        .filter(|family| !family.members.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_sorted_by_kin_and_stand_once() {
        let rows = [
            (Kin::Other, "new"),
            (Kin::Corrected, "b"),
            (Kin::ImplicitExplicit, "c"),
            (Kin::Corrected, "a"),
            (Kin::Corrected, "b"),
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

    #[test]
    fn no_two_curves_look_alike() {
        let kins = Kin::ALL.into_iter().filter(|kin| *kin != Kin::Other);
        let rows: Vec<(Kin, String)> =
            kins.flat_map(|kin| (0..7).map(move |n| (kin, format!("{kin:?} {n}")))).collect();
        let families = families(rows.iter().map(|(kin, label)| (*kin, label.as_str())));
        let looks: Vec<Look> =
            families.iter().flat_map(|family| &family.members).map(|(_, look)| *look).collect();
        assert_eq!(looks.len(), 70);
        for (n, look) in looks.iter().enumerate() {
            assert!(!looks[..n].contains(look), "{n}");
        }
    }
}
