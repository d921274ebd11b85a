//! Forcing terms: the tolerance of an inner linear solve, given how far the outer iteration is from
//! its goal.

use crate::{Declared, Word, declare};

/// Rule for the forcing terms `η_k` of an inexact Newton method: solve until `‖G + J δ‖ ≤ η_k ‖G‖`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ForcingRule {
    /// The same term in every iteration.
    Constant(f64),
    /// Choice 2 of Eisenstat and Walker (1996) with `γ = 0.9`, `α = 2`: large while the residual
    /// falls slowly, small once it falls fast. In the last iteration that Newton's method may take,
    /// the term is at most 0.01, unless a looser solve reaches the goal: no later one mends it.
    EisenstatWalker,
}

/// The kind of a forcing rule, without its constant. The setting `forcing` names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForcingKind {
    /// [`ForcingRule::Constant`].
    Constant,
    /// [`ForcingRule::EisenstatWalker`].
    EisenstatWalker,
}

impl Word for ForcingKind {
    const WORDS: &'static [(&'static str, Self)] =
        &[("constant", Self::Constant), ("eisenstat-walker", Self::EisenstatWalker)];
}

impl ForcingRule {
    /// The setting `forcing`.
    pub const FORCING: Declared<ForcingKind> = declare!(
        forcing: ForcingKind [Constant, EisenstatWalker] = Constant,
        "how tightly the inner CG solves: always alike, or by the progress of the outer iteration \
         (Eisenstat and Walker, choice 2; the last of Newton's iterations to 0.01)"
    );
    /// The setting `cg_tolerance`.
    pub const CG_TOLERANCE: Declared<f64> = declare!(
        cg_tolerance: f64 in 1e-12..=0.5 = 0.1,
        "relative tolerance of Newton's inner CG with forcing=constant; take 0.01 where \
         max_iterations is 1"
    );

    /// The rule of this kind. `term` is the constant of [`ForcingRule::Constant`]; the other kind
    /// ignores it.
    pub fn new(kind: ForcingKind, term: f64) -> Self {
        match kind {
            ForcingKind::Constant => Self::Constant(term),
            ForcingKind::EisenstatWalker => Self::EisenstatWalker,
        }
    }
}

/// `γ` of the rule.
const GAMMA: f64 = 0.9;
/// Greatest term, which is also the first one.
const GREATEST: f64 = 0.5;
/// The safeguard applies while it gives more than this.
const SAFEGUARD: f64 = 0.1;
/// Greatest term of a last iteration. The docs of `drape-backward-euler` have what other terms do
/// to linearised steps.
const GREATEST_OF_LAST: f64 = 0.01;

/// The sequence of forcing terms of one outer iteration.
///
/// ```text
/// η_k = γ (‖G_k‖/‖G_{k−1}‖)²                                  η_0 = 0.5
/// η_k ≥ γ η_{k−1}²           where that is more than 0.1      (no sudden tightening by luck)
/// η_k ≤ 0.5, or 0.01 in the last iteration of Newton's method (no later one mends a loose solution)
/// η_k ≥ 0.5 goal/‖G_k‖, but at most 0.5                       (no solve beyond the goal)
/// ```
///
/// ```
/// use drape_integrator::{Forcing, ForcingRule};
/// let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
/// assert_eq!(forcing.next(1.0, 0.0), 0.5);
/// assert_eq!(forcing.next(0.5, 0.0), 0.225); // 0.9 (0.5)²
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Forcing {
    rule: ForcingRule,
    greatest: f64,
    /// Norm of the last residual, and its term.
    before: Option<(f64, f64)>,
}

impl Forcing {
    /// Starts an outer iteration.
    pub fn new(rule: ForcingRule) -> Self {
        Self::at_most(rule, GREATEST)
    }

    /// As [`new`](Self::new) with another first and greatest term than 0.5. Near the goal a term may
    /// be larger, up to 0.5, since no solve goes beyond the goal.
    pub(crate) fn at_most(rule: ForcingRule, greatest: f64) -> Self {
        Self { rule, greatest, before: None }
    }

