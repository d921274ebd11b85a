//! The number of substeps that an explicit step needs.

use crate::{LargestEigenvalue, Method, PrepareError, StepError, StepReport, StiffnessBound, Word};
use drape_model::{Revisions, System, Vec3};

/// Factor of the estimated largest eigenvalue, which approaches the true one from below.
const MARGIN: f64 = 1.05;
/// Substeps between two estimates.
const INTERVAL: u32 = 30;
/// Products for each past [`INTERVAL`].
const PRODUCTS: u32 = 2;
/// Most products of one estimate that starts from the last one's vector.
const MOST_PRODUCTS: u32 = 20;
/// Force evaluations that cost as much as a product with the Hessian: measured as 3.2 to 3.5, on
/// 400 and 2704 particles, with shear and without.
const EVALUATIONS_PER_PRODUCT: u32 = 3;

/// Most substeps in a step. A step that needs more would not end in a time that anyone waits for.
const MOST_SUBSTEPS: u32 = 100_000;

/// How an explicit method divides its steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepControl {
    /// Not at all.
    Fixed,
    /// Into equal substeps within an estimated stability limit, which follows the cloth.
    Auto,
    /// Into equal substeps within a stability limit that holds at all positions.
    Bound,
}

impl Word for StepControl {
    const WORDS: &'static [(&'static str, Self)] =
        &[("fixed", Self::Fixed), ("auto", Self::Auto), ("bound", Self::Bound)];
}

impl StepControl {
    /// The limit that a method with this setting follows; `None` for fixed steps.
    ///
    /// # Errors
    /// [`PrepareError::Unsupported`] if the setting asks for a bound and none is known.
    pub fn limit(
        self,
        system: &System,
        method: &Method,
    ) -> Result<Option<StabilityLimit>, PrepareError> {
        let what = || "step=bound with a stiffness other than springs".to_owned();
        let refused = || PrepareError::Unsupported {
            method: method.id,
            what: what(),
            key: "effects".to_owned(),
        };
        match self {
            Self::Fixed => Ok(None),
            Self::Auto => Ok(Some(StabilityLimit::followed(system))),
            Self::Bound => StabilityLimit::bound(system).ok_or_else(refused).map(Some),
        }
    }
}

/// The largest eigenvalue `λ` of `M⁻¹∇²U`, followed as the cloth moves or bounded at all positions,
/// and the division of a step that it requires.
#[derive(Debug)]
pub struct StabilityLimit {
    source: Source,
    /// The present value of `λ`, 1/s².
    lambda: f64,
    /// Revisions of the system that `lambda` belongs to; `None` before the first value.
    known_for: Option<Revisions>,
}

/// Where `λ` comes from.
#[derive(Debug)]
enum Source {
    /// Estimated as the cloth moves.
    Followed { eigenvalue: LargestEigenvalue, substeps_since: u32 },
    /// Bounded for all positions.
    Bound(StiffnessBound),
}

impl StabilityLimit {
    /// A limit that follows the cloth: 1.05 times an estimate by power iteration. The first
    /// estimate, and each estimate after a change of the system, iterates to convergence. Later
    /// estimates use two products for every thirty substeps since the last one, and at most twenty.
    pub fn followed(system: &System) -> Self {
        let eigenvalue = LargestEigenvalue::new(system);
        Self::new(Source::Followed { eigenvalue, substeps_since: 0 })
    }

    /// A limit that holds at all positions ([`StiffnessBound`]); `None` if no bound is known.
    pub fn bound(system: &System) -> Option<Self> {
        StiffnessBound::new(system).map(|bound| Self::new(Source::Bound(bound)))
    }

    fn new(source: Source) -> Self {
        Self { source, lambda: 0.0, known_for: None }
    }

    /// Forgets `λ`.
    pub fn restart(&mut self) {
        self.known_for = None;
    }

    /// The least number of equal substeps of `h` seconds that are each at most `longest(λ)` seconds
    /// long, with `λ` at `x`; 1 if that number is undefined or `longest` is infinite.
    ///
    /// # Errors
    /// [`StepError::TooManySubsteps`] above 100 000 substeps.
    pub fn substeps(
        &mut self,
        system: &System,
        x: &[Vec3],
        h: f64,
        report: &mut StepReport,
        longest: impl FnOnce(f64) -> f64,
    ) -> Result<u32, StepError> {
        let limit = longest(self.stiffness(system, x, report));
        let count = Self::check((h / limit).ceil())?;
        self.took(count);
        Ok(count)
    }

    /// `λ` at `x`, 1/s². The report counts the products with the Hessian.
    pub fn stiffness(&mut self, system: &System, x: &[Vec3], report: &mut StepReport) -> f64 {
        report.force_evaluations += EVALUATIONS_PER_PRODUCT * self.update(system, x);
        self.lambda
    }

    /// Checks a number of substeps and converts it to an integer; 1 if it is not finite.
    ///
    /// # Errors
    /// [`StepError::TooManySubsteps`] above 100 000 substeps.
    pub fn check(count: f64) -> Result<u32, StepError> {
        let count = if count.is_finite() { (count as u32).max(1) } else { 1 };
        if count > MOST_SUBSTEPS {
            return Err(StepError::TooManySubsteps { needed: count, most: MOST_SUBSTEPS });
        }
        Ok(count)
    }

    /// Counts the substeps of a step. They determine when a followed limit makes its next estimate.
    pub fn took(&mut self, count: u32) {
        if let Source::Followed { substeps_since, .. } = &mut self.source {
            *substeps_since = substeps_since.saturating_add(count);
        }
    }

    /// Brings `λ` up to date; returns the number of products with the Hessian.
    fn update(&mut self, system: &System, x: &[Vec3]) -> u32 {
        let is_known = self.known_for.replace(system.revisions()) == Some(system.revisions());
        match &mut self.source {
            Source::Bound(_) if is_known => 0,
            Source::Bound(bound) => {
                self.lambda = bound.evaluate(system);
                0
            }
            Source::Followed { substeps_since, .. } if is_known && *substeps_since < INTERVAL => 0,
            Source::Followed { eigenvalue, substeps_since } => {
                let intervals = std::mem::take(substeps_since) / INTERVAL;
                let (lambda, products) = if is_known {
                    let products = intervals.saturating_mul(PRODUCTS).min(MOST_PRODUCTS);
                    (eigenvalue.estimate(system, x, products as usize), products)
                } else {
                    eigenvalue.restart();
                    let (lambda, products) = eigenvalue.converge(system, x);
                    (lambda, products as u32)
                };
                self.lambda = MARGIN * lambda;
                products
            }
        }
    }
}
