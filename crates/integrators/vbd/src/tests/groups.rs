//! The fast form of the sweeps beside the readable one.

use super::support::settings;
use crate::step::Workspace;
use drape_integrator::{PhaseClock, Scheme};
use drape_model::{DampingLaw, State, System};
use drape_oracle::bits;
use drape_oracle::scenes::{Sheet, build, floor, stir, uneven};

/// The state after some steps, in groups or one by one, and whether there were groups.
fn stepped(text: &str, (system, start): &(System, State), in_groups: bool) -> (Vec<u64>, bool) {
    let (settings, h) = (settings(text), 0.01);
    let mut work = Workspace::new(system, &settings, h).unwrap_or_else(|error| panic!("{error}"));
    let found = work.groups.is_some();
    if !in_groups {
        work.groups = None;
    }
    let mut state = start.clone();
    for _ in 0..3 {
        work.step(&settings, system, &mut state, h, &mut PhaseClock::off())
            .unwrap_or_else(|error| panic!("{error}"));
    }
    (bits(&state), found)
}

/// Full and projected damping, none, drag, a floor, pins, masses that differ.
fn scenes() -> Vec<(System, State)> {
    let sheet = Sheet { side: 7, tension: 2e3, shear: 2e2, damping: 8.0, ..Sheet::default() };
    let mut scenes = Vec::new();
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        scenes.push(Sheet { law, ..sheet }.build());
        let mut spec = Sheet { law, ..sheet }.spec();
        spec.obstacles = vec![floor(0.3)];
        spec.pins.truncate(1);
        scenes.push(build(&spec));
    }
    scenes.push(Sheet { damping: 0.0, ..sheet }.build());
    scenes.push(Sheet { side: 2, ..sheet }.build());
    scenes.into_iter().map(|scene| uneven(stir(scene, 0.03, 1.0))).collect()
}

#[test]
fn groups_give_the_bits_of_particles_one_by_one() {
    for (place, scene) in scenes().iter().enumerate() {
        for text in ["sweeps=3", "sweeps=5,chebyshev=0.9", "sweeps=2,start=inertial"] {
            let (expected, _) = stepped(text, scene, false);
            let (found, has_groups) = stepped(text, scene, true);
            assert!(has_groups, "scene {place} is swept in groups");
            assert!(found == expected, "scene {place}, {text}");
        }
    }
}
