//! Excerpts of a source text, found by their first and last lines.

/// Most lines of an excerpt.
const MOST: usize = 40;

/// Some lines of a file. The first is the only line that contains `from`. The last is the first
/// line from there on that contains `to`.
#[derive(Clone, Copy, Debug)]
pub struct Excerpt {
    /// The file, from the folder of its crate.
    pub file: &'static str,
    /// Text that the first line contains, and no other line.
    pub from: &'static str,
    /// Text that the last line contains.
    pub to: &'static str,
}

impl Excerpt {
    /// An excerpt of `src/lib.rs`.
    pub(crate) const fn docs(from: &'static str, to: &'static str) -> Self {
        Self { file: "src/lib.rs", from, to }
    }

    /// An excerpt of `src/step.rs`.
    pub(crate) const fn step(from: &'static str, to: &'static str) -> Self {
        Self { file: "src/step.rs", from, to }
    }

    /// An excerpt of another file.
    pub(crate) const fn of(file: &'static str, from: &'static str, to: &'static str) -> Self {
        Self { file, from, to }
    }

    /// The lines, without their common indentation and without the marks of documentation. `None`
    /// if they are missing, if there are too many of them, or if the first line is not unique.
    pub(crate) fn find(&self, sources: &[(&str, &str)]) -> Option<String> {
        let (_, text) = sources.iter().find(|(file, _)| *file == self.file)?;
        let lines: Vec<&str> = text.lines().map(plain).collect();
        let mut begins = (0..lines.len()).filter(|&n| lines[n].contains(self.from));
        let (begin, None) = (begins.next()?, begins.next()) else { return None };
        let length = lines[begin..].iter().position(|line| line.contains(self.to))? + 1;
        let part = (length <= MOST).then(|| &lines[begin..begin + length])?;
        let indent = |line: &&&str| line.len() - line.trim_start().len();
        let filled = part.iter().filter(|line| !line.trim().is_empty());
        let common = filled.map(|line| indent(&line)).min()?;
        let shown = part.iter().map(|line| line.get(common..).unwrap_or_default().trim_end());
        Some(shown.collect::<Vec<_>>().join("\n"))
    }
}

/// A line without the marks of documentation.
fn plain(line: &str) -> &str {
    line.strip_prefix("//! ").or_else(|| line.strip_prefix("//!")).unwrap_or(line)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    const TEXT: &[(&str, &str)] =
        &[("src/lib.rs", "//! a = b  (1)\n//!   b = c  (2)\n\n    let a = 1;\n        let b;\n")];

    #[test]
    fn an_excerpt_loses_its_indentation_and_nothing_else() {
        assert_eq!(Excerpt::docs("(1)", "(2)").find(TEXT).unwrap(), "a = b  (1)\n  b = c  (2)");
        assert_eq!(Excerpt::docs("a = 1", "let b").find(TEXT).unwrap(), "let a = 1;\n    let b;");
    }

    #[test]
    fn what_is_not_there_or_not_unique_is_not_found() {
        assert_eq!(Excerpt::docs("(3)", "(3)").find(TEXT), None);
        assert_eq!(Excerpt::docs("(1)", "(3)").find(TEXT), None);
        assert_eq!(Excerpt::docs("let", "let b").find(TEXT), None);
        assert_eq!(Excerpt::step("(1)", "(2)").find(TEXT), None);
    }
}
