//! Colours, markers, dashes and sizes.
//!
//! Colours are those of Okabe and Ito, which colour-blind readers can tell apart (their yellow is
//! left out: it vanishes on white). Markers and dashes differ too, so that a figure can also be
//! read in grey.

use crate::Verdict;
use plotters::style::RGBColor;

/// Font size of titles and labels in user units of the SVG (pixels at 100 %).
pub(super) const FONT: f64 = 15.0;
/// Font size of the figure's title.
pub(super) const TITLE_FONT: f64 = 19.0;
/// Half the size of a marker.
pub(super) const MARKER: f64 = 5.5;
/// The same for what stands behind the other curves.
pub(super) const SMALL_MARKER: f64 = 2.5;

pub(super) const INK: RGBColor = RGBColor(0x1a, 0x1a, 0x1a);
pub(super) const GRID: RGBColor = RGBColor(0xe2, 0xe2, 0xe2);
pub(super) const FRAME: RGBColor = RGBColor(0x80, 0x80, 0x80);

/// Blue, vermillion, bluish green, reddish purple, black, orange, sky blue; grey for what is no
/// method in particular.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0x00, 0x00, 0x00),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x98, 0x98, 0x98),
];
const GREY: usize = 7;

/// How far the colours of the forms of a method lie towards white, or towards black where the
/// colour is light.
const TONES: [f64; 7] = [0.0, 0.5, 0.25, 0.62, 0.38, 0.56, 0.13];
/// A colour of more than this weighted sum of its parts (2 : 5 : 1, of 255 each) is light.
const LIGHT: u32 = 1100;

/// Outlines of the markers, in tenths of half their size: [`KINDS`] for methods, then as many for
/// all else.
const MARKERS: [&[(i32, i32)]; 2 * KINDS] = [
    // Disc (a dodecagon).
    &[
        (10, 0),
        (9, 5),
        (5, 9),
        (0, 10),
        (-5, 9),
        (-9, 5),
        (-10, 0),
        (-9, -5),
        (-5, -9),
        (0, -10),
        (5, -9),
        (9, -5),
    ],
    // Square.
    &[(-9, -9), (9, -9), (9, 9), (-9, 9)],
    // Triangle, point up.
    &[(0, -12), (11, 9), (-11, 9)],
    // Diamond.
    &[(0, -13), (13, 0), (0, 13), (-13, 0)],
    // Triangle, point down.
    &[(0, 12), (11, -9), (-11, -9)],
    // Upright bar.
    &[(-5, -13), (5, -13), (5, 13), (-5, 13)],
    // Flat bar.
    &[(-13, -5), (13, -5), (13, 5), (-13, 5)],
    // Plus.
    &[
        (-4, -12),
        (4, -12),
        (4, -4),
        (12, -4),
        (12, 4),
        (4, 4),
        (4, 12),
        (-4, 12),
        (-4, 4),
        (-12, 4),
        (-12, -4),
        (-4, -4),
    ],
    // Bow tie.
    &[(-12, -11), (0, -3), (12, -11), (12, 11), (0, 3), (-12, 11)],
    // Triangle, point to the left.
    &[(-12, 0), (9, -11), (9, 11)],
    // Star.
    &[(0, -15), (4, -4), (15, 0), (4, 4), (0, 15), (-4, 4), (-15, 0), (-4, -4)],
    // Triangle, point to the right.
    &[(12, 0), (-9, -11), (-9, 11)],
    // Hourglass.
    &[(-11, -12), (11, -12), (3, 0), (11, 12), (-11, 12), (-3, 0)],
    // Half a disc.
    &[(-13, 7), (-13, 3), (-10, -4), (-5, -8), (0, -9), (5, -8), (10, -4), (13, 3), (13, 7)],
];
/// Number of colours, markers and dashes.
const KINDS: usize = 7;

/// Inside of the markers of the forms of a method: nothing, a spot, strokes.
const INLAYS: [&[[(i32, i32); 2]]; 7] = [
    &[],
    &[[(-2, 0), (2, 0)]],
    &[[(-8, 0), (8, 0)]],
    &[[(0, -8), (0, 8)]],
    &[[(-5, 5), (5, -5)]],
    &[[(-5, -5), (5, 5)]],
    &[[(-7, 0), (7, 0)], [(0, -7), (0, 7)]],
];

/// Lengths of stroke and gap, in pixels; a gap of 0 is a full line.
const DASHES: [(i32, i32); 7] = [(1, 0), (9, 4), (3, 3), (14, 5), (6, 6), (18, 3), (2, 5)];

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    colour: usize,
    /// Lightness of the colour, of those in [`TONES`].
    tone: usize,
    shape: usize,
    line: usize,
}

impl Look {
    /// A grey line, for curves that are there to be seen, and not to be told apart.
    pub const GREY: Self = Self { colour: GREY, tone: 0, shape: 0, line: 0 };

    /// The n-th look of what is no method, such as a parameter or a phase. For n < 7 colour, marker
    /// and dashes are all distinct. No method has its marker.
    pub const fn number(n: usize) -> Self {
        Self::pair(n, n)
    }

    /// The n-th look of a family: for n < 7 and up to 49 families no two looks are the same. No
    /// method has its marker.
    pub const fn of_family(n: usize, family: usize) -> Self {
        let shape = KINDS + (n + family) % KINDS;
        Self { colour: n % KINDS, tone: 0, shape, line: (n + family / KINDS) % KINDS }
    }

