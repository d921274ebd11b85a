//! Contacts of one particle.

use super::basis::Basis;
use super::*;
use drape_model::{State, parse};

fn contact(normal: Vec3, target: f64) -> Contact {
    let (normal, shift, keep) = (normal.normalize(), 0.0, 0.0);
    let (recovery, least) = (target, f64::NEG_INFINITY);
    let (slack, friction, surface) = (0.0, 0.0, None);
    let (goes_on, gap, is_held, lent) = (false, 0.0, false, 0.0);
    Contact {
        particle: 0,
        obstacle: 0,
        normal,
        shift,
        recovery,
        target,
        keep,
        least,
        slack,
        friction,
        surface,
        goes_on,
        gap,
        is_held,
        lent,
    }
}

fn spread(count: usize) -> Vec<Contact> {
    let normals = [Vec3::new(0.1, 0.2, 1.0), Vec3::new(1.0, -0.1, 0.3), Vec3::new(0.2, 1.0, 0.1)];
    let contacts = normals.iter().zip([0.7, 0.4, 0.2]);
    contacts.take(count).map(|(&normal, target)| contact(normal, target)).collect()
}

#[test]
fn the_combined_velocity_has_the_target_along_every_normal() {
    for count in 1..=3 {
        let group = spread(count);
        let basis = Basis::of(&group);
        let z = basis.combine(|contact| contact.target);
        for contact in &group {
            assert!((contact.normal.dot(&z) - contact.target).abs() < 1e-12, "{count}: {z:?}");
        }
        assert!(basis.filter().apply(z).norm() < 1e-12, "z has a free part");
    }
}

#[test]
fn the_contact_with_the_most_negative_multiplier_pulls() {
    for count in 1..=3 {
        let group = spread(count);
        let basis = Basis::of(&group);
        for worst in 0..count {
            let impulse = |factor: f64| {
                group.iter().enumerate().fold(Vec3::zeros(), |p, (k, contact)| {
                    p + contact.normal * if k == worst { factor } else { 0.5 - 0.1 * k as f64 }
                })
            };
            assert_eq!(basis.pulling(&impulse(-0.9), |_| true), Some(group[worst].normal));
            assert_eq!(basis.pulling(&impulse(1e-3), |_| true), None);
        }
    }
}

#[test]
fn dependent_normals_are_left_out_and_flat_angles_do_not_shoot() {
    let twice = [contact(Vec3::z(), 1.0), contact(Vec3::z(), 0.5)];
    assert_eq!(Basis::of(&twice).combine(|c| c.target), Vec3::z());
    let opposite = [contact(Vec3::z(), 1.0), contact(-Vec3::z(), 0.5)];
    assert_eq!(Basis::of(&opposite).len, 1);
    let fan =
        [contact(Vec3::x(), 1.0), contact(Vec3::y(), 1.0), contact(Vec3::new(1.0, 1.0, 0.0), 1.0)];
    assert_eq!(Basis::of(&fan).len, 2);
    let groove =
        [contact(Vec3::new(1.0, 0.0, 0.01), 1.0), contact(Vec3::new(-1.0, 0.0, 0.01), 1.0)];
    let z = Basis::of(&groove).combine(|c| c.target);
    assert!(z.norm() <= 2.0_f64.sqrt() + 1e-12 && z.z > 1.0, "{z:?}");
}

fn ball_on_plane(e: f64, z: f64, v: f64) -> (System, State) {
    let text = format!(
        r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": [1],
        "position_m": [[0, 0, {z}]], "velocity_m_s": [[0, 0, {v}]] }},
        "obstacles": [{{ "plane": {{ "point_m": [0, 0, 0], "normal": [0, 0, 1],
            "restitution": {e} }} }}] }}"#
    );
    parse("test", &text).expect("valid").spec().build().expect("valid")
}