    /// The forcing term for a residual of norm `norm`. The outer iteration ends at the norm `goal`,
    /// in the same unit.
    #[doc(alias = "Eisenstat-Walker")]
    pub fn next(&mut self, norm: f64, goal: f64) -> f64 {
        let term = match (self.rule, self.before) {
            (ForcingRule::Constant(term), _) => return term,
            (ForcingRule::EisenstatWalker, None) => self.greatest,
            (ForcingRule::EisenstatWalker, Some((last_norm, last_term))) => {
                let ratio = norm / last_norm;
                let term = GAMMA * ratio * ratio;
                let kept = GAMMA * last_term * last_term;
                if kept > SAFEGUARD { term.max(kept) } else { term }
            }
        };
        let least = if norm > 0.0 { 0.5 * goal / norm } else { GREATEST };
        let term = term.min(self.greatest).max(least).min(GREATEST);
        self.before = Some((norm, term));
        term
    }

    /// As [`next`](Self::next) for the last iteration, after which no other is planned. From then
    /// on every term is tight.
    pub(crate) fn last(&mut self, norm: f64, goal: f64) -> f64 {
        self.greatest = self.greatest.min(GREATEST_OF_LAST);
        self.next(norm, goal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each line by hand: the square of the reduction times 0.9, the safeguard, the two bounds.
    #[test]
    fn the_sequence_is_that_of_choice_2_with_its_safeguards() {
        let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
        let residuals_and_terms = [
            (1.0, 0.5),                  // the first
            (0.9, 0.5),                  // 0.9 · 0.81 = 0.729, cut to 0.5
            (0.09, 0.225),               // 0.9 · 0.01 = 0.009; the safeguard keeps 0.9 · 0.25
            (0.009, 0.009),              // 0.9 · 0.225² = 0.0456 is below 0.1: no safeguard
            (0.0009, 0.5 * 1e-4 / 9e-4), // 0.009 would solve beyond the goal of 1e-4
        ];
        for (norm, expected) in residuals_and_terms {
            let term = forcing.next(norm, 1e-4);
            assert!((term - expected).abs() < 1e-12, "at {norm}: {term}, not {expected}");
        }
    }

    /// A greatest term of 0.03 instead of 0.5 gives way where the goal is near.
    #[test]
    fn a_tighter_rule_stays_tight_until_the_goal_is_near() {
        let mut forcing = Forcing::at_most(ForcingRule::EisenstatWalker, 0.03);
        let residuals_and_terms = [
            (1.0, 0.03),               // the first
            (0.9, 0.03),               // 0.9 · 0.81, cut to 0.03
            (0.09, 0.009),             // 0.9 · 0.01, as with 0.5
            (4e-4, 0.5 * 1e-4 / 4e-4), // a fall by 0.125 reaches half of the goal of 1e-4
            (1.01e-4, 0.5 / 1.01),
            (0.5e-4, 0.5), // never above 0.5
        ];
        for (norm, expected) in residuals_and_terms {
            let term = forcing.next(norm, 1e-4);
            assert!((term - expected).abs() < 1e-12, "at {norm}: {term}, not {expected}");
        }
    }

    /// The last iteration is tight, and so are those to which a safeguard leads after it.
    #[test]
    fn the_last_iteration_is_tight() {
        let mut forcing = Forcing::new(ForcingRule::EisenstatWalker);
        assert_eq!(forcing.next(1.0, 1e-4), 0.5);
        let terms = [
            (0.9, 0.01),
            (0.8, 0.01),
            (0.08, 0.009), // 0.9 · 0.01
            (4e-4, 0.5 * 1e-4 / 4e-4),
            (0.5e-4, 0.5),
        ];
        for (norm, expected) in terms {
            let term = forcing.last(norm, 1e-4);
            assert!((term - expected).abs() < 1e-12, "at {norm}: {term}, not {expected}");
        }
        assert_eq!(Forcing::new(ForcingRule::Constant(0.03)).last(1.0, 1e-3), 0.03);
    }

    #[test]
    fn a_constant_term_is_constant() {
        let mut forcing = Forcing::new(ForcingRule::Constant(0.03));
        assert_eq!([1.0, 0.5, 1e-9].map(|norm| forcing.next(norm, 1e-3)), [0.03; 3]);
    }
}
