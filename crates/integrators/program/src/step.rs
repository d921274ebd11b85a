//! The step: a request and its answer.

use crate::message::RESTART;
use crate::process::Process;
use crate::program::ProgramSettings;
use drape_integrator::{Method, Phase, PhaseClock, PrepareError, Scheme, StepError, StepReport};
use drape_model::{EffectKind, Revisions, State, System, Vec3};
use std::io::Write as _;

/// Bytes of a vector.
const VECTOR: usize = 24;
/// A pinned particle may be off its place by this share of its distance from the origin, and by as
/// many metres: enough for programs that compute in single precision.
const PIN_TOLERANCE: f64 = 1e-5;

/// A program in a run.
#[derive(Debug)]
pub(crate) struct Session {
    process: Process,
    /// The system that it knows.
    sent: Option<Revisions>,
    is_restarted: bool,
    /// The present request.
    request: Vec<u8>,
}

impl Scheme for Session {
    type Settings = ProgramSettings;

    fn method(settings: &ProgramSettings) -> &'static Method {
        settings.program.method
    }

    fn new(system: &System, settings: &ProgramSettings, _h: f64) -> Result<Self, PrepareError> {
        refuse_unknown(system, settings.program.method.id)?;
        let mut process = settings.program.start(settings.start).map_err(PrepareError::Outside)?;
        let n = system.len();
        process.reserve(2 * VECTOR * n);
        let request = Vec::with_capacity(256 + VECTOR * (2 * n + system.pins().len()));
        Ok(Self { process, sent: None, is_restarted: false, request })
    }

    fn step(
        &mut self,
        settings: &ProgramSettings,
        system: &System,
        state: &mut State,
        h: f64,
        clock: &mut PhaseClock,
    ) -> Result<StepReport, StepError> {
        clock.switch(Phase::Solve);
        let report = self.ask(settings, system, state, h).map_err(|sentence| {
            settings.program.count(&self.process);
            StepError::Outside(sentence)
        })?;
        state.t += h;
        Ok(report)
    }

    fn restart(&mut self) {
        self.is_restarted = true;
    }

    fn is_portable(_settings: &ProgramSettings) -> bool {
        false
    }

    fn follows_springs(_settings: &ProgramSettings) -> bool {
        true
    }
}

impl Session {
    /// Sends what the program does not know yet, then asks for the step.
    fn ask(
        &mut self,
        settings: &ProgramSettings,
        system: &System,
        state: &mut State,
        h: f64,
    ) -> Result<StepReport, String> {
        if self.sent != Some(system.revisions()) {
            self.write_system(system, state)?;
            self.process.request("at `system`", &self.request, 0, settings.start)?;
            self.sent = Some(system.revisions());
        } else if self.is_restarted {
            self.process.request("at `restart`", RESTART, 0, settings.start)?;
        }
        self.is_restarted = false;
        self.write_step(system, state, h);
        let Self { process, request, .. } = self;
        let bytes = 2 * VECTOR * system.len();
        let (answer, bytes) = process.request("in a step", request, bytes, settings.step)?;
        let (x, v) = bytes.split_at(bytes.len() / 2);
        if let Some((pin, found, expected)) = strayed_pin(system, state, h, x) {
            return Err(process.failed(&format!(
                "put the pinned particle {pin} at {found:?} m in a step; expected {expected:?} m, \
                 where it is held or led"
            )));
        }
        let x = |particle| vector(x, particle);
        let v = |particle| vector(v, particle);
        for particle in 0..system.len() {
            if system.pinned()[particle] {
                // Exactly where it is led, with the velocity of the step, which it has already.
                state.x[particle] = place(system, state, h, particle);
            } else {
                (state.x[particle], state.v[particle]) = (x(particle), v(particle));
            }
        }
        Ok(answer.report())
    }

    /// `{"do":"system", …}`: the frozen system at the present state.
    fn write_system(&mut self, system: &System, state: &State) -> Result<(), String> {
        let spec = system.freeze(state).map_err(|effect| {
            self.process.failed(&format!("cannot be sent `{effect}`: no frozen system holds it"))
        })?;
        self.request.clear();
        let written =
            write!(self.request, "{{\"do\":\"system\",\"time_s\":{:?},\"system\":", state.t)
                .map_err(|error| error.to_string())
                .and_then(|()| {
                    serde_json::to_writer(&mut self.request, &spec)
                        .map_err(|error| error.to_string())
                });
        self.request.extend_from_slice(b"}\n");
        written
            .map_err(|error| self.process.failed(&format!("cannot be sent the system ({error})")))
    }

    /// `{"do":"step", …}`, then positions, velocities and places of the pins at the end of the
    /// step.
    fn write_step(&mut self, system: &System, state: &State, h: f64) {
        let out = &mut self.request;
        out.clear();
        let bytes = VECTOR * (2 * system.len() + system.pins().len());
        // Writing into memory does not fail.
        let _ = writeln!(
            out,
            "{{\"do\":\"step\",\"time_s\":{:?},\"step_s\":{h:?},\"bytes\":{bytes}}}",
            state.t
        );
        let mut add = |a: &Vec3| a.iter().for_each(|c| out.extend_from_slice(&c.to_le_bytes()));
        state.x.iter().for_each(&mut add);
        state.v.iter().for_each(&mut add);
        for &pin in system.pins() {
            add(&place(system, state, h, pin as usize));
        }
    }
}

/// Where a pinned particle is at the end of the step, m. [`drape_integrator::Scratch::ready`] has
/// set its velocity to the one that leads there.
fn place(system: &System, state: &State, h: f64, pin: usize) -> Vec3 {
    let moving = system.moving_pins().iter().find(|moving| moving.particle == pin);
    moving.map_or(state.x[pin], |moving| moving.position(state.t + h))
}

/// A pinned particle that the answer puts elsewhere: its index, its place and the right one, m.
fn strayed_pin(
    system: &System,
    state: &State,
    h: f64,
    x: &[u8],
) -> Option<(usize, [f64; 3], [f64; 3])> {
    system.pins().iter().map(|&pin| pin as usize).find_map(|pin| {
        let (found, expected) = (vector(x, pin), place(system, state, h, pin));
        let tolerance = PIN_TOLERANCE * (1.0 + expected.norm());
        // A NaN is a blow-up, which the run sees.
        ((found - expected).norm() > tolerance).then(|| (pin, found.into(), expected.into()))
    })
}

/// The vector of a particle.
fn vector(bytes: &[u8], particle: usize) -> Vec3 {
    Vec3::from_fn(|axis, _| number(bytes, 3 * particle + axis))
}

fn number(bytes: &[u8], place: usize) -> f64 {
    let mut eight = [0; 8];
    eight.copy_from_slice(&bytes[8 * place..8 * place + 8]);
    f64::from_le_bytes(eight)
}

/// Refuses effects that no frozen system can hold, or whose law the protocol does not send.
fn refuse_unknown(system: &System, method: &'static str) -> Result<(), PrepareError> {
    for effect in system.effects() {
        let is_curved = effect.split().is_some_and(|split| !split.has_one_slope());
        let is_own = matches!(effect.kind(), EffectKind::Own(_));
        if is_curved || is_own {
            let key = format!("effects.{}", effect.name());
            let what = match is_own {
                true => format!("`{}`, which no frozen system can hold", effect.name()),
                false => "springs with pieces, or with a stiffness of their own in compression"
                    .to_owned(),
            };
            return Err(PrepareError::Unsupported { method, what, key });
        }
    }
    Ok(())
}
