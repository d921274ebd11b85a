//! What the studies of films say to the pages: the uses that ask for frames, large cloth, substeps.

use super::{Advised, Answer, advised, facts, method, short, ties, timings};
use crate::studies::animation::facts::{
    Facts, GOOD, Run, Scene, TIE, TimingRow, fastest_of_each, leaders,
};
use std::path::Path;

/// How the ids of the hanging scenes begin, before the number of particles.
const HANGING: &str = "hanging, cotton-blend, light, n=";

/// The explicit method with which others are compared.
const EXPLICIT: &str = "symplectic-euler";

/// Stiffness over mass from which on cloth is stiff for the pages, 1/s².
const STIFF: f64 = 1e6;

/// The method of the film whose call has several substeps.
const LINES: &str = "xpbd-lines";

/// The good runs on a scene of a study of films, each the fastest of its method, fastest first.
pub(super) struct Frames {
    study: &'static str,
    scene: Scene,
    /// The good runs, each the fastest of its method, with the time of a frame, s.
    least: Vec<(Run, f64)>,
    /// Those of other methods that tie with the fastest.
    tied: Vec<Run>,
}

impl Frames {
    /// On the scene of the study whose name contains `part`.
    pub(super) fn of(results: &Path, study: &'static str, part: &str) -> Result<Self, String> {
        let Facts { scenes, mut runs, .. } = facts(results, study)?;
        let scene = scenes.into_iter().find(|scene| scene.id.contains(part)).ok_or_else(|| {
            let record = results.join(study).with_extension("json");
            let record = record.display();
            format!(
                "{record} has no scene whose id contains `{part}`; run `drape experiment {study}`"
            )
        })?;
        let timings: Vec<TimingRow> = timings(results, study)?;
        let time = |run: &Run| timings.iter().find(|row| row.is_of(run)).map(|row| row.frame_s);
        runs.retain(|run| run.scene == scene.id);
        let within = |share: f64| {
            let good = runs.iter().filter(|run| run.is_good_within(&scene, share));
            fastest_of_each(good.filter_map(|run| Some((run, time(run)?))))
        };
        let own = |(run, time): (&Run, f64)| (run.clone(), time);
        let least = within(1.0).into_iter().map(own).collect();
        let tied = leaders(within).into_iter().skip(1);
        let tied = tied.map(|(run, _)| run.clone()).collect();
        Ok(Self { study, scene, least, tied })
    }

    /// The runs of other methods that tie with the fastest, each told by `tell`, and by its error if
    /// that is slightly larger than a good one.
    fn near(&self, tell: impl Fn(&Run) -> String) -> Vec<String> {
        let told = |run: &Run| match self.scene.error(run) {
            Some(error) if !run.is_good(&self.scene) => {
                format!("{} (off by {:.1} mm)", tell(run), 1e3 * error)
            }
            _ => tell(run),
        };
        self.tied.iter().map(told).collect()
    }

    /// How near a good run is.
    fn within(&self) -> String {
        let good = self.scene.good_m();
        let noise = if good > GOOD { " (twice the noise)" } else { "" };
        format!("within {:.0} mm{noise}", 1e3 * good)
    }

    /// Says how exact the true motion is, where that is worse than its noise.
    fn uncertainty(&self) -> String {
        let Scene { reference_error_m, .. } = self.scene;
        match reference_error_m > self.scene.floor_m() {
            true => format!(", true motion known to {:.0} mm", 1e3 * reference_error_m),
            false => String::new(),
        }
    }
}

/// The method of a run, for a text.
fn named(run: &Run) -> String {
    format!("`{}`", method(&run.label))
}

/// The form of a run beside its calls. These tell the number of substeps, so the form need not.
fn form_beside_calls(run: &Run) -> String {
    match run.inside {
        Some(_) => method(&run.label).to_owned(),
        None => short(&run.method),
    }
}

/// The fastest good method, and its ties, on a scene of a study, and what a comparison advises
/// for the bundled scene of the use.
pub(super) fn of_frames(results: &Path, frames: &Frames, bundled: &str) -> Result<Answer, String> {
    let Frames { study, scene, least, .. } = frames;
    let place = match scene.id.split(',').next().unwrap_or_default() {
        "led" => ", one edge moved to and fro".to_owned(),
        place => format!(" {place}"),
    };
    let place = format!(
        "{}, {} damping, {} particles{place} for {} s",
        scene.fabric,
        scene.damping(),
        scene.particles,
        scene.span_s
    );
    let good = format!("good: {:.0} mm", 1e3 * scene.good_m());
    let kept = |kept| format!("; it keeps {:.0} % of the kinetic energy", 100.0 * kept);
    let kept = frames.least.first().and_then(|(run, _)| run.kinetic).map(kept).unwrap_or_default();
    let sure = frames.uncertainty();
    let measured = format!("{place}, {}{sure}{kept} (study `{study}`)", frames.within());
    let Advised { take: bundled, why: advised } = advised(results, bundled)?;
    let Some((first, time)) = least.first() else {
        let why = format!("`{study}`, {}: no run is good{advised}", scene.id);
        return Ok(Answer { take: "none".to_owned(), measured, bundled, why });
    };
    let form = form_beside_calls(first);
    // A run that leads only with another accepted error can take far longer.
    let tell = |run: &Run| {
        let own = least.iter().find(|(good, _)| good.label == run.label);
        match own.map(|(_, other)| other / time) {
            Some(times) if times > TIE => format!("{} ({times:.1} times the time)", named(run)),
            _ => named(run),
        }
    };
    let take =
        format!("`{form}`, {} a frame{}", first.calls(scene), ties("tie", &frames.near(tell)));
    let off = match scene.error(first) {
        Some(error) => format!("off by {:.1} mm ({good})", 1e3 * error),
        None => "its strain is kept".to_owned(),
    };
    // A tie says more than the next method.
    let next = least.get(1).filter(|_| frames.tied.is_empty());
    let next = next
        .map(|(run, other)| format!("; next: {}, {:.1} times the time", named(run), other / time));
    let (frame_ms, next) = (1e3 * time, next.unwrap_or_default());
    let why = format!("`{study}`, {}: {frame_ms:.1} ms a frame, {off}{next}{advised}", scene.id);
    Ok(Answer { take, measured, bundled, why })
}

