//! The hard cases. Each is a scene that is small enough for every method.

use super::tweak::Tweak;
use crate::HarnessError;
use crate::run::Simulation;
use crate::schedule::{Change, Schedule};
use crate::studies::sheet::{GRAVITY, MASS, Sheet};
use drape_model::{
    AirSpec, DampingLaw, DragSpec, KeyframeSpec, ObstacleSpec, PieceSpec, PinSpec, SpringEffect,
    SpringSpec, SystemSpec, TimeSpan, Vec3,
};
use drape_oracle::{Random, laws::hanging_chain};

/// Particles along each edge of most sheets.
const SIDE: u32 = 12;
/// Damping over mass of the tension springs, 1/s (the paper's); shear springs have a tenth.
const DAMPING: f64 = 40.0;
/// Stiffness of shear springs over that of tension springs.
const SHEAR: f64 = 0.1;
/// Greatest stiffness over mass of a scene whose true motion is computed, 1/s². Stiffer sheets
/// hardly stretch, so they release the same energy.
const TAME: f64 = 1e7;
const TAME_FINE: f64 = 1e6;
/// Size of the perturbation of a start, in mesh widths.
const PERTURBATION: f64 = 1e-4;
/// Largest energy that a perturbation may store in the springs, over `E_ref`.
const PERTURBATION_ENERGY: f64 = 1e-3;

/// One hard case, or one variant of it.
pub(super) struct Case {
    /// `H01` to `H24`.
    pub(super) id: &'static str,
    /// What the case is, in two or three words.
    pub(super) title: &'static str,
    /// The scene in one sentence.
    pub(super) scene: &'static str,
    /// Whether it belongs to the quick subset.
    pub(super) is_quick: bool,
    /// The system and the way in which methods run on it.
    pub(super) setup: Setup,
}

/// A function that makes the system of a case.
pub(super) type Maker = fn() -> Result<SystemSpec, HarnessError>;

/// The system of a case and the way in which methods run on it.
pub(super) struct Setup {
    /// The system with its damping.
    pub(super) system: Maker,
    /// A softer system, if the true motion of `system` would take too many steps. The true motion
    /// gives `E_ref`.
    pub(super) tame: Option<Maker>,
    /// Step and duration, pattern of steps, and changes of stiffness.
    pub(super) schedule: Schedule,
    /// What the case changes in the methods' settings.
    pub(super) tweak: Tweak,
    /// Whether the start is an equilibrium that methods must keep.
    pub(super) is_at_rest: bool,
    /// Two particles that start at the same place and are perturbed alike.
    pub(super) twins: Option<(usize, usize)>,
}

impl Setup {
    /// A plain run with steps of `step_s`, for 2 s or 200 steps, whichever is longer.
    fn new(system: Maker, step_s: f64) -> Self {
        let duration_s = if step_s < 0.01 { 2.0 } else { 200.0 * step_s };
        Self {
            system,
            tame: None,
            schedule: Schedule::steady(TimeSpan { step_s, duration_s }),
            tweak: Tweak::None,
            is_at_rest: false,
            twins: None,
        }
    }

    fn tame(self, tame: Maker) -> Self {
        Self { tame: Some(tame), ..self }
    }

    fn tweak(self, tweak: Tweak) -> Self {
        Self { tweak, ..self }
    }
}

impl Case {
    /// Id and title: the name of the case in records.
    pub(super) fn name(&self) -> String {
        format!("{} {}", self.id, self.title)
    }

    /// How the energy of the case is judged; most cases are `closed` systems.
    pub(super) fn judged(&self) -> &'static str {
        match self.id {
            "H09" => "closed: the step size is the method's own affair, nothing flows in",
            "H10" => {
                "the work that a change of stiffness does on the springs is recorded at the \
                 moment of the change and \
                 taken out of the energy; the available energy includes it"
            }
            "H11" => {
                "from the moment at which the pin has stopped: the work that it does until then \
                 is its own affair; what a \
                 method takes in too much meanwhile is seen only where it comes out later"
            }
            "H14" => "closed: air at rest takes energy and gives none",
            "H12" | "H13" => {
                "what the contacts add to the energy of the reference trajectory while they push \
                 out is granted \
                 to every method"
            }
            "H18" => {
                "against the energy that lifts the sheet by a mesh width; besides, the \
                 unperturbed sheet may move by \
                 at most 1e-6 mesh widths, at no more than 1e-6 of the speed of a fall through \
                 one, else a stable run \
                 counts as marginal"
            }
            _ => "closed",
        }
    }
}

