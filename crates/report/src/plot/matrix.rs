//! A table of coloured tiles with a letter in each: verdicts of rows × columns.

use super::draw::{
    Area, CHARACTER, Failure, LINE, MARGIN, SLIM, WIDTH, plain, text_style, with_description,
};
use super::style::{FONT, FRAME, GRID, INK, TITLE_FONT};
use crate::number::wrap;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Rows and columns of tiles, with a legend below them.
pub struct Matrix {
    /// Names above the columns, written upwards where they are longer than a column is wide.
    pub columns: Vec<String>,
    /// The rows, from the top.
    pub rows: Vec<Row>,
    /// Meaning of the tiles.
    pub legend: Vec<(Tile, String)>,
    /// Sentences below the legend.
    pub notes: Vec<String>,
}

/// One row.
pub struct Row {
    /// Name before the row.
    pub label: String,
    /// Whether a line separates the row from the row above.
    pub is_first: bool,
    /// For each column the tiles side by side; empty if the column has none.
    pub tiles: Vec<Vec<Tile>>,
}

/// A coloured rectangle with a letter.
#[derive(Clone, PartialEq)]
pub struct Tile {
    /// Its colour.
    pub shade: Shade,
    /// The letter in it, or a few words; in two lines with a line break between them.
    pub text: String,
    /// Whether it has a thick frame.
    pub is_marked: bool,
}

/// Colour of a tile, from good to bad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shade {
    /// Correct result.
    Good,
    /// Nearly correct result.
    Fair,
    /// Wrong result.
    Bad,
    /// Worst possible result.
    Worst,
    /// No verdict: the result could not be determined.
    Open,
    /// Not applicable.
    Idle,
    /// Nothing goes wrong because nothing moves.
    Still,
    /// Several are as good: no colour, a thin frame.
    Tie,
}

impl Shade {
    /// Lighter than the colours of curves, so that letters can be read on them.
    fn colour(self) -> RGBColor {
        match self {
            Self::Good => RGBColor(0xa6, 0xdc, 0xc6),
            Self::Fair => RGBColor(0xfb, 0xdf, 0x8c),
            Self::Bad => RGBColor(0xee, 0x9b, 0x66),
            Self::Worst => RGBColor(0x8c, 0x2d, 0x04),
            Self::Open => RGBColor(0xbf, 0xdd, 0xf3),
            Self::Idle => RGBColor(0xf2, 0xf2, 0xf2),
            Self::Still => RGBColor(0xc9, 0xb8, 0xdc),
            Self::Tie => WHITE,
        }
    }

    fn ink(self) -> RGBColor {
        if self == Self::Worst { WHITE } else { INK }
    }
}

/// Least and greatest height of a row. Few rows are drawn higher.
const ROW: std::ops::RangeInclusive<i32> = 25..=48;
/// Height of a row whose tiles have two lines.
const TWO_LINES: i32 = 42;
/// Least size of a letter in a tile, over the usual one.
const LEAST_SHARE: f64 = 0.7;
/// A letter in a tile is no smaller than this where it fits, px.
const LEAST_FONT: f64 = 14.0;
/// Mean width of a character, over its size.
const EM: f64 = 0.56;
/// Height that a table should have.
const HEIGHT: i32 = 560;
/// Side of a tile in the legend.
const SAMPLE: i32 = 20;
/// Characters here are known to be mostly narrow: a little less than in legends of curves.
const NARROW: i32 = CHARACTER - 1;

/// Height of a label above a row.
const LABEL: i32 = 26;

/// Where the labels of the rows stand.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Labels {
    /// Left of the tiles.
    Beside,
    /// Above the tiles, on a slim page.
    Above,
}