/// The fastest good method on a scene of `animation-long`, with its share of the time of
/// `symplectic-euler`, and the forms that tie with it.
fn fastest(results: &Path, id: &str) -> Result<(Frames, String), String> {
    let frames = Frames::of(results, "animation-long", id)?;
    let Frames { scene, least, .. } = &frames;
    if scene.id != id {
        return Err(format!("animation-long has no scene `{id}`, only `{}`", scene.id));
    }
    let (first, time) =
        least.first().ok_or_else(|| format!("animation-long, {id}: no run is good"))?;
    let form = |run: &Run| match (form_beside_calls(run), run.inside) {
        (form, Some(_)) => format!("`{form}` ({} a frame)", run.calls(scene)),
        (form, None) => format!("`{form}`"),
    };
    let explicit = least.iter().find(|(run, _)| run.label == EXPLICIT);
    let share = match explicit {
        Some((_, other)) if other > time => {
            format!(", {:.0} % of the time of `{EXPLICIT}`", 100.0 * time / other)
        }
        _ => String::new(),
    };
    let told = form(first) + &share + &ties("tie", &frames.near(form));
    Ok((frames, told))
}

/// The fastest good methods on hanging cloth of 2500 particles and more, mesh by mesh.
///
/// # Errors
/// When a record cannot be read or lacks one of these scenes.
pub fn on_large_cloth(results: &Path) -> Result<String, String> {
    let meshes = ["2500", "10000", "40000"];
    let told = meshes.map(|particles| {
        let (_, told) = fastest(results, &format!("{HANGING}{particles}"))?;
        Ok::<_, String>(format!("{particles} particles: {told}"))
    });
    Ok(told.into_iter().collect::<Result<Vec<_>, _>>()?.join(". "))
}

/// Names the forms that a long study did not run or time on a scene.
fn not_run(record: &Facts, scene: &Scene) -> String {
    let own = || record.missing.iter().filter(|missing| missing.scene == scene.id);
    let lacking: Vec<_> = own().flat_map(|missing| &missing.not_run).collect();
    let spent: Vec<_> = own().flat_map(|missing| &missing.over_budget).collect();
    let untimed: Vec<_> = own().flat_map(|missing| &missing.not_timed).collect();
    let kinds = [(lacking, "not run"), (spent, "over the budget"), (untimed, "not timed")];
    let told = kinds.iter().filter(|(labels, _)| !labels.is_empty()).map(|(labels, why)| {
        let labels: Vec<_> = labels.iter().map(|label| format!("`{label}`")).collect();
        format!("{} ({why})", labels.join(", "))
    });
    let told: Vec<_> = told.collect();
    if told.is_empty() { String::new() } else { format!(", without {}", told.join(", ")) }
}

/// The fastest good methods on large hanging cloth over 5 s, mesh by mesh.
///
/// # Errors
/// As [`on_large_cloth`].
pub fn on_large_cloth_for_long(results: &Path) -> Result<String, String> {
    let record: Facts = facts(results, "animation-long")?;
    let told = ["2500", "40000"].map(|particles| {
        let (frames, told) = fastest(results, &format!("{HANGING}{particles}, 5 s"))?;
        let not_run = not_run(&record, &frames.scene);
        let (within, sure) = (frames.within(), frames.uncertainty());
        Ok::<_, String>(format!("{particles} particles, {within}{sure}{not_run}: {told}"))
    });
    Ok(told.into_iter().collect::<Result<Vec<_>, _>>()?.join(". "))
}

/// What light damping is.
///
/// # Errors
/// When the record cannot be read or has no such scene.
pub fn light_damping(results: &Path) -> Result<String, String> {
    let Facts { scenes, .. } = facts(results, "animation")?;
    let light = scenes.iter().find(|scene| scene.damping() == "light");
    let light = light.ok_or("animation: no scene has light damping")?.damping_over_stiffness_s;
    Ok(format!("Light damping: {light:e} s times the stiffness of each spring."))
}