/// A sheet that hangs by two corners.
fn hanging(stiffness: f64) -> Sheet {
    Sheet {
        side: SIDE,
        tension: stiffness,
        shear: SHEAR * stiffness,
        damping: DAMPING,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    }
}

/// A free sheet.
fn free(stiffness: f64) -> Sheet {
    Sheet { is_pinned: false, ..hanging(stiffness) }
}

fn pins(particles: impl Iterator<Item = u32>) -> Vec<PinSpec> {
    particles.map(PinSpec::still).collect()
}

/// H03: a square metre of 40 × 40 particles with a membrane stiffness of up to 10³ N/m. `most`
/// bounds the stiffness over mass, 1/s².
fn fabric(kilograms_per_m2: f64, most: f64) -> Result<SystemSpec, HarnessError> {
    let side = 40;
    let mass = kilograms_per_m2 / f64::from(side * side);
    let mut spec = Sheet { side, ..hanging((1e3 / mass).min(most)) }.spec()?;
    // The sheet is made for particles of [`MASS`]: this keeps k/m and d/m.
    let factor = mass / MASS;
    spec.particles.mass_kg.fill(mass);
    for spring in &mut spec.springs {
        spring.stiffness_n_per_m *= factor;
        spring.damping_n_s_per_m *= factor;
    }
    Ok(spec)
}

/// H04: a sheet squeezed in its plane to half its size.
fn squeezed() -> Result<SystemSpec, HarnessError> {
    let mut spec = hanging(1e5).spec()?;
    for [x, y, _] in &mut spec.particles.position_m {
        (*x, *y) = (0.5 * *x, 0.5 * *y);
    }
    Ok(spec)
}

/// H05: an inner particle and the neighbour that starts at its place.
const TWINS: (usize, usize) = (77, 78);

fn coincident() -> Result<SystemSpec, HarnessError> {
    let mut spec = hanging(1e5).spec()?;
    spec.particles.position_m[TWINS.1] = spec.particles.position_m[TWINS.0];
    Ok(spec)
}

/// H06: a sheet that spins about the normal through its middle.
fn spinning() -> Result<SystemSpec, HarnessError> {
    const SPEED: f64 = 20.0;
    let mut spec = Sheet { gravity: [0.0; 3], ..free(1e4) }.spec()?;
    let spin = |&[x, y, _]: &[f64; 3]| [-SPEED * y, SPEED * x, 0.0];
    spec.particles.velocity_m_s = spec.particles.position_m.iter().map(spin).collect();
    Ok(spec)
}

/// H07: heavy and light particles alternate like the squares of a chessboard, on springs of 10 N/m.
fn two_masses(light: f64) -> Result<SystemSpec, HarnessError> {
    let mut spec = hanging(1e4).spec()?;
    for (n, mass) in spec.particles.mass_kg.iter_mut().enumerate() {
        let (row, column) = (n / SIDE as usize, n % SIDE as usize);
        if (row + column) % 2 == 1 {
            *mass *= light;
        }
    }
    Ok(spec)
}

/// H08: springs that are soft at first and then stiff, as in Kawabata's curves.
fn two_slopes() -> Result<SystemSpec, HarnessError> {
    let mut spec = hanging(1e4).spec()?;
    let is_tension = |spring: &&mut SpringSpec| spring.effect == SpringEffect::Tension;
    for spring in spec.springs.iter_mut().filter(is_tension) {
        let stiffness_n_per_m = spring.stiffness_n_per_m;
        let soft = PieceSpec { up_to_strain: Some(0.02), stiffness_n_per_m };
        let steep = 100.0 * stiffness_n_per_m;
        spring.pieces = [soft, PieceSpec { up_to_strain: None, stiffness_n_per_m: steep }].into();
    }
    Ok(spec)
}

