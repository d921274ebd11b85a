//! What `draw` writes, from synthetic records.

#![allow(clippy::unwrap_used)]

use crate::common::{self, complete};
use drape_harness::studies::cg_vs_stiffness::facts as cg;
use drape_harness::studies::{all, draw};
use drape_report::Verdict;
use drape_report::file::write_json;
use drape_report::{RecordError, ReportError};
use std::collections::BTreeMap;
use std::path::Path;

/// Draws and returns the text of every file by its name below the folder.
fn drawn(results: &Path) -> BTreeMap<String, String> {
    let name = |path: &Path| path.strip_prefix(results).unwrap().to_str().unwrap().to_owned();
    let files = draw(results).unwrap();
    files.iter().map(|path| (name(path), std::fs::read_to_string(path).unwrap())).collect()
}

/// The cells of every row of every table.
fn table_rows(html: &str) -> Vec<Vec<String>> {
    let select = |css| scraper::Selector::parse(css).unwrap();
    let document = scraper::Html::parse_document(html);
    let cells = |row: scraper::ElementRef<'_>| {
        row.select(&select("td")).map(|cell| cell.text().collect()).collect()
    };
    document.select(&select("tbody tr")).map(cells).collect()
}

fn texts_of(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|cell| (*cell).to_owned()).collect()
}

fn texts<'a>(document: &'a roxmltree::Document<'_>) -> Vec<roxmltree::Node<'a, 'a>> {
    document.descendants().filter(|node| node.has_tag_name("text")).collect()
}

fn words(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let text = |node: &roxmltree::Node<'_, '_>| node.text().unwrap_or_default().trim().to_owned();
    texts(&document).iter().map(text).collect()
}

#[test]
fn every_figure_and_the_page_are_written() {
    let folder = complete();
    // For a look at the pictures: DRAPE_REPORT_LOOK=folder keeps a copy.
    let files = drawn(folder.path());
    if let Some(copy) = std::env::var_os("DRAPE_REPORT_LOOK") {
        for (name, text) in &files {
            drape_report::file::write_atomically(&Path::new(&copy).join(name), text.as_bytes())
                .unwrap();
        }
    }
    // Pictures have tests of their own.
    let drawn_here = all().iter().copied().filter(|study| study.name() != "pictures");
    let figures: Vec<_> = drawn_here.flat_map(|study| study.figures()).collect();
    let lessons = figures.iter().filter(|figure| figure.file.starts_with("course-")).count();
    // The synthetic course has three lessons only.
    assert_eq!(lessons, 25);
    assert_eq!(files.len(), figures.len() - 21 + 2);
    let page = &files["README.md"];
    let report = scraper::Html::parse_document(&files["report.html"]);
    let report: String = report.root_element().text().collect();
    let mut missing = Vec::new();
    for figure in figures {
        assert!(figure.caption.split_whitespace().count() > 30, "{}", figure.file);
        if !files.contains_key(&format!("figures/{}", figure.file)) {
            missing.push(figure.file);
            continue;
        }
        assert!(files.contains_key(&format!("figures/{}", figure.file)), "{}", figure.file);
        assert!(page.contains(&format!("(figures/{})", figure.file)), "{}", figure.file);
        assert!(report.contains(&figure.caption.replace('`', "")), "{}", figure.file);
    }
    assert!(missing.iter().all(|file| file.starts_with("course-")), "{missing:?}");
}

