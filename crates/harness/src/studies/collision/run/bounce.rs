//! Rebounds compared with theory, of a particle and of a flat sheet as a whole.

use super::Form;
use super::fall::{Body, SIDE, STEP, Target, teleport, touching};
use crate::HarnessError;
use crate::methods::Choice;
use crate::studies::collision::facts::{Bounce, TELEPORT};
use crate::studies::sheet::{GRAVITY, MASS, Sheet};
use crate::studies::stepper::Stepper;
use drape_model::{DampingLaw, GravitySpec, State, System, SystemSpec, Vec3};

/// Height of the start above the surface, as the time of the fall, s.
const FLIGHT: f64 = 0.095;
/// Stiffness over mass of the sheet, 1/s².
const STIFFNESS: f64 = 1e4;

/// A fall, before its system is built.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    pub(super) is_sheet: bool,
    pub(super) target: Target,
    pub(super) speed: f64,
    pub(super) restitution: f64,
}

/// Where a particle meets the sphere, m: off its top, so that the normal is not vertical.
const OFF: [f64; 2] = [0.1, 0.05];

impl Case {
    fn spec(&self) -> Result<SystemSpec, HarnessError> {
        let sheet = Sheet {
            side: SIDE,
            tension: STIFFNESS,
            shear: 0.1 * STIFFNESS,
            damping: 40.0,
            law: DampingLaw::Full,
            gravity: GRAVITY,
            is_pinned: false,
        };
        let mut spec = sheet.spec()?;
        if !self.is_sheet {
            spec.particles.mass_kg = vec![MASS];
            spec.particles.position_m = vec![[OFF[0], OFF[1], 0.0]];
            spec.springs.clear();
            spec.triangles.clear();
            spec.effects.gravity = Some(GravitySpec { m_s2: GRAVITY });
        }
        for position in &mut spec.particles.position_m {
            position[2] += FLIGHT * self.speed;
        }
        spec.particles.velocity_m_s =
            vec![[0.0, 0.0, -self.speed]; spec.particles.position_m.len()];
        Ok(spec)
    }

    /// Whether the surface is horizontal where it is hit. Then the body rises where it fell.
    fn is_level(&self) -> bool {
        self.target != Target::Sphere
    }
}

/// Mean position and velocity. All masses are equal.
fn center(state: &State) -> (Vec3, Vec3) {
    let mean = |vectors: &[Vec3]| {
        vectors.iter().fold(Vec3::zeros(), |sum, v| sum + v) / vectors.len() as f64
    };
    (mean(&state.x), mean(&state.v))
}

/// Runs one fall and its rebound.
pub(super) fn bounce(form: &Form, case: &Case) -> Result<Bounce, HarnessError> {
    let choice = Choice::parse(form.method, &[])?;
    let mut spec = case.spec()?;
    let body = Body::new(&mut spec, case.target.obstacle(case.restitution))?;
    let (system, obstacle): (&System, _) = (body.seen(form), body.obstacle());
    let mut state = body.simulation.state.clone();
    let mut stepper = Stepper::new(&choice, system, STEP)?;
    let g = -GRAVITY[2];
    let drop = FLIGHT * case.speed;
    let arrival = (case.speed * case.speed + 2.0 * g * drop).sqrt();
    let rise = case.restitution * arrival / g;
    // The way down, the way up, and some steps after both.
    let steps = ((FLIGHT + rise) / STEP).ceil() as u64 + 5;
    let mut measured = None;
    let mut height: Option<f64> = None;
    for _ in 0..steps {
        let inside = touching(obstacle, &state.x).contains(&true);
        let (x_before, v_before) = center(&state);
        if stepper.step(system, &mut state)?.is_none() {
            break;
        }
        let (x_moved, v_moved) = center(&state);
        let met = if form.way_out == TELEPORT {
            let moved = teleport(obstacle, &mut state);
            if moved > 0 {
                stepper.restart(&state);
            }
            (moved > 0).then_some((x_moved, v_moved))
        } else {
            inside.then_some((x_before, v_before))
        };
        let (x, v) = center(&state);
        if let (Some((x_met, v_met)), None) = (met, measured) {
            let normal = if case.is_sheet { Vec3::z() } else { obstacle.distance(&x_met).1 };
            measured = Some(normal.dot(&v) / -normal.dot(&v_met));
        }
        if measured.is_some() {
            height = Some(height.map_or(x.z, |height| height.max(x.z)));
        }
    }
    let level = |value: Option<f64>| value.filter(|_| case.is_level());
    Ok(Bounce {
        body: if case.is_sheet { "sheet" } else { "particle" }.to_owned(),
        obstacle: case.target.name().to_owned(),
        label: form.label.to_owned(),
        way_out: form.way_out.to_owned(),
        method: choice.full_id(),
        speed_m_s: case.speed,
        restitution: case.restitution,
        measured,
        height_m: level(height),
        height_theory_m: level(Some(
            case.restitution * case.restitution * (drop + case.speed * case.speed / (2.0 * g)),
        )),
        portable: choice.is_portable(),
    })
}