const CYCLE: [f64; 4] = [1.0, 2.0, 1.0, 0.5];

const STIFFENED: [Change; 2] =
    [Change { time_s: 0.7, factor: 100.0 }, Change { time_s: 1.4, factor: 0.01 }];

/// H11: one pin moves along a chord of the circle about the other pin. The row between them ends as
/// long as it was.
fn yanked() -> Result<SystemSpec, HarnessError> {
    const CHORD: f64 = 0.6;
    const SPEED: f64 = 10.0;
    let mut spec = hanging(1e5).spec()?;
    let [here, there] = [0, SIDE as usize - 1].map(|n| Vec3::from(spec.particles.position_m[n]));
    let towards = 0.5 * CHORD * CHORD;
    let up = (CHORD * CHORD - towards * towards).sqrt();
    let offset = (there - here) * towards + Vec3::z() * up;
    spec.pins[0].path = vec![
        KeyframeSpec { time_s: 0.5, offset_m: [0.0; 3] },
        KeyframeSpec { time_s: 0.5 + CHORD / SPEED, offset_m: offset.into() },
    ];
    Ok(spec)
}

const FLOOR: f64 = -1.0;

fn floor() -> ObstacleSpec {
    ObstacleSpec::plane([0.0, 0.0, FLOOR], [0.0, 0.0, 1.0], 0.0)
}

/// H12: the middle of the sheet hits a corner of the table at 10 m/s.
fn thrown_at_a_corner() -> Result<SystemSpec, HarnessError> {
    let mut spec = free(1e5).spec()?;
    for [x, y, z] in &mut spec.particles.position_m {
        (*x, *y, *z) = (*x + 0.5, *y + 0.5, 0.05);
    }
    spec.particles.velocity_m_s = vec![[0.0, 0.0, -10.0]; spec.particles.mass_kg.len()];
    let table = ObstacleSpec::cuboid([0.0, 0.0, 0.5 * FLOOR], [1.0, 1.0, -FLOOR], 0.0);
    spec.obstacles = vec![table, floor()];
    Ok(spec)
}

/// H13: a sheet that cuts through a ball at its start, a little above the ball's centre.
fn inside_a_ball() -> Result<SystemSpec, HarnessError> {
    let mut spec = free(1e5).spec()?;
    let ball = ObstacleSpec::sphere([0.0, 0.0, -0.05], 0.35, 0.0);
    spec.obstacles = vec![ball, floor()];
    Ok(spec)
}

/// H15: columns lie at distances of 1/2, 1/4, … 1/2048 m. Springs belong to one fabric, `k ∝ 1/ℓ`.
fn graded() -> Result<SystemSpec, HarnessError> {
    let mut spec = hanging(1e4).spec()?;
    let side = SIDE as usize;
    for n in 0..side * side {
        let column = n % side;
        spec.particles.position_m[n][0] = 0.5 - (0..column).fold(1.0, |width: f64, _| 0.5 * width);
    }
    as_one_fabric(&mut spec);
    Ok(spec)
}

/// H14: the drag slows the sheet as a whole by `cA/M` = 1111/s.
fn in_a_gust() -> Result<SystemSpec, HarnessError> {
    const COEFFICIENT: f64 = 160.0;
    let mut spec = Sheet { gravity: [0.0; 3], ..free(1e3) }.spec()?;
    spec.particles.velocity_m_s = vec![[0.0, 0.0, -10.0]; spec.particles.mass_kg.len()];
    let drag = DragSpec::Linear { coefficient_n_s_per_m3: COEFFICIENT };
    spec.effects.air = Some(AirSpec { drag, wind: None });
    Ok(spec)
}

