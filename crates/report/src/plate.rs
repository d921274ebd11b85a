//! A figure's name, title, caption and the function that makes it.

use crate::plot::{Atlas, Dense, Drawing, Matrix, Sheet, Stacked};
use crate::{Content, Figure, Files, ReportError};
use std::error::Error;

/// A figure: its description in the record, and the function that draws it from an input `I`.
pub struct Plate<I> {
    /// File name below `figures/`.
    pub file: &'static str,
    /// Title, one line.
    pub title: &'static str,
    /// What to see, then what is drawn under which conditions.
    pub caption: &'static str,
    /// The function that draws it.
    pub draw: Draw<I>,
}

/// A function that draws an input; it returns `None` if the input has no data for the figure.
pub enum Draw<I> {
    /// Panels of curves.
    Sheet(fn(&I) -> Option<Sheet>),
    /// Many panels of curves with the same axes, on a slim page.
    Dense(fn(&I) -> Option<Sheet>),
    /// A table of tiles.
    Matrix(fn(&I) -> Option<Matrix>),
    /// A table of tiles on a slim page.
    Stacked(fn(&I) -> Option<Matrix>),
    /// Maps of tiles.
    Atlas(fn(&I) -> Option<Atlas>),
    /// A picture as PNG.
    Picture(fn(&I) -> Option<Picture>),
}

/// The bytes of a picture, or the reason why it could not be drawn.
pub type Picture = Result<Vec<u8>, Box<dyn Error + Send + Sync>>;

impl<I> Plate<I> {
    /// The description of the figure for the record.
    pub fn figure(&self) -> Figure {
        Figure {
            file: self.file.to_owned(),
            title: self.title.to_owned(),
            caption: self.caption.to_owned(),
        }
    }

    fn content(&self, input: &I) -> Option<Result<Content, ReportError>> {
        match self.draw {
            Draw::Sheet(make) => self.svg(make(input)?),
            Draw::Dense(make) => self.svg(Dense(make(input)?)),
            Draw::Matrix(make) => self.svg(make(input)?),
            Draw::Stacked(make) => self.svg(Stacked(make(input)?)),
            Draw::Atlas(make) => self.svg(make(input)?),
            Draw::Picture(make) => {
                let error = |source| ReportError::Picture { file: self.file, source };
                Some(make(input)?.map(Content::Png).map_err(error))
            }
        }
    }

    fn svg(&self, drawing: impl Drawing) -> Option<Result<Content, ReportError>> {
        let error = |source| ReportError::Draw { file: self.file, source };
        Some(drawing.svg(self.title, self.caption).map(Content::Text).map_err(error))
    }
}

/// Draws the plates that have data, adds their files to `files` and returns them for the page.
///
/// # Errors
/// A [`ReportError`] for the figure that could not be drawn.
pub fn draw_all<I>(
    plates: &[Plate<I>],
    input: &I,
    files: &mut Files,
) -> Result<Vec<Figure>, ReportError> {
    let mut drawn = Vec::new();
    for plate in plates {
        let Some(content) = plate.content(input) else { continue };
        files.push((format!("figures/{}", plate.file), content?));
        drawn.push(plate.figure());
    }
    Ok(drawn)
}
