//! The report in a browser: Chromium opens it from disk, on a phone and on a desk, light and dark, and prints it.
//!
//! Without Chromium these tests say that they were skipped; with DRAPE_BROWSER=required they fail then.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod common;

use drape_harness::studies::draw;
use headless_chrome::protocol::cdp::types::Event;
use headless_chrome::protocol::cdp::{Emulation, Log, Network, Page};
use headless_chrome::{Browser, LaunchOptions, Tab};
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const PHONE: u32 = 390;
const DESK: u32 = 1280;
/// Every action may take this long on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Chromium, or `None` after saying that there is none.
fn chromium() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::env::split_paths(&folders).collect::<Vec<_>>();
    let found = names
        .iter()
        .flat_map(|name| paths.iter().map(move |path| path.join(name)))
        .find(|path| path.is_file());
    if found.is_none() {
        let is_required =
            std::env::var_os("DRAPE_BROWSER").is_some_and(|value| value == "required");
        assert!(!is_required, "DRAPE_BROWSER=required, but no chromium is on the path");
        println!("skipped: no chromium is on the path");
    }
    found
}

/// A page that was opened, and all that went wrong on it.
struct Opened {
    tab: Arc<Tab>,
    complaints: Arc<Mutex<Vec<String>>>,
    _browser: Browser,
}

/// Opens the report of a folder in a window so wide; notes requests, messages of the console and exceptions.
fn open(chromium: PathBuf, results: &Path, width: u32, scheme: &str) -> Opened {
    let options = LaunchOptions::default_builder()
        .path(Some(chromium))
        // Who runs tests as root, as in a container, has no sandbox.
        .sandbox(false)
        .window_size(Some((width, 900)))
        .idle_browser_timeout(PATIENCE)
        .args(vec![OsStr::new("--disable-dev-shm-usage")])
        .build()
        .unwrap();
    let browser = Browser::new(options).unwrap();
    let tab = browser.new_tab().unwrap();
    tab.set_default_timeout(PATIENCE);
    tab.call_method(Emulation::SetDeviceMetricsOverride {
        width,
        height: 900,
        device_scale_factor: 1.0,
        mobile: width < 600,
        scale: None,
        screen_width: None,
        screen_height: None,
        position_x: None,
        position_y: None,
        dont_set_visible_size: None,
        screen_orientation: None,
        viewport: None,
        display_feature: None,
        device_posture: None,
    })
    .unwrap();
    emulate(&tab, scheme);

    let address = format!("file://{}", results.join("report.html").display());
    let complaints = Arc::new(Mutex::new(Vec::new()));
    let (notes, own) = (Arc::clone(&complaints), address.clone());
    tab.add_event_listener(Arc::new(move |event: &Event| {
        let complaint = match event {
            Event::NetworkRequestWillBeSent(event) => {
                let url = &event.params.request.url;
                (*url != own && !url.starts_with("data:")).then(|| format!("request for {url}"))
            }
            Event::RuntimeConsoleAPICalled(event) => {
                Some(format!("console {:?}: {:?}", event.params.Type, event.params.args))
            }
            Event::RuntimeExceptionThrown(event) => {
                Some(format!("exception: {:?}", event.params.exception_details))
            }
            Event::LogEntryAdded(event)
                if event.params.entry.level != Log::LogEntryLevel::Verbose =>
            {
                Some(format!("log: {:?}", event.params.entry))
            }
            _ => None,
        };
        notes.lock().unwrap().extend(complaint);
    }))
    .unwrap();
    tab.enable_runtime().unwrap();
    tab.enable_log().unwrap();
    tab.call_method(Network::Enable {
        max_total_buffer_size: None,
        max_resource_buffer_size: None,
        max_post_data_size: None,
        report_direct_socket_traffic: None,
        enable_durable_messages: None,
    })
    .unwrap();
    tab.navigate_to(&address).unwrap().wait_until_navigated().unwrap();
    Opened { tab, complaints, _browser: browser }
}

