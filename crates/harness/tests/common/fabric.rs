//! A synthetic record of the study of fabrics.

use super::record;
use drape_harness::studies::fabric::facts::{
    Band, Bent, Cloth, Drape, Edgewise, Facts, Model, Width,
};
use drape_report::Record;

/// Strips whose errors fall, one that is not at rest; two cloths, one with a band.
pub(crate) fn fabric() -> Record<Facts> {
    let mut bent = Vec::new();
    for (n, model) in Model::ALL.into_iter().enumerate() {
        for gamma in [1.0, 8.0, 16.0] {
            for segments in [10, 20, 40] {
                let exact = gamma / 8.0;
                let error = (n + 1) as f64 / f64::from(segments);
                bent.push(Bent {
                    model,
                    gamma,
                    segments,
                    particles: 33,
                    drop_over_reach: Some(exact * (1.0 + error)),
                    exact,
                    residual: if n == 5 && segments == 40 { 0.5 } else { 1e-9 },
                    iterations: 7,
                    portable: true,
                });
            }
        }
    }
    let width = |(model, rows): (Model, u32)| Width {
        model,
        gamma: 8.0,
        rows,
        width_over_length: 0.03 * f64::from(rows),
        drop_over_reach: 0.9,
        rigidity_over_stiffness: 2.5 + 0.01 * f64::from(rows),
        narrow: 2.4,
        wide: 3.0,
        residual: 1e-9,
        iterations: 7,
        portable: true,
    };
    let widths = [
        (Model::Angles, 3),
        (Model::Triangles, 3),
        (Model::Triangles, 25),
        (Model::SquaresAsSheet, 3),
    ];
    let edgewise = [Some(21.5), None].map(|critical_gamma| Edgewise {
        model: Model::Triangles,
        rows: 3,
        segments: 20,
        turned: critical_gamma.is_none(),
        width_over_length: 0.09,
        critical_gamma,
        law: critical_gamma.map(|_| 22.3),
        residual: 1e-9,
        portable: true,
    });
    let cloth = |name: &str, class: Option<&str>| Cloth {
        name: name.to_owned(),
        areal_density_kg_m2: 0.3,
        bending_n_m: [6e-5, 1e-4],
        bending_length_m: [0.027, 0.032],
        class: class.map(str::to_owned),
    };
    let drape = |cloth: &str, cells: u32, residual: f64| Drape {
        cloth: cloth.to_owned(),
        cells,
        waves: 4,
        particles: 200,
        coefficient: 0.7 + 0.004 * f64::from(cells),
        residual,
        is_minimum: true,
        iterations: 100,
        portable: true,
    };
    let facts = Facts {
        bent,
        widths: widths.map(width).into(),
        edgewise: edgewise.into(),
        cloths: vec![cloth("denim", Some("denim")), cloth("fleece", None)],
        bands: vec![
            Band { class: "silk".to_owned(), least: 0.2, greatest: 0.4 },
            Band { class: "denim".to_owned(), least: 0.7, greatest: 0.9 },
        ],
        drapes: vec![
            drape("denim", 16, 1e-6),
            drape("fleece", 24, 1e-6),
            drape("fleece", 32, 1e-6),
            drape("denim", 40, 1e-6),
            drape("denim", 24, 1.0),
        ],
    };
    record("fabric", false, facts)
}