#[test]
fn figures_name_axes_units_and_every_curve() {
    let variants = ["plain", "updated-paper", "updated-robust"];
    let stiffnesses =
        ["10²", "10³", "10⁴", "10⁵", "10⁶", "10⁷", "10⁸"].map(|k| format!("k/m = {k} s⁻²"));
    let failed = "run was unstable or diverged";
    let mut expected: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    let mut expect = |file, entries: &[&str]| {
        expected.entry(file).or_default().extend(entries.iter().map(|e| (*e).to_owned()));
    };
    expect("tables-counts.svg", &variants);
    expect("tables-counts.svg", &["the paper's count", failed, "run was marginal"]);
    expect("tables-counts.svg", &["forcing term ε (dimensionless)", "CG iterations in 1 s"]);
    expect("tables-counts.svg", &["Table 3, row 2: hanging textile"]);
    expect("tables-counts.svg", &["2704 particles, k/m = 10⁶ s⁻², h = 0.01 s"]);
    expect("tables-exponents.svg", &variants);
    expect("tables-exponents.svg", &["stiffness over mass k/m (s⁻²)"]);
    expect("tables-exponents.svg", &["count / paper's count (ratio)"]);
    expect("tables-exponents.svg", &["ratio 1: the paper's count", "reading that drape takes"]);
    expect("tables-cost.svg", &["CG", "set-up of the matrix", "rest", "the paper"]);
    expect("tables-cost.svg", &["share of the solver's time (%)", "plain, matrix kept"]);
    expect("tables-cost.svg", &["2700 ms per simulated s"]);
    for preconditioner in ["none", "jacobi", "ic0"] {
        for start in ["extrapolated", "last", "best"] {
            expect("cg-vs-stiffness.svg", &[&format!("{preconditioner}, {start}")]);
        }
    }
    for file in ["cg-vs-stiffness.svg", "cg-plain-vs-updated.svg"] {
        expect(file, &["stiffness over mass k/m (s⁻²)", "CG iterations per step", "0"]);
    }
    expect("cg-vs-stiffness.svg", &["400 particles, plain", "2704 particles, updated-paper"]);
    expect("cg-plain-vs-updated.svg", &["400 particles", "2704 particles"]);
    expect("cg-plain-vs-updated.svg", &variants);
    expect("cg-plain-vs-updated.svg", &[failed, "run was marginal"]);
    expect("cg-vs-theta.svg", &["θ = h²k/m (dimensionless)", "CG iterations per step"]);
    expect("cg-vs-theta.svg", &["h = 0.001 s", "h = 0.002 s", "h = 0.005 s", "h = 0.01 s"]);
    expect("cg-vs-theta.svg", &["h = 0.02 s", "h = 0.05 s"]);
    expect("cg-vs-step.svg", &["time step h (s)", "CG iterations in 1 s", "400 particles, plain"]);
    expect("cg-vs-forcing-term.svg", &["forcing term ε (dimensionless)", "CG iterations per step"]);
    for stiffness in &stiffnesses {
        expect("cg-vs-step.svg", &[stiffness]);
        expect("cg-vs-forcing-term.svg", &[stiffness]);
    }
    expect("motion-vs-stiffness.svg", &["imex-euler", "imex-updated", "backward-euler", failed]);
    expect("motion-vs-stiffness.svg", &["imex-updated, tension only", "h = 0.01 s"]);
    expect("motion-vs-stiffness.svg", &["vertical displacement at t = 0.3 s (m)"]);
    let labels = common::CURVES.map(|(_, label)| label);
    let crossed = "run was unstable or diverged";
    for file in ["order-smooth.svg", "order-stiff.svg", "order-observed.svg"] {
        expect(file, &labels);
    }
    for file in ["order-smooth.svg", "order-stiff.svg"] {
        expect(file, &["time step h (s)", "error over motion (dimensionless)"]);
        expect(file, &["slope 1", "slope 2"]);
    }
    expect("order-smooth.svg", &["Explicit, k/m = 400 s⁻²", "Other methods, k/m = 400 s⁻²"]);
    expect("order-stiff.svg", &["Explicit, k/m = 10⁴ s⁻²", "Explicit, k/m = 10⁶ s⁻²", crossed]);
    expect("order-observed.svg", &["observed order", "theory", crossed]);
    expect("order-observed.svg", &["smooth, k/m = 400 s⁻², projected damping"]);
    for file in ["momentum-spin.svg", "momentum-spin-left.svg", "momentum-drift.svg"] {
        expect(file, &labels);
    }
    expect(
        "momentum-spin.svg",
        &["time (s)", "|L|/|L₀|", "Implicit-explicit, one step, k/m = 10⁶ s⁻²"],
    );
    expect("momentum-spin-left.svg", &["two particles, k/m = 10⁴ s⁻²", crossed]);
    expect("momentum-spin-left.svg", &["|L|/|L₀| after one second (dimensionless)"]);
    expect("momentum-drift.svg", &["drift of momentum (dimensionless)", crossed]);
    expect("momentum-drift.svg", &["falling sheet, k/m = 10⁴ s⁻²"]);
    for scene in ["hanging-1e4", "hanging-1e6", "spinning-1e4", "sphere-1e4"] {
        let name = |kind: &str| -> &'static str { format!("energy-{kind}-{scene}.svg").leak() };
        let (ledger, curves) = (name("ledger"), name("over-time"));
        expect(curves, &labels);
        expect(curves, &["time (s)", "(H − H₀)/E_ref", "Explicit, undamped", crossed]);
        expect(curves, &["Other methods, damped, d/m = 40 s⁻¹"]);
        expect(ledger, &["numerical damping", "damping of the scene", "residual of the solver"]);
        expect(ledger, &["pins and contacts", "corrections", "leapfrog", "unheard-of"]);
        expect(ledger, &["change of the total energy (% of what the scene sets free)"]);
        // Shorter, but with its true number; the unstable run by its verdict.
        expect(ledger, &["600 %", "−600 %", "diverged", "−53 %"]);
        expect(
            ledger,
            &["Bars longer than 100 % are drawn shorter; the numbers in them are true."],
        );
    }
    for file in
        ["stability-atlas.svg", "stability-atlas-undamped.svg", "stability-atlas-damping.svg"]
    {
        expect(file, &["S", "L", "M", "U", "D", "B", "stable", "locked", "over budget", "10⁻²"]);
        expect(file, &["explicit-euler", "unheard-of"]);
    }
    expect("stability-atlas.svg", &["10⁴", "10⁶"]);
    expect("stability-atlas-damping.svg", &["0", "40.0"]);
    expect("stability-limits.svg", &["pair, d/m = 40 s⁻¹", "sheet, d/m = 40 s⁻¹", crossed]);
    expect("stability-limits.svg", &["longest stable step, measured over theory (ratio)"]);
    expect("stability-shear.svg", &["imex-euler", "imex-updated", "h = 0.01 s", crossed]);
    expect("stability-shear.svg", &["stiffness ratio k_s/k (dimensionless)"]);
    for file in ["locking-stiffness.svg", "locking-step.svg"] {
        expect(file, &labels);
        expect(file, &["retained motion R", "half of the motion", crossed]);
    }
    expect("locking-stiffness.svg", &["stiffness over mass k/m (s⁻²)"]);
    expect("locking-step.svg", &["time step h (s)"]);
    expect("locking-terminal.svg", &["terminal speed of the law (m/s)", "the law", "imex-euler"]);
    expect("locking-spring.svg", &["θ = h²k/m (dimensionless)", "spring along x", "imex-euler"]);
    expect(
        "control-work.svg",
        &["hanging, k/m = 10⁶ s⁻², order 1", "bdf2, adaptive", "imex-euler, constant", crossed],
    );
    expect("control-work.svg", &["work (sweeps over the springs)", "error over motion"]);
    expect("control-matvecs.svg", &["products with the matrix", "imex-euler, adaptive"]);
    expect("control-steps.svg", &["time (s)", "step size (s)", "backward-euler", "bdf2"]);
    expect("control-forcing.svg", &["hanging, k/m = 10⁴ s⁻²", "backward-euler, Eisenstat-Walker"]);
    expect("control-forcing.svg", &["inner tolerance ε (dimensionless)"]);
    expect("hard-cases.svg", &common::METHODS);
    expect("hard-cases.svg", &["H01 longest of titles"]);
    expect(
        "hard-cases.svg",
        &["S", "s", "M", "D", "b", "stable", "over budget", "nothing to vary"],
    );
    expect("hard-cases.svg", &["not what theory says"]);
    let ways = ["imex-euler, teleport", "baraff-witkin, position", "baraff-witkin, teleport"];
    expect("collision-iterations.svg", &ways);
    expect("collision-iterations.svg", &["severe: twice as many", "table-3-1e6", crossed]);
    expect("collision-course.svg", &["velocity", "position", "teleport", "time (s)"]);
    expect("collision-course.svg", &["baraff-witkin, k/m = 10⁶ s⁻²", "iterations a step"]);
    for file in ["collision-depth.svg", "collision-energy.svg"] {
        expect(file, &["baraff-witkin, velocity", "table, k/m = 10⁴ s⁻²", "sphere, k/m = 10⁶ s⁻²"]);
    }
    expect("collision-depth.svg", &["greatest depth over v h (dimensionless)"]);
    expect("collision-energy.svg", &["gain over the available energy (dimensionless)", "0"]);
    expect("effects-support.svg", &["I", "E", "R", "effect 19", "refused", "leapfrog"]);
    expect("post-correction-order.svg", &["backward", "disturbed start", "grid, 1 sweep a step"]);
    expect("post-correction-order.svg", &["triangles, 10 sweeps a step", "time (s)"]);
    expect("post-correction-limit.svg", &["limit of the elongation", "grid, t = 0.5 s"]);
    expect("post-correction-limit.svg", &["desbrun, 1 sweep a step", "without correction"]);
    expect("post-correction-sweeps.svg", &["greatest elongation left", "limit", "sweeps"]);
    expect("post-correction-sweeps.svg", &["triangles, limit 0.01", "alternating"]);
    expect("post-correction-bill.svg", &["energy given", "share of the weight held"]);
    expect("post-correction-bill.svg", &["grid, provot, 1 sweep a step, limit 0.1"]);
    for file in ["inverse-counts.svg", "inverse-cost.svg"] {
        expect(file, &["dense inverse", "sparse Cholesky", "CG with IC(0), one fabric"]);
        expect(file, &["particles", "20 times as much"]);
    }
    expect("inverse-counts.svg", &["operations", "bytes", "To solve once"]);
    expect("inverse-cost.svg", &["time (ms)", "A step", "Rebuild over one step"]);

    let front = "Pareto front of all methods";
    let error = "error over motion (dimensionless)";
    expect("work-precision.svg", &["time of the run (s)", error, front]);
    expect("work-precision.svg", &["k/m = 10¹⁰ s⁻², 400 particles", "explicit-euler"]);
    let effort = "modelled time (s)";
    for file in [
        "work-precision-effort.svg",
        "work-precision-stiff.svg",
        "work-precision-heavy.svg",
        "work-precision-size.svg",
    ] {
        expect(file, &[front, error, effort]);
    }
    expect("work-precision-effort.svg", &["Explicit, k/m = 10⁴ s⁻²", "Explicit, k/m = 10⁶ s⁻²"]);
    expect("work-precision-stiff.svg", &["Local solves, filters, other, k/m = 10¹⁰ s⁻²"]);
    expect("work-precision-heavy.svg", &["k/m = 10⁸ s⁻², 400 particles"]);
    expect("work-precision-size.svg", &["1600 particles, material fixed, k/m = 40000 s⁻²"]);
    expect("work-precision-map.svg", &["hanging, light, 10 %", "leapfrog =", "imex-updated"]);
    expect("work-precision-map.svg", &["stiffness limits the step (explicit)", "imex-updated"]);
    expect("trajectory-map.svg", &["d/m = 10 s⁻¹, 10 %", "ζ = 1, 0.1 %", "noise"]);
    expect("trajectory-map.svg", &["k/m = 10⁸ s⁻²", "a tie, whatever the kinds"]);
    expect("trajectory-noise.svg", &["half of 1 %", "d/m = 10 s⁻¹", "ζ = 1"]);
    expect("trajectory-front.svg", &[front, effort, "noise", "k/m = 10⁸ s⁻², ζ = 1"]);
    expect("trajectory-errors.svg", &["Trajectory", "Shape", "Stretch", "Energy", "Motion kept"]);
    expect("trajectory-errors.svg", &["distance of surfaces (mm)", "motion kept R", "noise"]);
    let models = drape_harness::studies::fabric::facts::Model::ALL.map(|model| model.name());
    for file in ["fabric-master-curve.svg", "fabric-convergence.svg"] {
        expect(file, &models);
    }
    expect("fabric-master-curve.svg", &["10 edges", "40 edges", "exact", "drop over reach H/W"]);
    expect("fabric-convergence.svg", &["Γ = 8", "error of H/W (%)", "slope 1", "slope 2"]);
    expect("fabric-widths.svg", &["rows of particles across", "derived: narrow", "Γ = 8"]);
    expect("fabric-drape.svg", &["denim", "published: silk", "16 squares across"]);
    expect("fabric-drape.svg", &["drape coefficient (%)", "published band of a class"]);
    expect("scaling-cost.svg", &["particles n", "ns a particle and step", "phase: solve"]);
    expect("scaling-cost.svg", &["144 bytes a particle at 10.0 GB/s", "imex-euler, by phase"]);
    expect("scaling-cg.svg", &["CG iterations per step", "k/m fixed", "material fixed"]);
    expect("animation-frames.svg", &["ms a frame", "error of shape (mm)", "noise", "good enough"]);
    expect("animation-frames.svg", &["cotton-blend, light damping", "k/m = 4.0·10⁶ s⁻², 1 s"]);
    expect(
        "animation-frames.svg",
        &["any other method", "In every panel: L symplectic-euler; ✗ leapfrog."],
    );
    expect("animation-map.svg", &["hanging", "10 mm, good", "a tie, whatever the kinds"]);
    let kind = "it takes more sweeps or substeps (local solves)";
    let longer = "Most scenes last 0.3 to 0.6 s. Over 5 s some of these runs gain energy:";
    expect("animation-map.svg", &[kind, longer, "the map of animation-long."]);
    expect(
        "animation-long-cheapest.svg",
        &["hanging", "on a ball", "locked", "over the budget of work"],
    );
    let partly = "hanging: 20 of 22 methods were run; over budget in a shorter span: 1;";
    expect("animation-long-map.svg", &["hanging", "1 mm", partly, "sound, but not timed: 1."]);
    expect("animation-frames.svg", &["10²"]);
    expect("animation-long-frames.svg", &["cotton-blend, light damping", "400 particles, 1 s"]);
    let partly = "hanging: 20 of 22 methods were run; over budget in a shorter span: 1; sound, but \
                  not timed: 1.";
    expect("animation-long-frames.svg", &["✗ leapfrog", partly]);
    expect("rest-arrival.svg", &["step (ms)", "at rest after (s)", "time that a run has"]);
    expect(
        "rest-cheapest.svg",
        &[
            "square table",
            "locked",
            "at rest in a shape that is not right",
            "on its way at the end",
        ],
    );
    expect("animation-front.svg", &["ms a frame", "error (mm)", "good enough", "the front"]);
    expect(
        "animation-cheapest.svg",
        &["hanging", "on a ball", "locked", "over the budget of work"],
    );
    expect(
        "regret.svg",
        &["regret (ratio of times)", "effort of the comparison (% of the search)"],
    );
    expect("regret.svg", &["greatest that it should have", "target met on a pushed cloth"]);
    expect("claims.svg", &["in all", "criterion", "reading 2", "holds: 27", "fails: 1"]);
    expect("claims.svg", &["depends: 0", "undecided: 1"]);
    expect(
        "claims.svg",
        &["C01 (§2.2) stationary iterations are unfit for stiff systems, CG fits"],
    );
    let leads = "M01 with light damping leapfrog leads at errors of 0.1 % and below";
    expect("claims-modern.svg", &[leads, "holds: 1", "fails: 7", "undecided: 0"]);
    expect("course-motion.svg", &["retained motion R (dimensionless)", "leapfrog", crossed]);
    for file in ["course-explicit-euler.svg", "course-leapfrog.svg", "course-provot.svg"] {
        expect(file, &["time (s)", "height (m)", "true motion", "k/m = 10⁶ s⁻²"]);
    }
    expect("course-explicit-euler.svg", &["explicit-euler", crossed]);
    expect("course-leapfrog.svg", &["explicit-euler", "leapfrog", crossed]);
    expect("course-provot.svg", &["leapfrog", "provot", crossed]);

    let folder = complete();
    let files = drawn(folder.path());
    assert_eq!(expected.len(), files.len() - 2);
    for (file, entries) in expected {
        let words = words(&files[&format!("figures/{file}")]);
        for entry in entries {
            assert!(words.contains(&entry), "{file} lacks `{entry}`: {words:?}");
        }
    }
    let lacks = |file: &str, text: &str| {
        let words = words(&files[&format!("figures/{file}")]);
        assert!(!words.iter().any(|word| word.contains(text)), "{file}: {words:?}");
    };
    // The long study is the one that the note means.
    lacks("animation-long-map.svg", "Over 5 s");
    // A sluggish run wins nowhere.
    lacks("animation-map.svg", "sluggish");
    // An error of twenty times a good one stands on the figure of the short study alone.
    lacks("animation-long-frames.svg", "10²");
}

