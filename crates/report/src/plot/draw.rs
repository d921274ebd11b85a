//! From a [`Sheet`] to the text of an SVG file.

use super::style::{FONT, FRAME, GRID, INK, MARKER, SMALL_MARKER, TITLE_FONT};
use super::{At, Bar, Fill, Look, Panel, Sheet, State};
use crate::number::{significant, wrap};
use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Failure = DrawingAreaErrorKind<std::io::Error>;
type Pixel = (i32, i32);

pub(super) const WIDTH: i32 = 1000;
pub(super) const MARGIN: i32 = 16;
pub(super) const LINE: i32 = 21;
/// Room between the edge of a panel's place and the label of its y axis.
const INSET: i32 = 8;
/// Plotters divides sizes by this factor when it writes SVG.
const SIZE_FACTOR: f64 = 1.24;
/// Generous width of a character of [`FONT`]: the reader's font is not known here.
pub(super) const CHARACTER: i32 = 9;
/// Dashes of rules, by the order in which the legend lists them.
const RULE_DASHES: [(i32, i32); 2] = [(12, 5), (2, 4)];

/// Two panels beside each other on a slim page, for panels with the same axes.
const DENSE_COLUMNS: usize = 2;
/// Width of a slim page.
pub(super) const SLIM: i32 = 680;
/// Size and line of the names above a dense panel, and the height of what it plots.
const SMALL_FONT: f64 = 14.0;
const SMALL_LINE: i32 = 18;
const DENSE_PLOT: i32 = 220;
/// Room left of a panel that has its vertical axis in common with its neighbour, and right of all.
const COMMON_AXIS: i32 = 10;
const RIGHT: i32 = 22;

/// Of more entries those of a row of panels stand below the row, if there are two panels in it.
const MOST_ENTRIES: usize = 16;

/// What a legend entry shows.
#[derive(Clone, Copy, PartialEq)]
enum Key {
    Series(Look, bool),
    Behind(Look),
    Rule(usize),
    Band,
    Fill(Fill),
    State(State),
}

/// How the panels of a sheet lie.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Layout {
    /// Two beside each other, or one where it is alone or has bars.
    Wide,
    /// Two beside each other with one vertical axis a row, below the legend.
    Dense,
}

/// Where a panel lies.
#[derive(Clone, Copy)]
struct Place {
    corner: Pixel,
    size: (i32, i32),
    /// Height of what stands above the axes.
    head: i32,
    /// Width of what stands left of the axes.
    side: i32,
    /// Whether the vertical axis has labels.
    has_labels: bool,
    /// Whether its neighbours are near.
    is_dense: bool,
}

