//! The drag of the air: its matrix, and when it takes or gives energy.

use drape_model::effects::{Air, DragLaw, Gust, Wind};
use drape_model::{Effect, Level, Vec3};
use drape_oracle::Random;
use drape_oracle::finite_difference::{Dense, check};

const LAWS: [DragLaw; 2] = [DragLaw::Linear(0.8), DragLaw::Quadratic(0.7)];
const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [2, 1, 3]];

fn vectors(random: &mut Random) -> [Vec3; 4] {
    [(); 4].map(|()| random.vector())
}

fn air(law: DragLaw, wind: Option<Wind>) -> Air {
    Air::new(law, wind, TRIANGLES.to_vec())
}

fn steady(velocity: Vec3) -> Option<Wind> {
    Some(Wind { velocity, gust: None })
}

fn force(air: &Air, at: Level<'_>) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); at.x.len()];
    air.add_damping_force(at, &mut out);
    out
}

#[test]
fn the_matrix_is_the_derivative_of_the_lagged_force_symmetric_and_positive_semidefinite() {
    let mut random = Random::new(1);
    for law in LAWS {
        for _ in 0..40 {
            let (x, v) = (vectors(&mut random), vectors(&mut random));
            let air = air(law, steady(random.vector()));
            let found = check(&air, &[1.0; 4], &x, &v);
            assert!(found.damping.best() < 1e-9, "{found:?}");
            let mut matrix = Dense::zeros(4);
            air.add_damping(Level { t: 0.0, x: &x, v: &v }, 1.0, &mut matrix);
            let values = matrix.0.symmetric_eigenvalues();
            assert!(values.min() > -1e-14 && values.max() > 0.0, "{values}");
            assert!((&matrix.0 - matrix.0.transpose()).norm() < 1e-14);
        }
    }
}

#[test]
fn still_air_takes_energy_and_a_wind_can_give_it() {
    let mut random = Random::new(2);
    for law in LAWS {
        let power = |air: &Air, x: &[Vec3], v: &[Vec3]| {
            let f = force(air, Level { t: 0.0, x, v });
            f.iter().zip(v).map(|(f, v)| f.dot(v)).sum::<f64>()
        };
        let mut gained = 0;
        for _ in 0..100 {
            let (x, v) = (vectors(&mut random), vectors(&mut random));
            assert!(power(&air(law, None), &x, &v) <= 0.0);
            gained += u32::from(power(&air(law, steady(random.vector() * 5.0)), &x, &v) > 0.0);
        }
        assert!((20..80).contains(&gained), "{gained}");
    }
}

#[test]
fn the_force_depends_on_the_relative_velocity_alone_and_vanishes_with_it() {
    let mut random = Random::new(3);
    for law in LAWS {
        let (x, v, w) = (vectors(&mut random), vectors(&mut random), random.vector());
        let moved = v.map(|v| v + w);
        let still = force(&air(law, None), Level { t: 0.0, x: &x, v: &v });
        let in_wind = force(&air(law, steady(w)), Level { t: 0.0, x: &x, v: &moved });
        for (a, b) in still.iter().zip(&in_wind) {
            assert!((a - b).norm() < 1e-14, "{a:?} {b:?}");
        }
        let along = force(&air(law, steady(w)), Level { t: 0.0, x: &x, v: &[w; 4] });
        assert!(along.iter().all(|f| f.norm() < 1e-15));
    }
}

#[test]
fn a_flat_sheet_meets_the_drag_of_its_area_and_none_edge_on() {
    let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(1.0, 1.0, 0.0)];
    let total = |law, v: Vec3| {
        force(&air(law, None), Level { t: 0.0, x: &x, v: &[v; 4] }).iter().sum::<Vec3>()
    };
    assert!((total(LAWS[0], Vec3::z() * 3.0) + Vec3::z() * (0.8 * 3.0)).norm() < 1e-14);
    assert!((total(LAWS[1], Vec3::z() * 3.0) + Vec3::z() * (0.7 * 9.0)).norm() < 1e-14);
    assert_eq!(total(LAWS[1], Vec3::new(3.0, -2.0, 0.0)), Vec3::zeros());
}

#[test]
fn a_triangle_without_area_meets_no_air() {
    let x = [Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0, Vec3::x()];
    for law in LAWS {
        let (v, air) = ([Vec3::z(); 4], air(law, None));
        let at = Level { t: 0.0, x: &x, v: &v };
        assert_eq!(force(&air, at), [Vec3::zeros(); 4]);
        let mut matrix = Dense::zeros(4);
        air.add_damping(at, 1.0, &mut matrix);
        assert_eq!(matrix, Dense::zeros(4));
    }
}

#[test]
fn gusts_follow_the_time_of_the_level() {
    let wind = Wind { velocity: Vec3::zeros(), gust: Some(Gust::new(Vec3::z() * 2.0, 1.0, 11)) };
    let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(1.0, 1.0, 0.0)];
    let air = air(LAWS[0], Some(wind));
    for t in [0.0, 0.1, 7.3] {
        let f = force(&air, Level { t, x: &x, v: &[Vec3::zeros(); 4] });
        let sum: Vec3 = f.iter().sum();
        assert!((sum - wind.at(t) * 0.8).norm() < 1e-14, "{t}");
    }
    assert_ne!(wind.at(0.0), wind.at(0.1));
}
