//! How many substeps with how many stages a step needs.

use crate::coefficients::{Coefficients, MOST_STAGES};
use crate::settings::{Division, RkcSettings};
use drape_integrator::{DampingBound, StabilityLimit, StepError, StepReport};
use drape_model::{System, Vec3};

/// Modes that are tested, and the ratio of their stiffnesses: they reach down to a thousandth of
/// the largest.
const MODES: u32 = 64;
const RATIO: f64 = 0.896_150_501_946_605_3;

/// The division of a step.
#[derive(Debug)]
pub(crate) struct Divider {
    limit: StabilityLimit,
    damping: DampingBound,
    /// Damping of the fastest mode over the bound of the damping.
    share: f64,
    /// `h`, `λ`, `δ` and what was found for them.
    known: Option<([f64; 3], u32)>,
}

impl Divider {
    pub(crate) fn new(system: &System) -> Self {
        let bound = StabilityLimit::bound(system);
        // Both bounds together are right for damping in proportion to the stiffness. The estimate
        // is between a half and the whole of the bound, and so is the damping of its mode.
        let share = if bound.is_some() { 1.0 } else { 0.5 };
        let limit = bound.unwrap_or_else(|| StabilityLimit::followed(system));
        Self { limit, damping: DampingBound::new(system), share, known: None }
    }

    /// Whether springs are damped.
    pub(crate) fn is_damped(&mut self, system: &System) -> bool {
        self.damping.evaluate(system) > 0.0
    }

    pub(crate) fn restart(&mut self) {
        self.limit.restart();
    }

    /// The number of equal substeps in `h` seconds; sets the coefficients of their stages.
    pub(crate) fn divide(
        &mut self,
        settings: &RkcSettings,
        system: &System,
        x: &[Vec3],
        h: f64,
        coefficients: &mut Coefficients,
        report: &mut StepReport,
    ) -> Result<u32, StepError> {
        if settings.step == Division::Fixed {
            coefficients.set(settings.stages);
            return Ok(1);
        }
        let lambda = self.limit.stiffness(system, x, report);
        let damping = self.damping.evaluate(system);
        let key = [h, lambda, damping];
        // A failed search leaves other coefficients.
        let count = match self.known.take() {
            Some((known, count)) if known == key => count,
            _ => search(settings, h, (lambda, damping), self.share, coefficients)?,
        };
        self.known = Some((key, count));
        self.limit.took(count);
        Ok(count)
    }
}

/// The least number of substeps of a rising series with which all modes are stable.
fn search(
    settings: &RkcSettings,
    h: f64,
    (lambda, damping): (f64, f64),
    share: f64,
    coefficients: &mut Coefficients,
) -> Result<u32, StepError> {
    let radius = settings.safety * damping.max(lambda.sqrt()); // ϱ, (R6)
    let most = f64::from(settings.stages.min(MOST_STAGES));
    let mut count = StabilityLimit::check((1.54 * h * radius / (most * most - 1.0)).ceil())?;
    loop {
        let part = h / f64::from(count);
        let stages = (1.0 + 1.54 * part * radius).sqrt().ceil().clamp(2.0, most); // (R6)
        coefficients.set(stages as u32);
        let mut of_largest = 1.0;
        let is_stable = (0..MODES).all(|_| {
            let mode =
                coefficients.is_stable(part, of_largest * lambda, of_largest * share * damping);
            of_largest *= RATIO;
            mode
        });
        if is_stable || !radius.is_finite() {
            return Ok(count);
        }
        count = StabilityLimit::check((1.25 * f64::from(count)).ceil())?;
    }
}
