//! Angles and hinges as constraints that yield.

use super::Colouring;
use drape_model::{Effect, System, Vec3};

/// The angles of one effect: `C = θ − θ₀` with the compliance `1/K`.
#[derive(Debug)]
pub struct CompliantAngles {
    /// Place of the effect in the system.
    effect: usize,
    /// The particles of each angle in the order of a sweep; the first stands for a missing fourth.
    list: Vec<[u32; 4]>,
    /// The place of each in the list of the effect.
    numbers: Vec<u32>,
    /// `λ`, N m s².
    multipliers: Vec<f64>,
}

impl CompliantAngles {
    /// The angles of an effect of `system`; `None` if the effect has no angles.
    pub fn new(
        (place, effect): (usize, &dyn Effect),
        particles: usize,
        is_coloured: bool,
    ) -> Option<Self> {
        let mut list = Vec::new();
        effect.stencils()?.visit(&mut |members| {
            let first = members.first().copied().unwrap_or_default();
            list.push(std::array::from_fn(|k| members.get(k).copied().unwrap_or(first)));
        });
        let colouring = match is_coloured {
            true => Colouring::greedy(particles, &list),
            false => Colouring::list(list.len()),
        };
        Some(Self {
            effect: place,
            list: colouring.order.iter().map(|&number| list[number as usize]).collect(),
            multipliers: vec![0.0; list.len()],
            numbers: colouring.order,
        })
    }

    /// Projects all angles once. It moves the displacements `q` of the particles from `base`, both
    /// in m. In the first sweep of a substep the multipliers start from 0.
    ///
    /// ```text
    /// Δλ = −(λ + b C) / (1 + b Σ w |∇C|²)      b = Kτ²      q += w ∇C Δλ                     (X6)
    /// ```
    pub fn sweep(
        &mut self,
        system: &System,
        tau: f64,
        (base, way): (&[Vec3], &mut [Vec3]),
        inverse_mass: &[f64],
        is_first: bool,
    ) {
        let Some(stencils) = system.effects().nth(self.effect).and_then(Effect::stencils) else {
            return;
        };
        let angles = self.list.iter().zip(&self.numbers).zip(&mut self.multipliers);
        for ((members, &number), multiplier) in angles {
            let members = members.map(|i| i as usize);
            let lambda = if is_first { 0.0 } else { *multiplier };
            *multiplier = lambda;
            let at = members.map(|i| base[i] + way[i]);
            let Some(turn) = stencils.turn(number as usize, &at) else { continue };
            let pull = turn.stiffness * tau * tau;
            let weighted =
                |(&i, gradient): (&usize, &Vec3)| inverse_mass[i] * gradient.norm_squared();
            let mobility: f64 = members.iter().zip(&turn.gradient).map(weighted).sum();
            let step = -(lambda + pull * turn.excess) / (1.0 + pull * mobility);
            *multiplier = lambda + step;
            for (&i, gradient) in members.iter().zip(&turn.gradient) {
                way[i] += gradient * (inverse_mass[i] * step);
            }
        }
    }
}