/// One step of symplectic Euler under gravity; returns whether the contact ended up active.
fn step(set: &mut ContactSet, system: &System, state: &mut State, h: f64, g: f64) -> bool {
    let mut constraints = Constraints::free(1);
    set.detect(system, &state.x, &state.v, (h, h), &mut constraints);
    let free = state.v[0] + Vec3::z() * (h * g);
    let mut impulse = [Vec3::zeros()];
    let v = &mut state.v;
    set.solve(system, &mut constraints, &mut impulse, |constraints, wanted| {
        v[0] = free;
        constraints.impose(v);
        wanted.fill(v, |impulse| impulse[0] = v[0] - free);
        Ok::<(), ()>(())
    })
    .expect("never fails");
    state.x[0] += state.v[0] * h;
    set.settle(&mut state.v, |_| ());
    !set.is_empty()
}

#[test]
fn a_resting_contact_is_active_in_every_step() {
    let (system, mut state) = ball_on_plane(0.6, 0.3, 0.0);
    let mut set = ContactSet::new(&system);
    for k in 0..2000 {
        let active = step(&mut set, &system, &mut state, 0.01, -9.81);
        assert!(k < 500 || (active && state.v[0].norm() == 0.0), "step {k}: {:?}", state.v[0]);
        if k % 100 == 99 {
            set.restart();
        }
    }
}

#[test]
fn recovery_over_many_steps_keeps_what_the_impact_left_and_no_more() {
    for (e, left) in [(0.0, 0.0), (0.05, 0.5), (0.5, 5.0)] {
        let (system, mut state) = ball_on_plane(e, -0.09, -10.0);
        let mut set = ContactSet::new(&system);
        while state.x[0].z < 0.0 {
            let before = state.x[0].z;
            step(&mut set, &system, &mut state, 0.01, 0.0);
            let speed = (state.x[0].z - before) / 0.01;
            assert!(speed <= f64::max(1.0, left) + 1e-9, "e = {e}: led out at {speed}");
            assert!((state.v[0].z - left).abs() < 1e-12, "e = {e}: {:?}", state.v[0]);
        }
    }
}

#[test]
fn an_obstacle_bears_what_rests_on_it_and_not_what_leaves_it() {
    for (e, speed, rests) in [(0.0, -1.0, true), (0.5, -1.0, false), (0.0, 1.0, false)] {
        let (system, state) = ball_on_plane(e, 0.0, speed);
        let mut set = ContactSet::new(&system);
        set.detect(&system, &state.x, &state.v, (0.01, 0.01), &mut Constraints::free(1));
        for a in [Vec3::new(1.0, 2.0, -9.81), Vec3::new(1.0, 2.0, 0.5)] {
            let mut left = [a];
            set.support(0.01, &mut left);
            let expected = if rests { Vec3::new(1.0, 2.0, 0.0) } else { a };
            assert_eq!(left[0], expected, "e = {e}, at {speed} m/s");
        }
    }
}

/// Final height and velocity of one step of a multistep method from `(x, v)` to `x* + τ v_+`, if
/// there is a contact.
fn multistep(e: f64, (x, v): (f64, f64), ahead: f64, tau: f64) -> Option<(f64, f64)> {
    let (system, state) = ball_on_plane(e, x, v);
    let (mut set, mut constraints) = (ContactSet::new(&system), Constraints::free(1));
    let x_star = [Vec3::new(3.0, -2.0, x + ahead)];
    let from = (&state.x[..], &state.v[..]);
    set.detect_multistep(
        &system,
        MultistepMotion { from, h: 0.01, end: 0.01, x_star: &x_star, tau },
        &mut constraints,
    );
    let mut v = [Vec3::new(1.0, 2.0, -9.0)];
    constraints.impose(&mut v);
    let z = x_star[0].z + tau * v[0].z;
    set.settle(&mut v, |_| ());
    assert_eq!(v[0].xy(), Vec3::new(1.0, 2.0, 0.0).xy(), "the plane is smooth");
    (!set.is_empty()).then_some((z, v[0].z))
}

