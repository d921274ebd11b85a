//! Axes: where a value lies and which ticks it has.

use crate::number::{power_of_ten, significant};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// One axis of a panel. `low`, `high` and the ticks are positions: values on a linear axis, decimal
/// logarithms on a logarithmic one.
#[derive(Clone)]
pub struct Axis {
    pub(super) label: String,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) ticks: Vec<(f64, String)>,
    scale: Scale,
}

#[derive(Clone, Copy, PartialEq)]
enum Scale {
    Linear,
    /// Values that have no logarithm lie at `zero`, where there is one, below a break.
    Log {
        zero: Option<Zero>,
    },
}

#[derive(Clone, Copy, PartialEq)]
struct Zero {
    at: f64,
    gap: f64,
}

impl Axis {
    /// A logarithmic axis for `values`, of which only the positive ones count.
    pub fn log(label: &str, values: &[f64]) -> Self {
        let logs = || values.iter().filter(|v| **v > 0.0).map(|v| libm::log10(*v));
        let (least, greatest) =
            logs().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let (least, greatest) = if least <= greatest { (least, greatest) } else { (0.0, 0.0) };
        let margin = (0.07 * (greatest - least)).max(0.12);
        let (low, high) = (least - margin, greatest + margin);
        Self {
            label: label.to_owned(),
            low,
            high,
            ticks: log_ticks(low, high),
            scale: Scale::Log { zero: None },
        }
    }

    /// As [`Axis::log`], with a place for zeros below a break if there are zeros.
    pub fn log_with_zero(label: &str, values: &[f64]) -> Self {
        let mut axis = Self::log(label, values);
        if values.iter().any(|v| *v <= 0.0) {
            let span = axis.high - axis.low;
            let zero = Zero { at: axis.low - 0.09 * span, gap: axis.low - 0.02 * span };
            // Ticks stay above the break.
            axis.low = zero.at - 0.06 * span;
            axis.ticks.push((zero.at, "0".to_owned()));
            axis.scale = Scale::Log { zero: Some(zero) };
        }
        axis
    }

    /// A linear axis over `values`. Values beyond it are drawn at its edge.
    pub fn linear(label: &str, values: &[f64]) -> Self {
        let (least, greatest) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let (least, greatest) = if least <= greatest { (least, greatest) } else { (0.0, 0.0) };
        let margin = if greatest > least { 0.08 * (greatest - least) } else { 0.5 };
        let (low, high) = (least - margin, greatest + margin);
        let step = nice_step((high - low) / 6.0);
        let decimals = (-libm::floor(libm::log10(step))).max(0.0) as usize;
        let first = libm::ceil(low / step) as i64;
        let last = libm::floor(high / step) as i64;
        let ticks = (first..=last)
            .map(|n| {
                let value = n as f64 * step;
                (value, format!("{value:.decimals$}").replace('-', "−"))
            })
            .collect();
        Self { label: label.to_owned(), low, high, ticks, scale: Scale::Linear }
    }

    /// Names from the top down, at 0, −1, −2 …; the n-th name is at `-(n as f64)`.
    pub fn names(label: &str, names: &[String]) -> Self {
        let ticks = names.iter().enumerate().map(|(n, name)| (-(n as f64), name.clone())).collect();
        Self {
            label: label.to_owned(),
            low: 0.4 - names.len() as f64,
            high: 0.6,
            ticks,
            scale: Scale::Linear,
        }
    }

    /// Shares in per cent with room for text behind the bars.
    pub fn per_cent(label: &str) -> Self {
        let ticks = (0..=5).map(|n| (f64::from(20 * n), format!("{}", 20 * n))).collect();
        Self { label: label.to_owned(), low: 0.0, high: 152.0, ticks, scale: Scale::Linear }
    }

    /// The same axis where values beyond its outer ticks were moved to them: the ticks say so.
    #[must_use]
    pub fn clipped(mut self) -> Self {
        if let [(_, first), .., (_, last)] = self.ticks.as_mut_slice() {
            *first = format!("≤ {first}");
            *last = format!("≥ {last}");
        }
        self
    }

    /// Position of a value, moved to the nearest edge when it lies beyond.
    pub(super) fn position(&self, value: f64) -> f64 {
        let position = match self.scale {
            Scale::Linear => value,
            Scale::Log { .. } if value > 0.0 => libm::log10(value),
            Scale::Log { zero: Some(zero) } => zero.at,
            Scale::Log { zero: None } => self.low,
        };
        position.clamp(self.low, self.high)
    }