/// Light or dark.
fn emulate(tab: &Tab, scheme: &str) {
    let feature = Emulation::MediaFeature {
        name: "prefers-color-scheme".to_owned(),
        value: scheme.to_owned(),
    };
    tab.call_method(Emulation::SetEmulatedMedia { media: None, features: Some(vec![feature]) })
        .unwrap();
}

impl Opened {
    /// The value of an expression, by way of JSON.
    fn value(&self, expression: &str) -> Value {
        let object = self.tab.evaluate(&format!("JSON.stringify({expression})"), true).unwrap();
        serde_json::from_str(object.value.unwrap().as_str().unwrap()).unwrap()
    }

    /// Keeps a picture below the folder in DRAPE_REPORT_LOOK, for a look at it.
    fn keep(&self, name: &str) {
        let Some(folder) = std::env::var_os("DRAPE_REPORT_LOOK") else { return };
        let format = Page::CaptureScreenshotFormatOption::Png;
        let picture = self.tab.capture_screenshot(format, None, None, true).unwrap();
        std::fs::write(Path::new(&folder).join(name), picture).unwrap();
    }
}

/// What holds at every width.
fn check(results: &Path, width: u32) {
    let Some(chromium) = chromium() else { return };
    draw(results).unwrap();
    let page = open(chromium, results, width, "light");

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

    sorts(&page);
    enlarges(&page);
    let is_open = page.value("document.getElementById('contents').open");
    assert_eq!(is_open, json!(width > 600), "the contents are closed on a phone");

    let colours = "getComputedStyle(document.body).backgroundColor";
    let light = page.value(colours);
    emulate(&page.tab, "dark");
    assert_ne!(page.value(colours), light);
    page.keep(&format!("dark-{width}.png"));
    emulate(&page.tab, "light");
    assert_eq!(page.value(colours), light);

    let pdf = page.tab.print_to_pdf(None).unwrap();
    assert!(pdf.starts_with(b"%PDF") && pdf.len() > 20_000, "{} bytes", pdf.len());
    if let Some(folder) = std::env::var_os("DRAPE_REPORT_LOOK") {
        std::fs::write(Path::new(&folder).join(format!("print-{width}.pdf")), pdf).unwrap();
    }
    let complaints = page.complaints.lock().unwrap();
    assert!(complaints.is_empty(), "{complaints:#?}");
}

/// A click on the head of a column sorts by it, another one turns the order round; so does the keyboard.
fn sorts(page: &Opened) {
    page.value(
        "(() => { const heads = [...document.querySelectorAll('main table')].map((t) => t.tHead.rows[0].cells[0]); \
         window.head = heads.find((h) => { const c = [...h.closest('table').tBodies[0].rows].map((r) => r.cells[0].textContent); return new Set(c).size > 2; }); \
         window.column = () => [...head.closest('table').tBodies[0].rows].map((r) => r.cells[0].textContent.trim()); \
         window.before = column(); for (const d of document.querySelectorAll('details')) if (d.contains(head)) d.open = true; return 1; })()",
    );
    let click = "head.querySelector('button').click()";
    let before = page.value("column()");
    page.tab.evaluate(click, false).unwrap();
    let (rising, order) = (page.value("column()"), page.value("head.getAttribute('aria-sort')"));
    assert_eq!(order, json!("ascending"));
    page.tab.evaluate("head.querySelector('button').focus()", false).unwrap();
    page.tab.press_key("Enter").unwrap();
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
fn enlarges(page: &Opened) {
    page.tab.evaluate("document.querySelector('.enlarge').click()", false).unwrap();
    assert_eq!(page.value("document.getElementById('large').open"), json!(true));
    let width = page.value("document.querySelector('dialog svg').getBoundingClientRect().width");
    assert!(width.as_f64().unwrap() > 900.0, "{width}");
    let twice = "[...document.querySelectorAll('[id]')].length - new Set([...document.querySelectorAll('[id]')].map((e) => e.id)).size";
    assert_eq!(page.value(twice), json!(0));
    page.tab.evaluate("document.querySelector('dialog button').click()", false).unwrap();
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
