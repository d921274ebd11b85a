//! The page, as it is compiled into the program. `page/` holds its sources.

/// A file of the page.
pub(crate) struct Asset {
    /// Name below the address of the lab; empty for the page itself.
    pub(crate) name: &'static str,
    /// Content type.
    pub(crate) kind: &'static str,
    /// Content.
    pub(crate) bytes: &'static [u8],
}

/// All files of the page.
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

/// What the page may load and whom it may talk to: this server alone.
pub(crate) const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
     img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
     frame-ancestors 'none'";