#[test]
fn figures_are_well_formed_and_no_text_leaves_them() {
    let folder = complete();
    for (name, svg) in drawn(folder.path()).iter().filter(|(name, _)| name.ends_with(".svg")) {
        let document = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{name}: {e}"));
        let root = document.root_element();
        assert_eq!(root.attribute("role"), Some("img"), "{name}");
        for tag in ["title", "desc"] {
            let element = root.children().find(|node| node.has_tag_name(tag)).unwrap();
            assert!(!element.text().unwrap_or_default().is_empty(), "{name}: {tag}");
        }
        let size = |side| root.attribute(side).unwrap().parse::<f64>().unwrap();
        let (width, height) = (size("width"), size("height"));
        // A table of tiles is as high as its rows, and so are panels on a slim page.
        let is_flat =
            ["-map.svg", "-frames.svg", "-modern.svg"].iter().any(|end| name.ends_with(end));
        let is_high = height >= 550.0 || is_flat;
        // These fit a phone.
        let is_slim = name.contains("animation")
            && !name.contains("long-frames")
            && ["-map.svg", "-frames.svg"].iter().any(|end| name.ends_with(end));
        let is_wide = if is_slim { width == 680.0 } else { width >= 900.0 };
        assert!(is_wide && is_high, "{name}: {width} × {height}");
        for node in texts(&document) {
            let number = |key| node.attribute(key).unwrap().parse::<f64>().unwrap();
            let text = node.text().unwrap_or_default().trim();
            let font = number("font-size");
            assert!(font > 13.99, "{name}: `{text}` is {font} px");
            // Extent along the line of writing, with a generous width of characters.
            let length = 0.56 * font * text.chars().count() as f64;
            let before = match node.attribute("text-anchor").unwrap() {
                "start" => 0.0,
                "middle" => 0.5 * length,
                _ => length,
            };
            let turned = node.attribute("transform").is_some();
            let (at, limit) =
                if turned { (height - number("y"), height) } else { (number("x"), width) };
            let across = if turned { number("x") } else { number("y") };
            let across_limit = if turned { width } else { height };
            assert!(
                at - before >= 0.0 && at - before + length <= limit,
                "{name}: `{text}` runs from {} to {} of {limit}",
                at - before,
                at - before + length
            );
            assert!((0.0..=across_limit).contains(&across), "{name}: `{text}` at {across}");
        }
    }
}

