//! The report in a browser: Chromium opens it from disk, on a phone and on a desk, light and dark,
//! and prints it.
//!
//! Without Chromium these tests say that they were skipped; with DRAPE_BROWSER=required they fail
//! then.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;

use crate::devtools::{Browser, chromium};
use base64::prelude::{BASE64_STANDARD, Engine as _};
use drape_harness::studies::draw;
use serde_json::{Value, json};
use std::path::Path;

const PHONE: u32 = 390;
const DESK: u32 = 1280;

/// A page that was opened from disk.
struct Opened {
    browser: Browser,
    address: String,
}

/// Opens the report of a folder in a window so wide.
fn open(chromium: &Path, results: &Path, width: u32, scheme: &str) -> Opened {
    let mut browser = Browser::start(chromium);
    for domain in ["Page", "Runtime", "Log", "Network"] {
        browser.call(&format!("{domain}.enable"), &json!({}));
    }
    let window =
        json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600 });
    browser.call("Emulation.setDeviceMetricsOverride", &window);
    let address = format!("file://{}", results.join("report.html").display());
    let mut page = Opened { browser, address };
    page.emulate(scheme);
    page.browser.call("Page.navigate", &json!({ "url": page.address }));
    page.browser.wait_for("Page.loadEventFired");
    page
}

impl Opened {
    fn value(&mut self, expression: &str) -> Value {
        self.browser.value(expression)
    }

    /// Light or dark.
    fn emulate(&mut self, scheme: &str) {
        let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
        self.browser.call("Emulation.setEmulatedMedia", &json!({ "features": [feature] }));
    }

    /// Requests for anything but the page, messages of the console, exceptions and log entries.
    fn complaints(&self) -> Vec<String> {
        let complaint = |event: &Value| {
            let params = &event["params"];
            match event["method"].as_str().unwrap() {
                "Network.requestWillBeSent" => {
                    let url = params["request"]["url"].as_str().unwrap();
                    (url != self.address && !url.starts_with("data:"))
                        .then(|| format!("request for {url}"))
                }
                "Log.entryAdded" if params["entry"]["level"] == "verbose" => None,
                "Log.entryAdded" | "Runtime.consoleAPICalled" | "Runtime.exceptionThrown" => {
                    Some(event.to_string())
                }
                _ => None,
            }
        };
        self.browser.events.iter().filter_map(complaint).collect()
    }

    /// Keeps a file below the folder in DRAPE_REPORT_LOOK, if it is set: a human can then look at
    /// it.
    fn keep(name: &str, bytes: impl FnOnce() -> Vec<u8>) {
        if let Some(folder) = std::env::var_os("DRAPE_REPORT_LOOK") {
            std::fs::write(Path::new(&folder).join(name), bytes()).unwrap();
        }
    }

    /// The bytes that a command of the page returns.
    fn bytes(&mut self, method: &str, params: &Value) -> Vec<u8> {
        let answer = self.browser.call(method, params);
        BASE64_STANDARD.decode(answer["data"].as_str().unwrap()).unwrap()
    }
}

