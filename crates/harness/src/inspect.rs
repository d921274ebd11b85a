//! Describes a scene, and predicts what each method would do with it, without a run.

use crate::methods::{self, Choice};
use crate::motion::{LOCKED, Lever, Unforeseen, implicit_springs, size};
use crate::run::Simulation;
use crate::stability::gershgorin;
use crate::theory::form_of;
use drape_integrator::{ExplicitNumbers, Implicit, LargestEigenvalue, Settings, Supports};
use drape_model::{Effect, System, SystemSpec, Vec3, Violation};
use serde::Serialize;
use std::collections::BTreeMap;

/// The value of `format`.
pub const INSPECTION_FORMAT: &str = "drape-inspection/1";
/// Steps for which verdicts are predicted, s: one frame of a film at 60 Hz, and the paper's step.
pub const STEPS_S: [f64; 2] = [1.0 / 60.0, 0.01];
/// Time span of the motion that is predicted, s.
const SPAN: f64 = 1.0;
/// Products of the power iteration for the stiffest mode.
const PRODUCTS: usize = 100;
/// A spectral radius above 1 by no more than this is round-off.
const ROUND_OFF: f64 = 1e-9;

/// A scene, measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// Always [`INSPECTION_FORMAT`].
    pub format: &'static str,
    /// Name of the scene.
    pub name: String,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs by effect.
    pub springs: BTreeMap<String, usize>,
    /// Number of angles that resist shear or bending.
    pub angles: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of pinned particles.
    pub pins: usize,
    /// Number of obstacles.
    pub obstacles: usize,
    /// Closed lines of edges that belong to one triangle only.
    pub boundaries: usize,
    /// Groups of particles that springs, angles or triangles connect.
    pub groups: usize,
    /// Number of these groups that have no pin.
    pub free_groups: usize,
    /// Extent along x, y and z, m.
    pub size_m: [f64; 3],
    /// Sum of all masses, kg.
    pub mass_kg: f64,
    /// Area of all triangles, m².
    pub area_m2: f64,
    /// Mass over area, kg/m²; `null` without triangles.
    pub areal_density_kg_m2: Option<f64>,
    /// Least and greatest length of a spring at rest, m; `null` without springs.
    pub rest_length_m: Option<[f64; 2]>,
    /// Least and greatest stiffness of a spring over the mass of its lighter end, 1/s².
    pub stiffness_over_mass_per_s2: Option<[f64; 2]>,
    /// Largest eigenvalue of the stiffness over the mass at the start, 1/s², approached from below.
    pub largest_eigenvalue_per_s2: f64,
    /// Damping ratio ζ of the mode of this eigenvalue, by the damping of the springs.
    pub damping_ratio: f64,
    /// Longest stable step by method id, s, of the methods that take their springs at the old level.
    /// It is on the safe side: the stiffest mode has the largest damping of all modes.
    pub explicit_limits_s: BTreeMap<String, f64>,
    /// Why theory predicts nothing about locking; `null` where it does.
    pub motion_unforeseen: Option<String>,
    /// Numbers that look like a mistake of units.
    pub doubts: Vec<String>,
    /// Each method of the registry at its default settings.
    pub methods: Vec<MethodForecast>,
}

/// What a method would do with a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodForecast {
    /// Its id.
    pub id: &'static str,
    /// Why it refuses the scene; `null` where it supports it.
    pub refusal: Option<String>,
    /// The predictions at each of [`STEPS_S`]; empty where the method refuses the scene.
    pub steps: Vec<Forecast>,
}

/// What theory says about a method at a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// The step, s.
    pub step_s: f64,
    /// The greatest `h²k/m` of a spring.
    pub theta: f64,
    /// The verdict.
    pub verdict: Foreseen,
    /// Share of the motion that it keeps; `null` where theory predicts nothing.
    pub share: Option<f64>,
    /// Why, in a sentence.
    pub reason: String,
}

/// A verdict by theory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Foreseen {
    /// No mode grows, and theory has no sign that the cloth stands still.
    Stable,
    /// It keeps less than half of the motion.
    Locked,
    /// A mode grows.
    Unstable,
    /// The bounds of theory decide neither for stable nor for unstable.
    Unclear,
}

impl Foreseen {
    /// The word in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Locked => "locked",
            Self::Unstable => "unstable",
            Self::Unclear => "unclear",
        }
    }
}

