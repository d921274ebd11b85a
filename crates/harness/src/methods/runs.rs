//! The forms of a method that the studies run.
//!
//! A study that compares all methods asks each for its forms. A method that names none runs at its
//! defaults, under its id, so a new method needs no entry here to be compared. Studies of single
//! properties (a spring that locks, the bill of effects) run the methods that ask for it.

use crate::presets::Preset;
use crate::theory::LoadLaw;

/// A method in certain settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Variant {
    /// Short name for tables and legends.
    pub(crate) label: &'static str,
    /// Method id with settings, as [`super::Choice::parse`] reads it.
    pub(crate) method: &'static str,
}

impl Variant {
    pub(crate) const fn new(label: &'static str, method: &'static str) -> Self {
        Self { label, method }
    }
}

/// Whether the method's statement of what it conserves is meant for a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keeps {
    AsStated,
    /// It is solved loosely, or treats momentum differently.
    Otherwise,
}

/// With which steps the study of locking runs a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Steps {
    All,
    /// The four longest: a step factorises several times.
    Long,
    /// The longest only.
    One,
}

/// How many calls of a form the study of animation makes in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Substeps {
    /// A few, from one on.
    Ladder,
    /// As few as keep it stable: stiffness limits its step.
    Limit,
}

/// A form in the study of animation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Film {
    pub(crate) form: Variant,
    pub(crate) substeps: Substeps,
}

impl Film {
    /// Stiffness does not limit its step.
    pub(crate) const fn ladder(label: &'static str, method: &'static str) -> Self {
        Self { form: Variant::new(label, method), substeps: Substeps::Ladder }
    }

    /// Stiffness limits its step.
    pub(crate) const fn limit(label: &'static str, method: &'static str) -> Self {
        Self { form: Variant::new(label, method), substeps: Substeps::Limit }
    }
}

/// A form in the study of scaling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contender {
    pub(crate) label: &'static str,
    pub(crate) method: &'static str,
    /// Particles along each edge of the largest mesh on which a step takes no more than seconds.
    pub(crate) largest: u32,
}

impl Contender {
    /// On meshes on which a step of any method takes no more than seconds.
    pub(crate) const fn usual(form: Variant) -> Self {
        Self { label: form.label, method: form.method, largest: 52 }
    }
}

/// The forms of one method, study by study.
#[derive(Debug)]
pub(crate) struct Runs {
    /// Settings that a user can call by a name.
    pub(crate) presets: &'static [Preset],
    /// Solved so tightly that the error of the step shows.
    pub(crate) order: &'static [Variant],
    pub(crate) energy: &'static [Variant],
    pub(crate) momentum: &'static [(Variant, Keeps)],
    /// Forms with limits of their own: as published, of other orders, solved exactly.
    pub(crate) stability: &'static [Variant],
    pub(crate) hard_cases: &'static [Variant],
    /// Solved tightly.
    pub(crate) locking: &'static [(Variant, Steps)],
    /// The law of a single spring that is loaded across itself, where one is known.
    pub(crate) locked_spring: &'static [(Variant, LoadLaw)],
    pub(crate) work_precision: &'static [work::Variant],
    /// The first stands for the method in scenes that are too dear for all forms.
    pub(crate) animation: &'static [Film],
    /// Named where larger meshes than [usual](Contender::usual) serve, or not even these.
    pub(crate) scaling: &'static [Contender],
    /// Whether the study of effects takes times with it.
    pub(crate) are_effects_timed: bool,
    /// Whether it is in the quick subset of the study of effects.
    pub(crate) are_effects_quick: bool,
}

impl Runs {
    /// The method at its defaults in all studies that compare all methods.
    pub(crate) const DEFAULTS: Self = Self {
        presets: &[],
        order: &[],
        energy: &[],
        momentum: &[],
        stability: &[],
        hard_cases: &[],
        locking: &[],
        locked_spring: &[],
        work_precision: &[],
        animation: &[],
        scaling: &[],
        are_effects_timed: false,
        are_effects_quick: false,
    };
}

/// Forms in the study of work and precision.
pub(crate) mod work {
    /// What differs between the runs of a form.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) enum Knob {
        /// The number of steps, doubled from run to run.
        Steps,
        /// A setting of the method, which divides the steps that it is given: its name and values,
        /// coarsest first.
        Setting(&'static str, &'static [f64]),
        /// The tolerance of the adaptive method of a library.
        Library(&'static [f64]),
    }

    /// Where a form is run.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(crate) enum Scope {
        /// Everywhere, all its runs timed; it stands in the headline figure.
        Headline,
        /// Everywhere.
        Main,
        /// In the series over the stiffness with light damping only.
        Extra,
    }

    /// A method in certain settings, with a knob.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct Variant {
        /// Short name for tables and legends.
        pub(crate) label: &'static str,
        /// Method id with settings, as [`crate::methods::Choice::parse`] reads it.
        pub(crate) method: &'static str,
        pub(crate) knob: Knob,
        pub(crate) scope: Scope,
    }

    impl Variant {
        const fn new(label: &'static str, method: &'static str, scope: Scope) -> Self {
            Self { label, method, knob: Knob::Steps, scope }
        }

        /// With another knob than the number of steps.
        pub(crate) const fn knob(self, knob: Knob) -> Self {
            Self { knob, ..self }
        }
    }

    /// Local error of positions that a method under step size control may make, in mesh widths.
    const LOCAL_ERRORS: &[f64] = &[1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001];

    pub(crate) const fn headline(label: &'static str, method: &'static str) -> Variant {
        Variant::new(label, method, Scope::Headline)
    }

    pub(crate) const fn main(label: &'static str, method: &'static str) -> Variant {
        Variant::new(label, method, Scope::Main)
    }

    pub(crate) const fn extra(label: &'static str, method: &'static str) -> Variant {
        Variant::new(label, method, Scope::Extra)
    }

    /// A method under step size control.
    pub(crate) const fn adaptive(label: &'static str, method: &'static str) -> Variant {
        extra(label, method).knob(Knob::Setting("tolerance", LOCAL_ERRORS))
    }
}