/// H15: at each particle that is moved, two triangles become slivers.
fn slivers() -> Result<SystemSpec, HarnessError> {
    const DISTANCE: f64 = 1e-3;
    let mut spec = hanging(1e4).triangulated(0.0, 0)?;
    let side = SIDE as usize;
    for (row, column) in
        (1..side - 2).step_by(3).flat_map(|r| (1..side - 2).step_by(3).map(move |c| (r, c)))
    {
        let [from, to] = [0, 1].map(|k| spec.particles.position_m[row * side + column + k][0]);
        spec.particles.position_m[row * side + column][0] = to - DISTANCE * (to - from);
    }
    as_one_fabric(&mut spec);
    Ok(spec)
}

/// Sets every rest length to the distance of the spring's ends, and scales `k ∝ 1/ℓ`.
fn as_one_fabric(spec: &mut SystemSpec) {
    for spring in &mut spec.springs {
        let end = |n: u32| Vec3::from(spec.particles.position_m[n as usize]);
        let length = (end(spring.i) - end(spring.j)).norm();
        spring.stiffness_n_per_m *= spring.rest_length_m / length;
        spring.rest_length_m = length;
    }
}

/// H18: an upright sheet held by its first row. Each column is a hanging chain in equilibrium.
fn at_rest() -> Result<SystemSpec, HarnessError> {
    // Explicit steps stay within their limit. No spring stretches by a tenth, beyond which Provot
    // would correct it.
    let sheet = Sheet { shear: 0.0, damping: 0.25 * DAMPING, ..free(1.2e4) };
    let mut spec = sheet.spec()?;
    spec.pins = pins(0..SIDE);
    let links = SIDE as usize - 1;
    let spacing = 1.0 / links as f64;
    let lengths = hanging_chain(
        &vec![MASS; links],
        &vec![MASS * sheet.tension; links],
        &vec![spacing; links],
        -GRAVITY[2],
    );
    for (n, [_, y, z]) in spec.particles.position_m.iter_mut().enumerate() {
        (*y, *z) = (0.0, -lengths[..n / SIDE as usize].iter().sum::<f64>());
    }
    Ok(spec)
}

/// H17: every particle is pinned.
fn all_pinned() -> Result<SystemSpec, HarnessError> {
    let mut spec = free(1e4).spec()?;
    spec.pins = pins(0..SIDE * SIDE);
    Ok(spec)
}

/// H17: a single particle.
fn one_particle() -> Result<SystemSpec, HarnessError> {
    Sheet { side: 1, ..free(1e4) }.spec()
}

/// Particles along an edge of the sheets with one heavy particle, which is an inner one.
const HEAVY_SIDE: u32 = 10;
const HEAVY: usize = 55;

/// H21: one particle is much heavier than the others, on springs of 100 N/m.
fn one_falls() -> Result<SystemSpec, HarnessError> {
    let mut spec = Sheet { side: HEAVY_SIDE, ..hanging(1e5) }.spec()?;
    spec.particles.mass_kg[HEAVY] *= 1e6;
    Ok(spec)
}

/// H21: without gravity, all energy belongs to the light particles. The sheet starts in its plane
/// at nine tenths of its size.
fn one_stays() -> Result<SystemSpec, HarnessError> {
    let mut spec = Sheet { side: HEAVY_SIDE, gravity: [0.0; 3], ..hanging(1e5) }.spec()?;
    spec.particles.mass_kg[HEAVY] *= 1e9;
    for [x, y, _] in &mut spec.particles.position_m {
        (*x, *y) = (0.9 * *x, 0.9 * *y);
    }
    Ok(spec)
}

/// H23: the upper half has springs of 0.1 N/m; the lower half is `factor` times as stiff.
fn board_on_veil(factor: f64) -> Result<SystemSpec, HarnessError> {
    let mut spec = hanging(1e2).spec()?;
    let is_low = |n: u32| n / SIDE >= SIDE / 2;
    for spring in spec.springs.iter_mut().filter(|spring| is_low(spring.i) && is_low(spring.j)) {
        spring.stiffness_n_per_m *= factor;
    }
    Ok(spec)
}

/// H24: the same with a heavy particle in the middle of the board.
fn heavy_board(stiffness: f64) -> Result<SystemSpec, HarnessError> {
    let mut spec = board_on_veil(stiffness)?;
    spec.particles.mass_kg[(SIDE * (3 * SIDE / 4) + SIDE / 2) as usize] *= 1e9;
    Ok(spec)
}