/// The fewest substeps of a frame with which `xpbd-lines` has a good run on stiff cloth with light
/// damping, scene by scene.
///
/// # Errors
/// When a record cannot be read.
pub fn substeps_of_lines(results: &Path) -> Result<String, String> {
    let mut told = Vec::new();
    for study in ["animation", "animation-long"] {
        let Facts { scenes, runs, .. } = facts(results, study)?;
        let stiff = scenes.iter().filter(|scene| scene.stiffness_over_mass_per_s2 >= STIFF);
        for scene in stiff.filter(|scene| scene.damping() == "light") {
            let own = runs.iter().filter(|run| run.scene == scene.id && run.label == LINES);
            // A scene may lack its runs.
            let Some(most) = own.clone().map(Run::parts_of_a_frame).max() else { continue };
            let least = own.filter(|run| run.is_good(scene)).map(Run::parts_of_a_frame).min();
            let number =
                least.map_or_else(|| format!("none up to {most}"), |number| number.to_string());
            let place = scene.id.split(", ").next().unwrap_or_default();
            told.push(format!(
                "{number} ({place}, {}, {} particles, {} Hz, {:.1} s)",
                scene.fabric, scene.particles, scene.frames_per_s, scene.span_s
            ));
        }
    }
    Ok(told.join(", "))
}

/// The study with the scene of the film, and a part of the scene's id.
pub(super) const FILM: (&str, &str) = ("animation", "24 Hz");

/// The settings with which the command takes the fastest good method of the film.
///
/// # Errors
/// When a record cannot be read or no run is good.
pub fn command_of_film(results: &Path) -> Result<String, String> {
    let (study, part) = FILM;
    let Frames { scene, least, .. } = Frames::of(results, study, part)?;
    let (run, _) = least.first().ok_or_else(|| format!("{study}, {}: no run is good", scene.id))?;
    let calls = scene.frames_per_s * run.substeps;
    Ok(format!("`--method {} --dt 1/{calls}`", short(&run.method)))
}

/// In how many scenes one call a frame of each form is good, study by study.
///
/// # Errors
/// When a record cannot be read.
pub fn in_one_call(results: &Path) -> Result<String, String> {
    let studies = [facts::<Facts>(results, "animation")?, facts(results, "animation-long")?];
    let of = |label: &str| {
        let [short, long] = studies.each_ref().map(|Facts { scenes, runs, .. }| {
            let own = |scene: &Scene| {
                let id = scene.id.clone();
                runs.iter().filter(move |run| run.scene == id && run.label == label)
            };
            // A scene may lack its runs.
            let all: Vec<_> = scenes.iter().filter(|scene| own(scene).next().is_some()).collect();
            let is_good =
                |scene: &&&Scene| own(scene).any(|run| run.substeps == 1 && run.is_good(scene));
            format!("{} of {}", all.iter().filter(is_good).count(), all.len())
        });
        format!("`{label}` in {short} scenes of `animation` and {long} of `animation-long`")
    };
    Ok(format!("{}; {}", of(LINES), of("rkc")))
}

/// Whether a run is not good for its kinetic energy alone.
fn is_bounded(run: &Run, scene: &Scene) -> bool {
    run.is_sound() && run.is_near(scene, 1.0) && !run.is_lively(1.0)
}

/// The substeps of `xpbd-lines` that the bound on kinetic energy excludes on the scene of the film, and
/// the fewest that it lets pass.
///
/// # Errors
/// When a record cannot be read or has no scene of a film.
pub fn bound_of_film(results: &Path) -> Result<String, String> {
    let (study, part) = FILM;
    let Facts { scenes, runs, .. } = facts(results, study)?;
    let scene = scenes.iter().find(|scene| scene.id.contains(part));
    let scene = scene.ok_or_else(|| format!("{study} has no scene of a film"))?;
    let own = || runs.iter().filter(|run| run.scene == scene.id && run.label == LINES);
    let excluded = own().filter(|run| is_bounded(run, scene));
    let good = own().filter(|run| run.is_good(scene)).min_by_key(|run| run.parts_of_a_frame());
    let told = |run: &Run, what: &str| {
        let kept = 100.0 * run.kinetic.unwrap_or_default();
        format!("{} substeps of `{LINES}` keep {kept:.0} % and {what}", run.parts_of_a_frame())
    };
    let excluded = excluded.map(|run| told(run, "fail"));
    let told: Vec<_> = excluded.chain(good.map(|run| told(run, "pass"))).collect();
    Ok(told.join(", "))
}

/// The scenes of both studies in which the bound on kinetic energy alone excludes runs, each with
/// their number.
///
/// # Errors
/// When a record cannot be read.
pub fn bounded(results: &Path) -> Result<String, String> {
    let mut told = Vec::new();
    for study in ["animation", "animation-long"] {
        let Facts { scenes, runs, .. } = facts(results, study)?;
        for scene in &scenes {
            let own = runs.iter().filter(|run| run.scene == scene.id);
            let number = own.filter(|run| is_bounded(run, scene)).count();
            if number > 0 {
                told.push(format!("{number} ({})", scene.id));
            }
        }
    }
    Ok(told.join(", "))
}