#[test]
fn the_same_records_give_the_same_bytes() {
    let (first, second) = (complete(), complete());
    let files = drawn(first.path());
    assert_eq!(files, drawn(second.path()));
    assert_eq!(files, drawn(first.path()), "drawn over itself");
}

#[test]
fn a_quick_subset_is_drawn_with_what_there_is_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    write_json(&folder.path().join("tables.json"), &common::tables(true)).unwrap();
    write_json(&folder.path().join("cg-vs-stiffness.json"), &common::cg(true)).unwrap();
    // What an earlier, complete run left.
    std::fs::create_dir(folder.path().join("figures")).unwrap();
    std::fs::write(folder.path().join("figures/cg-vs-step.svg"), "stale").unwrap();
    let files = drawn(folder.path());
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "README.md",
            "figures/cg-plain-vs-updated.svg",
            "figures/cg-vs-stiffness.svg",
            "figures/cg-vs-theta.svg",
            "figures/tables-counts.svg",
            "figures/tables-exponents.svg",
            "report.html",
        ]
    );
    let page = &files["README.md"];
    assert_eq!(page.matches("Quick subset").count(), 2);
    assert!(!page.contains("cg-vs-step.svg"), "a stale figure is shown");
    let report = &files["report.html"];
    assert!(!report.contains("cg-vs-step.svg"), "a stale figure is shown");
    assert_eq!(report.matches("Quick subset").count(), 2);
    assert!(report.contains("No timings were taken here"));
}

