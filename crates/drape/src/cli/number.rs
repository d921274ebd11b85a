//! Numbers on the command line.

/// Numerator and denominator of a fraction such as 1/60; 1 is the denominator of a number. `None` if
/// the text is neither.
pub(crate) fn fraction(text: &str) -> Option<(f64, f64)> {
    let (a, b) = text.split_once('/').unwrap_or((text, "1"));
    let one = |text: &str| text.trim().parse::<f64>().ok();
    one(a).zip(one(b))
}

/// A number, or the value of a fraction.
///
/// # Errors
/// What was expected, if the text is neither.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    fraction(text)
        .map(|(a, b)| a / b)
        .ok_or_else(|| "expected a number, such as 0.01, 1e-3 or 1/60".to_owned())
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn a_number_is_a_decimal_or_a_fraction() {
        let cases =
            [("0.25", Ok(0.25)), ("1e-3", Ok(1e-3)), ("1/4", Ok(0.25)), (" 3 / 2 ", Ok(1.5))];
        for (text, expected) in cases {
            assert_eq!(number(text), expected, "{text}");
        }
        for text in ["", "zero", "1/", "/4", "1/2/3", "1,5"] {
            let error = number(text).expect_err(text);
            assert!(error.contains("1/60"), "{text}: {error}");
        }
    }
}
