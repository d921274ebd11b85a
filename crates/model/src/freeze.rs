//! Freezes a running system into data, so that another program can move the same cloth.

use crate::path::KeyframeSpec;
use crate::{
    Obstacle, ObstacleSpec, ParticlesSpec, Path, PinSpec, Shape, State, System, SystemSpec,
};

impl Path {
    fn frames(&self) -> Vec<KeyframeSpec> {
        let frame = |&(time_s, offset): &(f64, crate::Vec3)| KeyframeSpec {
            time_s,
            offset_m: offset.into(),
        };
        self.keyframes().iter().map(frame).collect()
    }
}

impl Obstacle {
    fn spec(&self) -> ObstacleSpec {
        let (restitution, friction) = (self.restitution, self.friction);
        let path = self.path.as_ref().map_or_else(Vec::new, Path::frames);
        match &self.shape {
            Shape::Plane { point, normal } => {
                let (point_m, normal) = ((*point).into(), (*normal).into());
                ObstacleSpec::Plane { point_m, normal, restitution, friction, path }
            }
            Shape::Box { center, half_extents } => {
                let (center_m, size_m) = ((*center).into(), (half_extents * 2.0).into());
                ObstacleSpec::Box { center_m, size_m, restitution, friction, path }
            }
            Shape::Sphere { center, radius } => {
                let (center_m, radius_m) = ((*center).into(), *radius);
                ObstacleSpec::Sphere { center_m, radius_m, restitution, friction, path }
            }
            Shape::Mesh(mesh) => {
                let vertices_m = mesh.vertices().iter().map(|&x| x.into()).collect();
                let triangles = mesh.triangles().to_vec();
                ObstacleSpec::Mesh { vertices_m, triangles, restitution, friction, path }
            }
        }
    }
}

impl System {
    /// Freezes the running system with its present masses, stiffnesses and pins, at `state`. Times
    /// of paths and gusts count from `state.t`. Particles keep the order of the system; springs are
    /// listed effect by effect. Triangles are listed only if the air needs them.
    ///
    /// # Errors
    /// The name of the first effect that a frozen system cannot hold. Such an effect is one that a
    /// user of this library wrote, or one with springs that have pieces or buckle.
    pub fn freeze(&self, state: &State) -> Result<SystemSpec, &'static str> {
        let mut spec = SystemSpec {
            name: self.name().to_owned(),
            particles: ParticlesSpec { mass_kg: self.mass().to_vec(), ..ParticlesSpec::default() },
            pins: self.pins().iter().map(|&pin| PinSpec::still(pin)).collect(),
            obstacles: self.obstacles().iter().map(Obstacle::spec).collect(),
            ..SystemSpec::default()
        };
        for moving in self.moving_pins() {
            let is_it = |pin: &&mut PinSpec| pin.particle as usize == moving.particle;
            if let Some(pin) = spec.pins.iter_mut().find(is_it) {
                pin.path = moving.path.frames();
            }
        }
        if !self.obstacles().is_empty() {
            spec.effects.contact = Some(*self.contact());
        }
        for effect in self.effects() {
            if !effect.describe(&mut spec) {
                return Err(effect.name());
            }
        }
        Ok(spec.with_state(state))
    }
}
