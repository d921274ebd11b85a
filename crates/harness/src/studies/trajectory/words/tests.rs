use super::super::facts::{Flaw, Tied};
use super::super::plates::{Input, PLATES};
use super::*;
use drape_report::plate::Draw;
use drape_report::plot::Shade;
use drape_report::{Record, Verdict};

/// A sheet with its noise, and with the error of its only good form.
fn scene(stiffness: f64, ratio: f64, floor: f64) -> Scene {
    Scene {
        id: format!("k/m = {stiffness:e}, ζ = {ratio}"),
        damping: format!("ζ = {ratio}"),
        particles: 400,
        springs: 1482,
        stiffness_over_mass_per_s2: stiffness,
        damping_over_mass_per_s: 10.0,
        damping_ratio: ratio,
        span_s: 0.25,
        motion_m: 0.2,
        released_j: 0.3,
        dissipated: 0.1,
        strain: 0.01,
        reference_error: 1e-9,
        reference_tolerance: 1e-10,
        members: 9,
        floor,
        shape_floor_m: 1e-6,
        strain_floor: 1e-6,
        energy_floor: 1e-6,
        budget_s: 0.05,
    }
}

fn row(scene: &Scene, label: &str, modelled_s: f64, error: f64, energy: f64) -> Row {
    let beside =
        Beside { shape_m: 0.1 * error, strain: -0.5 * error, energy, retained: 1.0 - error };
    let run = Run {
        error: Some(error),
        beside: Some(beside),
        modelled_s,
        effort: 1.0,
        steps: 8,
        force_evaluations: 8,
        ..Run::uncounted(8.0, Some(0.25 / 8.0), Verdict::Completed)
    };
    Row {
        scene: scene.id.clone(),
        label: label.to_owned(),
        method: label.to_owned(),
        knob: "steps".to_owned(),
        is_headline: true,
        runs: vec![run],
    }
}

/// Facts with two methods. `fast` is explicit. `firm` is implicit and takes `ratio` times the
/// winner's time, or is the winner.
fn facts(sheets: &[(f64, f64, f64, bool, f64)]) -> Facts {
    let mut facts = Facts { scenes: Vec::new(), rows: Vec::new(), winners: Vec::new() };
    for &(stiffness, damping, floor, is_explicit, ratio) in sheets {
        let scene = scene(stiffness, damping, floor);
        let times = if is_explicit { [1.0, ratio] } else { [ratio, 1.0] };
        facts.rows.push(row(&scene, "fast", times[0], 0.004, 0.02));
        facts.rows.push(row(&scene, "firm, tight", times[1], 0.008, -0.005));
        if scene.ranks(LEVEL) {
            let labels =
                if is_explicit { ["fast", "firm, tight"] } else { ["firm, tight", "fast"] };
            let tied = Tied { label: labels[1].to_owned(), is_explicit: !is_explicit, ratio };
            facts.winners.push(Winner {
                scene: scene.id.clone(),
                level: LEVEL,
                label: Some(labels[0].to_owned()),
                is_explicit: Some(is_explicit),
                value: Some(8.0),
                modelled_s: Some(1.0),
                energy: None,
                retained: None,
                runner_up: Some(labels[1].to_owned()),
                ratio: Some(ratio),
                tied: (ratio < LEAD).then_some(tied).into_iter().collect(),
                is_narrow: false,
            });
        }
        facts.scenes.push(scene);
    }
    facts
}

#[test]
fn words_count_leads_and_ties_and_say_where_noise_forbids_both() {
    let known = facts(&[
        (1e2, 0.01, 1e-5, true, 3.0),
        (1e4, 0.1, 1e-4, true, 1.5),
        (1e6, 0.1, 2e-4, false, 4.0),
        (1e8, 1.0, 3e-3, false, 2.5),
        (1e10, 0.01, 0.03, true, 3.0),
    ]);
    let said = words(&known);
    assert_eq!(
        said.conclusion,
        "For an error of 1 %, explicit methods lead by a factor of 2 on 1 of 4 damped sheets, \
         implicit ones on 2, and both kinds tie on 1. Implicit methods lead only from k/m = 10⁶ \
         s⁻² on. Cheapest or tied most often: `fast` where explicit methods lead; `firm` where \
         implicit ones lead; `fast` and `firm` where both kinds tie."
    );
    let all = said.observations.join(" ");
    for sentence in [
        "On 1 of 5 sheets, an error of 1 % cannot be ranked: a start that differs by 1 µm",
        "changes the end by 0.0010 % to 3.0 % of the motion, most at k/m = 1e10, ζ = 0.01.",
        "On 1 of 4 sheets, a ranking by final energy (error at most 1 %) has another winner",
        "Runs that may win at 1 % are off by up to 0.80 mm in shape, 0.40 % in strain and 2.0 % in energy.",
        "Runs within 10 % of the trajectory keep 0.992 to 0.996 of the motion.",
    ] {
        assert!(all.contains(sentence), "{sentence}: {all}");
    }
    // A run that stands still has the right energy, but is not counted.
    let mut still = known.clone();
    let beside = still.rows[0].runs[0].beside.as_mut().expect("errors");
    (beside.energy, beside.retained) = (0.0, 0.1);
    assert_eq!(words(&still).observations[2], said.observations[2]);
    // A sheet is named if no method reaches the error on it.
    let mut missed = known;
    missed.winners[0].label = None;
    missed.winners[0].is_explicit = None;
    missed.winners[0].tied.clear();
    let told = "on 0 of 4 damped sheets, implicit ones on 2, and both kinds tie on 1; on 1 no \
                method gets there within its budget.";
    assert!(words(&missed).conclusion.contains(told), "{:?}", words(&missed));
    assert!(said.caveats[0].contains("1 of 4 winners lead by less"), "{:?}", said.caveats);
    let longest = "4 of 4 winners take the longest step that may win,";
    assert!(said.caveats.iter().any(|text| text.starts_with(longest)), "{:?}", said.caveats);
}

