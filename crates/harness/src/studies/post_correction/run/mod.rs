//! Experiment `post-correction`: effects of shortening springs after each step (EEH section 3).

mod corrected;
mod sheets;
#[cfg(test)]
mod tests;

use crate::HarnessError;
use crate::facts::{Fact, fact};
use crate::studies::post_correction::facts::Facts;
use crate::studies::{Context, Measured, Start, cells, prepared};
use corrected::{DESBRUN, Group, PROVOT};
use sheets::{Kind, REFERENCE_STEP, SIDE, Setting};

const STEP: f64 = 0.0025;
const LIMITS: [f64; 4] = [0.1, 0.05, 0.02, 0.01];
/// Numbers of sweeps a step.
const SWEEPS: [u32; 2] = [1, 10];

fn groups(is_quick: bool) -> Vec<Group> {
    let group =
        |method, limit, sweeps| Group { method, limit, sweeps, step_s: STEP, all_orders: true };
    if is_quick {
        return vec![group(PROVOT, LIMITS[0], 1)];
    }
    let mut groups = Vec::new();
    for limit in LIMITS {
        groups.extend(SWEEPS.map(|sweeps| group(PROVOT, limit, sweeps)));
        groups.push(group(DESBRUN, limit, 1));
    }
    // The same groups with shorter steps show whether the residual vanishes.
    for division in [2.0, 4.0] {
        let step_s = STEP / division;
        groups.push(Group { step_s, all_orders: false, ..group(PROVOT, LIMITS[0], 1) });
    }
    groups
}

/// How the facts are measured.
pub(super) fn method() -> String {
    format!(
        "A sheet of {SIDE} × {SIDE} particles, 1 m × 1 m, hangs from two corners and starts \
         horizontally. Its springs have k/m = 1e4/s², the shear springs of the grid a tenth of \
         that; damping is full, with d/m = 10 s⁻¹. A second mesh of the same sheet consists of \
         triangles: its inner particles are displaced at random by a fifth of a mesh width, and \
         every edge is a spring. After each step of {STEP} s a correction shortens springs that \
         are longer than the limit allows. The correction is Provot's (symplectic Euler) or \
         Desbrun's (`inverse_dynamics=true`), in one to ten sweeps a step and in several orders. \
         `list 1` and `list 2` are forward sweeps over permuted lists of springs. Each step is \
         taken twice from the same state, with its correction and without it; the difference is \
         the effect of the correction. For comparison, a stiff sheet with k/m = 1e7/s² runs \
         without a correction (symplectic Euler, h = {REFERENCE_STEP} s, checked against twice \
         that). Distances are ‖x − x_ref‖_M/‖x_ref − x_0‖_M. The residual is ‖M a − f‖/‖f‖ with a \
         = (v_(n+1) − v_n)/h and f at the start of the step; a step of symplectic Euler has none. \
         Free sheets spin in their plane at 10 rad/s for 1 s, without gravity and damping. Sweeps \
         are counted on a sheet that fell for 0.25 s without correction."
    )
}

/// The systems from which the study's runs start.
pub(super) fn starts() -> Vec<Start> {
    let of = |kind: Kind| {
        let sheet = |name: String, stiffness| Start::new(name, move || kind.spec(stiffness, true));
        let soft = sheet(kind.name().to_owned(), sheets::SOFT);
        let stiff = sheet(format!("{}, stiff", kind.name()), sheets::STIFF);
        [soft, stiff].into_iter().chain(corrected::starts(kind))
    };
    Kind::ALL.into_iter().flat_map(of).collect()
}

pub(super) fn run(context: &Context<'_>) -> Result<Measured<Facts>, HarnessError> {
    let quick = context.quick;
    let kinds = if quick { &Kind::ALL[..1] } else { &Kind::ALL[..] };
    let settings = prepared(context, "references", kinds, |&kind| Setting::new(kind, STEP))?;
    let groups = groups(quick);
    let pairs: Vec<_> = settings
        .iter()
        .flat_map(|setting| groups.iter().map(move |group| (setting, group)))
        .collect();
    let rows =
        cells(context, "hanging", &pairs, |(setting, group)| corrected::rows(setting, group))?;
    let limits: Vec<_> = [None].into_iter().chain(LIMITS.map(Some)).collect();
    let mut inputs = Vec::new();
    for kind in Kind::ALL {
        for method in [PROVOT, DESBRUN] {
            inputs.extend(limits.iter().map(|&limit| (kind, method, limit)));
        }
    }
    inputs.retain(|&(kind, method, limit)| {
        !quick || (kind == Kind::Grid && method == PROVOT && limit == Some(LIMITS[0]))
    });
    let spins = cells(context, "spinning", &inputs, |&(kind, method, limit)| {
        corrected::spin(kind, method, limit, STEP)
    })?;
    let mut inputs = Vec::new();
    for setting in &settings {
        for limit in [LIMITS[0], LIMITS[3]] {
            for order in ["forward", "alternating", "shuffled"] {
                inputs.push((setting, limit, order));
            }
        }
    }
    inputs.retain(|(_, limit, order)| !quick || (*limit == LIMITS[0] && *order == "forward"));
    let sweeps = cells(context, "sweeps", &inputs, |&(setting, limit, order)| {
        corrected::sweeps(setting, limit, order, STEP)
    })?;
    let meshes = settings.iter().map(|setting| setting.mesh.clone()).collect();
    let rows = rows.all()?.concat();
    let facts = Facts { meshes, rows, spins: spins.all()?, sweeps: sweeps.all()? };
    let (facts, scenes, seed) =
        (facts, settings.iter().map(|s| (s.mesh.id.clone(), s.hash.clone())).collect(), Some(1));
    Ok(Measured { facts, timings: None, scenes, seed })
}

/// The study's facts in the form in which two records are compared.
pub(crate) fn comparable(facts: &Facts) -> Vec<Fact> {
    let Facts { meshes, rows, spins, sweeps } = facts;
    let meshes = meshes.iter();
    let meshes = meshes.map(|mesh| fact(format!("mesh {}", mesh.id), mesh.portable, mesh));
    let rows = rows.iter().map(|row| {
        let key = format!(
            "{} {}, limit {}, sweeps {}, {}, h = {}",
            row.mesh, row.label, row.limit, row.sweeps, row.order, row.step_s
        );
        fact(key, row.portable, row)
    });
    let spins = spins.iter().map(|spin| {
        let key = format!("spin {} {}, limit {:?}", spin.mesh, spin.label, spin.limit);
        fact(key, spin.portable, spin)
    });
    let sweeps = sweeps.iter().map(|sweeps| {
        let key = format!("sweeps {}, limit {}, {}", sweeps.mesh, sweeps.limit, sweeps.order);
        fact(key, sweeps.portable, sweeps)
    });
    meshes.chain(rows).chain(spins).chain(sweeps).collect()
}