#[test]
fn a_multistep_contact_ends_the_step_where_a_one_step_contact_would() {
    for (ahead, tau) in [(0.0, 0.01), (-0.01, 0.005), (-0.003, 0.02 / 3.0)] {
        let close = |found: Option<(f64, f64)>, (z, v): (f64, f64)| {
            let (found_z, found_v) = found.expect("a contact");
            let off = (found_z - z).abs().max((found_v - v).abs());
            assert!(off < 1e-15, "x* = x + {ahead}, τ = {tau}: {found_z}, {found_v}");
        };
        let step = |e, from| multistep(e, from, ahead, tau);
        close(step(0.0, (-0.004, -1.0)), (0.0, 0.0)); // on the surface, at rest
        close(step(0.0, (-0.3, 0.0)), (-0.29, 0.0)); // not faster than the limit of 1 m/s
        close(step(1.0, (-0.004, -2.0)), (-0.004, 2.0)); // reflected where it is
        assert_eq!(step(1.0, (-0.004, 2.0)), None, "it leaves by itself");
        assert_eq!(step(0.0, (0.004, -2.0)), None, "it is outside");
    }
}

#[test]
fn settling_reports_contacts_that_begin_and_end() {
    let (system, mut state) = ball_on_plane(0.0, -1e-3, -1.0);
    let mut set = ContactSet::new(&system);
    let mut constraints = Constraints::free(1);
    for (x, expected) in [(-1e-3, true), (0.0, false), (0.5, true), (0.6, false)] {
        state.x[0].z = x;
        set.detect(&system, &state.x, &state.v, (0.01, 0.01), &mut constraints);
        let mut calls = 0;
        state.v[0] = Vec3::zeros();
        set.settle(&mut state.v, |_| calls += 1);
        assert_eq!(calls > 0, expected, "at {x}");
    }
}

/// The old velocity does not lead a resting particle inside, but the velocity that a step has found
/// does: it may come as far as the surface.
#[test]
fn a_contact_begins_where_the_predicted_position_lies_inside() {
    let (system, state) = ball_on_plane(0.0, 0.001, 0.0);
    let (h, mut contacts) = (0.01, ContactSet::new(&system));
    let mut constraints = ContactSet::constraints(&system);
    let motion =
        MultistepMotion { from: (&state.x, &state.v), h, end: h, x_star: &state.x, tau: h };
    for (speed, is_met) in [(-1.0, true), (-0.05, false), (1.0, false)] {
        let free = [Vec3::new(3.0, 0.0, speed)];
        contacts.detect_predicted(&system, motion, &free, &mut constraints);
        assert_eq!(contacts.is_empty(), !is_met, "{speed}");
        if is_met {
            assert!((constraints.prescribed(0).z + 0.1).abs() < 1e-15);
        }
        contacts.detect_multistep(&system, motion, &mut constraints);
        assert!(contacts.is_empty(), "{speed}");
    }
}

/// Particles on a rough surface, all across a gap.
fn across_gaps(count: u32) -> (System, ContactSet, Constraints) {
    let places: Vec<[f64; 3]> = (0..count).map(|i| [i.into(), 0.0, 1e-3]).collect();
    let masses = vec![1.0; count as usize];
    let text = format!(
        r#"{{ "format": "drape-system/1", "particles": {{ "mass_kg": {masses:?},
        "position_m": {places:?} }}, "obstacles": [{{ "plane": {{ "point_m": [0, 0, 0],
            "normal": [0, 0, 1], "friction": 0.3 }} }}] }}"#
    );
    let (system, _) = parse("test", &text).expect("valid").spec().build().expect("valid");
    let mut set = ContactSet::new(&system);
    set.candidates = (0..count)
        .map(|particle| {
            let target = -0.1 - 1e-3 * f64::from(particle);
            Contact {
                particle,
                friction: 0.3,
                goes_on: true,
                gap: 1e-3,
                ..contact(Vec3::z(), target)
            }
        })
        .collect();
    let mut constraints = ContactSet::constraints(&system);
    set.write(&system, &mut constraints);
    (system, set, constraints)
}

