//! The tension of one kind of spring over its length.

use super::buckling::Buckling;
use drape_kernels::lanes::Four;
use drape_kernels::vector::SLOTS;
use std::sync::Arc;

/// A change of length below this part of the rest length takes the tension in its middle for the
/// mean tension.
const TINY: f64 = 1e-8;

/// A piece of the curve in tension: from strain [`from`](Self::from) on, up to the next piece.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    /// Strain at which it begins.
    from: f64,
    /// Slope `k_p`, N/m.
    stiffness: f64,
    /// Tension where it begins, over the rest length, N/m.
    tension: f64,
    /// Energy where it begins, over the square of the rest length, N/m.
    energy: f64,
}

/// A piece that no stretch reaches.
static BEYOND: Piece = Piece { from: f64::INFINITY, stiffness: 0.0, tension: 0.0, energy: 0.0 };

/// The curve in tension: at least one piece, the first from strain 0. Laws share it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve(Arc<[Piece]>);

impl Curve {
    /// A curve from the stiffness (N/m) of each piece and the strain at which it ends. Strains are
    /// above 0 and rise; the last one is infinite.
    pub(crate) fn new(pieces: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (mut from, mut tension, mut energy) = (0.0, 0.0, 0.0);
        let mut list = Vec::new();
        for (stiffness, up_to) in pieces {
            list.push(Piece { from, stiffness, tension, energy });
            let stretch = up_to - from;
            energy += tension * stretch + 0.5 * stiffness * stretch * stretch;
            tension += stiffness * stretch;
            from = up_to;
        }
        Self(list.into())
    }
}

/// Behaviour of a spring that is shorter than its rest length.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Compression {
    /// `T = k (L − ℓ)`.
    Linear { stiffness: f64 },
    /// It pushes back until it buckles.
    Buckling(Buckling),
}

/// Tension `T` (N), energy `U` (J) and slope `T'` (N/m) of a spring as functions of its length `L`
/// (m), for any rest length `ℓ` (m).
///
/// In tension the curve is piecewise linear over the strain `L/ℓ − 1`. `T` and `U` are continuous,
/// both 0 at `L = ℓ`:
///
/// ```text
/// T = T_p + k_p (L − L_p)        U = U_p + T_p (L − L_p) + ½ k_p (L − L_p)²
/// L_p = ℓ (1 + strain_p)
/// ```
///
/// The slope at a kink is the slope on its longer side.
#[derive(Clone, Debug, PartialEq)]
pub struct TensionLaw {
    compression: Compression,
    curve: Curve,
}

impl TensionLaw {
    /// A curve in tension, and a stiffness (N/m) in compression.
    pub(crate) fn new(compression_stiffness: f64, curve: Curve) -> Self {
        Self { compression: Compression::Linear { stiffness: compression_stiffness }, curve }
    }

    /// The same curve, but buckling when compressed.
    pub(crate) fn buckling(self, buckling: Buckling) -> Self {
        Self { compression: Compression::Buckling(buckling), ..self }
    }

    /// The piece at a stretch `L − ℓ`; `None` in compression.
    fn piece(&self, rest: f64, stretch: f64) -> Option<&Piece> {
        self.curve.0.iter().rev().find(|piece| stretch >= rest * piece.from)
    }

    /// Tension `T(L)`, N; negative in compression. `rest` and `length` are in m.
    pub fn tension(&self, rest: f64, length: f64) -> f64 {
        let stretch = length - rest;
        match (self.piece(rest, stretch), &self.compression) {
            (Some(p), _) => rest * p.tension + p.stiffness * (stretch - rest * p.from),
            (None, Compression::Linear { stiffness }) => stiffness * stretch,
            (None, Compression::Buckling(buckling)) => buckling.tension(rest, length),
        }
    }

    /// As [`tension`](Self::tension) for four springs; `None` if one of them buckles.
    #[inline(always)]
    pub(super) fn tensions<F: Four>(
        four: F,
        [a, b, c, d]: [&Self; SLOTS],
        rest: F::Numbers,
        length: F::Numbers,
    ) -> Option<F::Numbers> {
        let slopes = [a.slope_in_compression()?, b.slope_in_compression()?];
        let slopes = [slopes[0], slopes[1], c.slope_in_compression()?, d.slope_in_compression()?];
        let stretch = four.sub(length, rest);
        let mut tension = four.mul(four.load(slopes), stretch);
        let most = a.pieces().max(b.pieces()).max(c.pieces().max(d.pieces()));
        for number in 0..most {
            let [a, b, c, d] = [a.at(number), b.at(number), c.at(number), d.at(number)];
            let from = four.load([a.from, b.from, c.from, d.from]);
            let slope = four.load([a.stiffness, b.stiffness, c.stiffness, d.stiffness]);
            let start = four.load([a.tension, b.tension, c.tension, d.tension]);
            let from = four.mul(rest, from);
            let beyond = four.mul(slope, four.sub(stretch, from));
            let on_piece = four.add(four.mul(rest, start), beyond);
            tension = four.where_at_most(from, stretch, on_piece, tension);
        }
        Some(tension)
    }