/// Draws a sheet. `title` and `description` also go into the file's `<title>` and `<desc>`.
pub(super) fn svg(
    sheet: &Sheet,
    layout: Layout,
    title: &str,
    description: &str,
) -> Result<String, Failure> {
    let wide = sheet.panels.len() == 1 || sheet.panels.iter().any(|panel| !panel.bars.is_empty());
    let (page, columns) = match layout {
        Layout::Dense => (SLIM, DENSE_COLUMNS),
        Layout::Wide => (WIDTH, if wide { 1 } else { 2 }),
    };
    let letters = |most: i32| (most * page / WIDTH) as usize;
    let mut legend = Legend::of(sheet, letters(105));
    let title_lines = wrap(title, letters(88));
    let rows: Vec<&[Panel]> = sheet.panels.chunks(columns).collect();
    let is_near = layout == Layout::Wide && columns == 2 && legend.entries.len() > MOST_ENTRIES;
    let near: Vec<Vec<(Legend, i32, i32)>> =
        if is_near { legend.split(&rows) } else { rows.iter().map(|_| Vec::new()).collect() };
    let below = |legends: &[(Legend, i32, i32)]| {
        let heights = legends.iter().map(|(legend, _, width)| legend.entries_height(*width) + 14);
        heights.max().unwrap_or(0)
    };
    let heights: Vec<i32> = rows
        .iter()
        .zip(&near)
        .map(|(row, near)| row_height(row, layout, sheet.panels.len()) + below(near))
        .collect();
    let head = MARGIN + 26 * title_lines.len() as i32;
    let body: i32 = heights.iter().sum();
    // Entries have margins of their own, as in a box.
    let wide_page = page + 2 * MARGIN;
    let (above, foot) = match layout {
        Layout::Wide => (0, legend.height(page)),
        Layout::Dense => (legend.entries_height(wide_page) + MARGIN, legend.notes_height()),
    };
    let head = head + above;
    let height = head + body + foot + MARGIN;

    let mut text = String::new();
    {
        let root =
            SVGBackend::with_string(&mut text, (page as u32, height as u32)).into_drawing_area();
        root.fill(&WHITE)?;
        for (n, line) in title_lines.iter().enumerate() {
            let style = text_style(TITLE_FONT, FontStyle::Bold, INK, HPos::Left, VPos::Top);
            root.draw_text(line, &style, (MARGIN, MARGIN + 26 * n as i32))?;
        }
        if layout == Layout::Dense {
            legend.draw_entries(&root, (-MARGIN, head - above), wide_page)?;
        }
        let mut top = head;
        for ((row, row_height), near) in rows.iter().zip(&heights).zip(&near) {
            let plots = row_height - below(near);
            for (legend, left, width) in near {
                legend.draw_entries(&root, (*left, top + plots - 8), *width)?;
            }
            for (column, panel) in row.iter().enumerate() {
                let size = (page / columns as i32, plots);
                let place = match layout {
                    Layout::Wide => Place {
                        corner: (size.0 * column as i32, top),
                        size,
                        head: panel_head(panel),
                        side: side(panel),
                        has_labels: true,
                        is_dense: false,
                    },
                    Layout::Dense => dense_place(row, column, (page, top), plots),
                };
                draw_panel(&root, panel, &legend, place)?;
            }
            top += row_height;
        }
        match layout {
            Layout::Dense => legend.draw_notes(&root, (MARGIN, top), page - MARGIN)?,
            Layout::Wide => {
                let corners = [(MARGIN, top), (page - MARGIN, top + legend.height(page))];
                root.draw(&Rectangle::new(corners, GRID.stroke_width(1)))?;
                let below = legend.draw_entries(&root, (0, top), page)?;
                legend.write_notes(&root, (2 * MARGIN, below))?;
            }
        }
        root.present()?;
    }
    Ok(with_description(&text, title, description))
}

/// The place of a panel of which all in a row have plots of the same size and the axis of the
/// first.
fn dense_place(row: &[Panel], column: usize, (page, top): (i32, i32), height: i32) -> Place {
    let first = side(&row[0]);
    let others = DENSE_COLUMNS as i32 - 1;
    let plot = (page - INSET - first - others * COMMON_AXIS) / DENSE_COLUMNS as i32;
    let left = if column == 0 { 0 } else { INSET + first + plot };
    let left = left + (column.max(1) as i32 - 1) * (plot + COMMON_AXIS);
    let side = if column == 0 { first } else { COMMON_AXIS - INSET };
    Place {
        corner: (left, top),
        size: (INSET + side + plot, height),
        head: row.iter().map(panel_head).max().unwrap_or(0),
        side,
        has_labels: column == 0,
        is_dense: true,
    }
}

/// Height of title and names above a panel.
fn panel_head(panel: &Panel) -> i32 {
    10 + LINE * panel.title.len() as i32 + SMALL_LINE * panel.above.len() as i32
}

/// Room for labels and name of the vertical axis.
fn side(panel: &Panel) -> i32 {
    38 + CHARACTER * panel.y.tick_width() as i32
}

/// Adds role, title and description for readers who do not see the picture.
pub(super) fn with_description(svg: &str, title: &str, description: &str) -> String {
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let (open, rest) = svg.split_once('>').unwrap_or((svg, ""));
    format!(
        "{open} role=\"img\" aria-labelledby=\"title desc\">\n<title \
         id=\"title\">{}</title>\n<desc id=\"desc\">{}</desc>{rest}",
        escape(title),
        escape(description)
    )
}

