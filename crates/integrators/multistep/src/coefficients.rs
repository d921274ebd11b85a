//! Coefficients of the methods, for steps of any sizes.

/// Most steps of a method here.
pub const MAX_STEPS: usize = 3;

/// A linear `k`-step method for `y' = f(t, y)`, EEH (1), `k` from 1 to 3:
///
/// ```text
/// Σ_{j=0}^{k} α_j y_{n+j} = h Σ_{j=0}^{k} β_j f_{n+j}
/// ```
///
/// Level `n + k` is the new one, and `h` is the size of the step that leads to it. Earlier steps
/// may have had other sizes: the coefficients come from the polynomials that interpolate at the
/// times of the levels. At equal steps:
///
/// | `k` | Adams–Bashforth: `α` | `β` | BDF: `α` | `β` |
/// |---|---|---|---|---|
/// | 1 | `(−1, 1)` | `(1, 0)`, explicit Euler | `(−1, 1)` | `(0, 1)`, backward Euler |
/// | 2 | `(0, −1, 1)` | `(−1, 3, 0)/2` | `(1, −4, 3)/2` | `(0, 0, 1)` |
/// | 3 | `(0, 0, −1, 1)` | `(5, −16, 23, 0)/12` | `(−2, 9, −18, 11)/6` | `(0, 0, 0, 1)` |
#[doc(alias = "EEH 1")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearMultistep {
    steps: usize,
    alpha: [f64; MAX_STEPS + 1],
    beta: [f64; MAX_STEPS + 1],
}

/// Times of the levels from level `n + k − 1` on, newest first, in multiples of the present step:
/// `1, 0, −h_{n−1}/h_n, …`.
fn times(steps: &[f64]) -> [f64; MAX_STEPS + 1] {
    let mut times = [1.0, 0.0, 0.0, 0.0];
    for j in 1..steps.len() {
        times[j + 1] = times[j] - steps[j] / steps[0];
    }
    times
}

/// Value at `t` of the polynomial that is 1 at node `j` and 0 at the other nodes.
fn lagrange(nodes: &[f64], j: usize, t: f64) -> f64 {
    let others = nodes.iter().enumerate().filter(|(i, _)| *i != j);
    others.fold(1.0, |product, (_, node)| product * (t - node) / (nodes[j] - node))
}

/// Integral over [0, 1] of a polynomial of degree 3 or less: Simpson's rule is exact for it.
fn integral(polynomial: impl Fn(f64) -> f64) -> f64 {
    (polynomial(0.0) + 4.0 * polynomial(0.5) + polynomial(1.0)) / 6.0
}

impl LinearMultistep {
    /// Explicit Adams (Adams–Bashforth), EEH (2): the last step is the integral of the polynomial
    /// through the last `k` values of `f`. One step gives explicit Euler.
    ///
    /// `steps` are the sizes of the last `k` steps, s, the present one first. The order is `k`.
    ///
    /// ```
    /// use drape_multistep::LinearMultistep;
    /// let twice_as_long = LinearMultistep::adams_bashforth(&[0.2, 0.1]);
    /// assert_eq!(twice_as_long.beta(), [-1.0, 2.0, 0.0]);
    /// ```
    ///
    /// # Panics
    /// Unless there are one to three steps.
    #[doc(alias = "EEH 2")]
    #[must_use]
    pub fn adams_bashforth(steps: &[f64]) -> Self {
        let (k, times) = (steps.len(), times(steps));
        let old = &times[1..=k];
        let (mut alpha, mut beta) = ([0.0; MAX_STEPS + 1], [0.0; MAX_STEPS + 1]);
        (alpha[k - 1], alpha[k]) = (-1.0, 1.0);
        for j in 0..k {
            beta[j] = integral(|t| lagrange(old, k - 1 - j, t));
        }
        Self { steps: k, alpha, beta }
    }

    /// Backward differentiation (BDF), EEH (3): the polynomial through all `k + 1` levels has the
    /// slope `f` at the new one. One step gives backward Euler.
    ///
    /// `steps` are as for [`adams_bashforth`](Self::adams_bashforth). The order is `k`.
    ///
    /// ```
    /// use drape_multistep::LinearMultistep;
    /// assert_eq!(LinearMultistep::bdf(&[0.1, 0.1]).alpha(), [0.5, -2.0, 1.5]);
    /// ```
    ///
    /// # Panics
    /// Unless there are one to three steps.
    #[doc(alias = "EEH 3")]
    #[must_use]
    pub fn bdf(steps: &[f64]) -> Self {
        let (k, times) = (steps.len(), times(steps));
        let old = &times[1..=k];
        let (mut alpha, mut beta) = ([0.0; MAX_STEPS + 1], [0.0; MAX_STEPS + 1]);
        for (age, node) in old.iter().enumerate() {
            // Derivatives at the new node of the polynomials of old node `age` and of the new node.
            alpha[k - 1 - age] = -lagrange(old, age, 1.0) / (1.0 - node);
            alpha[k] += 1.0 / (1.0 - node);
        }
        beta[k] = 1.0;
        Self { steps: k, alpha, beta }
    }

    /// Number `k` of steps.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// `α_0 … α_k`, oldest level first.
    pub fn alpha(&self) -> &[f64] {
        &self.alpha[..=self.steps]
    }

    /// `β_0 … β_k`, oldest level first.
    pub fn beta(&self) -> &[f64] {
        &self.beta[..=self.steps]
    }

    /// `τ = h β_k/α_k`, the factor of the new slope in the new level, s; 0 for an explicit method.
    pub fn tau(&self, h: f64) -> f64 {
        h * self.beta[self.steps] / self.alpha[self.steps]
    }

    /// `−α_j/α_k` for `j < k`, which sum to 1: the weights of the old levels in their mean.
    pub fn past_weights(&self) -> [f64; MAX_STEPS] {
        let k = self.steps;
        std::array::from_fn(|j| if j < k { -self.alpha[j] / self.alpha[k] } else { 0.0 })
    }
}

/// Weights of the last `k` levels, oldest first, for an extrapolation of order `k` to the new time:
/// `(−1, 2)` at two equal steps. The entries beyond the first `k` are 0.
///
/// # Panics
/// Unless there are one to three steps.
pub fn extrapolation(steps: &[f64]) -> [f64; MAX_STEPS] {
    let (k, times) = (steps.len(), times(steps));
    let old = &times[1..=k];
    std::array::from_fn(|j| if j < k { lagrange(old, k - 1 - j, 1.0) } else { 0.0 })
}

#[cfg(test)]
mod tests;
