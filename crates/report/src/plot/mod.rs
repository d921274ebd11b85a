//! Parts that all figures share.
//!
//! A [`Sheet`] is data: panels with axes, series, rules and bars. [`Drawing::svg`] turns it into
//! the text of one SVG file. Positions inside a panel are those of its [`Axis`] (logarithms are
//! taken there); plotters maps them to pixels and draws axes and grid, `draw` adds curves, markers
//! and legend. A [`Matrix`] is a table of coloured tiles instead, an [`Atlas`] many small ones.

mod atlas;
mod axis;
mod draw;
mod matrix;
mod style;

pub use atlas::{Atlas, Map};
pub use axis::Axis;
pub use matrix::{Matrix, Row, Shade, Tile};
pub use style::{Fill, Look, State};

use plotters::drawing::DrawingAreaErrorKind;

/// Data that a figure can be made from.
pub trait Drawing {
    /// The text of an SVG file. `title` and `description` also go into its `<title>` and `<desc>`.
    fn svg(
        &self,
        title: &str,
        description: &str,
    ) -> Result<String, DrawingAreaErrorKind<std::io::Error>>;
}

impl Drawing for Sheet {
    fn svg(
        &self,
        title: &str,
        description: &str,
    ) -> Result<String, DrawingAreaErrorKind<std::io::Error>> {
        draw::svg(self, draw::Layout::Wide, title, description)
    }
}

/// A sheet on a slim page that can be read on a phone: two panels beside each other. They have one
/// vertical axis a row, so all must have the same axes. The legend stands above them.
pub struct Dense(pub Sheet);

impl Drawing for Dense {
    fn svg(
        &self,
        title: &str,
        description: &str,
    ) -> Result<String, DrawingAreaErrorKind<std::io::Error>> {
        draw::svg(&self.0, draw::Layout::Dense, title, description)
    }
}

impl Drawing for Matrix {
    fn svg(
        &self,
        title: &str,
        description: &str,
    ) -> Result<String, DrawingAreaErrorKind<std::io::Error>> {
        matrix::svg(self, matrix::Labels::Beside, title, description)
    }
}

/// A table on a slim page that can be read on a phone: the labels stand above the rows.
pub struct Stacked(pub Matrix);

impl Drawing for Stacked {
    fn svg(
        &self,
        title: &str,
        description: &str,
    ) -> Result<String, DrawingAreaErrorKind<std::io::Error>> {
        matrix::svg(&self.0, matrix::Labels::Above, title, description)
    }
}

impl Drawing for Atlas {
    fn svg(
        &self,
        title: &str,
        description: &str,
    ) -> Result<String, DrawingAreaErrorKind<std::io::Error>> {
        atlas::svg(self, title, description)
    }
}

/// A figure: panels in rows, one legend below them.
pub struct Sheet {
    /// The panels, in reading order.
    pub panels: Vec<Panel>,
    /// Sentences below the legend.
    pub notes: Vec<String>,
}

/// One pair of axes and the drawing between them.
pub struct Panel {
    /// Lines above the panel.
    pub title: Vec<String>,
    /// Smaller lines at its upper edge: what has no place between the axes.
    pub above: Vec<String>,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves, drawn in this order.
    pub series: Vec<Series>,
    /// Straight lines behind the curves.
    pub rules: Vec<Rule>,
    /// Horizontal bars.
    pub bars: Vec<Bar>,
}

impl Panel {
    /// An empty panel.
    pub fn new(title: Vec<String>, x: Axis, y: Axis) -> Self {
        let (series, rules, bars) = (Vec::new(), Vec::new(), Vec::new());
        Self { title, above: Vec::new(), x, y, series, rules, bars }
    }
}

/// Points joined by a line.
pub struct Series {
    /// Entry of the legend. Series with the same label share one entry.
    pub label: String,
    /// Colour, dashes and marker.
    pub look: Look,
    /// The points, in the order in which the line passes them.
    pub points: Vec<Point>,
    /// Whether a line joins the points.
    is_joined: bool,
    /// Whether it is drawn thin, with small markers, behind the others.
    is_behind: bool,
    /// From one marker to the next, in points; a run that failed is marked wherever it is.
    stride: usize,
}

impl Series {
    /// A series with its points sorted by x; `None` if there are no points.
    pub fn new(label: String, look: Look, mut points: Vec<Point>) -> Option<Self> {
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        Self::path(label, look, points)
    }

    /// The same line with about ten markers, however many points it has.
    pub fn sparse(self) -> Self {
        Self { stride: self.points.len().div_ceil(10).max(1), ..self }
    }

    /// A series whose line passes the points in the given order; `None` if there are no points.
    pub fn path(label: String, look: Look, points: Vec<Point>) -> Option<Self> {
        let is_any = !points.is_empty();
        let (is_joined, is_behind) = (true, false);
        is_any.then_some(Self { label, look, points, is_joined, is_behind, stride: 1 })
    }

