//! Pictures of the experiment `pictures`, drawn from its positions.

use super::facts::{Facts, METHODS, PAPER, REFERENCE, Scene, Shot, fall_share};
use drape_model::{Obstacle, Shape, Vec3};
use drape_render::{Camera, Colour, Font, Image, Subject, View, draw};
use drape_report::number::{significant, wrap};
use drape_report::page::{Table, absent};
use drape_report::plate::{Draw, Picture, Plate};

/// The input of the pictures.
pub(super) type Input = crate::studies::Input<Facts>;

pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "pictures-paper.png",
        title: "A table cloth and a hanging textile",
        caption: "(a)–(c) The table cloth falls, drapes over the square table and hangs in folds \
            at its corners; (d) the textile hangs stretched from two corners. The scenes of the \
            paper’s figure 4: 2704 particles, k/m = 10⁶ s⁻², soft shear and bending springs; 400 \
            particles, k/m = 10⁴ s⁻², after one second. The two sides of the cloth have two \
            colours.",
        draw: Draw::Picture(|input| paper(&input.facts).map(png)),
    },
    Plate {
        file: "pictures-methods.png",
        title: "All methods on the same sheet",
        caption: "Most explicit methods diverge within the first tenth of a second (named below); \
            of the others, some hang almost still and some bring the cloth down on time. A sheet \
            of 400 particles, k/m = 10⁶ s⁻², starts flat and hangs from two corners, h = 0.01 s, \
            default settings; a row for each method, a column for each time. The first row is the \
            reference, leapfrog with a fiftieth of that step.",
        draw: Draw::Picture(|input| methods(&input.facts).map(png)),
    },
];

/// Size of one of the paper's pictures, and the space between two, pixels.
const LARGE: [u32; 2] = [620, 500];
const GAP: u32 = 8;
/// Size of a picture of a method, pixels.
const SMALL: [u32; 2] = [150, 132];
/// Number of blocks beside each other into which the rows of methods are divided.
const BLOCKS: usize = 2;
const PAPER_VIEW: View = View { azimuth_deg: -62.0, elevation_deg: 24.0 };
/// The view of the methods' pictures. It looks along the fall, so that the sheet passes no other.
const METHODS_VIEW: View = View { azimuth_deg: 28.0, elevation_deg: 14.0 };

fn png(image: Image) -> Picture {
    image.png().map_err(Into::into)
}

/// Positions of a shot, m; `None` if it has no picture or does not fit its scene.
fn positions(shot: &Shot, scene: &Scene) -> Option<Vec<Vec3>> {
    let count = scene.rows as usize * scene.columns as usize;
    let x: Vec<Vec3> =
        shot.position_m.chunks_exact(3).map(|x| Vec3::new(x[0], x[1], x[2])).collect();
    (count > 0 && x.len() == count).then_some(x)
}

fn scene_of<'a>(facts: &'a Facts, shot: &Shot) -> Option<&'a Scene> {
    facts.scenes.iter().find(|scene| scene.id == shot.scene)
}

fn subject(scene: &Scene, x: &[Vec3]) -> Subject {
    let table = scene.table.as_ref().map(|table| {
        let half_extents = Vec3::from(table.size_m) * 0.5;
        Obstacle::from(Shape::Box { center: table.center_m.into(), half_extents })
    });
    Subject::grid(scene.rows, scene.columns, table.as_slice(), x)
}

fn aspect(size: [u32; 2]) -> f64 {
    f64::from(size[0]) / f64::from(size[1])
}

/// The paper's pictures in two columns.
fn paper(facts: &Facts) -> Option<Image> {
    let shots: Vec<&Shot> = facts.shots.iter().filter(|shot| shot.series == PAPER).collect();
    let mut images = Vec::new();
    for (letter, shot) in ('a'..).zip(&shots) {
        let scene = scene_of(facts, shot)?;
        let x = positions(shot, scene)?;
        let subject = subject(scene, &x);
        // All pictures of a scene have the same camera.
        let same = shots.iter().filter(|other| other.scene == shot.scene);
        let seen: Vec<Vec3> = same
            .filter_map(|other| Some(subject.points(&positions(other, scene)?)))
            .flatten()
            .collect();
        let camera = Camera::fit(PAPER_VIEW, &seen, aspect(LARGE));
        let mut image = draw(&subject, &x, &camera, LARGE);
        // A quick record has only one picture.
        let letter = if shots.len() > 1 { format!("({letter}) ") } else { String::new() };
        let label = format!("{letter}{}, t = {} s", shot.label, shot.time_s);
        image.write(&label, 14, LARGE[1] - Font::Medium.height() - 10, Font::Medium, Colour::INK);
        images.push(image);
    }
    let columns = images.len().min(2) as u32;
    let rows = (images.len() as u32).div_ceil(2);
    let extent = |count: u32, side: u32| count * (side + GAP) + GAP;
    (rows > 0).then(|| {
        let mut sheet = Image::new(extent(columns, LARGE[0]), extent(rows, LARGE[1]));
        for (n, image) in (0..).zip(&images) {
            let place = |n: u32, side: u32| GAP + n * (side + GAP);
            sheet.paste(image, place(n % 2, LARGE[0]), place(n / 2, LARGE[1]));
        }
        sheet
    })
}

