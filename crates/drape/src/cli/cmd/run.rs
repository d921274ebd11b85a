//! `drape run`.

use super::frames::Frames;
use super::probe::{Form, Probes};
use super::refusal;
use crate::cli::exit::Diverged;
use crate::cli::input::{files, in_file, load};
use crate::cli::interrupt::{self, Interrupted};
use crate::cli::limit::LimitArguments;
use crate::cli::number::number;
use crate::cli::output::{Sink, print};
use crate::cli::progress::bar;
use clap::builder::TypedValueParser as _;
use drape_harness::auto;
use drape_harness::judgement::{Judge, Rise};
use drape_harness::methods::{Choice, MethodError};
use drape_harness::record::{Run, Sample};
use drape_harness::{HarnessError, Moment, OrderedSimulation, Passage, Peak, Team, time_span};
use drape_integrator::ExplicitNumbers;
use drape_model::{SystemSpec, TimeSpan};
use drape_report::{printable, tell};
use std::collections::BTreeSet;
use std::num::NonZero;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled scene, or a file with a scene or a discretised system
    scene: String,
    /// Id of a method; settings follow a colon: imex-euler:forcing_term=0.05,start=last. Or
    /// program:COMMAND, such as program:./mine.py, for a program of your own. Or auto:error=0.01 for
    /// the form and step that the study work-precision advises for this error
    #[arg(long)]
    method: String,
    /// Time step, s, a number or a fraction such as 1/60 (default: of the scene; a discretised system has none)
    #[arg(long, allow_negative_numbers = true, value_parser = number)]
    dt: Option<f64>,
    /// Simulated time, s (default: of the scene; a discretised system has none)
    #[arg(long, allow_negative_numbers = true, value_parser = number)]
    duration: Option<f64>,
    /// A setting of the method; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Write the run into this file: .json (format "drape-run/2"), or .csv with only the energies
    /// and momenta over time. With - the run goes to standard output and the summary to standard
    /// error
    #[arg(long)]
    out: Option<PathBuf>,
    /// Also record the seconds of each phase of a step
    #[arg(long)]
    phases: bool,
    /// Number of threads. It does not change the results. Sheets below about 16 000 particles use
    /// one thread
    #[arg(
        long, value_name = "N", default_value = "1",
        value_parser = clap::value_parser!(u16).range(1..=1024).try_map(NonZero::try_from),
    )]
    threads: NonZero<u16>,
    #[command(flatten)]
    limit: LimitArguments,
    #[command(flatten)]
    probes: super::probe::ProbeArguments,
    #[command(flatten)]
    frames: super::frames::FrameArguments,
}

