//! Figures and tables of the experiment `fabric`.

use super::facts::{Bent, Drape, Edgewise, Facts, Model, Width};
use drape_report::number::{percent, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Axis, Draft, Look, Panel, Point, Rule, Series, Sheet, State, panels_of,
};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "fabric-master-curve.svg",
        title: "How far a strip bends under its weight",
        caption: "Angles, and hinges with the factor of their mesh, approach the exact curve as \
            the mesh is refined. Springs to the next particle but one depart from it and find no \
            rest on fine meshes. Drop of the free end over its reach against Γ = ρ g L³/B; each \
            panel is a mesh. The textile standard is the point Γ = 8, a chord of 41.5°. Strips \
            that are not at rest are left out.",
        draw: Draw::Sheet(master_curve),
    },
    Plate {
        file: "fabric-convergence.svg",
        title: "Error of a strip over the number of edges",
        caption: "Angles along rows converge with second order. Hinges with the factor of their \
            mesh converge while the strip is light; a strip that bends far resists curling \
            across, and their factor assumes that it curls. With the stiffness of a wide sheet \
            the error stays, and springs get worse. Error of the drop over the reach; each panel \
            is a Γ.",
        draw: Draw::Sheet(convergence),
    },
    Plate {
        file: "fabric-widths.svg",
        title: "Rigidity of a strip over its width",
        caption: "A narrow strip of hinges curls across and is softer than a wide one, which bends \
            to a cylinder; the width does not matter to angles along rows. Shown is the rigidity \
            with which the exact strip bends as far, over that of a wide sheet, for strips of 30 \
            edges with rising numbers of rows. Dashed: the derived values for a narrow strip and \
            for a sheet.",
        draw: Draw::Sheet(widths),
    },
    Plate {
        file: "fabric-drape.svg",
        title: "Drape coefficients beside published bands",
        caption: "The width of a row is the spread over meshes and folds. Each marker is a rest \
            position of a cloth of 30 cm on a table of 18 cm: a bundled material on one mesh from \
            one start. Lower rows: published bands for classes of cloth. A cloth with a \
            coefficient of 100 % does not bend at all.",
        draw: Draw::Sheet(drapes),
    },
];

/// A point of a specimen at rest.
fn point(x: f64, y: f64) -> Point {
    Point { x, y, state: State::Stable }
}

fn look(model: Model) -> Look {
    Look::number(1 + Model::ALL.iter().position(|known| *known == model).unwrap_or_default())
}

fn master_curve(input: &Input) -> Option<Sheet> {
    let facts = &input.facts;
    let draft = |segments: u32| -> Draft {
        let own: Vec<&Bent> = facts.bent.iter().filter(|bent| bent.segments == segments).collect();
        let exact = own.iter().map(|bent| point(bent.gamma, bent.exact)).collect();
        let mut series: Vec<Series> =
            Series::new("exact".to_owned(), Look::number(0), exact).into_iter().collect();
        series.extend(Model::ALL.into_iter().filter_map(|model| {
            let of_model = own.iter().filter(|bent| bent.model == model && bent.error().is_some());
            let points = of_model.filter_map(|b| Some(point(b.gamma, b.drop_over_reach?)));
            Series::new(model.name().to_owned(), look(model), points.collect())
        }));
        (vec![format!("{segments} edges")], series, Vec::new())
    };
    panels_of(
        facts.meshes().into_iter().map(draft).collect(),
        |xs| Axis::log("Γ = ρ g L³/B (dimensionless)", xs),
        |ys| Axis::log("drop over reach H/W", ys),
    )
}

/// Up to four values of `Γ`, including the least and the greatest.
fn shown_gammas(facts: &Facts) -> Vec<f64> {
    let gammas = facts.gammas();
    let n = gammas.len();
    if n <= 4 { gammas } else { [0, n / 3, 2 * n / 3, n - 1].map(|k| gammas[k]).into() }
}

fn convergence(input: &Input) -> Option<Sheet> {
    let facts = &input.facts;
    let draft = |gamma: f64| -> Draft {
        let of = |model: Model| {
            let own = facts.bent.iter().filter(|bent| (bent.model, bent.gamma) == (model, gamma));
            let points = own.filter_map(|bent| {
                Some(point(f64::from(bent.segments), 100.0 * libm::fabs(bent.error()?)))
            });
            Series::new(model.name().to_owned(), look(model), points.collect())
        };
        let series: Vec<Series> = Model::ALL.into_iter().filter_map(of).collect();
        let first = facts.meshes().first().map_or(1.0, |first| f64::from(*first));
        let rules = [1.0, 2.0].map(|order| Rule {
            label: format!("slope {order:.0}"),
            at: At::Slope { order: -order, x: first, y: 3.0 },
        });
        (vec![format!("Γ = {gamma}")], series, rules.into())
    };
    panels_of(
        shown_gammas(facts).into_iter().map(draft).collect(),
        |xs| Axis::log("edges along the free length", xs),
        |ys| Axis::log("error of H/W (%)", ys),
    )
}