/// All cases, in the order of their ids.
pub(super) fn all() -> Vec<Case> {
    let case = |id, title, scene, setup| Case { id, title, scene, is_quick: false, setup };
    let quick = |case: Case| Case { is_quick: true, ..case };
    let pattern = |setup: Setup| {
        let time = TimeSpan { step_s: 0.01, duration_s: 2.25 };
        Setup { schedule: Schedule { pattern: &CYCLE, ..Schedule::steady(time) }, ..setup }
    };
    let stiffened = |setup: Setup| Setup {
        schedule: Schedule { changes: &STIFFENED, ..setup.schedule },
        ..setup
    };
    let ten_seconds = |setup: Setup| {
        let time = TimeSpan { step_s: 0.005, duration_s: 10.0 };
        Setup { schedule: Schedule::steady(time), is_at_rest: true, ..setup }
    };
    let tame: Maker = || hanging(TAME).spec();
    vec![
        case(
            "H01",
            "k/m = 1e8",
            "A sheet that hangs by two corners from a horizontal start.",
            Setup::new(|| hanging(1e8).spec(), 0.01).tame(tame),
        ),
        case(
            "H01",
            "k/m = 1e10",
            "The same sheet, stiffer.",
            Setup::new(|| hanging(1e10).spec(), 0.01).tame(tame),
        ),
        case(
            "H01",
            "k/m = 1e12",
            "The same sheet, stiffer still.",
            Setup::new(|| hanging(1e12).spec(), 0.01).tame(tame),
        ),
        case(
            "H02",
            "h = 1/15 s",
            "The hanging sheet at k/m = 1e4.",
            Setup::new(|| hanging(1e4).spec(), 1.0 / 15.0),
        ),
        case(
            "H02",
            "h = 0.1 s",
            "The hanging sheet at k/m = 1e4.",
            Setup::new(|| hanging(1e4).spec(), 0.1),
        ),
        case(
            "H03",
            "heavy fabric",
            "40 × 40 particles, membrane stiffness 10³ N/m, 0.3 kg/m²: k/m = 5.3e6.",
            Setup::new(|| fabric(0.3, f64::INFINITY), 0.01).tame(|| fabric(0.3, TAME_FINE)),
        ),
        case(
            "H03",
            "light fabric",
            "40 × 40 particles, membrane stiffness 10³ N/m, 0.05 kg/m²: k/m = 3.2e7.",
            Setup::new(|| fabric(0.05, f64::INFINITY), 0.01).tame(|| fabric(0.05, TAME_FINE)),
        ),
        quick(case(
            "H04",
            "squeezed to half",
            "A hanging sheet at k/m = 1e5 that starts in its plane at half its size: every spring \
             is compressed, the \
             Hessian is indefinite.",
            Setup::new(squeezed, 0.01),
        )),
        case(
            "H05",
            "two in one place",
            "A hanging sheet at k/m = 1e5, two neighbours in the middle of which start in the \
             same place.",
            Setup { twins: Some(TWINS), ..Setup::new(coincident, 0.01) },
        ),
        case(
            "H06",
            "free spin",
            "A free sheet at k/m = 1e4 without gravity turns at 20 rad/s about its normal.",
            Setup::new(spinning, 0.005),
        ),
        case(
            "H07",
            "masses 1 : 1e6",
            "A hanging sheet on springs of 10 N/m, particles of 1 g and of 1 µg like the squares \
             of a chessboard.",
            Setup::new(|| two_masses(1e-6), 0.01).tame(|| two_masses(0.1)),
        ),
        case(
            "H08",
            "slopes 1 : 100",
            "A hanging sheet whose tension springs have k/m = 1e4 up to 2 %, 1e6 beyond, 1e3 in \
             compression.",
            Setup::new(two_slopes, 0.01),
        ),
        case(
            "H09",
            "step up and down",
            "A hanging sheet at k/m = 1e5 in steps of 10, 20, 10, 5 ms, round and round.",
            pattern(Setup::new(|| hanging(1e5).spec(), 0.01)),
        ),
        case(
            "H10",
            "stiffness × 100",
            "A hanging sheet whose k/m goes from 1e4 to 1e6 after 0.7 s and back after 1.4 s.",
            stiffened(Setup::new(|| hanging(1e4).spec(), 0.01)),
        ),
        case(
            "H11",
            "yanked pin",
            "A hanging sheet at k/m = 1e5, one pin of which is yanked by 0.6 m after 0.5 s at 10 \
             m/s and stops dead.",
            Setup::new(yanked, 0.01),
        ),
        case(
            "H12",
            "table's corner",
            "A free sheet at k/m = 1e5 hits a table's edges and corner at 10 m/s and falls on to \
             the floor.",
            Setup::new(thrown_at_a_corner, 0.01),
        ),
        case(
            "H13",
            "inside a ball",
            "A free sheet at k/m = 1e5 starts across a ball of 0.35 m radius, above a floor.",
            Setup::new(inside_a_ball, 0.01),
        ),
        case(
            "H14",
            "gust of wind",
            "A free sheet at k/m = 1e3 without gravity moves broadside through still air at 10 \
             m/s: a gust, in the frame of \
             the air. Its drag is linear, with hca/(3m) = 2.2 for a triangle of area a.",
            Setup::new(in_a_gust, 0.01),
        ),
        case(
            "H15",
            "lengths 1 : 1e3",
            "A hanging sheet with columns at 1/2, 1/4, … 1/2048 m, springs of one fabric (k ∝ \
             1/ℓ).",
            Setup::new(graded, 0.01),
        ),
        case(
            "H15",
            "sliver triangles",
            "A hanging sheet of triangles at k/m = 1e4, every ninth particle of which lies a \
             thousandth of a mesh width beside \
             its neighbour; springs of one fabric (k ∝ 1/ℓ).",
            Setup::new(slivers, 0.01),
        ),
        case(
            "H16",
            "explicit shear",
            "A hanging sheet at k/m = 1e6 whose shear springs are as stiff as its tension springs \
             and, where a \
             method leaves the choice, stay out of its matrix.",
            Setup::new(|| Sheet { shear: 1e6, ..hanging(1e6) }.spec(), 0.01)
                .tweak(Tweak::ExplicitShear),
        ),
        quick(case(
            "H17",
            "all pinned",
            "A sheet every particle of which is pinned.",
            Setup::new(all_pinned, 0.01),
        )),
        case(
            "H17",
            "none pinned",
            "A sheet at k/m = 1e4 in free fall.",
            Setup::new(|| free(1e4).spec(), 0.01),
        ),
        quick(case(
            "H17",
            "one particle",
            "One particle in free fall.",
            Setup::new(one_particle, 0.01),
        )),
        case(
            "H18",
            "at rest for 10 s",
            "A sheet without shear springs at k/m = 1.2e4 hangs from its first row in equilibrium.",
            ten_seconds(Setup::new(at_rest, 0.005)),
        ),
        case(
            "H19",
            "loosest ε",
            "A hanging sheet at k/m = 1e5; every method at the loosest tolerance that it allows.",
            Setup::new(|| hanging(1e5).spec(), 0.01).tweak(Tweak::Loosest),
        ),
        case(
            "H19",
            "tightest ε",
            "The same at the tightest.",
            Setup::new(|| hanging(1e5).spec(), 0.01).tweak(Tweak::Tightest),
        ),
        case(
            "H20",
            "ε = 0.1",
            "A hanging sheet at k/m = 1e6; every method that has a forcing term at 0.1.",
            Setup::new(|| hanging(1e6).spec(), 0.01).tweak(Tweak::ForcingTerm(0.1)),
        ),
        case(
            "H21",
            "one mass × 1e6",
            "A hanging sheet of 10 × 10 particles at k/m = 1e5, an inner one of which has 10⁶ times \
             the mass of the others: nearly all energy is that of its fall.",
            Setup::new(one_falls, 0.01),
        ),
        case(
            "H21",
            "one mass × 1e9",
            "A sheet of 10 × 10 particles at k/m = 1e5 without gravity, an inner one of which has \
             10⁹ times the mass of the others, starts in its plane at nine tenths of its size.",
            Setup::new(one_stays, 0.01),
        ),
        case(
            "H22",
            "masses 1 : 1e9",
            "A hanging sheet on springs of 10 N/m, particles of 1 g and of 1 ng like the squares \
             of a chessboard.",
            Setup::new(|| two_masses(1e-9), 0.01).tame(|| two_masses(0.1)),
        ),
        case(
            "H23",
            "stiffness 1 : 1e9",
            "A hanging sheet whose upper half has k/m = 1e2 and whose lower half has 1e11: a board \
             on a veil.",
            Setup::new(|| board_on_veil(1e9), 0.01).tame(|| board_on_veil(1e5)),
        ),
        case(
            "H24",
            "both 1 : 1e9",
            "The board on a veil, a particle in the middle of which has 10⁹ times the mass of the \
             others.",
            Setup::new(|| heavy_board(1e9), 0.01).tame(|| heavy_board(1e5)),
        ),
    ]
}