/// A row of pictures for each method, in two blocks.
fn methods(facts: &Facts) -> Option<Image> {
    let shots: Vec<&Shot> = facts.shots.iter().filter(|shot| shot.series == METHODS).collect();
    let scene = scene_of(facts, shots.first()?)?;
    let mut labels: Vec<&str> = shots.iter().map(|shot| shot.label.as_str()).collect();
    labels.dedup();
    // A method without a picture has no row; its name is written below.
    let has_picture = |label: &str| {
        shots.iter().any(|shot| shot.label == label && positions(shot, scene).is_some())
    };
    let (labels, lost): (Vec<&str>, Vec<&str>) =
        labels.into_iter().partition(|label| has_picture(label));
    let mut times: Vec<f64> = shots.iter().map(|shot| shot.time_s).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    // The camera fits the first row, i.e. the reference, and the sheet at its release.
    let first: Vec<Vec3> = shots
        .iter()
        .filter(|shot| labels.first().is_some_and(|label| shot.label == *label))
        .filter_map(|shot| positions(shot, scene))
        .flatten()
        .collect();
    let subject = subject(scene, &first);
    let camera = Camera::fit(METHODS_VIEW, &first, aspect(SMALL));

    let rows = labels.len().div_ceil(BLOCKS) as u32;
    let title = Font::Small.height() + 4;
    let head = Font::Medium.height() + 14;
    let row_height = title + SMALL[1] + GAP;
    let block_width = times.len() as u32 * (SMALL[0] + 2) + 3 * GAP;
    let foot = match (lost.as_slice(), times.first()) {
        ([], _) | (_, None) => Vec::new(),
        (lost, Some(first)) => {
            let said = format!("Diverged before t = {first} s: {}.", lost.join(", "));
            let width = BLOCKS as u32 * block_width - 2 * GAP;
            wrap(&said, (width / Font::Medium.width("m")) as usize)
        }
    };
    let line = Font::Medium.height() + 6;
    let height = head + rows * row_height + GAP + foot.len() as u32 * line;
    let mut sheet = Image::new(BLOCKS as u32 * block_width, height);
    for (n, text) in (0..).zip(&foot) {
        sheet.write(text, GAP, head + rows * row_height + n * line, Font::Medium, Colour::INK);
    }
    for (n, label) in (0..).zip(&labels) {
        let (left, top) = (GAP + n / rows * block_width, head + n % rows * row_height);
        sheet.write(label, left, top, Font::Small, Colour::INK);
        for (column, time) in (0..).zip(&times) {
            let left = left + column * (SMALL[0] + 2);
            if n % rows == 0 {
                sheet.write(&format!("t = {time} s"), left, 8, Font::Small, Colour::GREY);
            }
            let Some(shot) = shots.iter().find(|s| s.label == *label && s.time_s == *time) else {
                continue;
            };
            let image = match (positions(shot, scene), shot.diverged_at_s) {
                (Some(x), _) => draw(&subject, &x, &camera, SMALL),
                (None, Some(time)) => Image::failure(SMALL, &format!("diverged at {time:.2} s")),
                (None, None) => Image::failure(SMALL, "no picture"),
            };
            sheet.paste(&image, left, top + title);
        }
    }
    Some(sheet)
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    vec![falls(&input.facts), shots(&input.facts)]
}

/// The table of falls. The method that has fallen farthest at the first time comes first.
fn falls(facts: &Facts) -> Table {
    let shots = || facts.shots.iter().filter(|s| s.series == METHODS && s.label != REFERENCE);
    let mut labels: Vec<&str> = shots().map(|shot| shot.label.as_str()).collect();
    labels.dedup();
    let mut times: Vec<f64> = shots().map(|shot| shot.time_s).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let shot = |label: &str, time: f64| shots().find(|s| s.label == label && s.time_s == time);
    let share = |label: &str| {
        let shot = times.first().and_then(|time| shot(label, *time));
        shot.and_then(|shot| fall_share(facts, shot)).unwrap_or(f64::NEG_INFINITY)
    };
    labels.sort_by(|a, b| share(b).total_cmp(&share(a)));
    let text = |shot: Option<&Shot>| match shot {
        Some(shot) if shot.diverged_at_s.is_some() => "✗".to_owned(),
        Some(shot) => {
            fall_share(facts, shot).map_or_else(absent, |share| significant(100.0 * share, 3))
        }
        None => absent(),
    };
    let line = |label: &&str| {
        let cells = times.iter().map(|time| text(shot(label, *time)));
        std::iter::once((*label).to_owned()).chain(cells).collect()
    };
    Table {
        title: "**Mean fall over that of the reference** (%), the farthest first. ✗ diverged."
            .to_owned(),
        header: std::iter::once("method".to_owned())
            .chain(times.iter().map(|time| format!("t = {time} s")))
            .collect(),
        names: 1,
        rows: labels.iter().map(line).collect(),
    }
}

/// The table of the times of each run's pictures, and of runs that ended before.
fn shots(facts: &Facts) -> Table {
    let row = |shot: &Shot| {
        let state = match shot.diverged_at_s {
            Some(time) if shot.position_m.is_empty() => format!("diverged at {time:.3} s"),
            _ => "completed".to_owned(),
        };
        vec![
            shot.scene.clone(),
            shot.label.clone(),
            shot.method.clone(),
            shot.step_s.to_string(),
            shot.time_s.to_string(),
            state,
        ]
    };
    Table {
        title: "**All pictures**".to_owned(),
        header: ["scene", "label", "method", "h (s)", "t (s)", "run"].map(str::to_owned).to_vec(),
        names: 3,
        rows: facts.shots.iter().map(row).collect(),
    }
}
