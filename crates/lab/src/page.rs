//! The page, as it is compiled into the program. `page/` holds its sources.

use drape_harness::record::Judged;
use std::sync::OnceLock;

/// A file of the page.
#[cfg(feature = "server")]
pub(crate) struct Asset {
    /// Name below the address of the lab; empty for the page itself.
    pub(crate) name: &'static str,
    /// Content type.
    pub(crate) kind: &'static str,
    /// Content.
    pub(crate) bytes: &'static [u8],
}

/// All files of the page.
#[cfg(feature = "server")]
pub(crate) const ASSETS: [Asset; 3] = [
    Asset { name: "", kind: "text/html; charset=utf-8", bytes: include_bytes!("../page/lab.html") },
    Asset {
        name: "lab.css",
        kind: "text/css; charset=utf-8",
        bytes: include_bytes!("../page/lab.css"),
    },
    Asset {
        name: "lab.js",
        kind: "text/javascript; charset=utf-8",
        bytes: include_bytes!("../page/lab.js"),
    },
];

/// The content security policy: the page loads from this server alone and talks to it alone.
#[cfg(feature = "server")]
pub(crate) const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
     img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
     frame-ancestors 'none'";

/// The source that decides the verdicts, as it was compiled.
const JUDGEMENT: &str = include_str!("../../harness/src/judgement.rs");
/// The address of that source below the page's own.
pub(crate) const SOURCE: &str = "judgement.rs.html";

/// A part of the line that decides a verdict.
fn mark(kind: Judged) -> &'static str {
    match kind {
        Judged::Stable => "(false, true) => (Judged::Stable",
        Judged::Locked => "(true, _) => (Judged::Locked",
        Judged::GainedEnergy => "let is_sure = sure >",
        Judged::Diverged => "(Judged::Diverged,",
        Judged::Unknown => "(false, false) => (Judged::Unknown",
    }
}

/// The line that decides a verdict, as an address below that of the page.
pub(crate) fn decides(kind: Judged) -> String {
    let line = JUDGEMENT.lines().position(|line| line.contains(mark(kind)));
    line.map_or_else(|| SOURCE.to_owned(), |line| format!("{SOURCE}#L{}", line + 1))
}

/// The source that decides the verdicts as a page, with a place for each line.
pub fn source() -> &'static str {
    static PAGE: OnceLock<String> = OnceLock::new();
    PAGE.get_or_init(|| {
        let escape = |line: &str| line.replace('&', "&amp;").replace('<', "&lt;");
        let lines: String = (1..)
            .zip(JUDGEMENT.lines())
            .map(|(n, line)| format!("<span id=\"L{n}\">{n:>4}  {}</span>\n", escape(line)))
            .collect();
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <title>How drape judges a run</title>\n<link rel=\"icon\" href=\"data:,\">\n\
             <link rel=\"stylesheet\" href=\"lab.css\">\n</head>\n<body>\n\
             <h1>crates/harness/src/judgement.rs</h1>\n<pre class=\"source\">{lines}</pre>\n\
             </body>\n</html>\n"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_verdict_has_a_line_that_decides_it() {
        let kinds = [
            Judged::Stable,
            Judged::Locked,
            Judged::GainedEnergy,
            Judged::Diverged,
            Judged::Unknown,
        ];
        for kind in kinds {
            let found = JUDGEMENT.lines().filter(|line| line.contains(mark(kind))).count();
            assert_eq!(found, 1, "{kind:?}");
            let place = decides(kind);
            let line = place.rsplit_once('#').map(|(_, line)| line.to_owned()).unwrap_or_default();
            assert!(source().contains(&format!("id=\"{line}\"")), "{place}");
        }
    }
}
