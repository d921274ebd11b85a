//! The scenes: one sheet at every stiffness and damping.

use crate::HarnessError;
use crate::studies::trajectory::facts::{FEWEST, LEVELS, Scene};
use crate::studies::work_precision::run::scenes::{Case as Sheet, Setting, Shape};
use crate::studies::work_precision::run::truth::PERTURBED;
use drape_model::SystemSpec;

/// Values of k/m, 1/s².
const STIFFNESSES: [f64; 5] = [1e2, 1e4, 1e6, 1e8, 1e10];
/// Values of the damping, from none to one with which the stiffest mode does not oscillate.
const DAMPINGS: [Damping; 6] = [
    Damping::OverMass(0.0),
    Damping::OverMass(10.0),
    Damping::OverMass(40.0),
    Damping::Ratio(0.01),
    Damping::Ratio(0.1),
    Damping::Ratio(1.0),
];
/// Particles along each edge: usually, and on sheets whose true motion would take too long.
const SIDE: u32 = 20;
const SMALL_SIDE: u32 = 10;
const STIFF: f64 = 1e9;
/// Modelled time that a run may take, s: two and a half times as long as the slowest winner.
pub(super) const BUDGET_S: f64 = 0.05;

/// The damping in the scene's own terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Damping {
    /// d/m, 1/s.
    OverMass(f64),
    /// The damping ratio of the stiffest mode.
    Ratio(f64),
}

/// A scene, before its system is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Case {
    /// k/m, 1/s².
    pub(super) stiffness: f64,
    pub(super) damping: Damping,
}

/// All scenes, sorted by damping.
pub(super) fn cases() -> Vec<Case> {
    let at = |damping| STIFFNESSES.map(|stiffness| Case { stiffness, damping });
    DAMPINGS.into_iter().flat_map(at).collect()
}

impl Case {
    /// Whether the quick subset has this case.
    pub(super) fn is_quick(&self) -> bool {
        self.stiffness == 1e4 && self.damping == Damping::OverMass(10.0)
    }

    pub(super) fn id(&self) -> String {
        format!("k/m = {:e}, {}", self.stiffness, self.damping_name())
    }

    fn damping_name(&self) -> String {
        match self.damping {
            Damping::OverMass(value) => format!("d/m = {value}"),
            Damping::Ratio(value) => format!("ζ = {value}"),
        }
    }

    /// `2 ω` over the damping of the stiffest mode at d/m = 1/s. In this mode, neighbours along one
    /// axis move against each other within the sheet. Its ω² is 4 (k + k_s)/m, and full damping
    /// acts with (4 d + 8 d_s)/m. Shear springs have a quarter of the stiffness and a tenth of the
    /// damping.
    fn scale(&self) -> f64 {
        2.0 * (4.0 * 1.25 * self.stiffness).sqrt() / (4.0 + 8.0 * 0.1)
    }

    /// d/m, 1/s.
    pub(super) fn damping_over_mass(&self) -> f64 {
        match self.damping {
            Damping::OverMass(value) => value,
            Damping::Ratio(value) => value * self.scale(),
        }
    }

    fn sheet(&self) -> Sheet {
        let is_stiff = self.stiffness > STIFF;
        Sheet {
            shape: Shape::Hanging,
            is_heavy: false,
            stiffness: self.stiffness,
            side: if is_stiff { SMALL_SIDE } else { SIDE },
            light: self.damping_over_mass(),
            series: Vec::new(),
            budget: f64::INFINITY,
        }
    }

    pub(super) fn spec(&self) -> Result<SystemSpec, HarnessError> {
        self.sheet().spec()
    }
}

/// A scene with its true motions.
pub(super) struct Stage {
    pub(super) scene: Scene,
    pub(super) setting: Setting,
}

impl Stage {
    pub(super) fn new(case: &Case) -> Result<Self, HarnessError> {
        let (mut setting, noise) = Setting::among_noise(&case.sheet())?;
        // A smaller error is below the noise, or below every level.
        setting.enough = LEVELS.into_iter().fold(1.0, f64::min).max(noise.error);
        setting.most_s = BUDGET_S;
        setting.fewest = FEWEST;
        setting.stabilised_begin_coarse = true;
        let sheet = &mut setting.scene;
        sheet.id = case.id();
        let scene = Scene {
            id: sheet.id.clone(),
            damping: case.damping_name(),
            particles: sheet.particles,
            springs: sheet.springs,
            stiffness_over_mass_per_s2: case.stiffness,
            damping_over_mass_per_s: case.damping_over_mass(),
            damping_ratio: case.damping_over_mass() / case.scale(),
            span_s: sheet.span_s,
            motion_m: sheet.motion_m,
            released_j: noise.released_j,
            dissipated: noise.dissipated,
            strain: noise.true_strain,
            reference_error: sheet.reference_error,
            reference_tolerance: sheet.reference_tolerance,
            members: 1 + PERTURBED,
            floor: noise.error,
            shape_floor_m: noise.shape_m,
            strain_floor: noise.strain,
            energy_floor: noise.energy,
            budget_s: setting.most_s,
        };
        Ok(Self { scene, setting })
    }
}
