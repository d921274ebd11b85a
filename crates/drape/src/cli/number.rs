//! Numbers on the command line.

/// A number, or a fraction such as 1/60.
///
/// # Errors
/// What was expected, if the text is neither.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    let one = |text: &str| text.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((a, b)) => one(a).zip(one(b)).map(|(a, b)| a / b),
        None => one(text),
    };
    value.ok_or_else(|| "expected a number, such as 0.01, 1e-3 or 1/60".to_owned())
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
