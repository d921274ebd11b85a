//! Many small maps of coloured tiles with the same axes: verdicts of methods over two quantities.

use super::draw::{
    Area, CHARACTER, Failure, LINE, MARGIN, WIDTH, plain, text_style, with_description,
};
use super::matrix::{Tile, draw_tile};
use super::style::{GRID, INK, TITLE_FONT};
use crate::number::wrap;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Maps in rows, with a legend below them.
pub struct Atlas {
    /// Labels below the columns of tiles; empty where there is no room for a label.
    pub x_ticks: Vec<String>,
    /// Labels beside the rows of tiles, from the top.
    pub y_ticks: Vec<String>,
    /// The maps, in reading order.
    pub maps: Vec<Map>,
    /// Meaning of the tiles.
    pub legend: Vec<(Tile, String)>,
    /// Sentences below the legend; they name the axes.
    pub notes: Vec<String>,
}

/// One map of tiles.
pub struct Map {
    /// Line above the map.
    pub title: String,
    /// Rows from the top, each from the left; `None` if nothing was run for the tile.
    pub tiles: Vec<Vec<Option<Tile>>>,
}

/// Maps beside each other.
const ACROSS: usize = 4;
/// Height of a tile.
const ROW: i32 = 21;
/// Room between two maps.
const GAP: i32 = 14;
/// Side of a tile in the legend, and the height of its line.
const SAMPLE: i32 = 20;
const LEGEND_ROW: i32 = 26;

/// Few maps leave room below them, so that no figure is much flatter than the others.
const LEAST_HEIGHT: i32 = 560;

/// Draws an atlas. `title` and `description` also go into the file's `<title>` and `<desc>`.
pub(super) fn svg(atlas: &Atlas, title: &str, description: &str) -> Result<String, Failure> {
    let width_of = |text: &String| CHARACTER * text.chars().count() as i32;
    let title_lines = wrap(title, 88);
    let notes: Vec<String> = atlas.notes.iter().flat_map(|note| wrap(note, 105)).collect();
    let left = MARGIN + atlas.y_ticks.iter().map(width_of).max().unwrap_or(0) + 8;
    let columns = (atlas.x_ticks.len() as i32).max(1);
    let place = (WIDTH - MARGIN - left) / ACROSS as i32;
    let tile = (place - GAP) / columns;
    let letters = ((place - GAP) / CHARACTER) as usize;
    let titles: Vec<Vec<String>> = atlas.maps.iter().map(|map| wrap(&map.title, letters)).collect();
    let title_rows: Vec<i32> = titles
        .chunks(ACROSS)
        .map(|row| row.iter().map(Vec::len).max().unwrap_or(0) as i32)
        .collect();
    let body = ROW * atlas.y_ticks.len() as i32;
    let height_of = |lines: i32| LINE * lines + body + LINE + 12;
    let head = MARGIN + 26 * title_lines.len() as i32 + 4;
    let foot = head + title_rows.iter().map(|lines| height_of(*lines)).sum::<i32>();
    let per_line = {
        let widest = atlas.legend.iter().map(|(_, text)| width_of(text)).max().unwrap_or(0);
        ((WIDTH - 4 * MARGIN) / (SAMPLE + 24 + widest)).max(1)
    };
    let legend_rows = (atlas.legend.len() as i32 + per_line - 1) / per_line;
    let legend_height = 14 + LEGEND_ROW * legend_rows + LINE * notes.len() as i32;
    let height = (foot + legend_height + MARGIN).max(LEAST_HEIGHT);

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
        let rows = atlas.maps.chunks(ACROSS).zip(titles.chunks(ACROSS)).zip(&title_rows);
        for ((maps, titles), lines) in rows {
            let tiles_top = top + LINE * lines;
            for (n, tick) in atlas.y_ticks.iter().enumerate() {
                let middle = tiles_top + ROW * n as i32 + ROW / 2;
                root.draw_text(tick, &plain(HPos::Right, VPos::Center), (left - 6, middle))?;
            }
            for (n, (map, title)) in maps.iter().zip(titles).enumerate() {
                let x = left + place * n as i32;
                // Titles stand on their tiles, also where a neighbour's has more lines.
                let first = tiles_top - LINE * title.len() as i32;
                for (m, line) in title.iter().enumerate() {
                    let place = (x, first + LINE * m as i32);
                    root.draw_text(line, &plain(HPos::Left, VPos::Top), place)?;
                }
                draw_map(&root, map, (x, tiles_top), tile)?;
                for (m, tick) in atlas.x_ticks.iter().enumerate() {
                    let middle = x + tile * m as i32 + tile / 2;
                    let place = (middle, tiles_top + body + 3);
                    root.draw_text(tick, &plain(HPos::Center, VPos::Top), place)?;
                }
            }
            top += height_of(*lines);
        }
        let corners = [(MARGIN, foot), (WIDTH - MARGIN, foot + legend_height)];
        root.draw(&Rectangle::new(corners, GRID.stroke_width(1)))?;
        for (n, (tile, label)) in atlas.legend.iter().enumerate() {
            let (column, row) = (n as i32 % per_line, n as i32 / per_line);
            let x = 2 * MARGIN + (WIDTH - 4 * MARGIN) / per_line * column;
            let y = foot + 8 + LEGEND_ROW * row;
            draw_tile(&root, tile, (x, y), (SAMPLE, SAMPLE))?;
            let place = (x + SAMPLE + 8, y + SAMPLE / 2);
            root.draw_text(label, &plain(HPos::Left, VPos::Center), place)?;
        }
        for (n, note) in notes.iter().enumerate() {
            let y = foot + 10 + LEGEND_ROW * legend_rows + LINE * n as i32;
            root.draw_text(note, &plain(HPos::Left, VPos::Top), (2 * MARGIN, y))?;
        }
        root.present()?;
    }
    Ok(with_description(&text, title, description))
}

fn draw_map(
    root: &Area<'_>,
    map: &Map,
    (left, top): (i32, i32),
    width: i32,
) -> Result<(), Failure> {
    for (n, row) in map.tiles.iter().enumerate() {
        for (m, tile) in row.iter().enumerate() {
            let Some(tile) = tile else { continue };
            let corner = (left + width * m as i32, top + ROW * n as i32);
            draw_tile(root, tile, corner, (width - 1, ROW - 1))?;
        }
    }
    Ok(())
}