/// Draws a table. `title` and `description` also go into the file's `<title>` and `<desc>`.
pub(super) fn svg(
    matrix: &Matrix,
    labels: Labels,
    title: &str,
    description: &str,
) -> Result<String, Failure> {
    let longest = |texts: &mut dyn Iterator<Item = &String>| {
        texts.map(|text| text.chars().count() as i32).max().unwrap_or(0)
    };
    let beside = NARROW * longest(&mut matrix.rows.iter().map(|row| &row.label)) + 18;
    let (page, left, label) = match labels {
        Labels::Beside => (WIDTH, MARGIN + beside, 0),
        Labels::Above => (SLIM, MARGIN, LABEL),
    };
    let letters = |most: i32| (most * page / WIDTH) as usize;
    let title_lines = wrap(title, letters(88));
    let notes: Vec<String> =
        matrix.notes.iter().flat_map(|note| wrap(note, letters(105))).collect();
    let width = (page - MARGIN - left) / (matrix.columns.len() as i32).max(1);
    let widest = NARROW * longest(&mut matrix.columns.iter());
    let is_upwards = widest > width;
    let heading = if is_upwards { widest + 14 } else { LINE + 10 };
    let top = MARGIN + 26 * title_lines.len() as i32 + heading;
    let legend_columns = {
        let widest = longest(&mut matrix.legend.iter().map(|(_, text)| text));
        ((page - 4 * MARGIN) / (SAMPLE + 24 + CHARACTER * widest)).max(1)
    };
    let legend_rows = (matrix.legend.len() as i32 + legend_columns - 1) / legend_columns;
    let legend_height = 14 + 26 * legend_rows + LINE * notes.len() as i32;
    let count = matrix.rows.len() as i32;
    let others = top + 14 + legend_height + MARGIN;
    let is_broken = matrix.rows.iter().flat_map(|row| &row.tiles).any(|tiles| {
        let room = (width - 3) / (tiles.len() as i32).max(1);
        tiles.iter().any(|tile| tile.text.contains('\n') || width_of(&tile.text) > room)
    });
    let least = if is_broken { TWO_LINES } else { *ROW.start() };
    let tile_height = ((HEIGHT - others) / count.max(1) - label).clamp(least, *ROW.end());
    let row_height = label + tile_height;
    let foot = top + row_height * count + 14;
    let height = foot + legend_height + MARGIN;

    let mut text = String::new();
    {
        let root =
            SVGBackend::with_string(&mut text, (page as u32, height as u32)).into_drawing_area();
        root.fill(&WHITE)?;
        for (n, line) in title_lines.iter().enumerate() {
            let style = text_style(TITLE_FONT, FontStyle::Bold, INK, HPos::Left, VPos::Top);
            root.draw_text(line, &style, (MARGIN, MARGIN + 26 * n as i32))?;
        }
        let style = if is_upwards {
            plain(HPos::Left, VPos::Center).transform(FontTransform::Rotate270)
        } else {
            plain(HPos::Center, VPos::Bottom)
        };
        for (n, name) in matrix.columns.iter().enumerate() {
            let x = left + width * n as i32 + width / 2;
            root.draw_text(name, &style, (x, top - 6))?;
        }
        for (n, row) in matrix.rows.iter().enumerate() {
            let y = top + row_height * n as i32;
            if row.is_first {
                let line =
                    vec![(MARGIN, y - 1), (left + width * matrix.columns.len() as i32, y - 1)];
                root.draw(&PathElement::new(line, GRID.stroke_width(1)))?;
            }
            let middle = match labels {
                Labels::Beside => y + tile_height / 2,
                Labels::Above => y + LABEL / 2 + 2,
            };
            root.draw_text(&row.label, &plain(HPos::Left, VPos::Center), (MARGIN, middle))?;
            draw_row(&root, &row.tiles, (left, y + label), (width, tile_height))?;
        }
        let corners = [(MARGIN, foot), (page - MARGIN, foot + legend_height)];
        root.draw(&Rectangle::new(corners, GRID.stroke_width(1)))?;
        for (n, (tile, label)) in matrix.legend.iter().enumerate() {
            let (column, row) = (n as i32 % legend_columns, n as i32 / legend_columns);
            let x = 2 * MARGIN + (page - 4 * MARGIN) / legend_columns * column;
            let y = foot + 8 + 26 * row;
            draw_tile(&root, tile, (x, y), (SAMPLE, SAMPLE))?;
            let place = (x + SAMPLE + 8, y + SAMPLE / 2);
            root.draw_text(label, &plain(HPos::Left, VPos::Center), place)?;
        }
        for (n, note) in notes.iter().enumerate() {
            let y = foot + 10 + 26 * legend_rows + LINE * n as i32;
            root.draw_text(note, &plain(HPos::Left, VPos::Top), (2 * MARGIN, y))?;
        }
        root.present()?;
    }
    Ok(with_description(&text, title, description))
}

/// The tiles of a row whose upper left corner is `(left, top)`; `width` is that of a column.
fn draw_row(
    root: &Area<'_>,
    columns: &[Vec<Tile>],
    (left, top): (i32, i32),
    (width, height): (i32, i32),
) -> Result<(), Failure> {
    for (n, tiles) in columns.iter().enumerate() {
        let each = (width - 3) / (tiles.len() as i32).max(1);
        for (m, tile) in tiles.iter().enumerate() {
            let x = left + width * n as i32 + each * m as i32;
            draw_tile(root, tile, (x, top + 1), (each - 1, height - 3))?;
        }
    }
    Ok(())
}

pub(super) fn draw_tile(
    root: &Area<'_>,
    tile: &Tile,
    (left, top): (i32, i32),
    (width, height): (i32, i32),
) -> Result<(), Failure> {
    let corners = [(left, top), (left + width, top + height)];
    root.draw(&Rectangle::new(corners, tile.shade.colour().filled()))?;
    if tile.shade == Shade::Tie {
        root.draw(&Rectangle::new(corners, FRAME.stroke_width(1)))?;
    }
    if tile.is_marked {
        let (right, bottom) = (left + width - 1, top + height - 1);
        let (left, top) = (left + 1, top + 1);
        let ring = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        root.draw(&PathElement::new(ring, INK.stroke_width(2)))?;
    }
    let lines = match tile.text.rsplit_once(' ') {
        _ if tile.text.contains('\n') => tile.text.lines().collect(),
        Some((name, rest)) if width_of(&tile.text) > width && height >= TWO_LINES - 3 => {
            vec![name, rest]
        }
        _ => vec![tile.text.as_str()],
    };
    let middle = top + height / 2 - LINE / 2 * (lines.len() as i32 - 1);
    for (n, line) in lines.into_iter().enumerate() {
        // Where a name alone is too long it is written smaller.
        let share = f64::from(width) / f64::from(width_of(line).max(1));
        let fitting = f64::from(width) / (EM * line.chars().count().max(1) as f64);
        let size = (FONT * share.clamp(LEAST_SHARE, 1.0)).max(fitting.min(LEAST_FONT));
        let ink = tile.shade.ink();
        let style = text_style(size, FontStyle::Normal, ink, HPos::Center, VPos::Center);
        root.draw_text(line, &style, (left + width / 2, middle + LINE * n as i32))?;
    }
    Ok(())
}

/// About how wide a text in a tile is, with some room on both sides, px.
fn width_of(text: &str) -> i32 {
    match text.chars().count() as i32 {
        // A sign or a number stands in a narrow tile.
        count if count <= 5 => 0,
        count => CHARACTER * count + 4,
    }
}