/// Describes a system and predicts what each method would do with it.
///
/// # Errors
/// [`Violation`] for the first value of the system that is refused.
pub fn inspect(spec: &SystemSpec) -> Result<Inspection, Violation> {
    let (system, state) = spec.build()?;
    let simulation = Simulation { system, state };
    let stage = Stage::of(&simulation);
    let x = &simulation.state.x;
    let (low, high) = x.iter().fold((x[0], x[0]), |(low, high), x| (low.inf(x), high.sup(x)));
    let mut springs = BTreeMap::new();
    for spring in &spec.springs {
        *springs.entry(format!("{:?}", spring.effect).to_lowercase()).or_insert(0) += 1;
    }
    let area_m2: f64 = spec.triangles.iter().map(|t| area(x, t)).sum();
    let mass_kg: f64 = spec.particles.mass_kg.iter().sum();
    let (groups, free_groups) = count_groups(spec);
    let mass = simulation.system.mass();
    let quotient = |i: u32, j: u32, k: f64| k / mass[i as usize].min(mass[j as usize]);
    let quotients = spec.springs.iter().map(|s| quotient(s.i, s.j, s.stiffness_n_per_m));
    let mut inspection = Inspection {
        format: INSPECTION_FORMAT,
        name: spec.name.clone(),
        particles: x.len(),
        springs,
        angles: angles(&simulation.system),
        triangles: spec.triangles.len(),
        pins: simulation.system.pins().len(),
        obstacles: spec.obstacles.len(),
        boundaries: boundaries(&spec.triangles).len(),
        groups,
        free_groups,
        size_m: (high - low).into(),
        mass_kg,
        area_m2,
        areal_density_kg_m2: (area_m2 > 0.0).then(|| mass_kg / area_m2),
        rest_length_m: range(spec.springs.iter().map(|s| s.rest_length_m)),
        stiffness_over_mass_per_s2: range(quotients),
        largest_eigenvalue_per_s2: stage.eigenvalue,
        damping_ratio: stage.damping_ratio,
        explicit_limits_s: stage.explicit_limits(),
        motion_unforeseen: stage.lever(Implicit::Springs).err().map(|reason| reason.to_string()),
        doubts: Vec::new(),
        methods: methods::all().map(|method| stage.forecast(method.id)).collect(),
    };
    inspection.doubts = doubts(&inspection, spec);
    Ok(inspection)
}

/// Number of angles of all effects.
fn angles(system: &System) -> usize {
    let mut count = 0;
    for stencils in system.effects().filter_map(Effect::stencils) {
        stencils.visit(&mut |_| count += 1);
    }
    count
}

fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range, value| {
        let [low, high] = range.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

fn area(x: &[Vec3], triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|i| x[i as usize]);
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// Sets of numbers that are joined pair by pair.
struct Sets(Vec<usize>);

impl Sets {
    fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, i: u32, j: u32) {
        let (a, b) = (self.root(i as usize), self.root(j as usize));
        self.0[a.max(b)] = a.min(b);
    }
}

/// The number of the connected group of each particle, in the order of their first particles.
pub fn groups(spec: &SystemSpec) -> Vec<usize> {
    let n = spec.particles.mass_kg.len();
    let mut sets = Sets::new(n);
    for spring in &spec.springs {
        sets.join(spring.i, spring.j);
    }
    for [a, b, c] in &spec.triangles {
        sets.join(*a, *b);
        sets.join(*b, *c);
    }
    let mut number = vec![0; n];
    let mut count = 0;
    for i in 0..n {
        // The root of a set is its first particle.
        let root = sets.root(i);
        if root == i {
            number[i] = count;
            count += 1;
        }
        number[i] = number[root];
    }
    number
}

/// Numbers of connected groups, and of those without a pin.
fn count_groups(spec: &SystemSpec) -> (usize, usize) {
    let number = groups(spec);
    let mut held = vec![false; number.iter().max().map_or(0, |last| last + 1)];
    for pin in &spec.pins {
        held[number[pin.particle as usize]] = true;
    }
    (held.len(), held.iter().filter(|held| !**held).count())
}

/// The connected parts of the boundary, as lists of particles. They stand in the order of their
/// first particles, and pins select them by their place in this order.
pub fn boundaries(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for [a, b, c] in triangles {
        for [i, j] in [[a, b], [b, c], [c, a]] {
            *edges.entry([*i.min(j), *i.max(j)]).or_default() += 1;
        }
    }
    let n = triangles.iter().flatten().max().map_or(0, |last| *last as usize + 1);
    let mut sets = Sets::new(n);
    let mut on_border = vec![false; n];
    for ([i, j], _) in edges.iter().filter(|(_, count)| **count == 1) {
        sets.join(*i, *j);
        on_border[*i as usize] = true;
        on_border[*j as usize] = true;
    }
    let mut parts: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for i in (0..n).filter(|&i| on_border[i]) {
        // The root of a set is its first particle.
        parts.entry(sets.root(i)).or_default().push(i as u32);
    }
    parts.into_values().collect()
}

