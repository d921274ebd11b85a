//! Messages on standard error.

use std::borrow::Cow;
use std::io::Write as _;

/// Writes a message as one line to standard error, with the arguments of [`format!`]. What is not
/// [`printable`](crate::printable) in it is escaped.
///
/// A message is a courtesy: where it cannot be written, because the reader closed the pipe or the
/// disk is full, the program goes on, and its exit code stays what it is. [`eprintln!`] panics.
#[macro_export]
macro_rules! tell {
    ($($part:tt)*) => { $crate::tell(::std::format_args!($($part)*)) };
}

/// Writes a message as one line to standard error. See [`tell!`](crate::tell!).
pub fn tell(message: std::fmt::Arguments<'_>) {
    // One write a line, so that lines of several processes do not mix.
    let line = format!("{}\n", printable(&message.to_string()));
    let _ = std::io::stderr().lock().write_all(line.as_bytes());
}

/// Escapes the characters that move the cursor, start a terminal sequence or change the direction
/// of writing. Names come from files, and files may come from anywhere.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_command) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '\n' | '\r' | '\t' => shown.extend(c.escape_default()),
            c if is_command(c) => shown.extend(c.escape_unicode()),
            c => shown.push(c),
        }
    }
    Cow::Owned(shown)
}

/// Whether a character is for the terminal and not for the eye.
fn is_command(c: char) -> bool {
    // Marks of direction, separators of lines and paragraphs, the mark of the byte order.
    let is_mark =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || is_mark || c == '\u{feff}'
}

#[cfg(test)]
mod tests {
    use super::printable;

    #[test]
    fn what_commands_a_terminal_is_escaped_and_nothing_else() {
        let cases = [
            ("\u{1b}[31mred", r"\u{1b}[31mred"),
            ("one\ntwo\r\tthree", r"one\ntwo\r\tthree"),
            ("\u{9b}2J\u{7}\u{202e}", r"\u{9b}2J\u{7}\u{202e}"),
            (r"C:\ö – h² ‖r‖ ✗", r"C:\ö – h² ‖r‖ ✗"),
        ];
        for (text, shown) in cases {
            assert_eq!(printable(text), shown);
        }
    }
}
