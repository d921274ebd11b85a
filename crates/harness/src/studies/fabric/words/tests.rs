//! The words for made-up facts.

use super::super::facts::{Band, Bent, Drape, Width};
use super::*;

fn bent(model: Model, segments: u32, error: f64) -> Bent {
    Bent {
        model,
        gamma: 1.0,
        segments,
        particles: 9,
        drop_over_reach: Some(0.1246 * (1.0 + error)),
        exact: 0.1246,
        residual: 1e-8,
        iterations: 5,
        portable: true,
    }
}

fn drape(coefficient: f64, residual: f64) -> Drape {
    Drape {
        cloth: "denim".to_owned(),
        cells: 16,
        waves: 2,
        particles: 9,
        coefficient,
        residual,
        is_minimum: true,
        iterations: 5,
        portable: true,
    }
}

fn facts() -> Facts {
    let width = |rows: u32, rigidity_over_stiffness: f64| Width {
        model: Model::Triangles,
        gamma: 1.0,
        rows,
        width_over_length: 0.1,
        drop_over_reach: 0.1,
        rigidity_over_stiffness,
        narrow: 8.0 / 3.0,
        wide: 3.0,
        residual: 1e-8,
        iterations: 5,
        portable: true,
    };
    let mut lost = bent(Model::Springs, 20, 0.5);
    lost.residual = 1.0;
    Facts {
        bent: vec![
            bent(Model::Angles, 10, 0.04),
            bent(Model::Angles, 20, 0.01),
            bent(Model::Buckling, 10, 0.2),
            bent(Model::Buckling, 20, 0.4),
            lost,
        ],
        widths: vec![width(3, 2.68), width(25, 2.9)],
        edgewise: vec![Edgewise {
            model: Model::Triangles,
            rows: 3,
            segments: 20,
            turned: false,
            width_over_length: 0.1,
            critical_gamma: Some(22.0),
            law: Some(22.3),
            residual: 1e-9,
            portable: true,
        }],
        cloths: vec![Cloth {
            name: "denim".to_owned(),
            areal_density_kg_m2: 0.3,
            bending_n_m: [1e-5, 1e-5],
            bending_length_m: [0.02, 0.02],
            class: Some("denim".to_owned()),
        }],
        bands: vec![Band { class: "denim".to_owned(), least: 0.7, greatest: 0.9 }],
        drapes: vec![drape(0.8, 1e-5), drape(0.76, 1e-5), drape(0.3, 1.0)],
    }
}

#[test]
fn right_models_are_told_from_wrong_ones_and_cloths_inside_their_band_from_others() {
    let said = words(&facts());
    for part in [
        "angles along rows (+1.0 %).",
        "springs that buckle (+40 %); linear springs (not at rest).",
    ] {
        assert!(said.conclusion.contains(part), "{part}: {}", said.conclusion);
    }
    assert!(said.conclusion.contains("denim 76–80 %, inside 70–90 % of denim."), "{said:?}");
    let mut facts = facts();
    facts.bands[0].least = 0.78;
    let said = words(&facts);
    assert!(said.conclusion.contains("76–80 %, not inside 78–90 % of denim."), "{said:?}");
}

#[test]
fn orders_widths_limits_and_residuals_are_told() {
    let said = words(&facts());
    let all = said.observations.join(" ");
    let on_edge = format!("on edge ({}) buckles at Γ = 22.0;", Model::Triangles.name());
    for part in [
        "2.0 (angles along rows)",
        "3 to 25 rows give 2.68 to 2.90 on triangles (derived 2.67 to 3.00)",
        on_edge.as_str(),
        "the law of a slender beam gives 22.3.",
        "up to 4.0 points between meshes and starts (denim), and by up to 4.0 between starts",
        "Of 11 specimens, 9 are at rest, with a residual of at most 1.0e-5 ",
    ] {
        assert!(all.contains(part), "{part}: {all}");
    }
    assert!(said.caveats.contains(&"1 of the drape tests did not come to rest.".to_owned()));
}

#[test]
fn an_error_that_grows_has_no_order() {
    let facts = facts();
    assert!(facts.order(Model::Buckling, 1.0).is_none());
    assert!(facts.order(Model::Springs, 1.0).is_none());
}