/// A scene with the numbers that all methods share.
struct Stage<'a> {
    simulation: &'a Simulation,
    /// Largest eigenvalue of the stiffness over the mass at the start, from below, 1/s².
    eigenvalue: f64,
    /// Damping ratio of its mode.
    damping_ratio: f64,
    /// Bounds of the stiffness and damping over the mass from above, 1/s² and 1/s.
    bounds: (f64, f64),
    levers: [Result<Lever, Unforeseen>; 2],
}

impl<'a> Stage<'a> {
    fn of(simulation: &'a Simulation) -> Self {
        let Simulation { system, state } = simulation;
        let lever = |implicit| Lever::of(system, state, implicit, SPAN);
        let mut mode = LargestEigenvalue::new(system);
        let eigenvalue = mode.estimate(system, &state.x, PRODUCTS);
        Self {
            simulation,
            eigenvalue,
            damping_ratio: mode.damping_ratio(system, &state.x, eigenvalue),
            bounds: gershgorin(system),
            levers: [lever(Implicit::Springs), lever(Implicit::Tension)],
        }
    }

    fn lever(&self, implicit: Implicit) -> Result<Lever, Unforeseen> {
        match implicit {
            Implicit::Tension => self.levers[1],
            _ => self.levers[0],
        }
    }

    /// The longest stable step for the springs that a method takes at the old level, s.
    fn limit(&self, choice: &Choice) -> f64 {
        let (method, settings) = (choice.method(), choice.settings());
        let is_explicit = |effect: &dyn Effect| method.is_explicit(effect, settings);
        let Simulation { system, state } = self.simulation;
        ExplicitNumbers::new(system, state, &is_explicit).limit()
    }

    /// The longest stable step of a method, s, at most `most`. It comes from the closed form on the
    /// stiffest mode with all the damping.
    fn closed_limit(&self, choice: &Choice, most: f64) -> f64 {
        let Some(limit) = form_of(choice.method().id).and_then(|form| form.limit) else {
            return most;
        };
        let is_stable =
            |h: f64| (limit.radius)(h * h * self.eigenvalue, h * self.bounds.1) <= 1.0 + ROUND_OFF;
        if is_stable(most) {
            return most;
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_stable(middle) { low = middle } else { high = middle }
        }
        low
    }

    fn explicit_limits(&self) -> BTreeMap<String, f64> {
        let explicit = methods::all().filter(|method| method.supports == Supports::Explicit);
        let choices = explicit.filter_map(|method| Choice::parse(method.id, &[]).ok());
        let limits = choices.filter(|choice| {
            choice.method().check(&self.simulation.system).is_ok() && !divides(choice)
        });
        limits
            .map(|choice| {
                let limit = self.closed_limit(&choice, self.limit(&choice).min(1.0));
                (choice.method().id.to_owned(), limit)
            })
            .collect()
    }

    fn forecast(&self, id: &'static str) -> MethodForecast {
        let choice = match Choice::parse(id, &[]) {
            Ok(choice) => choice,
            Err(error) => {
                return MethodForecast { id, refusal: Some(error.to_string()), steps: Vec::new() };
            }
        };
        let refusal = choice.method().check(&self.simulation.system).err();
        let refusal = refusal.map(|refusal| refusal.to_string());
        let limit = match choice.method().supports {
            _ if refusal.is_some() => f64::INFINITY,
            Supports::Explicit => self.closed_limit(&choice, self.limit(&choice).min(1.0)),
            _ => self.limit(&choice),
        };
        let steps = STEPS_S.iter().filter(|_| refusal.is_none());
        let steps = steps.map(|&h| self.at(&choice, limit, h)).collect();
        MethodForecast { id, refusal, steps }
    }