    /// The look of a method by its place in the registry: no two of 49 have both colour and marker
    /// in common. Lightness and dashes distinguish the forms of a method; the first form has number
    /// 0.
    pub const fn of_method(place: usize, form: usize) -> Self {
        Self {
            colour: place % 7,
            tone: form % 7,
            shape: (place + place / 7) % 7,
            line: (place + form) % 7,
        }
    }

    /// The same colour with a marker that no method has, for forms of a method without lines.
    #[must_use]
    pub const fn shifted(self, by: usize) -> Self {
        Self { shape: KINDS + (self.shape + by) % KINDS, ..self }
    }

    /// Colour and dashes for one property, marker for another. No method has its marker.
    pub const fn pair(line: usize, shape: usize) -> Self {
        Self { colour: line % KINDS, tone: 0, shape: KINDS + shape % KINDS, line: line % KINDS }
    }

    /// The same shape in black, for entries of the legend that hold for all series.
    pub(super) const fn in_ink(self) -> Self {
        Self { colour: 4, tone: 0, ..self }
    }

    /// Colour and marker, which mean one method.
    #[cfg(test)]
    pub(crate) fn mark(self) -> (usize, usize) {
        (self.colour, self.shape)
    }

    /// The colour, of which further forms have a lighter tone; a darker one where the colour is
    /// light already.
    pub(super) fn colour(self) -> RGBColor {
        let RGBColor(r, g, b) = COLOURS[self.colour];
        let light = 2 * u32::from(r) + 5 * u32::from(g) + u32::from(b);
        let end = if light > LIGHT { 0.0 } else { 255.0 };
        let mix = |part: u8| {
            let part = f64::from(part);
            libm::round(part + TONES[self.tone] * (end - part)) as u8
        };
        RGBColor(mix(r), mix(g), mix(b))
    }

    /// Strokes inside a marker, which tell the forms of a method apart beside their tones: from one
    /// point to the other, in tenths of half its size.
    pub(super) fn inlay(self) -> &'static [[(i32, i32); 2]] {
        INLAYS[self.tone]
    }

    /// A colour that stands out on that of the marker.
    pub(super) fn contrast(self) -> RGBColor {
        let RGBColor(r, g, b) = self.colour();
        let light = 2 * u32::from(r) + 5 * u32::from(g) + u32::from(b);
        if light > LIGHT { INK } else { RGBColor(255, 255, 255) }
    }

    /// Outline of a marker of half the width `size` around (0, 0), in pixels.
    pub(super) fn outline(self, size: f64) -> impl Iterator<Item = (i32, i32)> {
        let scale = move |tenths: i32| libm::round(f64::from(tenths) * size / 10.0) as i32;
        MARKERS[self.shape].iter().map(move |&(x, y)| (scale(x), scale(y)))
    }

    pub(super) fn dashes(self) -> (i32, i32) {
        DASHES[self.line]
    }
}

/// How the run of a point ended, as its marker shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Filled marker.
    Stable,
    /// Hollow marker.
    Marginal,
    /// Hollow marker: a run near the true end that has gained energy or hardly moves.
    Flawed,
    /// Hollow marker, crossed out: any other verdict.
    Failed,
}

impl State {
    /// The marker state of a verdict.
    pub fn of_verdict(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Stable => Self::Stable,
            Verdict::Marginal => Self::Marginal,
            _ => Self::Failed,
        }
    }
}

/// How a part of a bar is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    /// Dark and plain.
    Dark,
    /// Light, with slanted strokes.
    Hatched,
    /// Light and plain.
    Light,
    /// Light, with upright strokes.
    Upright,
    /// Light, with strokes slanted both ways.
    Crossed,
}

impl Fill {
    pub(super) fn colour(self) -> RGBColor {
        match self {
            Self::Dark => COLOURS[0],
            Self::Hatched => RGBColor(0xfb, 0xe3, 0xb0),
            Self::Light => RGBColor(0xf2, 0xf2, 0xf2),
            Self::Upright => RGBColor(0xc9, 0xe8, 0xdb),
            Self::Crossed => RGBColor(0xf0, 0xcf, 0xe0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seven forms of a method on white: no two tones are alike, and none vanishes.
    #[test]
    fn tones_of_a_colour_are_told_apart_from_each_other_and_from_white() {
        for place in 0..7 {
            let tones: Vec<_> = (0..7).map(|form| Look::of_method(place, form).colour()).collect();
            for (n, tone) in tones.iter().enumerate() {
                let apart = |RGBColor(r, g, b): &RGBColor| {
                    let parts = [(r, tone.0), (g, tone.1), (b, tone.2)];
                    parts.map(|(&a, b)| u32::from(a.abs_diff(b))).iter().sum::<u32>()
                };
                assert!(tones[..n].iter().all(|other| apart(other) >= 15), "{place}: {tones:?}");
                assert!(apart(&WHITE_PAPER) >= 120, "{place}: {tone:?}");
            }
        }
    }

    /// A marker of a parameter, a phase or a family is never mistaken for that of a method.
    #[test]
    fn what_is_no_method_has_other_markers() {
        let methods: Vec<_> = (0..49).map(|place| Look::of_method(place, 0).shape).collect();
        for n in 0..49 {
            let others = [
                Look::number(n),
                Look::pair(n, n / 7),
                Look::of_family(n, n / 7),
                Look::of_method(n, 1).shifted(1),
            ];
            for other in others {
                assert!(!methods.contains(&other.shape), "{n}: {other:?}");
            }
        }
        for (n, marker) in MARKERS.iter().enumerate() {
            assert!(!MARKERS[..n].contains(marker), "{n}");
        }
    }

    const WHITE_PAPER: RGBColor = RGBColor(255, 255, 255);
}
