//! Small parts of the report: marked words, cells, names of places, drawings.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use minijinja::value::{Serde, Value};
use serde::Serialize;

/// A piece of a sentence.
#[derive(Debug, PartialEq, Serialize)]
pub(super) struct Span {
    /// `text`, `strong` or `code`.
    pub(super) kind: &'static str,
    pub(super) text: String,
}

/// Splits a sentence at `**strong**` and `` `code` ``; a mark without its partner is text.
pub(super) fn spans(text: &str) -> Vec<Span> {
    let mut spans = Vec::new();
    let mut rest = text;
    let span = |kind, text: &str| Span { kind, text: text.to_owned() };
    while let Some((at, kind, mark)) = next_mark(rest) {
        let inside = &rest[at + mark.len()..];
        let Some(end) = inside.find(mark) else { break };
        spans.extend((at > 0).then(|| span("text", &rest[..at])));
        spans.push(span(kind, &inside[..end]));
        rest = &inside[end + mark.len()..];
    }
    spans.extend((!rest.is_empty()).then(|| span("text", rest)));
    spans
}

/// Where the first mark is that has a partner.
fn next_mark(text: &str) -> Option<(usize, &'static str, &'static str)> {
    [("strong", "**"), ("code", "`")]
        .into_iter()
        .filter_map(|(kind, mark)| {
            let at = text.find(mark)?;
            text[at + mark.len()..].contains(mark).then_some((at, kind, mark))
        })
        .min()
}

/// [`spans`] for a template.
pub(super) fn spans_value(text: String) -> Value {
    Value::from(Serde(spans(&text)))
}

/// The id of a figure or a section: its name without the characters that ids must not hold.
pub(super) fn slug(name: &str) -> String {
    let name = name.strip_suffix(".svg").unwrap_or(name);
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

/// Verdicts and other words that a cell may consist of, with the class that colours it.
const WORDS: [(&str, &[&str]); 4] = [
    ("good", &["holds", "stable", "completed"]),
    ("fair", &["marginal", "undecided", "locked"]),
    ("bad", &["fails", "unstable", "diverged", "unexplained"]),
    ("idle", &["refused", "not applicable", "over budget", "stopped", "–"]),
];

/// The class of a cell, by its verdict or the sign behind its number; empty for any other.
pub(super) fn verdict(text: String) -> &'static str {
    let word = text.trim_matches('*').trim();
    let known = WORDS.iter().find(|(_, words)| words.contains(&word));
    match known {
        Some((class, _)) => class,
        None if word.ends_with('✗') => "bad",
        None if word.ends_with('°') => "fair",
        None => "",
    }
}

/// A drawing as part of a page. Its title and description get ids of their own, since a page holds
/// several; its numbers lose the digits that binary fractions add.
pub(super) fn inlined(svg: &str, slug: &str) -> String {
    let mut text = svg.trim().to_owned();
    for (from, to) in [
        ("aria-labelledby=\"title desc\"", format!("aria-labelledby=\"{slug}-title {slug}-desc\"")),
        ("<title id=\"title\">", format!("<title id=\"{slug}-title\">")),
        ("<desc id=\"desc\">", format!("<desc id=\"{slug}-desc\">")),
        (" xmlns=\"http://www.w3.org/2000/svg\"", String::new()),
    ] {
        text = text.replacen(from, &to, 1);
    }
    text.replace(" opacity=\"1\"", "").replace("15.000000000000002", "15")
}

/// A drawing that embeds a picture, with title and description.
pub(super) fn picture(png: &[u8], [title, description]: [&str; 2]) -> String {
    // Width and height stand at the beginning of the first chunk.
    let side = |at: usize| {
        let bytes = png.get(at..at + 4).and_then(|bytes| bytes.try_into().ok());
        bytes.map_or(0, u32::from_be_bytes)
    };
    let (width, height) = (side(16), side(20));
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    format!(
        "<svg role=\"img\" aria-labelledby=\"title desc\" viewBox=\"0 0 {width} {height}\">\n\
         <title id=\"title\">{}</title>\n<desc id=\"desc\">{}</desc>\n\
         <image width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{}\"/>\n</svg>",
        escaped(title),
        escaped(description),
        BASE64_STANDARD.encode(png)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<(&'static str, String)> {
        spans(text).into_iter().map(|span| (span.kind, span.text)).collect()
    }

    #[test]
    fn marks_with_a_partner_are_cut_out_and_others_stay() {
        let span = |kind, text: &str| (kind, text.to_owned());
        assert_eq!(
            kinds("**Bold.** then `code`, end"),
            [
                span("strong", "Bold."),
                span("text", " then "),
                span("code", "code"),
                span("text", ", end"),
            ]
        );
        assert_eq!(kinds("2 ** 3 `x`"), [span("text", "2 ** 3 "), span("code", "x")]);
        assert_eq!(kinds("a ` b"), [span("text", "a ` b")]);
        assert!(kinds("").is_empty());
    }

    #[test]
    fn cells_are_coloured_by_whole_words_and_signs_only() {
        let cases = [
            ("holds", "good"),
            ("**fails**", "bad"),
            ("undecided", "fair"),
            ("1.2 ✗", "bad"),
            ("0.3 °", "fair"),
            ("an unstable run", ""),
            ("0.3", ""),
        ];
        for (text, class) in cases {
            assert_eq!(verdict(text.to_owned()), class, "{text}");
        }
    }

    #[test]
    fn titles_and_descriptions_of_pictures_are_escaped() {
        let text = picture(&[], ["a < b", "b > a & c"]);
        assert!(text.contains(">a &lt; b</title>"), "{text}");
        assert!(text.contains(">b &gt; a &amp; c</desc>"), "{text}");
    }

    #[test]
    fn an_inlined_drawing_has_ids_of_its_own_and_names_no_address() {
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-labelledby=\"title desc\">\n\
                   <title id=\"title\">T</title>\n<desc id=\"desc\">D</desc></svg>\n";
        let text = inlined(svg, "a");
        assert!(text.contains("aria-labelledby=\"a-title a-desc\""), "{text}");
        assert!(text.contains("id=\"a-title\"") && text.contains("id=\"a-desc\""), "{text}");
        assert!(!text.contains("http"), "{text}");
    }
}