fn row_height(row: &[Panel], layout: Layout, panels: usize) -> i32 {
    let head = row.iter().map(panel_head).max().unwrap_or(0);
    let bars = row.iter().map(|panel| panel.bars.len()).max().unwrap_or(0) as i32;
    let plot = match (layout, bars, panels) {
        (Layout::Dense, ..) => DENSE_PLOT,
        (_, 0, 1) => 430,
        (_, 0, 2) => 400,
        (_, 0, _) => 320,
        (_, bars, _) => 34 * bars + 80,
    };
    // Names on the y axis need a line each.
    let ticks = row.iter().map(|panel| panel.y.ticks.len()).max().unwrap_or(0) as i32;
    let least = if layout == Layout::Dense { 0 } else { LINE * ticks + 80 };
    head + plot.max(least)
}

pub(super) fn text_style(
    size: f64,
    weight: FontStyle,
    colour: RGBColor,
    horizontal: HPos,
    vertical: VPos,
) -> TextStyle<'static> {
    FontDesc::new(FontFamily::SansSerif, size * SIZE_FACTOR, weight)
        .color(&colour)
        .pos(Pos::new(horizontal, vertical))
}

pub(super) fn plain(horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    text_style(FONT, FontStyle::Normal, INK, horizontal, vertical)
}