#[test]
fn a_figure_whose_scenes_were_not_run_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    write_json(&folder.path().join("order.json"), &common::order(true)).unwrap();
    write_json(&folder.path().join("momentum.json"), &common::momentum(true)).unwrap();
    write_json(&folder.path().join("energy.json"), &common::energy(true)).unwrap();
    write_json(&folder.path().join("stability.json"), &common::stability(true)).unwrap();
    write_json(&folder.path().join("locking.json"), &common::locking(true)).unwrap();
    let files = drawn(folder.path());
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "README.md",
            "figures/energy-ledger-spinning-1e4.svg",
            "figures/energy-over-time-spinning-1e4.svg",
            "figures/locking-spring.svg",
            "figures/locking-terminal.svg",
            "figures/momentum-drift.svg",
            "figures/momentum-spin-left.svg",
            "figures/momentum-spin.svg",
            "figures/order-observed.svg",
            "figures/order-smooth.svg",
            "figures/stability-limits.svg",
            "report.html",
        ]
    );
    let rows = table_rows(&files["report.html"]);
    let has = |cells: &[&str]| rows.iter().any(|row| row.starts_with(&texts_of(cells)));
    assert!(has(&["provot, limit out of reach", "1", "−0.25 ✗; 4.00"]), "{rows:?}");
    assert!(has(&["provot", "–", "2.00"]), "{rows:?}");
    assert!(!files["report.html"].contains("stiff, k/m = 10⁶"));
}

