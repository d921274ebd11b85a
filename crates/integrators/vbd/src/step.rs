//! The step.

use crate::lanes::Groups;
use crate::rows::{Rows, colours, neighbours};
use crate::settings::{Start, VBD, VbdSettings};
use crate::sweep::{Iterate, Problem};
use crate::terms::{Damping, Terms};
use drape_integrator::{
    ContactSet, EnergyLedger, Implicit, IncrementalPotential, Method, Phase, PhaseClock,
    PrepareError, Registration, Scheme, StepError, StepReport, Stepper, Taken,
};
use drape_model::{Revisions, State, System, Vec3};
use drape_solvers::Constraints;

/// Vertex block descent.
#[doc(alias = "Chen-Liu-Yang-Yuksel 2024")]
#[doc(alias = "AVBD")]
pub type Vbd = Stepper<Workspace>;

/// Entry of this method in the registry.
pub static REGISTRATION: Registration = Registration::new::<Workspace>(&VBD);

/// Memory of a step, and history.
#[derive(Debug)]
pub struct Workspace {
    /// `Φ`: gives the target, the residual and the impulse of contacts.
    pub(crate) potential: IncrementalPotential,
    pub(crate) iterate: Iterate,
    pub(crate) constraints: Constraints,
    terms: Terms,
    damping: Damping,
    colours: Rows<u32>,
    /// The fast form of the sweeps, where there is one.
    pub(crate) groups: Option<Groups>,
    target: Vec<Vec3>,
    contacts: ContactSet,
    impulse: Vec<Vec3>,
    gradient: Vec<Vec3>,
    /// `v_{n−1}`, m/s.
    previous: Vec<Vec3>,
    /// Bits of the size of the last step, and its system; `None` without history.
    last: Option<(u64, Revisions)>,
}

impl Scheme for Workspace {
    type Settings = VbdSettings;

    fn method(_settings: &VbdSettings) -> &'static Method {
        &VBD
    }

    fn new(system: &System, settings: &VbdSettings, _h: f64) -> Result<Self, PrepareError> {
        let implicit = Implicit::Everything;
        let mut pairs = Vec::new();
        for effect in implicit.effects(system) {
            if effect.split().is_none() && effect.stencils().is_none() && !effect.is_drag() {
                let (what, key) = (effect.name().to_owned(), format!("effects.{}", effect.name()));
                return Err(PrepareError::Unsupported { method: VBD.id, what, key });
            }
            effect.visit_pairs(&mut |i, j| pairs.push((i, j)));
        }
        let zeros = || vec![Vec3::zeros(); system.len()];
        let terms = Terms::new(system, settings.augmented);
        let colours = colours(&neighbours(system.len(), &pairs));
        Ok(Self {
            potential: IncrementalPotential::new(system, implicit),
            iterate: Iterate::new(system.len()),
            constraints: Constraints::free(system.len()),
            groups: Groups::new(&terms, &colours),
            terms,
            damping: Damping::new(system),
            colours,
            target: zeros(),
            contacts: ContactSet::new(system),
            impulse: ContactSet::impulse(system),
            gradient: zeros(),
            previous: zeros(),
            last: None,
        })
    }

    fn step(
        &mut self,
        settings: &VbdSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        clock.switch(Phase::Contact);
        let (from, end) = ((&state.x[..], &state.v[..]), state.t + h);
        self.contacts.detect(system, from.0, from.1, (h, end), &mut self.constraints);
        clock.switch(Phase::Forces);
        self.begin(settings, system, state, h);
        let Self { potential, iterate, constraints, terms, damping, colours, groups, .. } = self;
        let Self { target, contacts, impulse, gradient, .. } = self;
        clock.switch(Phase::Solve);
        let groups = groups.as_ref();
        let problem = Problem { system, h, from: &state.x, target, damping, colours, groups };
        let mut sweeps = 0;
        contacts.solve(system, constraints, impulse, |constraints, wanted| {
            problem.minimise(settings, terms, constraints, iterate); // (V2)–(V5)
            sweeps += settings.sweeps;
            wanted.fill(&iterate.v, |impulse| {
                impulse.copy_from_slice(potential.gradient(system, &iterate.v));
            });
            Ok::<(), StepError>(())
        })?;
        gradient.copy_from_slice(potential.gradient(system, &iterate.v)); // ∇Φ(v_{n+1})
        let residual = potential.filtered_norm(constraints, gradient);
        clock.switch(Phase::Update);
        self.previous.copy_from_slice(&state.v);
        self.last = Some((h.to_bits(), system.revisions()));
        state.v.copy_from_slice(&iterate.v);
        state.x.copy_from_slice(&iterate.x); // x_{n+1} = x_n + h v_{n+1}, (V6)
        contacts.settle(&mut state.v, |_| ());
        state.t = end;
        Ok(StepReport {
            relative_residual: potential.relative(residual),
            force_evaluations: 1 + sweeps + potential.evaluations(),
            outer_passes: sweeps,
            ..StepReport::default()
        })
    }

    fn restart(&mut self) {
        self.last = None;
        self.contacts.restart();
    }

    fn ledger(&mut self, _settings: &VbdSettings, taken: &Taken<'_>) -> Option<EnergyLedger> {
        Some(self.energy_ledger(taken))
    }

    fn is_portable(_settings: &VbdSettings) -> bool {
        true
    }

    /// The order of the particles decides which of two neighbours moves first.
    fn follows_springs(_settings: &VbdSettings) -> bool {
        true
    }
}

impl Workspace {
    /// Sets up the potential of a step, and the start of its sweeps.
    fn begin(&mut self, settings: &VbdSettings, system: &System, state: &State, h: f64) {
        let Self { potential, iterate, damping, terms, target, gradient: frozen, .. } = self;
        let (from, lagged) = ((&state.x[..], &state.v[..]), state.level());
        frozen.fill(Vec3::zeros());
        potential.implicit().add_explicit_forces(system, lagged, frozen);
        potential.begin(system, h, from, lagged, frozen);
        target.copy_from_slice(potential.target()); // v̂ = v_n + h M⁻¹ f_explicit, (V1)
        let has_changed = terms.refresh(system);
        if let Some(groups) = self.groups.as_mut().filter(|_| has_changed) {
            groups.refresh(terms);
        }
        damping.assemble(system, lagged);
        let has_history = self.last == Some((h.to_bits(), system.revisions()));
        if settings.augmented {
            terms.soften(system.mass(), h, has_history.then_some(settings.gamma));
        }
        for (i, v) in iterate.v.iter_mut().enumerate() {
            *v = match settings.start {
                Start::Previous => Vec3::zeros(),
                Start::Adaptive if has_history => {
                    let (v_n, step) = (state.v[i], target[i] - state.v[i]);
                    let followed = (v_n - self.previous[i]).dot(&step) / step.norm_squared();
                    let fell = step.norm_squared() > 0.0;
                    if fell { v_n + step * followed.clamp(0.0, 1.0) } else { v_n }
                }
                Start::Adaptive | Start::Inertial => target[i],
            };
        }
    }
}