    /// The same series, thin and behind the others.
    pub fn behind(self) -> Self {
        Self { is_behind: true, ..self }
    }

    /// The same points without a line between them.
    pub fn apart(self) -> Self {
        Self { is_joined: false, ..self }
    }
}

/// A value with the verdict of the run that gave it.
#[derive(Clone, Copy, PartialEq)]
pub struct Point {
    /// Position on the horizontal axis.
    pub x: f64,
    /// Position on the vertical axis.
    pub y: f64,
    /// How the run ended.
    pub state: State,
}

/// A straight line across the panel.
pub struct Rule {
    /// Entry of the legend.
    pub label: String,
    /// Position of the line.
    pub at: At,
}

/// Position of a rule.
#[derive(Clone, Copy, PartialEq)]
pub enum At {
    /// Horizontal, at this value of y.
    Y(f64),
    /// A grey band from the bottom of the panel up to this value of y.
    Below(f64),
    /// Vertical, at this value of x.
    X(f64),
    /// With this slope through this point, on two logarithmic axes.
    Slope {
        /// Power of x to which y is proportional.
        order: f64,
        /// Where it passes, on the horizontal axis.
        x: f64,
        /// Where it passes, on the vertical axis.
        y: f64,
    },
}

/// A horizontal bar from x = 0, in parts. Positive lengths go to the right, negative lengths to the
/// left.
pub struct Bar {
    /// Middle of the bar on the y axis; its thickness is 0.64.
    pub y: f64,
    /// Label in the legend, fill and length of each part.
    pub parts: Vec<(&'static str, Fill, f64)>,
    /// A bar that is longer than this on either side is drawn with this length. Its labels keep the
    /// true values.
    pub reach: f64,
    /// Text behind its right end.
    pub end: String,
}

impl Bar {
    /// Length of the longer side.
    pub fn longest_side(&self) -> f64 {
        let side = |sign: f64| -> f64 {
            self.parts.iter().map(|(.., length)| (sign * length).max(0.0)).sum()
        };
        side(1.0).max(side(-1.0))
    }
}

/// Title, series and rules of a panel that has no axes yet.
pub type Draft = (Vec<String>, Vec<Series>, Vec<Rule>);

/// Panels that share one pair of axes, so that they can be compared; `None` if no panel has points.
///
/// `x` and `y` make the axes from the values of all points. Panels without points are left out.
pub fn panels_of(
    drafts: Vec<Draft>,
    x: impl Fn(&[f64]) -> Axis,
    y: impl Fn(&[f64]) -> Axis,
) -> Option<Sheet> {
    let (xs, ys) = coordinates(drafts.iter().flat_map(|(_, series, _)| series));
    sheet_of(drafts, |_| (x(&xs), y(&ys)))
}

/// Panels with axes of their own, where their values lie far apart; `None` if no panel has points.
///
/// `x` and `y` make the axes of a panel from the values of its points. Panels without points are
/// left out.
pub fn panels_apart(
    drafts: Vec<Draft>,
    x: impl Fn(&[f64]) -> Axis,
    y: impl Fn(&[f64]) -> Axis,
) -> Option<Sheet> {
    sheet_of(drafts, |series| {
        let (xs, ys) = coordinates(series.iter());
        (x(&xs), y(&ys))
    })
}

/// The x and the y of all points.
fn coordinates<'a>(series: impl Iterator<Item = &'a Series>) -> (Vec<f64>, Vec<f64>) {
    series.flat_map(|series| &series.points).map(|point| (point.x, point.y)).unzip()
}

fn sheet_of(drafts: Vec<Draft>, axes: impl Fn(&[Series]) -> (Axis, Axis)) -> Option<Sheet> {
    let filled = drafts.into_iter().filter(|(_, series, _)| !series.is_empty());
    let panels: Vec<Panel> = filled
        .map(|(title, series, rules)| {
            let (x, y) = axes(&series);
            Panel { series, rules, ..Panel::new(title, x, y) }
        })
        .collect();
    (!panels.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

/// The different names found: those of `known` first, in the order of `known`, then all others.
pub fn names<'a>(known: &[&'a str], found: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let found: std::collections::BTreeSet<&str> = found.collect();
    let expected = known.iter().copied().filter(|name| found.contains(name));
    let others = found.iter().copied().filter(|name| !known.contains(name));
    expected.chain(others).collect()
}

/// Index of a name in `known`, or the length of `known` if it is not there. It is the number of the
/// look.
pub fn place_of(name: &str, known: &[&str]) -> usize {
    known.iter().position(|entry| *entry == name).unwrap_or(known.len())
}