    fn at(&self, choice: &Choice, limit: f64, h: f64) -> Forecast {
        let system = &self.simulation.system;
        let theta = h * h * Implicit::Springs.max_stiffness_over_mass(system);
        let told =
            |verdict, share, reason: String| Forecast { step_s: h, theta, verdict, share, reason };
        if divides(choice) {
            return told(Foreseen::Stable, None, "it divides its step by itself".to_owned());
        }
        let form = form_of(choice.method().id).and_then(|form| form.limit);
        if h > limit {
            let reason = format!("what it takes at the old level allows at most {limit:.2e} s");
            return told(Foreseen::Unstable, None, reason);
        }
        if let Some(form) = form {
            let (stiffness, damping) = self.bounds;
            if !form.is_stable(h, self.eigenvalue, 0.0)
                && !form.is_stable(h, self.eigenvalue, damping)
            {
                let reason = format!("the stiffest mode grows: stable for {}", form.rule);
                return told(Foreseen::Unstable, None, reason);
            }
            if !(form.is_stable(h, stiffness, 0.0) && form.is_stable(h, stiffness, damping)) {
                let reason = format!("near its limit: stable for {}", form.rule);
                return told(Foreseen::Unclear, None, reason);
            }
        }
        if choice.method().supports == Supports::Explicit {
            return told(Foreseen::Stable, None, "within its limit".to_owned());
        }
        match self.lever(implicit_springs(choice)) {
            // A reason that concerns all springs has a line of its own in the inspection.
            Err(reason) if self.levers[0].err() == Some(reason) => {
                told(Foreseen::Stable, None, "no mode of the springs grows".to_owned())
            }
            Err(reason) => told(
                Foreseen::Stable,
                None,
                format!("no mode of the springs grows; locking is not foreseen: {reason}"),
            ),
            Ok(lever) => match lever.share(choice, h) {
                None => told(Foreseen::Unclear, None, "it blows up on one spring".to_owned()),
                Some(share) if share < LOCKED => told(
                    Foreseen::Locked,
                    Some(share),
                    "its matrix holds the cloth back".to_owned(),
                ),
                Some(share) => {
                    let reason = "no mode of the springs grows, and the cloth moves".to_owned();
                    told(Foreseen::Stable, Some(share), reason)
                }
            },
        }
    }
}

/// Whether a method divides each step as the stiffness requires.
fn divides(choice: &Choice) -> bool {
    let settings: &Settings = choice.settings();
    choice.theory().divides && settings.get("step").is_some_and(|step| step != "fixed")
}