fn is_held(constraints: &Constraints, particle: u32) -> bool {
    constraints.filter(particle as usize) != Filter::Free
}

/// Each release lets the next neighbour pull, as in a sheet that is lifted at its edge.
#[test]
fn contacts_across_a_gap_are_released_as_long_as_one_pulls() {
    for count in [2, 6, 20] {
        let (system, mut set, mut constraints) = across_gaps(count);
        let (mut impulse, mut passes) = (vec![Vec3::zeros(); count as usize], 0);
        let mut held = count;
        set.solve(&system, &mut constraints, &mut impulse, |constraints, wanted| {
            passes += 1;
            held = (0..count).filter(|&i| is_held(constraints, i)).count() as u32;
            let first = count - held;
            wanted.fill(&[], |impulse| {
                for i in 0..count {
                    let along = if i == first { -1.0 } else { 1.0 };
                    impulse[i as usize] = Vec3::z() * if i < first { 0.0 } else { along };
                }
            });
            Ok::<(), ()>(())
        })
        .expect("never fails");
        assert_eq!((held, set.candidates.len()), (0, 0), "{count}: a contact pulls");
        assert!(passes <= 9, "{count}: {passes} passes");
    }
}

/// It sticks too much along the surface to pull; once it slides, it pulls.
#[test]
fn a_contact_across_a_gap_that_pulls_after_it_has_slid_is_released() {
    let (system, mut set, mut constraints) = across_gaps(1);
    let mut impulse = vec![Vec3::zeros()];
    let mut last = Filter::Fixed;
    let mut solves = 0;
    set.solve(&system, &mut constraints, &mut impulse, |constraints, wanted| {
        solves += 1;
        last = constraints.filter(0);
        let impulse = if solves == 1 { Vec3::new(1.0, 0.0, 1.0) } else { -Vec3::z() };
        wanted.fill(&[Vec3::x()], |out| out[0] = impulse);
        Ok::<(), ()>(())
    })
    .expect("never fails");
    assert_eq!(last, Filter::Free);
    assert_eq!(solves, 4, "it sticks, is free to slide, slides, flies");
}

/// Friction takes the impulse that stops the particle, `m (a + w)`, whichever part of it the
/// constraint takes before the forces act.
#[test]
fn a_held_contact_is_charged_once() {
    for (approach, gained) in [(-0.3, -0.2), (-0.05, -0.2), (0.1, -0.4)] {
        let (system, mut set, mut constraints) = across_gaps(1);
        let v = [Vec3::new(5.0, 0.0, approach)];
        let end = Vec3::new(5.0, 0.0, approach + gained);
        set.hold_gaps(&system, &v, |_| end, &mut constraints);
        assert_eq!(set.candidates.len(), 1);
        let mut velocity = [Vec3::zeros()];
        set.strike(&system, &mut constraints, &v, &mut velocity);
        assert!((velocity[0].z + 0.1).abs() < 1e-15, "it moves as far as the surface");
        velocity[0].z += gained;
        set.stop(&mut velocity);
        let expected = 5.0 + 0.3 * (approach + gained);
        assert!((velocity[0].x - expected).abs() < 1e-14, "{approach}: {}", velocity[0].x);
        assert_eq!(velocity[0].z, 0.0);
        // It would leave by itself.
        let (system, mut set, mut constraints) = across_gaps(1);
        set.hold_gaps(&system, &v, |_| Vec3::new(5.0, 0.0, -0.05), &mut constraints);
        assert!(set.is_empty() && !is_held(&constraints, 0));
    }
}