/// Title, axes and contents of one panel.
fn draw_panel(
    root: &Area<'_>,
    panel: &Panel,
    legend: &Legend,
    place: Place,
) -> Result<(), Failure> {
    let ((left, top), (width, height)) = (place.corner, place.size);
    let title_style = plain(HPos::Left, VPos::Top);
    // A title stands above the axes, unless it needs the room to their left.
    let longest = panel.title.iter().map(|line| line.chars().count()).max().unwrap_or(0) as i32;
    let indent = (INSET + place.side).min((width - CHARACTER * longest - MARGIN).max(MARGIN));
    let indent = if place.is_dense { INSET + place.side } else { indent };
    for (n, line) in panel.title.iter().enumerate() {
        root.draw_text(line, &title_style, (left + indent, top + 6 + LINE * n as i32))?;
    }
    let small = text_style(SMALL_FONT, FontStyle::Normal, INK, HPos::Left, VPos::Top);
    // These lines stand on the axes.
    let first = top + place.head - 2 - SMALL_LINE * panel.above.len() as i32;
    for (n, line) in panel.above.iter().enumerate() {
        root.draw_text(line, &small, (left + INSET + place.side, first + SMALL_LINE * n as i32))?;
    }
    let area =
        root.clone().shrink((left, top + place.head), (width as u32, (height - place.head) as u32));
    let mut chart = ChartBuilder::on(&area)
        .margin_top(4)
        .margin_right(RIGHT)
        .margin_left(if place.has_labels { INSET } else { INSET + place.side })
        .margin_bottom(10)
        .x_label_area_size(52)
        .y_label_area_size(if place.has_labels { place.side } else { 0 })
        .build_cartesian_2d(panel.x.clone(), panel.y.clone())?;
    let mut mesh = chart.configure_mesh();
    if !panel.bars.is_empty() {
        mesh.disable_y_mesh();
    }
    mesh.bold_line_style(GRID.stroke_width(1))
        .light_line_style(TRANSPARENT)
        .axis_style(FRAME)
        .label_style(plain(HPos::Left, VPos::Top))
        .axis_desc_style(plain(HPos::Left, VPos::Top))
        .x_desc(panel.x.label.as_str())
        .y_desc(if place.has_labels { panel.y.label.as_str() } else { "" })
        .draw()?;

    let pixel = |x: f64, y: f64| chart.backend_coord(&(x, y));
    let ((x0, y1), (x1, y0)) = (pixel(panel.x.low, panel.y.low), pixel(panel.x.high, panel.y.high));
    if !place.has_labels {
        root.draw(&PathElement::new(vec![(x0, y0), (x0, y1)], FRAME.stroke_width(1)))?;
    }
    if let Some(gap) = panel.y.gap() {
        let y = pixel(panel.x.low, gap).1;
        draw_line(root, &[(x0, y), (x1, y)], (3, 6), FRAME.stroke_width(1))?;
    }
    for rule in &panel.rules {
        let ends = match rule.at {
            At::Y(value) => {
                let y = pixel(panel.x.low, panel.y.position(value)).1;
                [(x0, y), (x1, y)]
            }
            At::Below(value) => {
                let y = pixel(panel.x.low, panel.y.position(value)).1;
                root.draw(&Rectangle::new([(x0, y), (x1, y1)], GRID.filled()))?;
                continue;
            }
            At::X(value) => {
                let x = pixel(panel.x.position(value), panel.y.low).0;
                [(x, y0), (x, y1)]
            }
            At::Slope { order, x, y } => {
                let (from, height) = (panel.x.position(x), panel.y.position(y));
                // Where the line leaves the panel at the bottom or top, or at its sides before
                // that.
                let end = |limit: f64| {
                    let x = from + (limit - height) / order;
                    let x = x.clamp(panel.x.low, panel.x.high);
                    pixel(x, height + order * (x - from))
                };
                [end(panel.y.low), end(panel.y.high)]
            }
        };
        draw_line(root, &ends, RULE_DASHES[legend.rule(&rule.label) % 2], INK.stroke_width(2))?;
    }
    for bar in &panel.bars {
        let shrink = (bar.reach / bar.longest_side()).min(1.0);
        draw_bar(root, bar, |x, y| pixel(x * shrink, y))?;
    }
    let at = |p: &super::Point| pixel(panel.x.position(p.x), panel.y.position(p.y));
    for series in panel.series.iter().filter(|series| series.is_behind) {
        let path: Vec<Pixel> = series.points.iter().map(at).collect();
        draw_line(root, &path, series.look.dashes(), behind(series.look))?;
        for point in path {
            draw_marker(root, point, series.look, State::Stable, SMALL_MARKER)?;
        }
    }
    let own: Vec<_> = panel.series.iter().filter(|series| !series.is_behind).collect();
    for series in own.iter().filter(|series| series.is_joined) {
        let path: Vec<Pixel> = series.points.iter().map(at).collect();
        draw_line(root, &path, series.look.dashes(), series.look.colour().stroke_width(2))?;
    }
    for (n, series) in own.iter().enumerate() {
        // Smaller and smaller, so that none hides the ones it coincides with.
        let size = MARKER * (1.25 - 0.15 * n.min(3) as f64);
        // Where curves coincide, the markers of each stand between those of the others.
        let offset = n * series.stride / own.len();
        for (k, point) in series.points.iter().enumerate() {
            if k % series.stride == offset || point.state != State::Stable {
                draw_marker(root, at(point), series.look, point.state, size)?;
            }
        }
    }
    Ok(())
}

/// The stroke of a line behind the others.
fn behind(look: Look) -> ShapeStyle {
    look.colour().stroke_width(if look == Look::GREY { 1 } else { 2 })
}

fn draw_line(
    root: &Area<'_>,
    path: &[Pixel],
    (dash, gap): (i32, i32),
    style: ShapeStyle,
) -> Result<(), Failure> {
    if path.len() < 2 {
        return Ok(());
    }
    if gap == 0 {
        root.draw(&PathElement::new(path.to_vec(), style))
    } else {
        root.draw(&DashedPathElement::new(path.iter().copied(), dash, gap, style))
    }
}

