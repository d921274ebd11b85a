//! Lessons: a method on a single spring, with a question that theory answers.
//!
//! A lesson stands in the module of its method ([`crate::methods`]). Its equations and its code are
//! excerpts of the method's crate. Its numbers follow from the method's law on the oscillator
//! `x'' = −κx − δx'`, so no answer is typed in. `tests/tests/lessons.rs` runs every lesson on its
//! own scene and compares the results with the answers.

mod excerpt;
mod law;
mod question;

pub use excerpt::Excerpt;
pub(crate) use law::Law;
pub(crate) use question::gravity;
pub use question::{Mark, Question};

use crate::methods;
use crate::theory::LoadLaw;
use drape_integrator::Method;

/// Points of the curve of [`Lesson::radii`].
const POINTS: i32 = 41;
/// The curve covers steps from one over this to this times the step of the lesson.
const SPAN: f64 = 100.0;

/// The setting that a lesson opens: one spring with one or more methods.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Name of the bundled scene.
    pub scene: &'static str,
    /// Methods with their settings. The question is about the first.
    pub methods: &'static [&'static str],
    /// Stiffness over mass `κ`, 1/s².
    pub stiffness: f64,
    /// Damping over mass `δ`, 1/s.
    pub damping: f64,
    /// Time step `h`, s.
    pub step: f64,
    /// Simulated time, s.
    pub duration: f64,
}

impl Setting {
    /// The oscillator with this method beside another one.
    pub(crate) const fn oscillator(methods: &'static [&'static str]) -> Self {
        let scene = "oscillator";
        Self { scene, methods, stiffness: 100.0, damping: 0.0, step: 0.01, duration: 1.0 }
    }

    /// The stiff spring with a load across it.
    pub(crate) const fn load(methods: &'static [&'static str]) -> Self {
        let scene = "loaded-spring";
        Self { scene, methods, stiffness: 1e6, damping: 0.0, step: 0.01, duration: 0.1 }
    }

    /// The same setting with another step and duration, s.
    pub(crate) const fn time(self, step: f64, duration: f64) -> Self {
        Self { step, duration, ..self }
    }

    /// The same setting with another spring: `κ` in 1/s², `δ` in 1/s.
    pub(crate) const fn spring(self, stiffness: f64, damping: f64) -> Self {
        Self { stiffness, damping, ..self }
    }

    /// Number of steps.
    pub fn steps(&self) -> u64 {
        (self.duration / self.step).round() as u64
    }

    /// `θ = h²κ` and `η = hδ` of a step of `h` seconds.
    pub(crate) fn numbers(&self, h: f64) -> (f64, f64) {
        (h * h * self.stiffness, h * self.damping)
    }
}

/// A common wrong answer.
#[derive(Clone, Copy, Debug)]
pub struct Trap {
    /// The answer, in the unit of the question.
    pub value: fn(&Setting) -> f64,
    /// Why it is wrong.
    pub hint: &'static str,
}

/// A lesson on one method.
#[derive(Debug)]
pub struct Lesson {
    /// Its title.
    pub title: &'static str,
    /// The idea to understand, in a few sentences.
    pub idea: &'static str,
    /// The crate of the method.
    pub docs: &'static str,
    /// Texts of that crate, by their files.
    pub sources: &'static [(&'static str, &'static str)],
    /// The equations, from the documentation of the crate.
    pub equation: Excerpt,
    /// The code that computes them.
    pub code: Excerpt,
    /// The effect of the method on the oscillator.
    pub(crate) law: Law,
    /// Its effect on a load across a stiff spring, if the question is about such a load.
    pub(crate) load: Option<LoadLaw>,
    /// The setting that it opens.
    pub setting: Setting,
    /// The question.
    pub question: Question,
    /// A further experiment to try.
    pub attempt: &'static str,
    /// The hint for an answer that is too small.
    pub low: &'static str,
    /// The hint for an answer that is too large.
    pub high: &'static str,
    /// Wrong answers with a hint of their own.
    pub traps: &'static [Trap],
    /// The study that goes on from here.
    pub study: &'static str,
}

/// All lessons with their methods, in the order of the registry. A method that was added has none.
pub fn lessons() -> impl Iterator<Item = (&'static Method, &'static Lesson)> {
    methods::taught()
}

/// The lesson on the method of that id.
///
/// # Errors
/// A sentence that names the known ids, where no lesson has that id.
pub fn find(id: &str) -> Result<(&'static Method, &'static Lesson), String> {
    lessons().find(|(method, _)| method.id == id).ok_or_else(|| {
        let known: Vec<_> = lessons().map(|(method, _)| method.id).collect();
        format!("no lesson `{id}`; expected one of {}", known.join(", "))
    })
}

impl Lesson {
    /// The equations; `None` if the crate no longer contains them.
    pub fn equation(&self) -> Option<String> {
        self.equation.find(self.sources)
    }

    /// The code; `None` if the crate no longer contains it.
    pub fn code(&self) -> Option<String> {
        self.code.find(self.sources)
    }

    /// The path of the file of an excerpt, from the root of drape.
    pub fn file(&self, excerpt: &Excerpt) -> String {
        let folder = self.docs.strip_prefix("drape-").unwrap_or(self.docs);
        format!("crates/integrators/{folder}/{}", excerpt.file)
    }

    /// Pairs of a step size, s, and the factor by which such a step multiplies the motion in the
    /// long run. The step sizes lie around that of the lesson, and the spring is that of the
    /// lesson.
    pub fn radii(&self) -> Vec<(f64, f64)> {
        let half = (POINTS - 1) / 2;
        let step =
            |n: i32| self.setting.step * libm::pow(SPAN, f64::from(n - half) / f64::from(half));
        (0..POINTS)
            .map(|n| {
                let h = step(n);
                let (theta, eta) = self.setting.numbers(h);
                (h, self.law.radius(theta, eta))
            })
            .collect()
    }
}