/// A touch, as many steps above the plane, and a fall onto it at 2 m/s.
#[test]
fn a_particle_bounces_after_four_steps_of_flight_and_not_earlier() {
    for (flight, left) in [(0, 0.0), (3, 0.0), (4, 2.0), (9, 2.0)] {
        let (system, _) = ball_on_plane(1.0, 0.0, 0.0);
        let (mut set, mut constraints) = (ContactSet::new(&system), Constraints::free(1));
        let mut meet = |z: f64, speed: f64| {
            let mut v = [Vec3::z() * speed];
            set.detect(&system, &[Vec3::z() * z], &v, (0.01, 0.01), &mut constraints);
            constraints.impose(&mut v);
            set.settle(&mut v, |_| ());
            v[0].z
        };
        meet(0.0, 0.0);
        (0..flight).for_each(|_| assert_eq!(meet(0.5, -2.0), -2.0));
        assert_eq!(meet(0.0, -2.0), left, "{flight}");
    }
}

/// A rough plane with one particle in a contact with a surface that moves.
fn on_a_moving_surface(surface: Vec3) -> (System, ContactSet, Constraints) {
    let (system, mut set, mut constraints) = across_gaps(1);
    let surface = Some(surface);
    set.candidates = vec![Contact { friction: 0.3, surface, ..contact(Vec3::z(), 0.0) }];
    set.write(&system, &mut constraints);
    (system, set, constraints)
}

#[test]
fn what_rubs_is_carried_along_by_the_surface() {
    let (_, set, _) = on_a_moving_surface(Vec3::x());
    let mut v = [Vec3::new(5.0, 0.0, -0.2)];
    set.stop(&mut v);
    assert!((v[0] - Vec3::x() * (5.0 - 0.3 * 0.2)).norm() < 1e-15, "{:?}", v[0]);
    v[0] = Vec3::new(1.05, 0.0, -0.2);
    set.stop(&mut v);
    assert!((v[0] - Vec3::x()).norm() < 1e-15, "it sticks: {:?}", v[0]);
}

/// Friction of 0.3 takes 0.3 of the impulse that would stop it, and of the slip beside the surface.
#[test]
fn what_slides_slips_beside_the_surface() {
    let (system, mut set, mut constraints) = on_a_moving_surface(Vec3::x());
    let (mut impulse, mut last) = ([Vec3::zeros()], Vec3::zeros());
    set.solve(&system, &mut constraints, &mut impulse, |constraints, wanted| {
        last = constraints.prescribed(0);
        wanted.fill(&[Vec3::x() * 3.0], |out| out[0] = Vec3::new(1.0, 0.0, 1.0));
        Ok::<(), ()>(())
    })
    .expect("never fails");
    assert!((last - Vec3::x() * (1.0 + 0.7 * 2.0)).norm() < 1e-15, "{last:?}");
}

#[test]
fn a_surface_that_rises_bears_what_rises_with_it() {
    let (_, mut set, _) = on_a_moving_surface(Vec3::z());
    for (keep, left) in [(1.0, 0.0), (1.5, -9.81)] {
        set.candidates[0].friction = 0.0;
        set.candidates[0].keep = keep;
        let mut a = [Vec3::new(1.0, 2.0, -9.81)];
        set.support(0.01, &mut a);
        assert_eq!(a[0], Vec3::new(1.0, 2.0, left), "{keep}");
    }
}

/// A particle that moves with an obstacle needs a multiplier of zero, but for round-off.
#[test]
fn a_gap_is_held_although_round_off_pulls() {
    for (off, is_held) in [(5e-10, true), (2e-9, false)] {
        let (system, mut set, mut constraints) = across_gaps(1);
        set.candidates[0].slack = 1e-9;
        let v = [-Vec3::z() * 0.1];
        set.hold_gaps(&system, &v, |_| Vec3::z() * (off - 0.1), &mut constraints);
        assert_eq!(!set.is_empty(), is_held, "{off}");
    }
}
