//! A force of your own: a magnet that pulls every particle.
//!
//! `cargo run --release --example write_an_effect` hangs a sheet with and without it.

#![allow(clippy::print_stdout, reason = "an example shows its numbers")]

use drape::methods::Choice;
use drape::model::{Effect, EffectKind, TimeSpan, Vec3};
use drape::{Runner, Simulation};

/// A magnet at `center` (m) with potential energy `U = −strength Σ 1/√(r² + a²)`; strength in N m².
#[derive(Clone, Debug)]
struct Magnet {
    center: Vec3,
    strength: f64,
}

/// `a²`, m²: keeps the force finite at the centre.
const SOFTENING: f64 = 0.01;

impl Effect for Magnet {
    fn kind(&self) -> EffectKind {
        EffectKind::Own("magnet")
    }

    fn energy(&self, _mass: &[f64], x: &[Vec3]) -> f64 {
        let depth =
            |x: &Vec3| self.strength / ((x - self.center).norm_squared() + SOFTENING).sqrt();
        -x.iter().map(depth).sum::<f64>()
    }

    /// The force is `−∇U`. Forces add up, so an effect adds and never overwrites.
    fn add_force(&self, _mass: &[f64], x: &[Vec3], out: &mut [Vec3]) {
        for (force, x) in out.iter_mut().zip(x) {
            let d = x - self.center;
            *force -= d * (self.strength / (d.norm_squared() + SOFTENING).powf(1.5));
        }
    }

    fn boxed_clone(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let plain = Simulation::load("hanging-textile-1e4")?;
    let mut pulled = plain.clone();
    let magnet = Magnet { center: Vec3::new(0.0, 0.0, 0.5), strength: 1e-3 };
    pulled.system.add_effect(Box::new(magnet));
    let time = TimeSpan { step_s: 0.01, duration_s: 0.5 };
    for method in ["backward-euler", "imex-updated"] {
        for (name, sheet) in [("without", &plain), ("with", &pulled)] {
            let run = Runner::new(&Choice::parse(method, &[])?, time).count(sheet)?;
            let lowest = run.state.x.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
            println!("{method}, {name} the magnet: lowest point at {lowest:.3} m");
        }
    }
    Ok(())
}