#[test]
fn what_the_quick_subset_of_contacts_and_corrections_lacks_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    write_json(&folder.path().join("collision.json"), &common::collision(true)).unwrap();
    let path = folder.path().join("post-correction.json");
    write_json(&path, &common::post_correction(true)).unwrap();
    let path = folder.path().join("precomputed-inverse.json");
    write_json(&path, &common::inverse(true)).unwrap();
    let files = drawn(folder.path());
    let has = |file: &str| files.contains_key(&format!("figures/{file}"));
    assert!(has("collision-iterations.svg") && has("post-correction-order.svg"));
    assert!(has("inverse-counts.svg") && !has("inverse-cost.svg"), "no timings were taken");
    assert!(!has("post-correction-limit.svg"), "one limit makes no curve");
    let report = &files["report.html"];
    let row = texts_of(&["table-3-1e4", "2.00", "4.00"]);
    assert!(table_rows(report).iter().any(|cells| cells.starts_with(&row)), "{report}");
    assert!(!report.contains("sphere"), "{report}");
}

#[test]
fn without_timings_the_headline_shows_effort_and_unverified_times_are_not_ranked() {
    let folder = tempfile::tempdir().unwrap();
    write_json(&folder.path().join("work-precision.json"), &common::work_precision(true)).unwrap();
    write_json(&folder.path().join("scaling.json"), &common::scaling(true)).unwrap();
    let files = drawn(folder.path());
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "README.md",
            "figures/scaling-cg.svg",
            "figures/work-precision-effort.svg",
            "figures/work-precision-map.svg",
            "figures/work-precision-size.svg",
            "figures/work-precision.svg",
            "report.html",
        ]
    );
    let axis = "modelled time (s)".to_owned();
    assert!(words(&files["figures/work-precision.svg"]).contains(&axis));
    assert!(!files["report.html"].contains("Fastest by the clock"));

    let mut timings = common::work_precision_timings();
    let quickest = |page: &str| page.contains("symplectic-euler, implicit damping, 8.00 ms");
    let draw_with = |timings: &drape_report::Timings<_>| {
        write_json(&folder.path().join("timings/work-precision.json"), timings).unwrap();
        drawn(folder.path()).remove("report.html").unwrap()
    };
    assert!(quickest(&draw_with(&timings)));
    for row in timings.rows.iter_mut().filter(|row| row.value == 64.0) {
        row.is_verified = false;
    }
    assert!(!quickest(&draw_with(&timings)));
}