/// The system with or without its damping.
fn with_damping(mut spec: SystemSpec, is_damped: bool) -> SystemSpec {
    for spring in spec.springs.iter_mut().filter(|_| !is_damped) {
        spring.damping_n_s_per_m = 0.0;
    }
    spec
}

/// The system of a case, damped or not.
pub(super) struct Scenery {
    pub(super) spec: SystemSpec,
    /// The unperturbed start.
    pub(super) simulation: Simulation,
    /// Least rest length of a tension spring, m; 0 if the system has none.
    pub(super) mesh_width: f64,
}

impl Scenery {
    pub(super) fn new(maker: Maker, is_damped: bool) -> Result<Self, HarnessError> {
        let spec = with_damping(maker()?, is_damped);
        let (system, state) = spec.build()?;
        let tension = spec.springs.iter().filter(|spring| spring.effect == SpringEffect::Tension);
        let least = tension.fold(f64::INFINITY, |least, spring| least.min(spring.rest_length_m));
        let mesh_width = if least.is_finite() { least } else { 0.0 };
        Ok(Self { spec, simulation: Simulation { system, state }, mesh_width })
    }

    /// Energy that lifts the whole system by a mesh width, J.
    pub(super) fn lift(&self) -> f64 {
        self.simulation.system.mass().iter().sum::<f64>() * -GRAVITY[2] * self.mesh_width
    }