fn widths(input: &Input) -> Option<Sheet> {
    let all = &input.facts.widths;
    let models = Model::ALL.into_iter().filter(|model| all.iter().any(|w| w.model == *model));
    let draft = |model: Model| -> Draft {
        let own: Vec<&Width> = all.iter().filter(|width| width.model == model).collect();
        let mut gammas: Vec<f64> = own.iter().map(|width| width.gamma).collect();
        gammas.sort_by(f64::total_cmp);
        gammas.dedup();
        let of = |(n, gamma): (usize, &f64)| {
            let of_gamma = own.iter().filter(|width| width.gamma == *gamma);
            let points = of_gamma.map(|width| {
                point(f64::from(width.rows), width.rigidity_over_stiffness / width.wide)
            });
            Series::new(format!("Γ = {gamma}"), Look::number(n), points.collect())
        };
        let series = gammas.iter().enumerate().filter_map(of).collect();
        let rules = own.first().map_or_else(Vec::new, |width| {
            vec![
                Rule { label: "derived: narrow".to_owned(), at: At::Y(width.narrow / width.wide) },
                Rule { label: "derived: sheet".to_owned(), at: At::Y(1.0) },
            ]
        });
        (vec![short(model).to_owned()], series, rules)
    };
    panels_of(
        models.map(draft).collect(),
        |xs| Axis::linear("rows of particles across", xs),
        |ys| {
            let narrow = all.iter().map(|width| width.narrow / width.wide);
            let ys: Vec<f64> = ys.iter().copied().chain(narrow).chain([1.0]).collect();
            Axis::linear("rigidity over that of a sheet", &ys)
        },
    )
}

/// The name of a model without its stiffness factor.
fn short(model: Model) -> &'static str {
    model.name().split(", k").next().unwrap_or_default()
}

/// The look of bands: a full line in a colour that no mesh has.
const BAND: Look = Look::of_family(5, 14);

fn drapes(input: &Input) -> Option<Sheet> {
    let Facts { cloths, bands, drapes, .. } = &input.facts;
    let resting = || drapes.iter().filter(|drape| drape.is_at_rest());
    let own: Vec<&str> = cloths
        .iter()
        .map(|cloth| cloth.name.as_str())
        .filter(|name| resting().any(|drape| drape.cloth == *name))
        .collect();
    let rows: Vec<String> = own
        .iter()
        .map(|name| (*name).to_owned())
        .chain(bands.iter().map(|band| format!("published: {}", band.class)))
        .collect();
    let per_cent = |value: f64| 100.0 * value;
    let values: Vec<f64> = resting()
        .map(|drape| drape.coefficient)
        .chain(bands.iter().flat_map(|band| [band.least, band.greatest]))
        .map(per_cent)
        .chain([0.0, 100.0])
        .collect();
    let axis = Axis::linear("drape coefficient (%)", &values);
    let mut panel = Panel::new(Vec::new(), axis, Axis::names("", &rows));
    let mut meshes: Vec<u32> = drapes.iter().map(|drape| drape.cells).collect();
    meshes.sort_unstable();
    meshes.dedup();
    for (n, cells) in meshes.iter().enumerate() {
        let of_mesh = resting().filter(|drape| drape.cells == *cells);
        let points = of_mesh.filter_map(|drape| {
            let place = own.iter().position(|name| *name == drape.cloth)?;
            Some(point(per_cent(drape.coefficient), -(place as f64)))
        });
        let label = format!("{cells} squares across");
        panel
            .series
            .extend(Series::new(label, Look::number(n), points.collect()).map(Series::apart));
    }
    for (n, band) in bands.iter().enumerate() {
        let y = -((own.len() + n) as f64);
        let ends = [band.least, band.greatest].map(|value| point(per_cent(value), y));
        panel.series.extend(Series::path(
            "published band of a class".to_owned(),
            BAND,
            ends.into(),
        ));
    }
    (!own.is_empty()).then(|| Sheet { panels: vec![panel], notes: Vec::new() })
}

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let facts = &input.facts;
    vec![
        curve(facts),
        orders(facts),
        width_table(facts),
        edge_table(facts),
        cloths(facts),
        tests(facts),
    ]
}

/// Drop over reach of every model on every mesh, with the exact strip.
fn curve(facts: &Facts) -> Table {
    let gammas = facts.gammas();
    let exact = |gamma: &f64| facts.bent.iter().find(|bent| bent.gamma == *gamma);
    let mut rows = vec![texts(&["exact", ""])];
    rows[0].extend(
        gammas.iter().map(|gamma| exact(gamma).map_or_else(absent, |b| format!("{:.4}", b.exact))),
    );
    for model in Model::ALL {
        for segments in facts.meshes() {
            let cell = |gamma: &f64| match facts.bent(model, *gamma, segments) {
                None => absent(),
                Some(bent) => match (bent.error(), bent.drop_over_reach) {
                    (Some(_), Some(ratio)) => format!("{ratio:.4}"),
                    _ => format!("not at rest ({:.0e})", bent.residual),
                },
            };
            let mut row = vec![model.name().to_owned(), segments.to_string()];
            row.extend(gammas.iter().map(cell));
            rows.push(row);
        }
    }
    let mut header = texts(&["model", "edges"]);
    header.extend(gammas.iter().map(|gamma| format!("Γ = {gamma}")));
    Table {
        title: "**Drop of the free end over its reach**, beside the exact strip.".to_owned(),
        header,
        names: 2,
        rows,
    }
}