#[test]
fn a_record_without_any_data_still_makes_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let mut record = common::cg(false);
    record.facts = cg::Facts { cells: Vec::new(), motion: Vec::new() };
    record.words = drape_report::Words::default();
    write_json(&folder.path().join("cg-vs-stiffness.json"), &record).unwrap();
    let files = drawn(folder.path());
    assert_eq!(files.len(), 2);
    assert!(files["report.html"].contains("no data for any figure"));
    assert!(files["README.md"].contains("The record states no conclusion"));
    assert!(!files["README.md"].contains("## tables"));
}

#[test]
fn zeros_and_single_points_are_drawn_inside_the_panel() {
    let folder = tempfile::tempdir().unwrap();
    let mut record = common::cg(false);
    for cell in &mut record.facts.cells {
        cell.cg_iterations = 0;
        cell.cg_per_step = 0.0;
    }
    record.facts.motion.retain(|motion| motion.verdict == Verdict::Diverged);
    write_json(&folder.path().join("cg-vs-stiffness.json"), &record).unwrap();
    let files = drawn(folder.path());
    assert_eq!(files.len(), 8);
    assert!(words(&files["figures/cg-vs-step.svg"]).contains(&"0".to_owned()));
    let motion = words(&files["figures/motion-vs-stiffness.svg"]).join(" ");
    assert!(motion.contains("4.50·10¹²⁰ (imex-updated)"), "{motion}");
}

#[test]
fn an_empty_folder_is_refused_with_its_name_and_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let error = draw(folder.path()).unwrap_err();
    assert!(matches!(&error, ReportError::NoRecords { folder: f } if f == folder.path()));
    let message = error.to_string();
    assert!(message.contains(&folder.path().display().to_string()), "{message}");
    assert!(message.contains("drape reproduce"), "{message}");
}

#[test]
fn a_broken_record_is_refused_by_name_and_nothing_is_written() {
    for name in ["tables.json", "timings/tables.json", "cg-vs-stiffness.json"] {
        let folder = complete();
        let path = folder.path().join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        // A number that JSON cannot hold is written as null.
        let broken = text.replacen("_s\": 0.0", "_s\": null, \"x\": 0.0", 1);
        assert_ne!(broken, text);
        std::fs::write(&path, broken).unwrap();
        let error = draw(folder.path()).unwrap_err();
        assert!(
            matches!(&error, ReportError::Record(RecordError::Format { path: p, .. }) if *p == path)
        );
        assert!(error.to_string().contains(&path.display().to_string()), "{error}");
        assert!(!folder.path().join("figures").exists(), "{name}");
    }
}

#[test]
fn a_record_of_another_experiment_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut record = common::tables(true);
    record.experiment = "collision".to_owned();
    let path = folder.path().join("tables.json");
    write_json(&path, &record).unwrap();
    let message = draw(folder.path()).unwrap_err().to_string();
    assert!(message.contains(&path.display().to_string()), "{message}");
    assert!(message.contains("`collision`") && message.contains("`tables`"), "{message}");
}

#[test]
fn the_index_names_question_findings_figures_and_command() {
    let folder = complete();
    let page = drawn(folder.path()).remove("README.md").unwrap();
    for text in [
        "The conclusion of animation. ([animation](#animation)) ",
        "**What does tables ask?**",
        "The conclusion of tables.",
        "- An observation, a | b.",
        "*Caveat.* A caveat.",
        "(figures/cg-vs-theta.svg)",
        "`report.html`",
        "(tables.json)",
        "`drape experiment tables`",
    ] {
        assert!(page.contains(text), "no `{text}` in {page}");
    }
    assert!(!page.contains("NaN") && !page.contains("inf "));
    assert!(page.lines().all(|line| !line.ends_with(' ')), "trailing blanks");
    assert!(!page.contains("\n\n\n"), "double blank lines in {page}");
}