    /// Speed of a fall through a mesh width, m/s.
    pub(super) fn fall_speed(&self) -> f64 {
        (2.0 * -GRAVITY[2] * self.mesh_width).sqrt()
    }

    /// The start with every free particle moved at random by up to 1e-4 mesh widths along each
    /// axis. The offsets are scaled down if they would store more than a thousandth of
    /// `reference_energy` (J) in the springs. Both `twins` move alike.
    pub(super) fn perturbed(
        &self,
        seed: u64,
        twins: Option<(usize, usize)>,
        reference_energy: f64,
    ) -> Simulation {
        let mut random = Random::new(seed);
        let Simulation { system, state } = &self.simulation;
        let reach = PERTURBATION * self.mesh_width;
        let mut offset: Vec<Vec3> = state.x.iter().map(|_| random.vector() * reach).collect();
        system.clear_pinned(&mut offset);
        if let Some((a, b)) = twins {
            offset[b] = offset[a];
        }
        let moved = |factor: f64| {
            let mut moved = state.clone();
            for (x, offset) in moved.x.iter_mut().zip(&offset) {
                *x += offset * factor;
            }
            moved
        };
        let stored = system.potential_energy(&moved(1.0).x) - system.potential_energy(&state.x);
        let most = PERTURBATION_ENERGY * reference_energy;
        // The energy grows with the square of the distance.
        let factor = if stored > most { (most / stored).sqrt() } else { 1.0 };
        Simulation { system: system.clone(), state: moved(factor) }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn every_case_builds_and_lasts_long_enough() {
        for case in all() {
            let setup = &case.setup;
            let time = setup.schedule.time;
            assert!(time.duration_s >= 2.0 && setup.schedule.steps() >= 200, "{}", case.name());
            for maker in [Some(setup.system), setup.tame].into_iter().flatten() {
                let scenery = Scenery::new(maker, true).unwrap();
                assert!(scenery.simulation.state.is_finite(), "{}", case.name());
            }
        }
    }

    #[test]
    fn names_are_all_different_and_cover_h01_to_h24() {
        let cases = all();
        let names: std::collections::BTreeSet<_> = cases.iter().map(Case::name).collect();
        assert_eq!(names.len(), cases.len());
        for n in 1..=24 {
            assert!(cases.iter().any(|case| case.id == format!("H{n:02}")), "H{n:02}");
        }
    }

    /// Drag exceeds the limit on an inner triangle, and on the sheet as a whole.
    #[test]
    fn explicit_drag_in_the_gust_is_beyond_its_limit() {
        let spec = in_a_gust().unwrap();
        let (h, cell) = (0.01, 1.0 / f64::from((SIDE - 1) * (SIDE - 1)));
        let Some(AirSpec { drag: DragSpec::Linear { coefficient_n_s_per_m3: c }, .. }) =
            spec.effects.air
        else {
            panic!("linear drag")
        };
        assert!(h * c * 0.5 * cell / (3.0 * MASS) > 2.0);
        let whole = spec.particles.mass_kg.iter().sum::<f64>();
        assert!(h * c / whole > 10.0);
    }

    #[test]
    fn slivers_have_edges_a_thousand_times_as_long_as_others() {
        let spec = slivers().unwrap();
        let lengths = spec.springs.iter().map(|spring| spring.rest_length_m);
        let (least, most) =
            lengths.fold((f64::INFINITY, 0.0_f64), |(a, b), l| (a.min(l), b.max(l)));
        assert!(most > 1e3 * least && most < 3e3 * least, "{least} {most}");
        let x = |i: u32| Vec3::from(spec.particles.position_m[i as usize]);
        let area = |&[a, b, c]: &[u32; 3]| 0.5 * (x(b) - x(a)).cross(&(x(c) - x(a))).z;
        let areas: Vec<_> = spec.triangles.iter().map(area).collect();
        let greatest = areas.iter().fold(0.0_f64, |most, area| most.max(*area));
        assert!(areas.iter().all(|area| *area > 0.0), "no triangle is turned over");
        let thin = areas.iter().filter(|area| **area < 2e-3 * greatest).count();
        assert_eq!(thin, 2 * 9);
    }

    #[test]
    fn the_sheet_at_rest_is_in_equilibrium() {
        let scenery = Scenery::new(at_rest, true).unwrap();
        let Simulation { system, state } = &scenery.simulation;
        let mut force = vec![Vec3::zeros(); system.len()];
        system.forces(state.level(), &mut force);
        for (force, pinned) in force.iter().zip(system.pinned()) {
            assert!(*pinned || force.norm() < 1e-12, "{force:?}");
        }
    }

    #[test]
    fn perturbations_keep_pins_and_twins_and_the_energy() {
        let scenery = Scenery::new(coincident, true).unwrap();
        let perturbed = scenery.perturbed(1, Some(TWINS), 1.0);
        let (x, start) = (&perturbed.state.x, &scenery.simulation.state.x);
        assert_eq!(x[TWINS.0], x[TWINS.1]);
        assert_eq!(x[0], start[0], "a pinned particle moved");
        assert!(x.iter().zip(start).filter(|(a, b)| a != b).count() > 100);
        let stiff = Scenery::new(|| hanging(1e12).spec(), true).unwrap();
        let perturbed = stiff.perturbed(1, None, 1.0);
        let stored = perturbed.system.potential_energy(&perturbed.state.x)
            - stiff.simulation.system.potential_energy(&stiff.simulation.state.x);
        assert!(stored > 0.0 && stored < 2e-3, "{stored}");
    }
}
