//! From a [`Sheet`] to the text of an SVG file.

use super::style::{FONT, FRAME, GRID, INK, MARKER, TITLE_FONT};
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

/// What a legend entry shows.
#[derive(Clone, Copy, PartialEq)]
enum Key {
    Series(Look, bool),
    Rule(usize),
    Band,
    Fill(Fill),
    State(State),
}

/// Draws a sheet. `title` and `description` also go into the file's `<title>` and `<desc>`.
pub(super) fn svg(sheet: &Sheet, title: &str, description: &str) -> Result<String, Failure> {
    let legend = Legend::of(sheet);
    let title_lines = wrap(title, 88);
    let wide = sheet.panels.len() == 1 || sheet.panels.iter().any(|panel| !panel.bars.is_empty());
    let columns = if wide { 1 } else { 2 };
    let rows: Vec<&[Panel]> = sheet.panels.chunks(columns).collect();
    let heights: Vec<i32> = rows.iter().map(|row| row_height(row, sheet.panels.len())).collect();
    let head = MARGIN + 26 * title_lines.len() as i32;
    let body: i32 = heights.iter().sum();
    let height = head + body + legend.height() + MARGIN;

    let mut text = String::new();
    {
        let root =
            SVGBackend::with_string(&mut text, (WIDTH as u32, height as u32)).into_drawing_area();
        root.fill(&WHITE)?;
        for (n, line) in title_lines.iter().enumerate() {
            let style = text_style(TITLE_FONT, FontStyle::Bold, INK, HPos::Left, VPos::Top);
            root.draw_text(line, &style, (MARGIN, MARGIN + 26 * n as i32))?;
        }
        let mut top = head;
        for (row, row_height) in rows.iter().zip(&heights) {
            let width = WIDTH / columns as i32;
            for (column, panel) in row.iter().enumerate() {
                draw_panel(
                    &root,
                    panel,
                    &legend,
                    (width * column as i32, top),
                    (width, *row_height),
                )?;
            }
            top += row_height;
        }
        legend.draw(&root, top)?;
        root.present()?;
    }
    Ok(with_description(&text, title, description))
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

fn row_height(row: &[Panel], panels: usize) -> i32 {
    let title = row.iter().map(|panel| panel.title.len()).max().unwrap_or(0) as i32;
    let bars = row.iter().map(|panel| panel.bars.len()).max().unwrap_or(0) as i32;
    let plot = match (bars, panels) {
        (0, 1) => 430,
        (0, 2) => 400,
        (0, _) => 320,
        (bars, _) => 34 * bars + 80,
    };
    // Names on the y axis need a line each.
    let ticks = row.iter().map(|panel| panel.y.ticks.len()).max().unwrap_or(0) as i32;
    let plot = plot.max(LINE * ticks + 80);
    10 + LINE * title + plot
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

/// Title, axes and contents of one panel whose upper left corner is `corner`.
fn draw_panel(
    root: &Area<'_>,
    panel: &Panel,
    legend: &Legend,
    corner: Pixel,
    (width, height): (i32, i32),
) -> Result<(), Failure> {
    let (left, top) = corner;
    let y_area = 38 + CHARACTER * panel.y.tick_width() as i32;
    let title_style = plain(HPos::Left, VPos::Top);
    // A title stands above the axes, unless it needs the room to their left.
    let longest = panel.title.iter().map(|line| line.chars().count()).max().unwrap_or(0) as i32;
    let indent = (INSET + y_area).min((width - CHARACTER * longest - MARGIN).max(MARGIN));
    for (n, line) in panel.title.iter().enumerate() {
        root.draw_text(line, &title_style, (left + indent, top + 6 + LINE * n as i32))?;
    }
    let title_height = 10 + LINE * panel.title.len() as i32;
    let area = root
        .clone()
        .shrink((left, top + title_height), (width as u32, (height - title_height) as u32));
    let mut chart = ChartBuilder::on(&area)
        .margin_top(4)
        .margin_right(22)
        .margin_left(INSET)
        .margin_bottom(10)
        .x_label_area_size(52)
        .y_label_area_size(y_area)
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
        .y_desc(panel.y.label.as_str())
        .draw()?;

    let pixel = |x: f64, y: f64| chart.backend_coord(&(x, y));
    let ((x0, y1), (x1, y0)) = (pixel(panel.x.low, panel.y.low), pixel(panel.x.high, panel.y.high));
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
    let place = |p: &super::Point| pixel(panel.x.position(p.x), panel.y.position(p.y));
    for series in panel.series.iter().filter(|series| series.is_joined) {
        let path: Vec<Pixel> = series.points.iter().map(place).collect();
        draw_line(root, &path, series.look.dashes(), series.look.colour().stroke_width(2))?;
    }
    for (n, series) in panel.series.iter().enumerate() {
        // Smaller and smaller, so that none hides the ones it coincides with.
        let size = MARKER * (1.25 - 0.15 * n.min(3) as f64);
        // Where curves coincide, the markers of each stand between those of the others.
        let offset = n * series.stride / panel.series.len();
        for (k, point) in series.points.iter().enumerate() {
            if k % series.stride == offset || point.state != State::Stable {
                draw_marker(root, place(point), series.look, point.state, size)?;
            }
        }
    }
    Ok(())
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

    fn of(sheet: &Sheet) -> Self {
        let mut entries: Vec<(Key, String)> = Vec::new();
        let mut rules: Vec<String> = Vec::new();
        let mut add = |key: Key, label: &str| {
            if !entries.iter().any(|(_, known)| known == label) {
                entries.push((key, label.to_owned()));
            }
        };
        let panels = || sheet.panels.iter();
        for series in panels().flat_map(|panel| &panel.series) {
            add(Key::Series(series.look, series.is_joined), &series.label);
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
        for (state, label) in
            [(State::Marginal, "run was marginal"), (State::Failed, "run was unstable or diverged")]
        {
            if points().any(|point| point.state == state) {
                add(Key::State(state), label);
            }
        }
        let mut notes = sheet.notes.clone();
        if panels().any(|panel| panel.y.gap().is_some()) {
            notes.push("0, below the dotted break: no CG iteration.".to_owned());
        }
        notes.extend(beyond_the_axis(sheet));
        Self { entries, rules, notes: notes.iter().flat_map(|note| wrap(note, 105)).collect() }
    }

    fn rule(&self, label: &str) -> usize {
        self.rules.iter().position(|known| known == label).unwrap_or(0)
    }

    /// Left edge and row of each entry: columns of equal width, as many as the widest entry allows.
    fn places(&self) -> Vec<(i32, i32)> {
        let widest = self.entries.iter().map(|(_, text)| text.chars().count()).max().unwrap_or(0);
        let room = WIDTH - 4 * MARGIN;
        let columns = (room / (Self::SYMBOL + CHARACTER * widest as i32 + 16)).max(1);
        let columns = columns.min(self.entries.len().max(1) as i32);
        (0..self.entries.len() as i32)
            .map(|n| (2 * MARGIN + room / columns * (n % columns), n / columns))
            .collect()
    }

    fn height(&self) -> i32 {
        let rows = self.places().last().map_or(0, |(_, row)| row + 1);
        14 + Self::ROW * rows + LINE * self.notes.len() as i32
    }

    fn draw(&self, root: &Area<'_>, top: i32) -> Result<(), Failure> {
        let corners = [(MARGIN, top), (WIDTH - MARGIN, top + self.height())];
        root.draw(&Rectangle::new(corners, GRID.stroke_width(1)))?;
        let places = self.places();
        for ((key, label), (left, row)) in self.entries.iter().zip(&places) {
            let y = top + 7 + Self::ROW * row + Self::ROW / 2;
            let (from, middle, to) = ((*left, y), (left + 20, y), (left + 40, y));
            match *key {
                Key::Series(look, is_joined) => {
                    if is_joined {
                        draw_line(root, &[from, to], look.dashes(), look.colour().stroke_width(2))?;
                    }
                    draw_marker(root, middle, look, State::Stable, MARKER)?;
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
                    draw_marker(root, middle, Look::number(0).in_ink(), state, MARKER)?;
                }
            }
            root.draw_text(label, &plain(HPos::Left, VPos::Center), (left + Self::SYMBOL, y))?;
        }
        let rows = places.last().map_or(0, |(_, row)| row + 1);
        for (n, note) in self.notes.iter().enumerate() {
            let y = top + 10 + Self::ROW * rows + LINE * n as i32;
            root.draw_text(note, &plain(HPos::Left, VPos::Top), (2 * MARGIN, y))?;
        }
        Ok(())
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
