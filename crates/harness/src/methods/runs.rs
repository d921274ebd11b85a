//! The forms of a method that the studies run.
//!
//! A study that compares all methods asks each method for its forms. A method that names none runs
//! at its defaults, under its id, so a new method takes part without an entry here. Studies of
//! single properties (a spring that locks, the cost of effects) run only the methods that ask for
//! it.

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

/// Whether a form conserves what its method states that it conserves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keeps {
    AsStated,
    /// Not necessarily: it is solved loosely, or treats momentum differently.
    Otherwise,
}

/// The steps with which the study `locking` runs a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Steps {
    All,
    /// The four longest, because a step factorises several times.
    Long,
    /// The longest one.
    One,
}

/// How many calls of a form the study `animation` makes in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Substeps {
    /// A few, from one on.
    Ladder,
    /// As few as keep it stable, because stiffness limits its step.
    Limit,
}

/// A form in the study `animation`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Film {
    pub(crate) form: Variant,
    pub(crate) substeps: Substeps,
}

impl Film {
    /// A form whose step stiffness does not limit.
    pub(crate) const fn ladder(label: &'static str, method: &'static str) -> Self {
        Self { form: Variant::new(label, method), substeps: Substeps::Ladder }
    }

    /// A form whose step stiffness limits.
    pub(crate) const fn limit(label: &'static str, method: &'static str) -> Self {
        Self { form: Variant::new(label, method), substeps: Substeps::Limit }
    }
}

/// A form whose work in one call is fixed by a setting, such as its number of substeps. The study
/// `animation` tries several numbers, as it tries several numbers of steps of an explicit method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Inside {
    /// Label of the form.
    pub(crate) label: &'static str,
    /// Key of the setting, a plural noun.
    pub(crate) setting: &'static str,
    /// Number of calls a frame and value of the setting, cheapest first; at most as many pairs as
    /// an explicit method has numbers of steps.
    pub(crate) rungs: &'static [(u32, u32)],
}

impl Inside {
    /// The setting that fixes the work in a call of the method's form of this label.
    pub(crate) fn of(method: &str, label: &str) -> Option<&'static Self> {
        let runs = super::runs_of(super::parts(method).0)?;
        runs.inside.iter().find(|inside| inside.label == label)
    }

    /// The form with another value of the setting.
    pub(crate) fn with(&self, method: &str, value: u32) -> String {
        let (id, settings) = super::parts(method);
        let is_other =
            |text: &&str| !text.is_empty() && text.split('=').next() != Some(self.setting);
        let mut settings: Vec<_> =
            settings.split(',').filter(is_other).map(str::to_owned).collect();
        settings.push(format!("{}={value}", self.setting));
        format!("{id}:{}", settings.join(","))
    }
}

/// A form in the study `scaling`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contender {
    pub(crate) label: &'static str,
    pub(crate) method: &'static str,
    /// Particles along each edge of the largest mesh on which a step takes no more than seconds.
    pub(crate) largest: u32,
}

impl Contender {
    /// A form on the usual meshes, on which a step of any method takes no more than seconds.
    pub(crate) const fn usual(form: Variant) -> Self {
        Self { label: form.label, method: form.method, largest: 52 }
    }
}

/// The forms of one method, study by study.
#[derive(Debug)]
pub(crate) struct Runs {
    /// Settings that a user can call by a name.
    pub(crate) presets: &'static [Preset],
    /// Forms solved so tightly that the error of the step shows.
    pub(crate) order: &'static [Variant],
    pub(crate) energy: &'static [Variant],
    pub(crate) momentum: &'static [(Variant, Keeps)],
    /// Forms with limits of their own: as published, of other orders, solved exactly.
    pub(crate) stability: &'static [Variant],
    pub(crate) hard_cases: &'static [Variant],
    /// Forms solved tightly, each with its steps.
    pub(crate) locking: &'static [(Variant, Steps)],
    /// The law of a single spring that is loaded across itself, where one is known.
    pub(crate) locked_spring: &'static [(Variant, LoadLaw)],
    pub(crate) work_precision: &'static [work::Variant],
    /// The first form stands for the method in scenes that are too expensive for all forms.
    pub(crate) animation: &'static [Film],
    /// The forms among these whose work in a call is fixed by a setting.
    pub(crate) inside: &'static [Inside],
    /// Forms whose largest mesh is not the [usual](Contender::usual) one.
    pub(crate) scaling: &'static [Contender],
    /// Whether the study `effects` measures times with this method.
    pub(crate) are_effects_timed: bool,
    /// Whether the method is in the quick subset of the study `effects`.
    pub(crate) are_effects_quick: bool,
}

impl Runs {
    /// A method that runs at its defaults in all studies that compare all methods.
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
        inside: &[],
        scaling: &[],
        are_effects_timed: false,
        are_effects_quick: false,
    };
}

/// Forms in the study `work-precision`.
pub(crate) mod work {
    /// The parameter that varies between the runs of a form.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) enum Knob {
        /// The number of steps, doubled from run to run.
        Steps,
        /// A setting of a method that divides the given steps by itself: its name, and its values,
        /// the coarsest first.
        Setting(&'static str, &'static [f64]),
        /// The tolerance of DOP853.
        Tolerance(&'static [f64]),
    }

    /// The series of the study in which a form is run.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(crate) enum Scope {
        /// All series, with all runs timed; the form stands in the headline figure.
        Headline,
        /// All series.
        Main,
        /// Only the series over the stiffness with light damping.
        Extra,
    }

    /// A method in certain settings, with the parameter that varies.
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

        /// The same form, with another parameter than the number of steps.
        pub(crate) const fn knob(self, knob: Knob) -> Self {
            Self { knob, ..self }
        }
    }

    /// Tolerances on the local error of positions, in mesh widths, under step size control.
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