fn orders(facts: &Facts) -> Table {
    let gammas = facts.gammas();
    let finest = facts.meshes().into_iter().next_back().unwrap_or_default();
    let line = |model: Model| {
        let cell = |gamma: &f64| {
            let error = facts.bent(model, *gamma, finest).and_then(Bent::error);
            let order = facts.order(model, *gamma).map_or_else(absent, |o| significant(o, 2));
            error.map_or_else(absent, |error| {
                let sign = if error < 0.0 { "−" } else { "+" };
                format!("{sign}{}; {order}", percent(libm::fabs(error), 2))
            })
        };
        std::iter::once(model.name().to_owned()).chain(gammas.iter().map(cell)).collect()
    };
    let mut header = texts(&["model"]);
    header.extend(gammas.iter().map(|gamma| format!("Γ = {gamma}")));
    Table {
        title: format!(
            "**Error on {finest} edges; observed order** between the two finest meshes, where the \
             error falls."
        ),
        header,
        names: 1,
        rows: Model::ALL.into_iter().map(line).collect(),
    }
}

fn width_table(facts: &Facts) -> Table {
    let line = |width: &Width| {
        vec![
            short(width.model).to_owned(),
            significant(width.gamma, 2),
            width.rows.to_string(),
            significant(width.width_over_length, 2),
            format!("{:.4}", width.drop_over_reach),
            significant(width.rigidity_over_stiffness, 4),
            significant(width.narrow, 4),
            significant(width.wide, 4),
            format!("{:.0e}", width.residual),
        ]
    };
    Table {
        title:
            "**Narrow and wide strips**: the rigidity B over the stiffness k. Angles, whose k is \
             B, show the effect of the mesh alone."
                .to_owned(),
        header: texts(&[
            "model",
            "Γ",
            "rows",
            "width over length",
            "H/W",
            "B/k",
            "derived: narrow",
            "derived: sheet",
            "residual",
        ]),
        names: 1,
        rows: facts.widths.iter().map(line).collect(),
    }
}

fn edge_table(facts: &Facts) -> Table {
    let number = |value: Option<f64>| value.map_or_else(absent, |value| significant(value, 4));
    let line = |edge: &Edgewise| {
        vec![
            edge.model.name().to_owned(),
            edge.segments.to_string(),
            edge.rows.to_string(),
            if edge.turned { "yes" } else { "no" }.to_owned(),
            significant(edge.width_over_length, 2),
            number(edge.critical_gamma),
            number(edge.law),
            format!("{:.0e}", edge.residual),
        ]
    };
    Table {
        title: "**Strips on edge**: the Γ at which they buckle to the side.".to_owned(),
        header: texts(&[
            "model",
            "edges",
            "rows",
            "turned over",
            "width over length",
            "critical Γ",
            "slender beam",
            "residual",
        ]),
        names: 1,
        rows: facts.edgewise.iter().map(line).collect(),
    }
}

/// Materials with the spread of their coefficients and the published bands.
fn cloths(facts: &Facts) -> Table {
    let centimetres = |value: f64| significant(100.0 * value, 3);
    let line = |cloth: &super::facts::Cloth| {
        let spread = facts.spread(&cloth.name);
        let end = |k: usize| spread.map_or_else(absent, |spread| percent(spread[k], 3));
        let band = facts.band(cloth).map_or_else(absent, |band| {
            format!("{}: {:.0}–{:.0} %", band.class, 100.0 * band.least, 100.0 * band.greatest)
        });
        vec![
            cloth.name.clone(),
            significant(cloth.areal_density_kg_m2, 3),
            centimetres(cloth.bending_length_m[0]),
            centimetres(cloth.bending_length_m[1]),
            end(0),
            end(1),
            band,
        ]
    };
    Table {
        title: "**Drape coefficients** over meshes and starts, beside the published bands."
            .to_owned(),
        header: texts(&[
            "material",
            "kg/m²",
            "bending length, warp (cm)",
            "weft (cm)",
            "least",
            "greatest",
            "published",
        ]),
        names: 1,
        rows: facts.cloths.iter().map(line).collect(),
    }
}

fn tests(facts: &Facts) -> Table {
    let line = |drape: &Drape| {
        vec![
            drape.cloth.clone(),
            drape.cells.to_string(),
            drape.waves.to_string(),
            drape.particles.to_string(),
            percent(drape.coefficient, 3),
            format!("{:.0e}", drape.residual),
            drape.iterations.to_string(),
            if drape.is_at_rest() { "yes" } else { "no" }.to_owned(),
        ]
    };
    Table {
        title: "**Drape tests**, one for each material, mesh and start.".to_owned(),
        header: texts(&[
            "material",
            "squares",
            "waves",
            "particles",
            "coefficient",
            "residual",
            "iterations",
            "at rest",
        ]),
        names: 1,
        rows: facts.drapes.iter().map(line).collect(),
    }
}