/// Numbers that are wrong for any cloth, each with its likely cause.
fn doubts(inspection: &Inspection, spec: &SystemSpec) -> Vec<String> {
    let mut doubts = Vec::new();
    let extent = size(&spec.particles.position_m.iter().map(|&x| x.into()).collect::<Vec<_>>());
    if extent > 20.0 {
        doubts.push(format!(
            "the cloth measures {extent:.3} m across: lengths are in m, so a mesh in cm or mm \
             needs `scale` 0.01 or 0.001"
        ));
    }
    if extent < 0.01 {
        doubts.push(format!("the cloth measures {extent:.2e} m across: lengths are in m"));
    }
    if let Some(density) = inspection.areal_density_kg_m2 {
        if density > 5.0 {
            doubts.push(format!(
                "the cloth weighs {density:.0} kg/m²; textiles weigh 0.02 to 1: are masses in g?"
            ));
        }
        if density < 1e-3 {
            doubts.push(format!(
                "the cloth weighs {density:.1e} kg/m²; textiles weigh 0.02 to 1 kg/m²"
            ));
        }
    }
    if let Some(gravity) = &spec.effects.gravity {
        let g = Vec3::from(gravity.m_s2).norm();
        if g > 0.0 && !(0.5..50.0).contains(&g) {
            doubts.push(format!("gravity is {g} m/s²; on Earth it is 9.81: is it in other units?"));
        }
    }
    if let Some([least, greatest]) = inspection.stiffness_over_mass_per_s2 {
        if greatest > 1e13 {
            doubts.push(format!(
                "k/m is up to {greatest:.1e} 1/s²: is the stiffness in N/m and the mass in kg?"
            ));
        }
        if greatest < 1.0 && least > 0.0 {
            doubts.push(format!(
                "k/m is at most {greatest:.1e} 1/s²: such a cloth stretches without end"
            ));
        }
    }
    doubts
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn of(scene: &str) -> Inspection {
        inspect(drape_model::load(scene).unwrap().spec()).unwrap()
    }

    fn verdict(inspection: &Inspection, id: &str) -> Foreseen {
        let method = inspection.methods.iter().find(|method| method.id == id).unwrap();
        assert_eq!(method.steps[1].step_s, 0.01);
        method.steps[1].verdict
    }

    #[test]
    fn a_stiff_sheet_is_measured_and_its_methods_are_foreseen() {
        let sheet = of("hanging-textile-1e6");
        assert_eq!((sheet.particles, sheet.pins, sheet.boundaries), (400, 2, 1));
        assert_eq!((sheet.groups, sheet.free_groups), (1, 0));
        assert!((sheet.mass_kg - 0.4).abs() < 1e-12 && (sheet.area_m2 - 1.0).abs() < 1e-9);
        let [low, high] = sheet.stiffness_over_mass_per_s2.unwrap();
        assert!(low <= high && (high / 1e6 - 1.0).abs() < 1e-9, "{low} {high}");
        assert_eq!(sheet.doubts, Vec::<String>::new());
        assert_eq!(verdict(&sheet, "imex-euler"), Foreseen::Locked);
        assert_eq!(verdict(&sheet, "explicit-euler"), Foreseen::Unstable);
        assert_eq!(verdict(&sheet, "symplectic-euler"), Foreseen::Unstable);
        assert_eq!(verdict(&sheet, "imex-updated"), Foreseen::Stable);
        assert_eq!(verdict(&sheet, "backward-euler"), Foreseen::Stable);
        let limit = sheet.explicit_limits_s["symplectic-euler"];
        assert!((5e-4..1e-3).contains(&limit), "{limit}");
        assert_eq!(sheet.methods.len(), methods::all().count());
    }

    /// A spring of mass m has `ζ = d/(2 √(km))`. Where each spring is damped along itself by `c = βk`,
    /// the stiffest mode has `ζ = β ω/2`. The sheets of `trajectory` have their ratio in their name.
    #[test]
    fn the_damping_ratio_is_that_of_the_stiffest_mode() {
        let mut spring = drape_model::load("oscillator").unwrap().spec().clone();
        for damping in [0.0, 3.0, 20.0] {
            let own = &mut spring.springs[0];
            own.damping_n_s_per_m = damping;
            let mass = spring.particles.mass_kg[1];
            let exact = damping / (2.0 * (own.stiffness_n_per_m * mass).sqrt());
            let found = inspect(&spring).unwrap().damping_ratio;
            assert!((found - exact).abs() <= 1e-9 * exact, "{damping}: {found}, not {exact}");
            assert!(found.is_sign_positive());
        }
        let mut denim = drape_model::load("hanging-denim").unwrap().spec().clone();
        denim.damping = drape_model::DampingLaw::Projected;
        denim.springs.retain(|spring| spring.effect != drape_model::SpringEffect::Bending);
        let denim = inspect(&denim).unwrap();
        let exact = 0.5 * 0.0002 * denim.largest_eigenvalue_per_s2.sqrt();
        assert!((denim.damping_ratio / exact - 1.0).abs() < 1e-3, "{denim:?}, not {exact}");
        for (part, ratio) in [("1e2", 0.01), ("1e6", 0.1), ("1e6", 1.0)] {
            let name = format!("trajectory/k/m = {part}, ζ = {ratio}");
            let start = crate::studies::start(&name).unwrap().unwrap();
            let found = inspect(&start.system().unwrap()).unwrap().damping_ratio;
            assert!((found / ratio - 1.0).abs() < 0.05, "{name}: {found}");
        }
    }

    #[test]
    fn a_method_that_refuses_a_scene_says_why() {
        let ball = of("sheet-on-sphere");
        let refusing = ball.methods.iter().filter(|method| method.refusal.is_some());
        let system = drape_model::load("sheet-on-sphere").unwrap().spec().build().unwrap().0;
        let expected = methods::all().filter(|method| method.check(&system).is_err());
        let (refusing, expected): (Vec<_>, Vec<_>) =
            (refusing.map(|m| m.id).collect(), expected.map(|m| m.id).collect());
        assert_eq!(refusing, expected);
        assert_eq!(ball.free_groups, 1);
        assert!(ball.motion_unforeseen.is_some());
    }

    #[test]
    fn mistakes_of_units_are_doubted_one_by_one() {
        let good = drape_model::load("hanging-textile-1e4").unwrap().spec().clone();
        let doubts = |change: &dyn Fn(&mut SystemSpec)| {
            let mut spec = good.clone();
            change(&mut spec);
            inspect(&spec).unwrap().doubts.join("; ")
        };
        assert_eq!(doubts(&|_| ()), "");
        let large = doubts(&|spec| {
            spec.particles.position_m.iter_mut().flatten().for_each(|x| *x *= 100.0);
        });
        assert!(large.contains("measures 141") && large.contains("scale"), "{large}");
        let heavy = doubts(&|spec| {
            spec.particles.mass_kg.iter_mut().for_each(|m| *m *= 1e3);
        });
        assert!(heavy.contains("weighs 400 kg/m²"), "{heavy}");
        let pulled = doubts(&|spec| {
            spec.effects.gravity = Some(drape_model::GravitySpec { m_s2: [0.0, 0.0, -9810.0] });
        });
        assert!(pulled.contains("gravity is 9810 m/s²"), "{pulled}");
    }
}