fn draw_marker(
    root: &Area<'_>,
    at: Pixel,
    look: Look,
    state: State,
    size: f64,
) -> Result<(), Failure> {
    let outline: Vec<Pixel> = look.outline(size).map(|(x, y)| (at.0 + x, at.1 + y)).collect();
    let inside = if state == State::Stable { look.colour() } else { WHITE };
    root.draw(&Polygon::new(outline.clone(), inside.filled()))?;
    let ring = outline.iter().chain(outline.first()).copied().collect::<Vec<_>>();
    root.draw(&PathElement::new(ring, look.colour().stroke_width(2)))?;
    let scale = |tenths: i32| libm::round(f64::from(tenths) * size / 10.0) as i32;
    for stroke in look.inlay() {
        let stroke = stroke.map(|(x, y)| (at.0 + scale(x), at.1 + scale(y))).to_vec();
        let ink = if state == State::Stable { look.contrast() } else { look.colour() };
        root.draw(&PathElement::new(stroke, ink.stroke_width(2)))?;
    }
    if state == State::Failed {
        let r = size as i32 + 3;
        for rise in [-r, r] {
            let stroke = vec![(at.0 - r, at.1 - rise), (at.0 + r, at.1 + rise)];
            root.draw(&PathElement::new(stroke, INK.stroke_width(2)))?;
        }
    }
    Ok(())
}

fn draw_bar(root: &Area<'_>, bar: &Bar, pixel: impl Fn(f64, f64) -> Pixel) -> Result<(), Failure> {
    let (mut left, mut right) = (0.0, 0.0);
    for (_, fill, length) in &bar.parts {
        let (start, end) = if *length < 0.0 {
            left += length;
            (left, left - length)
        } else {
            right += length;
            (right - length, right)
        };
        let (low, high) = (pixel(start, bar.y + 0.32), pixel(end, bar.y - 0.32));
        if high.0 == low.0 {
            continue; // thinner than a line
        }
        draw_fill(root, low, high, *fill)?;
        let text = format!("{length:.0} %").replace('-', "−");
        if high.0 - low.0 < CHARACTER * text.chars().count() as i32 + 4 {
            continue;
        }
        let middle = ((low.0 + high.0) / 2, (low.1 + high.1) / 2);
        let half = 4 * text.chars().count() as i32 + 3;
        let colour = if *fill == Fill::Dark { WHITE } else { INK };
        if !matches!(fill, Fill::Dark | Fill::Light) {
            let corners = [(middle.0 - half, middle.1 - 9), (middle.0 + half, middle.1 + 9)];
            root.draw(&Rectangle::new(corners, fill.colour().filled()))?;
        }
        let style = text_style(14.0, FontStyle::Normal, colour, HPos::Center, VPos::Center);
        root.draw_text(&text, &style, middle)?;
    }
    let (x, y) = pixel(right, bar.y);
    root.draw_text(&bar.end, &plain(HPos::Left, VPos::Center), (x + 8, y))
}

fn draw_fill(root: &Area<'_>, low: Pixel, high: Pixel, fill: Fill) -> Result<(), Failure> {
    root.draw(&Rectangle::new([low, high], fill.colour().filled()))?;
    if matches!(fill, Fill::Hatched | Fill::Crossed) {
        let rise = high.1 - low.1;
        for foot in (low.0 - rise..high.0).step_by(7).map(|x| x + 3) {
            // From (foot, bottom) up to the right, cut at the sides.
            let (from, to) = (foot.max(low.0), (foot + rise).min(high.0));
            if from < to {
                let stroke = vec![(from, high.1 - (from - foot)), (to, high.1 - (to - foot))];
                root.draw(&PathElement::new(stroke, INK.stroke_width(1)))?;
                if fill == Fill::Crossed {
                    let stroke = vec![(from, low.1 + (from - foot)), (to, low.1 + (to - foot))];
                    root.draw(&PathElement::new(stroke, INK.stroke_width(1)))?;
                }
            }
        }
    }
    if fill == Fill::Upright {
        for x in (low.0 + 3..high.0).step_by(6) {
            root.draw(&PathElement::new(vec![(x, low.1), (x, high.1)], INK.stroke_width(1)))?;
        }
    }
    root.draw(&Rectangle::new([low, high], INK.stroke_width(1)))
}

/// The entries that belong to all panels, placed in rows.
struct Legend {
    entries: Vec<(Key, String)>,
    rules: Vec<String>,
    notes: Vec<String>,
}