#[test]
fn verdicts_that_differ_from_theory_are_framed_listed_and_explained() {
    let folder = tempfile::tempdir().unwrap();
    write_json(&folder.path().join("hard-cases.json"), &common::hard_cases(false)).unwrap();
    let files = drawn(folder.path());
    assert_eq!(
        files.keys().collect::<Vec<_>>(),
        ["README.md", "figures/hard-cases.svg", "report.html"]
    );
    // One of each of the 28 cases, and one in the legend.
    assert_eq!(files["figures/hard-cases.svg"].matches("stroke-width=\"2\"").count(), 29);
    let cells: Vec<String> = table_rows(&files["report.html"]).concat();
    let count = |text: &str| cells.iter().filter(|cell| *cell == text).count();
    assert_eq!(count("a reason | why"), 1);
    assert_eq!(count("unexplained"), 27);
    assert!(count("M 0.12 / M 0.12") > 0 && count("b 1.25 s / b 1.25 s") > 0, "{cells:?}");
}

#[test]
fn a_claim_that_the_seconds_contradict_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let (claims, seconds) = common::claims();
    write_json(&folder.path().join("claims.json"), &claims).unwrap();
    let told = "by counted work (by seconds on this machine it does not)";
    let cells = |files: &BTreeMap<String, String>| table_rows(&files["report.html"]);
    let doubted = |rows: &[Vec<String>]| -> Vec<String> {
        let is_doubted = |row: &&Vec<String>| row.iter().any(|cell| cell.contains(told));
        rows.iter().filter(is_doubted).map(|row| row[0].clone()).collect()
    };
    let counted = drawn(folder.path());
    assert!(doubted(&cells(&counted)).is_empty());
    write_json(&folder.path().join("timings/claims.json"), &seconds).unwrap();
    let files = drawn(folder.path());
    let rows = cells(&files);
    assert_eq!(doubted(&rows), ["C02"]);
    let all: Vec<&str> = rows.iter().flatten().map(String::as_str).collect();
    let numbers = "ratio: 1.75 (limit 1.5); iterations: 12 1/step; gain: ∞ J";
    let repair = "With ∂F2 in the matrix the sheet falls 0.400 m in 0.3 s, without it 0.100 m.";
    assert!(all.contains(&numbers) && all.contains(&repair), "{all:?}");
    assert!(all.contains(&"a sheet | a table"), "{all:?}");
    // The figure does not change with the machine.
    assert_eq!(files["figures/claims.svg"], counted["figures/claims.svg"]);
}

/// No page calls an expectation about later methods a claim of the paper.
#[test]
fn expectations_stand_in_a_figure_and_a_table_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let (mut claims, _) = common::claims();
    write_json(&folder.path().join("claims.json"), &claims).unwrap();
    let files = drawn(folder.path());
    let holds = |file: &str, id: &str| {
        let words = words(&files[file]);
        words.iter().any(|word| word.starts_with(&format!("{id} ")))
    };
    for (id, paper) in [("C05", true), ("M05", false)] {
        assert_eq!(holds("figures/claims.svg", id), paper, "{id}");
        assert_eq!(holds("figures/claims-modern.svg", id), !paper, "{id}");
    }
    let page = scraper::Html::parse_document(&files["report.html"]);
    let table = scraper::Selector::parse("table").unwrap();
    let first_cells = |table: scraper::ElementRef<'_>| -> Vec<String> {
        let rows = scraper::Selector::parse("tbody tr").unwrap();
        let cell = scraper::Selector::parse("td").unwrap();
        let first =
            |row: scraper::ElementRef<'_>| row.select(&cell).next().map(|c| c.text().collect());
        table.select(&rows).filter_map(first).collect()
    };
    let ledgers: Vec<Vec<String>> = page.select(&table).map(first_cells).collect();
    let starts = |cells: &&Vec<String>, letter: char| cells.iter().all(|c| c.starts_with(letter));
    let sizes = |letter| -> Vec<usize> {
        let filled = ledgers.iter().filter(|cells| !cells.is_empty());
        filled.filter(|cells| starts(cells, letter)).map(Vec::len).collect()
    };
    // The ledger, and the two claims of this record that have several readings.
    assert_eq!((sizes('C'), sizes('M')), (vec![29, 2], vec![8]));
    // A record without any, as that of a quick run may be, has neither.
    claims.facts.claims.truncate(29);
    write_json(&folder.path().join("claims.json"), &claims).unwrap();
    let files = drawn(folder.path());
    assert!(!files.contains_key("figures/claims-modern.svg"));
    assert!(!files["report.html"].contains("Expectations about later methods"));
}
