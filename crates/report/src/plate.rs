//! A figure's name, title, caption and the function that makes it.

use crate::plot::{Drawing, Sheet};
use crate::{Content, Figure, Files, ReportError};

/// A figure: what the record says about it and how it is made of an input `I`.
pub struct Plate<I: ?Sized, D = Sheet> {
    /// File name below `figures/`.
    pub file: &'static str,
    /// Title, one line.
    pub title: &'static str,
    /// What is drawn, under which conditions, what to see.
    pub caption: &'static str,
    /// The drawing, or `None` when the input has no data for it.
    pub sheet: fn(&I) -> Option<D>,
}

impl<I: ?Sized, D> Plate<I, D> {
    /// What the record says about it.
    pub fn figure(&self) -> Figure {
        Figure {
            file: self.file.to_owned(),
            title: self.title.to_owned(),
            caption: self.caption.to_owned(),
        }
    }
}

/// Draws the plates that have data, adds their files to `files` and returns them for the page.
pub fn draw_all<I: ?Sized, D: Drawing>(
    plates: &[Plate<I, D>],
    input: &I,
    files: &mut Files,
) -> Result<Vec<Figure>, ReportError> {
    let mut drawn = Vec::new();
    for plate in plates {
        let Some(sheet) = (plate.sheet)(input) else { continue };
        let text = sheet
            .svg(plate.title, plate.caption)
            .map_err(|source| ReportError::Draw { file: plate.file, source })?;
        files.push((format!("figures/{}", plate.file), Content::Text(text)));
        drawn.push(plate.figure());
    }
    Ok(drawn)
}
