//! Numbers as text, with a sensible number of digits and readable powers of ten.

/// An integer in superscript digits.
fn superscript(n: i32) -> String {
    n.to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4'..='9' => char::from_u32('⁴' as u32 + (c as u32 - '4' as u32)).unwrap_or(c),
            _ => '⁰',
        })
        .collect()
}

/// The exponent n if `value` equals 10ⁿ up to rounding.
pub fn exponent_of_ten(value: f64) -> Option<i32> {
    if value <= 0.0 {
        return None;
    }
    let exponent = libm::log10(value);
    let rounded = libm::round(exponent);
    (libm::fabs(exponent - rounded) < 1e-9).then_some(rounded as i32)
}

/// 10ⁿ: `1`, `10`, `10⁴`, `10⁻³`.
pub fn power_of_ten(exponent: i32) -> String {
    match exponent {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        n => format!("10{}", superscript(n)),
    }
}

/// A stiffness over mass or another quantity that is usually a power of ten.
pub fn power(value: f64) -> String {
    exponent_of_ten(value).map_or_else(|| significant(value, 3), power_of_ten)
}

/// A setting such as a step or a forcing term, as the shortest decimal; as a power of ten beyond
/// four zeros.
pub fn setting(value: f64) -> String {
    if value != 0.0 && libm::fabs(value) < 1e-4 { power(value) } else { format!("{value}") }
}

/// The median. For an even number of values it is the mean of the two in the middle; `None` for no
/// values.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        n if n.is_multiple_of(2) => Some(0.5 * (values[middle - 1] + values[middle])),
        _ => Some(values[middle]),
    }
}

/// The median, in s, of times in nanoseconds; 0 for no times.
pub fn median_s(nanoseconds: &[u64]) -> f64 {
    1e-9 * median(nanoseconds.iter().map(|&ns| ns as f64)).unwrap_or(0.0)
}

/// A share in per cent, with `digits` significant digits.
pub fn percent(share: f64, digits: i32) -> String {
    format!("{} %", significant(100.0 * share, digits))
}

/// `value` with `digits` significant digits. Powers of ten are used only to avoid many zeros.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let sign = if value < 0.0 { "−" } else { "" };
    let size = libm::fabs(value);
    let mut exponent = libm::floor(libm::log10(size)) as i32;
    // 9.996 at three digits is 10.0: the exponent of the rounded number counts.
    if libm::round(size / ten_to(exponent - digits + 1)) >= ten_to(digits) {
        exponent += 1;
    }
    if (-3..6).contains(&exponent) {
        let decimals = (digits - 1 - exponent).max(0) as usize;
        format!("{sign}{size:.decimals$}")
    } else {
        let decimals = (digits - 1).max(0) as usize;
        format!("{sign}{:.decimals$}·10{}", size / ten_to(exponent), superscript(exponent))
    }
}

/// As [`significant`], without trailing zeros after the decimal point, for quotients of small
/// integers.
pub fn trimmed(value: f64, digits: i32) -> String {
    let text = significant(value, digits);
    if text.contains('.') && !text.contains('·') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn ten_to(exponent: i32) -> f64 {
    libm::pow(10.0, f64::from(exponent))
}

/// Wraps text to lines of at most `width` characters. Longer words are not split.
pub fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_with_sensible_digits() {
        let cases = [
            (0.0, "0"),
            (1.0, "1.00"),
            (9.996, "10.0"),
            (0.04567, "0.0457"),
            (-456.7, "−457"),
            (123_456.0, "123456"),
            (1_234_567.0, "1.23·10⁶"),
            (1.234e-7, "1.23·10⁻⁷"),
            (9.999e-7, "1.00·10⁻⁶"),
            (4.5e300, "4.50·10³⁰⁰"),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value, 3), text, "{value}");
        }
    }

    #[test]
    fn quotients_of_small_integers_keep_no_idle_zeros() {
        let cases = [(0.07, "0.07"), (2.0, "2"), (100.0, "100"), (1.5e-9, "1.50·10⁻⁹"), (0.0, "0")];
        for (value, text) in cases {
            assert_eq!(trimmed(value, 3), text, "{value}");
        }
    }

    #[test]
    fn the_median_lies_in_the_middle_of_sorted_values() {
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([4.0, 1.0, 2.0, 9.0]), Some(3.0));
        assert_eq!(median([]), None);
        assert_eq!(median_s(&[30, 10, 20]), 20e-9);
        assert_eq!(median_s(&[]), 0.0);
    }

    #[test]
    fn powers_of_ten_are_superscripts() {
        assert_eq!(power(1e4), "10⁴");
        assert_eq!(power(1e-3), "10⁻³");
        assert_eq!(power(1.0), "1");
        assert_eq!(power(4.69e7), "4.69·10⁷");
        assert_eq!(setting(0.05), "0.05");
        assert_eq!(setting(1e-6), "10⁻⁶");
    }

    #[test]
    fn lines_are_broken_between_words() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert!(wrap("", 7).is_empty());
    }
}