/// The different values found, in rising order.
pub fn values(found: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = found.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The texts of a drawing, with the horizontal and vertical places where they stand.
    fn texts(svg: &str) -> Vec<(String, f64, f64)> {
        let number = |tag: &str, key: &str| -> f64 {
            let rest = tag.split(&format!(" {key}=\"")).nth(1).expect("a place");
            rest.split('"').next().and_then(|text| text.parse().ok()).expect("a number")
        };
        let tags = svg.split("<text").skip(1).map(|tag| tag.split("</text>").next().unwrap_or(tag));
        tags.map(|tag| {
            let text = tag.split_once('>').map_or("", |(_, text)| text).trim().to_owned();
            (text, number(tag, "x"), number(tag, "y"))
        })
        .collect()
    }

    fn drawn(drawing: &dyn Drawing) -> String {
        drawing.svg("A title", "What it shows.").expect("a drawing")
    }

    fn width(svg: &str) -> &str {
        svg.split("width=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a width")
    }

    fn sheet() -> Sheet {
        let draft = |name: &str| {
            let points = [1.0, 2.0].map(|x| Point { x, y: x, state: State::Stable }).to_vec();
            let series =
                Series::new("a method".to_owned(), Look::number(0), points).expect("points");
            (vec![name.to_owned()], vec![series], Vec::new())
        };
        let drafts = ["one", "two", "three"].into_iter().map(draft).collect();
        let x = |values: &[f64]| Axis::linear("time", values);
        panels_of(drafts, x, |values| Axis::linear("error", values)).expect("panels")
    }

    /// Values that lie far apart would shrink to a point on common axes.
    #[test]
    fn panels_share_their_axes_or_have_their_own() {
        let draft = |scale: f64| {
            let points = [1.0, 2.0].map(|x| Point { x: scale * x, y: x, state: State::Stable });
            let series = Series::new("a method".to_owned(), Look::number(0), points.to_vec());
            (vec!["a panel".to_owned()], vec![series.expect("points")], Vec::new())
        };
        let axis = |values: &[f64]| Axis::linear("time", values);
        let spans = |make: &dyn Fn(Vec<Draft>) -> Option<Sheet>| {
            let sheet = make([1.0, 1000.0].map(draft).into()).expect("panels");
            let of = |panel: &Panel| (panel.x.low..=panel.x.high).contains(&1.5);
            sheet.panels.iter().map(of).collect::<Vec<_>>()
        };
        assert_eq!(spans(&|drafts| panels_of(drafts, axis, axis)), [true, true]);
        assert_eq!(spans(&|drafts| panels_apart(drafts, axis, axis)), [true, false]);
    }

    /// On the slim page two panels share a vertical axis, and the legend stands above them.
    #[test]
    fn a_dense_sheet_is_slim_and_names_its_vertical_axis_once_a_row() {
        let (wide, dense) = (drawn(&sheet()), drawn(&Dense(sheet())));
        assert_eq!((width(&wide), width(&dense)), ("1000", "680"));
        let named = |svg: &str, name: &str| texts(svg).iter().filter(|t| t.0 == name).count();
        assert_eq!((named(&wide, "error"), named(&dense, "error")), (3, 2));
        let place = |svg: &str, name: &str| texts(svg).iter().find(|t| t.0 == name).map(|t| t.2);
        assert!(place(&dense, "a method") < place(&dense, "one"), "{:?}", texts(&dense));
        assert!(place(&wide, "a method") > place(&wide, "three"), "{:?}", texts(&wide));
    }

    /// On the slim page the labels of the rows stand above their tiles.
    #[test]
    fn a_stacked_matrix_is_slim_and_has_its_labels_above_the_tiles() {
        let tile = || Tile { shade: Shade::Good, text: "s".to_owned(), is_marked: false };
        let matrix = || Matrix {
            columns: vec!["first".to_owned(), "second".to_owned()],
            rows: vec![Row {
                label: "a rather long label of the row".to_owned(),
                is_first: true,
                tiles: vec![vec![tile()], vec![tile()]],
            }],
            legend: vec![(tile(), "stable".to_owned())],
            notes: Vec::new(),
        };
        let (beside, above) = (drawn(&matrix()), drawn(&Stacked(matrix())));
        assert_eq!((width(&beside), width(&above)), ("1000", "680"));
        let places = |svg: &str| {
            let all = texts(svg);
            let label = all.iter().find(|text| text.0.starts_with("a rather")).cloned();
            let tile = all.into_iter().find(|text| text.0 == "s");
            (label.expect("a label"), tile.expect("a tile"))
        };
        let (label, tile) = places(&beside);
        assert!((label.2 - tile.2).abs() < 2.0, "{label:?} beside {tile:?}");
        let (label, tile) = places(&above);
        assert!(label.2 < tile.2 - 10.0 && tile.1 < 680.0 / 2.0, "{label:?} above {tile:?}");
    }
}
