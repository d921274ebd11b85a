//! Tests of a few specimens.

use super::*;

#[test]
fn angles_and_triangles_follow_the_exact_strip_and_a_sheets_stiffness_does_not()
-> Result<(), HarnessError> {
    let error = |model, segments| -> Result<f64, HarnessError> {
        let bent = strip::cantilevered(model, 1.0, segments, ROWS)?;
        Ok(bent.error().unwrap_or(f64::NAN))
    };
    let [coarse, fine] = [error(Model::Angles, 10)?, error(Model::Angles, 20)?];
    let order = (coarse / fine).log2();
    assert!(fine.abs() < 2e-3 && (order - 2.0).abs() < 0.2, "{coarse} {fine}");
    assert!(error(Model::Triangles, 20)?.abs() < 0.02);
    assert!(error(Model::SquaresAsSheet, 20)? > 0.15);
    Ok(())
}

#[test]
fn the_inverse_of_the_master_curve_is_its_inverse() {
    for gamma in [0.5, 8.0, 64.0] {
        let ratio = drape_oracle::elastica::cantilever(gamma).drop_over_reach();
        let found = strip::gamma_of(ratio, 1.2 * gamma);
        assert!((found / gamma - 1.0).abs() < 1e-9, "{gamma}: {found}");
    }
}

#[test]
fn a_slender_strip_of_triangles_on_edge_buckles_near_the_law_and_angles_resist_no_twist()
-> Result<(), HarnessError> {
    let triangles = strip::edgewise(Model::Triangles, 20, 3, false)?;
    let law = triangles.law.unwrap_or(f64::NAN);
    let found = triangles.critical_gamma.unwrap_or(f64::NAN);
    assert!((found / law - 1.0).abs() < 0.02, "{found} against {law}");
    let angles = strip::edgewise(Model::Angles, 20, 3, false)?;
    assert!(angles.critical_gamma.unwrap_or(f64::NAN) < 0.2 * found, "{angles:?}");
    // Diagonals along one direction make a strip chiral.
    let turned = [false, true].map(|turned| strip::edgewise(Model::Squares, 20, 3, turned));
    let [left, right] = turned.map(|edge| edge.map(|edge| edge.critical_gamma.unwrap_or(f64::NAN)));
    assert!(left? > 1.5 * right?);
    Ok(())
}

#[test]
fn the_quick_subset_is_part_of_the_whole() {
    let (quick, all) = (Plan::new(true), Plan::new(false));
    assert!(quick.bent.iter().all(|cell| all.bent.contains(cell)));
    assert!(quick.wide.iter().all(|cell| all.wide.contains(cell)));
    assert!(quick.edgewise.iter().all(|cell| all.edgewise.contains(cell)));
    assert!(quick.drapes.iter().all(|cell| all.drapes.contains(cell)));
}