impl Legend {
    const SYMBOL: i32 = 48;
    const ROW: i32 = 26;

    /// `letters` is the length of a line of the notes.
    fn of(sheet: &Sheet, letters: usize) -> Self {
        let mut entries: Vec<(Key, String)> = Vec::new();
        let mut rules: Vec<String> = Vec::new();
        let mut add = |key: Key, label: &str| {
            if !entries.iter().any(|(_, known)| known == label) {
                entries.push((key, label.to_owned()));
            }
        };
        let panels = || sheet.panels.iter();
        let series = || panels().flat_map(|panel| &panel.series);
        for series in series().filter(|series| !series.is_behind) {
            add(Key::Series(series.look, series.is_joined), &series.label);
        }
        for series in series().filter(|series| series.is_behind) {
            add(Key::Behind(series.look), &series.label);
        }
        for (label, fill, _) in panels().flat_map(|panel| &panel.bars).flat_map(|bar| &bar.parts) {
            add(Key::Fill(*fill), label);
        }
        for rule in panels().flat_map(|panel| &panel.rules) {
            if matches!(rule.at, At::Below(_)) {
                add(Key::Band, &rule.label);
            } else if !rules.contains(&rule.label) {
                add(Key::Rule(rules.len()), &rule.label);
                rules.push(rule.label.clone());
            }
        }
        let points = || panels().flat_map(|panel| &panel.series).flat_map(|series| &series.points);
        for (state, label) in [
            (State::Marginal, "run was marginal"),
            (State::Flawed, "run gained energy or hardly moved"),
            (State::Failed, "run was unstable or diverged"),
        ] {
            if points().any(|point| point.state == state) {
                add(Key::State(state), label);
            }
        }
        let mut notes = sheet.notes.clone();
        if panels().any(|panel| panel.y.gap().is_some()) {
            notes.push("Points below the dotted break are 0.".to_owned());
        }
        notes.extend(beyond_the_axis(sheet));
        Self { entries, rules, notes: notes.iter().flat_map(|note| wrap(note, letters)).collect() }
    }

    /// Takes out the entries of curves that are not in all rows, and returns them as legends of
    /// the rows, each with its left edge and width: one a row where its panels have curves in
    /// common, else one below each panel.
    fn split(&mut self, rows: &[&[Panel]]) -> Vec<Vec<(Self, i32, i32)>> {
        let has = |panels: &[Panel], label: &str| {
            panels.iter().flat_map(|panel| &panel.series).any(|series| series.label == label)
        };
        let is_common =
            |label: &str| rows.len() > 1 && rows.iter().all(|panels| has(panels, label));
        let (own, common): (Vec<_>, Vec<_>) = self.entries.drain(..).partition(|(key, label)| {
            matches!(key, Key::Series(..) | Key::Behind(_)) && !is_common(label)
        });
        self.entries = common;
        let of = |panels: &[Panel]| Self {
            entries: own.iter().filter(|(_, label)| has(panels, label)).cloned().collect(),
            rules: Vec::new(),
            notes: Vec::new(),
        };
        let legends = |row: &&[Panel]| match row {
            [first, second] => {
                let is_apart =
                    !own.iter().any(|(_, label)| has(&row[..1], label) && has(&row[1..], label));
                if is_apart && !first.series.is_empty() && !second.series.is_empty() {
                    let half = WIDTH / 2;
                    vec![(of(&row[..1]), 0, half), (of(&row[1..]), half, half)]
                } else {
                    vec![(of(row), 0, WIDTH)]
                }
            }
            [_] => vec![(of(row), 0, WIDTH / 2)],
            _ => vec![(of(row), 0, WIDTH)],
        };
        rows.iter().map(legends).collect()
    }

    fn rule(&self, label: &str) -> usize {
        self.rules.iter().position(|known| known == label).unwrap_or(0)
    }