    fn slope_in_compression(&self) -> Option<f64> {
        match &self.compression {
            Compression::Linear { stiffness } => Some(*stiffness),
            Compression::Buckling(_) => None,
        }
    }

    fn pieces(&self) -> usize {
        self.curve.0.len()
    }

    /// The piece of a number; one that no stretch reaches behind the last one.
    fn at(&self, number: usize) -> &Piece {
        self.curve.0.get(number).unwrap_or(&BEYOND)
    }

    /// Slope `T'(L)`, N/m; never negative.
    pub fn slope(&self, rest: f64, length: f64) -> f64 {
        match (self.piece(rest, length - rest), &self.compression) {
            (Some(piece), _) => piece.stiffness,
            (None, Compression::Linear { stiffness }) => *stiffness,
            (None, Compression::Buckling(buckling)) => buckling.slope(rest, length),
        }
    }

    /// Energy `U(L)`, J.
    pub fn energy(&self, rest: f64, length: f64) -> f64 {
        let stretch = length - rest;
        match (self.piece(rest, stretch), &self.compression) {
            (Some(p), _) => {
                let beyond = stretch - rest * p.from;
                rest * rest * p.energy + (rest * p.tension + 0.5 * p.stiffness * beyond) * beyond
            }
            (None, Compression::Linear { stiffness }) => 0.5 * stiffness * stretch * stretch,
            (None, Compression::Buckling(buckling)) => buckling.energy(rest, length),
        }
    }

    /// Secant stiffness `T/L`, N/m; negative in compression. The force is the secant stiffness
    /// times the difference of the ends.
    pub fn secant(&self, rest: f64, length: f64) -> f64 {
        self.tension(rest, length) / length
    }

    /// The mean `ΔU/ΔL` of the tension between two lengths, N, and its derivative with respect to
    /// `to`, N/m. The difference of two energies is used only between lengths on different pieces,
    /// where no digits cancel.
    pub fn mean_tension(&self, rest: f64, from: f64, to: f64) -> (f64, f64) {
        let difference = to - from;
        let pieces = [from, to].map(|length| self.piece(rest, length - rest));
        let is_linear = match (pieces, &self.compression) {
            ([Some(a), Some(b)], _) => std::ptr::eq(a, b),
            ([None, None], Compression::Linear { .. }) => true,
            _ => false,
        };
        if is_linear {
            let mean = 0.5 * (self.tension(rest, from) + self.tension(rest, to));
            return (mean, 0.5 * self.slope(rest, to));
        }
        if difference.abs() < TINY * rest {
            let middle = 0.5 * (from + to);
            return (self.tension(rest, middle), 0.5 * self.slope(rest, middle));
        }
        let mean = (self.energy(rest, to) - self.energy(rest, from)) / difference;
        (mean, (self.tension(rest, to) - mean) / difference)
    }

    /// The greatest slope `K`, N/m. Since `T(ℓ) = 0`, neither `T'` nor `T/L` exceeds it at any
    /// length. It is the smallest `K` for which `½ K L² − U` is convex in the difference of the
    /// ends.
    pub fn steepest(&self) -> f64 {
        let compression = match &self.compression {
            Compression::Linear { stiffness } => *stiffness,
            Compression::Buckling(buckling) => buckling.steepest(),
        };
        self.curve.0.iter().fold(compression, |most, piece| most.max(piece.stiffness))
    }

    /// Multiplies all tensions.
    pub(crate) fn scale(&mut self, factor: f64) {
        for piece in Arc::make_mut(&mut self.curve.0) {
            piece.stiffness *= factor;
            piece.tension *= factor;
            piece.energy *= factor;
        }
        match &mut self.compression {
            Compression::Linear { stiffness } => *stiffness *= factor,
            Compression::Buckling(buckling) => buckling.scale(factor),
        }
    }
}