/// All methods that tie with a winner fit the budget of a run, so no tie is told as a lead.
#[test]
fn the_budget_of_a_run_is_told_and_has_room_for_all_ties() {
    let mut known = facts(&[(1e4, 0.1, 1e-4, true, 3.0), (1e6, 0.1, 1e-4, true, 3.0)]);
    (known.winners[0].modelled_s, known.winners[1].modelled_s) = (Some(0.02), Some(0.01));
    let told =
        "Every run has at least 0.05 s of modelled time, and the slowest winner takes 0.020 s";
    assert!(words(&known).caveats.iter().any(|text| text.starts_with(told)), "{known:?}");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../results/trajectory.json").as_ref();
    let committed: Record<Facts> = drape_report::file::read_json(path).expect("a record");
    let most = LEAD * slowest(&committed.facts).expect("winners");
    assert!(committed.facts.scenes.iter().all(|scene| most <= scene.budget_s), "{most}");
}

#[test]
fn a_damping_is_named_only_where_less_damping_changes_the_lead() {
    let known = facts(&[
        (1e6, 0.01, 1e-5, true, 3.0),
        (1e6, 0.1, 1e-5, false, 3.0),
        (1e8, 1.0, 1e-5, false, 3.0),
    ]);
    let told = "only from k/m = 10⁶ s⁻² on, and only where the stiffest mode has a damping ratio of \
                at least 0.10.";
    assert!(words(&known).conclusion.contains(told), "{:?}", words(&known));
}

/// Counts leave out sheets without damping, and a caveat says so.
#[test]
fn a_sheet_without_damping_is_not_counted() {
    let mut known = facts(&[(1e4, 0.1, 1e-4, true, 3.0), (1e6, 0.0, 1e-4, false, 3.0)]);
    known.scenes[1].damping_over_mass_per_s = 0.0;
    let said = words(&known);
    assert!(said.conclusion.contains("on 1 of 1 damped sheets, implicit ones on 0"), "{said:?}");
    assert!(said.caveats.iter().any(|text| text.contains("the 1 sheets without")), "{said:?}");
}

/// A cheaper run with a flaw is told, but is no winner.
#[test]
fn words_count_the_runs_that_a_flaw_keeps_from_winning() {
    let mut known = facts(&[(1e4, 0.1, 1e-4, true, 3.0)]);
    let mut lucky = known.rows[0].clone();
    (lucky.runs[0].modelled_s, lucky.runs[0].flaw) = (0.1, Some(Flaw::GainsEnergy));
    known.rows.push(lucky);
    let caveats = words(&known).caveats;
    assert!(caveats.iter().any(|text| text.contains("at 10 % and on 1 at 1 %")), "{caveats:?}");
}

#[test]
fn one_calm_sheet_alone_gives_no_sentence_that_compares() {
    let said = words(&facts(&[(1e4, 0.1, 1e-4, true, 3.0)]));
    let alone = "by a factor of 2 on 1 of 1 damped sheets, implicit ones on 0, and both";
    assert!(said.conclusion.contains(alone), "{said:?}");
    assert!(!said.conclusion.contains("Implicit methods lead only"), "{said:?}");
    assert!(!said.observations.iter().any(|text| text.contains("most at")), "{said:?}");
}

/// The prices were fitted to damped sheets, so the map colours no winner without damping.
#[test]
fn winners_of_undamped_sheets_are_named_in_grey() {
    let mut known = facts(&[(1e4, 0.01, 1e-5, true, 3.0), (1e4, 0.1, 1e-5, true, 3.0)]);
    known.scenes[0].damping_over_mass_per_s = 0.0;
    let Draw::Matrix(map) = PLATES[0].draw else { panic!("the map comes first") };
    let map = map(&Input { facts: known, timings: None }).expect("a map");
    let named = map.rows.iter().flat_map(|row| {
        let tiles = row.tiles.iter().flatten().filter(|tile| !tile.text.is_empty());
        tiles.map(|tile| (row.label.as_str(), tile.text.as_str(), tile.shade))
    });
    let named: Vec<_> = named.collect();
    let expected =
        [("ζ = 0.01, 1 %", "fast ×3.0", Shade::Idle), ("ζ = 0.1, 1 %", "fast ×3.0", Shade::Open)];
    assert_eq!(named, expected);
}

#[test]
fn words_count_the_cheaper_runs_whose_steps_are_too_long_to_win() {
    let mut seen = facts(&[(1e4, 0.01, 1e-6, true, 4.0), (1e6, 0.01, 1e-6, true, 4.0)]);
    let cost = seen.winners[0].modelled_s.expect("a time");
    let mut long = seen.rows[0].clone();
    long.runs[0].value = 2.0;
    long.runs[0].step_s = Some(0.125);
    long.runs[0].modelled_s = 0.1 * cost;
    long.runs[0].flaw = Some(Flaw::SkipsPictures);
    seen.rows.push(long);
    let said = words(&seen);
    let of = |part: &str| said.caveats.iter().any(|text| text.contains(part));
    assert!(of("1 winners have a cheaper run with longer steps"), "{:?}", said.caveats);
    assert!(!of("it has gained energy or hardly moves"), "{:?}", said.caveats);
}