    /// Left edge and row of each entry in a box of this width: columns of equal width, as many as
    /// the widest entry allows.
    fn places(&self, width: i32) -> Vec<(i32, i32)> {
        let widest = self.entries.iter().map(|(_, text)| text.chars().count()).max().unwrap_or(0);
        let room = width - 4 * MARGIN;
        let columns = (room / (Self::SYMBOL + CHARACTER * widest as i32 + 16)).max(1);
        let columns = columns.min(self.entries.len().max(1) as i32);
        (0..self.entries.len() as i32)
            .map(|n| (2 * MARGIN + room / columns * (n % columns), n / columns))
            .collect()
    }

    fn entries_height(&self, width: i32) -> i32 {
        let rows = self.places(width).last().map_or(0, |(_, row)| row + 1);
        Self::ROW * rows
    }

    fn height(&self, width: i32) -> i32 {
        14 + self.entries_height(width) + LINE * self.notes.len() as i32
    }

    /// Height of a box that holds the notes alone.
    fn notes_height(&self) -> i32 {
        if self.notes.is_empty() { 0 } else { 14 + LINE * self.notes.len() as i32 }
    }

    /// The notes in a box of their own, up to `right`.
    fn draw_notes(&self, root: &Area<'_>, (x, y): Pixel, right: i32) -> Result<(), Failure> {
        if self.notes.is_empty() {
            return Ok(());
        }
        let corners = [(x, y), (right, y + self.notes_height())];
        root.draw(&Rectangle::new(corners, GRID.stroke_width(1)))?;
        self.write_notes(root, (x + MARGIN, y + 10))
    }

    fn write_notes(&self, root: &Area<'_>, (x, y): Pixel) -> Result<(), Failure> {
        for (n, note) in self.notes.iter().enumerate() {
            root.draw_text(note, &plain(HPos::Left, VPos::Top), (x, y + LINE * n as i32))?;
        }
        Ok(())
    }

    /// The entries in a box of this width; returns where notes go on.
    fn draw_entries(&self, root: &Area<'_>, (x, top): Pixel, width: i32) -> Result<i32, Failure> {
        let places = self.places(width);
        for ((key, label), (left, row)) in self.entries.iter().zip(&places) {
            let left = x + left;
            let y = top + 7 + Self::ROW * row + Self::ROW / 2;
            let (from, middle, to) = ((left, y), (left + 20, y), (left + 40, y));
            match *key {
                Key::Series(look, is_joined) => {
                    if is_joined {
                        draw_line(root, &[from, to], look.dashes(), look.colour().stroke_width(2))?;
                    }
                    draw_marker(root, middle, look, State::Stable, MARKER)?;
                }
                Key::Behind(look) => {
                    draw_line(root, &[from, to], look.dashes(), behind(look))?;
                    draw_marker(root, middle, look, State::Stable, SMALL_MARKER)?;
                }
                Key::Rule(n) => {
                    draw_line(root, &[from, to], RULE_DASHES[n % 2], INK.stroke_width(2))?;
                }
                Key::Band => {
                    let corners = [(from.0, y - 9), (to.0, y + 9)];
                    root.draw(&Rectangle::new(corners, GRID.filled()))?;
                }
                Key::Fill(fill) => draw_fill(root, (from.0, y - 9), (to.0, y + 9), fill)?,
                Key::State(state) => {
                    draw_marker(root, middle, Look::of_method(0, 0).in_ink(), state, MARKER)?;
                }
            }
            root.draw_text(label, &plain(HPos::Left, VPos::Center), (left + Self::SYMBOL, y))?;
        }
        Ok(top + 10 + self.entries_height(width))
    }
}

/// Values that were moved to the edge of their panel, spelt out.
fn beyond_the_axis(sheet: &Sheet) -> Option<String> {
    let mut values: Vec<String> = Vec::new();
    for panel in &sheet.panels {
        for series in &panel.series {
            let beyond = series.points.iter().filter(|point| !panel.y.holds(point.y));
            values.extend(beyond.map(|p| format!("{} ({})", significant(p.y, 3), series.label)));
        }
    }
    (!values.is_empty())
        .then(|| format!("On the edge of a panel, beyond its axis: {}.", values.join(", ")))
}
