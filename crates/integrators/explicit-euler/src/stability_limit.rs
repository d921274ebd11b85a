//! The number of substeps that an explicit step needs.

use drape_integrator::{LargestEigenvalue, StepError, StepReport, StiffnessBound};
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

/// `h_limit = safety · 2/√λ_max`.
#[derive(Debug)]
pub(crate) struct StabilityLimit {
    safety: f64,
    source: Source,
    /// The present value of `λ_max`, 1/s².
    lambda: f64,
    /// The system of `lambda`; `None` before the first.
    known_for: Option<Revisions>,
}

/// Where `λ_max` comes from.
#[derive(Debug)]
enum Source {
    /// Estimated as the cloth moves.
    Followed { eigenvalue: LargestEigenvalue, substeps_since: u32 },
    /// Bounded for all positions.
    Bound(StiffnessBound),
}

impl StabilityLimit {
    /// A limit that follows the cloth.
    pub(crate) fn followed(system: &System, safety: f64) -> Self {
        let eigenvalue = LargestEigenvalue::new(system);
        Self::new(safety, Source::Followed { eigenvalue, substeps_since: 0 })
    }

    /// A limit for all positions; `None` where no bound is known.
    pub(crate) fn bound(system: &System, safety: f64) -> Option<Self> {
        StiffnessBound::new(system).map(|bound| Self::new(safety, Source::Bound(bound)))
    }

    fn new(safety: f64, source: Source) -> Self {
        Self { safety, source, lambda: 0.0, known_for: None }
    }

    /// Forgets `λ_max`.
    pub(crate) fn restart(&mut self) {
        self.known_for = None;
    }

    /// The least number of equal substeps in `h` seconds within the limit at `x`; 1 where the limit
    /// is infinite or undefined.
    ///
    /// # Errors
    /// [`StepError::TooManySubsteps`] above [`MOST_SUBSTEPS`].
    pub(crate) fn substeps(
        &mut self,
        system: &System,
        x: &[Vec3],
        h: f64,
        report: &mut StepReport,
    ) -> Result<u32, StepError> {
        let products = self.update(system, x);
        report.force_evaluations += EVALUATIONS_PER_PRODUCT * products;
        let limit = self.safety * 2.0 / self.lambda.sqrt();
        let count = (h / limit).ceil();
        let count = if count.is_finite() { (count as u32).max(1) } else { 1 };
        if count > MOST_SUBSTEPS {
            return Err(StepError::TooManySubsteps { needed: count, most: MOST_SUBSTEPS });
        }
        if let Source::Followed { substeps_since, .. } = &mut self.source {
            *substeps_since = substeps_since.saturating_add(count);
        }
        Ok(count)
    }

    /// Brings `λ_max` up to date; returns the number of products with the Hessian.
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