    /// Whether a value has its true place on the axis.
    pub(super) fn holds(&self, value: f64) -> bool {
        match self.scale {
            Scale::Linear => (self.low..=self.high).contains(&value),
            Scale::Log { zero } => value > 0.0 || (value == 0.0 && zero.is_some()),
        }
    }

    /// Position of the break between zero and the logarithms.
    pub(super) fn gap(&self) -> Option<f64> {
        match self.scale {
            Scale::Log { zero } => zero.map(|zero| zero.gap),
            Scale::Linear => None,
        }
    }

    /// Characters of the longest tick label.
    pub(super) fn tick_width(&self) -> usize {
        self.ticks.iter().map(|(_, text)| text.chars().count()).max().unwrap_or(0)
    }
}

/// Plotters' view of an axis: positions, with the ticks as the only key points.
impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.low) / (self.high - self.low);
        limit.0 + libm::round(share * f64::from(limit.1 - limit.0)) as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|(at, _)| *at).collect()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        let tick = self.ticks.iter().find(|(at, _)| at == value);
        tick.map(|(_, text)| text.clone()).unwrap_or_default()
    }
}

/// Ticks at powers of ten, at 2 and 5 times them too where there are fewer than three.
fn log_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let (first, last) = (libm::ceil(low) as i32, libm::floor(high) as i32);
    let stride = ((last - first) / 8 + 1).max(1) as usize;
    if last - first >= 2 {
        return (first..=last).step_by(stride).map(|n| (f64::from(n), power_of_ten(n))).collect();
    }
    let plain = |mantissa: f64, n: i32| {
        let value = mantissa * libm::pow(10.0, f64::from(n));
        if (-4..5).contains(&n) {
            let decimals = (-n).max(0) as usize;
            format!("{value:.decimals$}")
        } else {
            significant(value, 1)
        }
    };
    let multiples: &[f64] = if high - low < 0.45 {
        &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    (first - 1..=last)
        .flat_map(|n| multiples.iter().map(move |m| (*m, n)))
        .map(|(m, n)| {
            let text = if m == 1.5 { plain(m * 10.0, n - 1) } else { plain(m, n) };
            (f64::from(n) + libm::log10(m), text)
        })
        .filter(|(at, _)| (low..=high).contains(at))
        .collect()
}

/// The next of 1, 2, 5 × 10ⁿ above `least`.
fn nice_step(least: f64) -> f64 {
    let decade = libm::pow(10.0, libm::floor(libm::log10(least)));
    [1.0, 2.0, 5.0].into_iter().map(|m| m * decade).find(|s| *s >= least).unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, text)| text.as_str()).collect()
    }

    #[test]
    fn log_axes_have_ticks_at_powers_of_ten() {
        assert_eq!(labels(&Axis::log("", &[1e2, 1e5])), ["10²", "10³", "10⁴", "10⁵"]);
        assert_eq!(labels(&Axis::log("", &[30.0, 300.0])), ["50", "100", "200"]);
    }

    #[test]
    fn one_point_and_none_still_have_a_range_with_ticks() {
        for values in [&[][..], &[0.0], &[7.0], &[2e6], &[1e-5]] {
            for axis in [Axis::log_with_zero("", values), Axis::linear("", values)] {
                assert!(axis.low < axis.high, "{values:?}");
                assert!(!axis.ticks.is_empty(), "{values:?}: {} {}", axis.low, axis.high);
            }
        }
    }

    #[test]
    fn zeros_lie_below_the_break_and_everything_inside_the_axis() {
        let axis = Axis::log_with_zero("", &[0.0, 0.5, 20.0]);
        let gap = axis.gap().expect("a break");
        assert!(axis.position(0.0) < gap && gap < axis.position(0.5));
        assert!(axis.position(1e300) <= axis.high && axis.position(-1.0) >= axis.low);
        assert!(Axis::log_with_zero("", &[0.5, 20.0]).gap().is_none());
    }

    #[test]
    fn a_clipped_axis_says_so_at_both_ends() {
        let axis = Axis::log("", &[1e2, 1e5]).clipped();
        assert_eq!(labels(&axis), ["≤ 10²", "10³", "10⁴", "≥ 10⁵"]);
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(
            labels(&Axis::linear("", &[-0.456, 0.0])),
            ["−0.4", "−0.3", "−0.2", "−0.1", "0.0"]
        );
    }
}