/// The method that the arguments name, and the step. `auto` chooses both and says why.
fn chosen(arguments: &Arguments) -> anyhow::Result<(Choice, Option<f64>)> {
    let Some(error) = auto::wanted(&arguments.method, &arguments.settings)? else {
        let choice = Choice::parse(&arguments.method, &arguments.settings)
            .map_err(|error: MethodError| HarnessError::from(error))?;
        return Ok((choice, arguments.dt));
    };
    let input = load(&arguments.scene, arguments.limit, None)?;
    let time = time_span(arguments.dt, arguments.duration, &input)?;
    let wish = auto::Wish { error, step_s: arguments.dt, frame_s: time.step_s };
    let pick =
        auto::choose(input.spec(), wish).map_err(|error| error.in_scene(&arguments.scene))?;
    tell!("drape: auto: {}", pick.reason);
    let choice = Choice::parse(&pick.method, &[]).map_err(HarnessError::from)?;
    Ok((choice, Some(pick.step_s)))
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let interrupt = interrupt::flag();
    let (choice, dt) = chosen(arguments)?;
    let input = load(&arguments.scene, arguments.limit, Some(&choice))?;
    let time = time_span(dt, arguments.duration, &input)?;
    let inputs = files(&arguments.scene, &input);
    let sink = |file: &PathBuf| Sink::check("--out", file, &inputs);
    let sink = arguments.out.as_ref().map(sink).transpose()?;
    let form = arguments.out.as_ref().map(|file| Form::of("--out", file)).transpose()?;
    let spec = input.spec();
    let mut simulation = OrderedSimulation::new(spec, &choice)
        .map_err(|violation| in_file(&arguments.scene, violation))?;
    let threads = NonZero::<usize>::from(arguments.threads);
    simulation.set_threads(threads);
    let mut team = Team::new(threads, spec.particles.mass_kg.len()).map_err(|error| {
        let expected = format!("fewer threads: the system refuses so many ({error})");
        refusal("--threads", threads, expected)
    })?;
    let step = time.step_s;
    let is_short = simulation.surely_allows(step);
    let is_damped = simulation.has_damping();
    let warn = |numbers, when: &str| step_warning(numbers, (&choice, is_damped), step, when);
    let at_start = (!is_short).then(|| team.run(|| simulation.explicit_numbers()));
    let warning = at_start.and_then(|numbers| warn(numbers, "at the start"));
    let was_warned = warning.is_some();
    if let Some(warning) = warning {
        tell!("drape: warning: {warning}");
    }
    if let Some(warning) = mass_warning(spec) {
        tell!("drape: warning: {warning}");
    }
    let mut judge = Judge::of(&simulation, &choice, time);
    if let Some(warning) = judge.expected().warning(&simulation, &choice, step) {
        tell!("drape: warning: {warning}");
    }
    let taken = (&inputs[..], sink.as_ref());
    let mut tunnels = simulation.tunnels();
    let is_driven = judge.is_driven();
    let mut frames = Frames::begin(&arguments.frames, spec, &simulation, time, taken)?;
    let (whole, rest) = time.steps();
    let mut probes = Probes::begin(
        &arguments.probes,
        spec,
        &simulation,
        whole + u64::from(rest.is_some()),
        taken,
    )?;
    let bar = bar(choice.method().id, whole + u64::from(rest.is_some()));
    let mut peak = Peak::default();
    let mut sound = Peak::before_a_rise_above(simulation.moving().energy());
    let every = whole.div_ceil(PEAKS).max(1);
    let simulate = || {
        let look = |moment: &Moment<'_>| {
            let (step, moving) = (moment.step, moment.moving());
            bar.as_ref().inspect(|bar| bar.set_position(step));
            if step % every == 0 && !was_warned {
                peak.look(moving);
            }
            // A run may diverge early: look more often at its beginning.
            if step % (step / PEAKS).max(1) == 0 && !was_warned && !is_driven {
                sound.look(moving);
            }
            judge.look(moment);
            tunnels.look(moment);
            if let Some(probes) = &mut probes {
                probes.look(moment);
            }
            if let Some(frames) = &mut frames {
                frames.look(moving);
            }
        };
        let phases = arguments.phases;
        simulation.simulate(time, |runner| {
            let runner = runner.series().phases(phases).stop_at(interrupt).observe(look);
            if is_driven { runner.ledger() } else { runner }
        })
    };
    let outcome = team.run(simulate).map_err(|error| error.in_scene(&arguments.scene))?;
    bar.inspect(|bar| bar.finish_and_clear());
    let gain = judge.gain(&simulation, &choice, &outcome);
    let verdict = team.run(|| judge.verdict(&simulation, &outcome, gain.as_ref()));
    let record = Run::of(spec, &choice, time, (&outcome, verdict), &simulation.state());
    if let Some(sink) = &sink {
        if form == Some(Form::Csv) {
            sink.write(super::probe::series(&record.series).as_bytes())?;
        } else {
            sink.write_run(&record)?;
        }
    }
    if let Some(probes) = &probes {
        probes.finish()?;
    }
    let speaks_data = sink.as_ref().is_some_and(Sink::is_standard)
        || probes.as_ref().is_some_and(Probes::is_standard)
        || frames.as_ref().is_some_and(Frames::is_standard);
    if let Some(frames) = frames {
        frames.finish()?;
    }
    if outcome.unconverged > 0 {
        tell!(
            "drape: warning: in {} of {} steps the solver stopped before its tolerance",
            outcome.unconverged,
            outcome.steps
        );
    }
    // Speeds after a divergence say nothing about the limit before it.
    let (peak, before) =
        if outcome.divergence.is_none() { (&peak, "") } else { (&sound, " before it diverges") };
    let at_peak = || team.run(|| simulation.explicit_numbers_at_peak(peak));
    let at_peak = (!is_short).then(at_peak).flatten();
    let warning = at_peak.and_then(|(t, numbers)| {
        warn(numbers, &format!("at t = {t:.4} s, where the cloth is fastest{before}"))
    });
    if let Some(warning) = warning {
        tell!("drape: warning: {warning}");
    }
    let gain = gain.and_then(Rise::warning);
    for warning in gain.into_iter().chain(tunnels.first().map(tunnel_warning)) {
        tell!("drape: warning: {warning}");
    }
    // What went wrong is told once, with the error.
    let reason = outcome.divergence.as_ref().map(|end| format!("at step {}", end.step));
    let summary = summary(&record, reason.as_ref().unwrap_or(&record.verdict.reason));
    // The end of the run decides the exit code, even if the summary cannot be printed.
    let printed = if speaks_data {
        summary.lines().for_each(|line| tell!("{line}"));
        Ok(())
    } else {
        print(&summary)
    };
    let kept = match &sink {
        Some(sink) => format!("the record until then is in {sink}"),
        None => "use --out FILE to keep the record until then".to_owned(),
    };
    if outcome.is_over_budget {
        let reached = simulation.state().t;
        return Err(Interrupted(format!(
            "interrupted at step {} (t = {reached} s of {} s); {kept}; to run it whole: {}",
            outcome.steps,
            time.duration_s,
            interrupt::command(&[])
        ))
        .into());
    }
    let Some(divergence) = outcome.divergence else { return printed };
    let how = if divergence.is_outside { "was given up" } else { "diverged" };
    Err(Diverged(format!(
        "{} {how} at step {} (t = {} s): {}; {kept}",
        choice.full_id(),
        divergence.step,
        divergence.time,
        divergence.criterion
    ))
    .into())
}