/// What holds at every width.
fn check(results: &Path, width: u32) {
    let Some(chromium) = chromium() else { return };
    draw(results).unwrap();
    let mut page = open(&chromium, results, width, "light");

    assert_eq!(page.value("innerWidth"), json!(width));
    assert_eq!(
        page.value("[...document.querySelectorAll('body *')].filter((e) => !e.closest('.scroll, dialog, svg, .skip') && e.getBoundingClientRect().right > innerWidth + 1).map((e) => e.tagName + ' ' + e.className)"),
        json!([]),
        "what reaches beyond the window"
    );
    let overflow = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
    assert_eq!(page.value(overflow), json!(0), "the page scrolls sideways");
    let figures = page.value(
        "[...document.querySelectorAll('main figure')].map((f) => { const b = f.querySelector('svg').getBoundingClientRect(); return [f.id, b.left, b.right, b.height]; })",
    );
    let figures = figures.as_array().unwrap();
    assert!(!figures.is_empty());
    for figure in figures {
        let number = |n: usize| figure[n].as_f64().unwrap();
        assert!(number(1) >= 0.0 && number(2) <= f64::from(width), "{figure}");
        assert!(
            number(3) > 100.0 && number(2) - number(1) > 0.6 * f64::from(width.min(900)),
            "{figure}"
        );
    }

    sorts(&mut page);
    enlarges(&mut page);
    let is_open = page.value("document.getElementById('contents').open");
    assert_eq!(is_open, json!(width > 600), "the contents are closed on a phone");

    let colours = "getComputedStyle(document.body).backgroundColor";
    let light = page.value(colours);
    page.emulate("dark");
    assert_ne!(page.value(colours), light);
    Opened::keep(&format!("dark-{width}.png"), || page.bytes("Page.captureScreenshot", &json!({})));
    page.emulate("light");
    assert_eq!(page.value(colours), light);

    let pdf = page.bytes("Page.printToPDF", &json!({}));
    assert!(pdf.starts_with(b"%PDF") && pdf.len() > 20_000, "{} bytes", pdf.len());
    Opened::keep(&format!("print-{width}.pdf"), || pdf);
    let complaints = page.complaints();
    assert!(complaints.is_empty(), "{complaints:#?}");
}

/// A click on the head of a column sorts by it, another one turns the order round; so does the
/// keyboard.
fn sorts(page: &mut Opened) {
    page.value(
        "(() => { const heads = [...document.querySelectorAll('main table')].map((t) => t.tHead.rows[0].cells[0]); \
         window.head = heads.find((h) => { const c = [...h.closest('table').tBodies[0].rows].map((r) => r.cells[0].textContent); return new Set(c).size > 2; }); \
         window.column = () => [...head.closest('table').tBodies[0].rows].map((r) => r.cells[0].textContent.trim()); \
         window.before = column(); for (const d of document.querySelectorAll('details')) if (d.contains(head)) d.open = true; return 1; })()",
    );
    let click = "head.querySelector('button').click()";
    let before = page.value("column()");
    page.value(click);
    let (rising, order) = (page.value("column()"), page.value("head.getAttribute('aria-sort')"));
    assert_eq!(order, json!("ascending"));
    page.value("head.querySelector('button').focus()");
    page.browser.press_enter();
    let (falling, order) = (page.value("column()"), page.value("head.getAttribute('aria-sort')"));
    assert_eq!(order, json!("descending"));
    assert_ne!(rising, falling);
    let sorted = |value: &Value| {
        let mut cells: Vec<_> = value.as_array().unwrap().iter().map(Value::to_string).collect();
        cells.sort();
        cells
    };
    assert_eq!(sorted(&before), sorted(&rising), "no row is lost");
    let ends = |value: &Value| {
        let cells = value.as_array().unwrap();
        (cells[0].clone(), cells[cells.len() - 1].clone())
    };
    let ((first, last), (top, bottom)) = (ends(&rising), ends(&falling));
    assert_eq!((first, last), (bottom, top));
}

/// A figure opens large and closes again; no id is there twice meanwhile.
fn enlarges(page: &mut Opened) {
    page.value("document.querySelector('.enlarge').click()");
    assert_eq!(page.value("document.getElementById('large').open"), json!(true));
    let width = page.value("document.querySelector('dialog svg').getBoundingClientRect().width");
    assert!(width.as_f64().unwrap() > 900.0, "{width}");
    let twice = "[...document.querySelectorAll('[id]')].length - new Set([...document.querySelectorAll('[id]')].map((e) => e.id)).size";
    assert_eq!(page.value(twice), json!(0));
    page.value("document.querySelector('dialog button').click()");
    assert_eq!(page.value("document.getElementById('large').open"), json!(false));
}

#[test]
fn the_report_of_complete_records_works_on_a_phone() {
    check(common::complete().path(), PHONE);
}

#[test]
fn the_report_of_complete_records_works_on_a_desk() {
    check(common::complete().path(), DESK);
}

#[test]
fn the_report_of_the_committed_records_works_on_a_phone() {
    check(common::copy_of_committed().path(), PHONE);
}

#[test]
fn the_report_of_the_committed_records_works_on_a_desk() {
    check(common::copy_of_committed().path(), DESK);
}