/// About how many times a run samples its speed.
const PEAKS: u64 = 100;

/// The warning for a step that is too long for forces at the old time level of a cloth that is
/// damped or not.
fn step_warning(
    numbers: ExplicitNumbers,
    (choice, is_damped): (&Choice, bool),
    step: f64,
    when: &str,
) -> Option<String> {
    let limit = numbers.limit();
    let what = if numbers.stiffness_limit() <= numbers.drag_limit() {
        "the stiffness"
    } else {
        "the drag of the air"
    };
    let divides = |(key, value): (&str, &str)| match key {
        "step" => value != "fixed",
        "tolerance" => value.parse::<f64>().is_ok_and(|tolerance| tolerance > 0.0),
        _ => false,
    };
    let is_divided = choice.settings().iter().any(divides);
    let id = choice.method().id;
    // Damping shortens the step; the limit of the stiffness alone is exact without it.
    let most = if choice.has_exact_limit() && !is_damped { "" } else { "at most " };
    let see = if is_damped { "; `drape inspect` gives a limit with damping" } else { "" };
    (step > limit && !is_divided).then(|| {
        format!(
            "{} takes {what} at the old time level, which allows steps of {most}about \
             {limit:.2e} s {when}; the step of {step} s is {:.1} times as long{see}",
            id,
            step / limit
        )
    })
}

/// Ratio of masses up to which every method is tested.
const TESTED_RATIO: f64 = 1e20;

/// Beyond that ratio the round-off of the heavy particle may stop a solver before the light ones
/// are solved.
fn mass_warning(spec: &SystemSpec) -> Option<String> {
    let pinned: BTreeSet<_> = spec.pins.iter().map(|pin| pin.particle as usize).collect();
    let masses = spec.particles.mass_kg.iter().copied().enumerate();
    let mut free: Vec<_> = masses.filter(|(i, _)| !pinned.contains(i)).collect();
    free.sort_by(|a, b| a.1.total_cmp(&b.1));
    let ((light, least), (heavy, most)) = (*free.first()?, *free.last()?);
    (most > TESTED_RATIO * least).then(|| {
        format!(
            "`particles.mass_kg[{heavy}]` is {most:e} and `particles.mass_kg[{light}]` is \
             {least:e}; expected a ratio of at most {TESTED_RATIO:e}: round-off of the heavy \
             particle may hide the motion of the light ones; pin the heavy one or make it lighter"
        )
    })
}

fn tunnel_warning(passage: &Passage) -> String {
    let Passage { time, step, particle, obstacle, shape, way, thickness } = passage;
    format!(
        "in the step to t = {time:.4} s particle {particle} and obstacles[{obstacle}] (a {shape}) \
         moved {way:.3e} m past each other; the {shape} is {thickness:.3e} m thick, and contacts \
         are found at the ends of steps alone: it may pass through; take steps of at most {:.1e} s",
        0.5 * step * thickness / way
    )
}

fn summary(run: &Run, reason: &str) -> String {
    let totals = run.totals;
    let energy = |position: Option<&Sample>| {
        position.and_then(|sample| sample.energy_j.get("total")).copied().unwrap_or(f64::NAN)
    };
    let totals_of = |sample: &Sample| sample.energy_j.get("total").copied();
    let greatest = run.series.iter().filter_map(totals_of).fold(f64::NEG_INFINITY, f64::max);
    let (whole, rest) = TimeSpan { step_s: run.dt_s, duration_s: run.final_state.time_s }.steps();
    let steps = match rest {
        Some(rest) if run.steps > whole => {
            let rest = (rest * 1e12).round() * 1e-12; // a difference: its last digits are round-off
            format!("{whole} steps of {} s and one of {rest} s", run.dt_s)
        }
        _ => format!("{} steps of {} s", run.steps, run.dt_s),
    };
    let settings: Vec<_> =
        run.settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let settings = match settings.join(", ") {
        none if none.is_empty() => none,
        list => format!(" ({list})"),
    };
    format!(
        "{} with {}{settings}: {steps} in {:.3e} s\n\
         CG iterations {}, outer passes {}, Newton iterations {}, matrix products {}, \
         force evaluations {}\n\
         total energy {:.6} J at the start, {greatest:.6} J at most, {:.6} J at the end\n\
         verdict: {}: {}\n",
        printable(&run.scene),
        run.method,
        totals.seconds,
        totals.cg_iterations,
        totals.outer_passes,
        totals.newton_iterations,
        totals.matvecs,
        totals.force_evaluations,
        energy(run.series.first()),
        energy(run.series.last()),
        run.verdict.kind,
        reason
    )
}
