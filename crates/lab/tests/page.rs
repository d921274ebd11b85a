//! The lab in a browser: Chromium opens it, and a person's clicks are made.
//!
//! Without Chromium these tests say that they were skipped; with DRAPE_BROWSER=required they fail
//! then. DRAPE_LAB_LOOK names a folder for screenshots.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

#[path = "../../harness/tests/devtools/mod.rs"]
mod devtools;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use devtools::{Browser, chromium};
use drape_lab::{Runs, Server};
use serde_json::{Value, json};
use std::path::Path;
use std::time::{Duration, Instant};

/// A busy machine that draws in software may need this long.
const PATIENCE: Duration = Duration::from_secs(180);
const PHONE: u32 = 390;
const DESK: u32 = 1280;

/// A server that lives as long as the test program.
fn serve() -> (String, Runs) {
    let server = Server::bind(0).unwrap();
    let (address, runs) = (server.address(), server.runs());
    std::thread::spawn(move || server.serve(std::future::pending()).unwrap());
    (address, runs)
}

struct Page {
    browser: Browser,
}

impl Page {
    fn open(chromium: &Path, address: &str, width: u32, features: &[(&str, &str)]) -> Self {
        let mut browser = Browser::start(chromium);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        let window =
            json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600 });
        browser.call("Emulation.setDeviceMetricsOverride", &window);
        let features: Vec<_> =
            features.iter().map(|(name, value)| json!({ "name": name, "value": value })).collect();
        browser.call("Emulation.setEmulatedMedia", &json!({ "features": features }));
        browser.call("Page.navigate", &json!({ "url": address }));
        browser.wait_for("Page.loadEventFired");
        Self { browser }
    }

    fn value(&mut self, expression: &str) -> Value {
        self.browser.value(expression)
    }

    /// Waits until an expression is true.
    fn wait_until(&mut self, expression: &str) {
        let begin = Instant::now();
        while self.value(expression) != json!(true) {
            if begin.elapsed() > PATIENCE {
                panic!("{expression}\n{}", self.value("document.body.innerText"));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Words of the verdicts, pane by pane.
    fn verdicts(&mut self) -> Value {
        self.value("[...document.querySelectorAll('.verdict strong')].map((e) => e.textContent)")
    }

    /// Changes an input as a person does.
    fn enter(&mut self, selector: &str, value: &str) {
        let (selector, value) = (json!(selector), json!(value));
        self.value(&format!(
            "{{ const e = document.querySelector({selector}); e.value = {value}; \
             e.dispatchEvent(new Event('change')); }}"
        ));
    }

    fn click(&mut self, selector: &str) {
        self.value(&format!("document.querySelector({}).click()", json!(selector)));
    }

    fn key(&mut self, key: &str) {
        let key = json!(key);
        self.value(&format!(
            "dispatchEvent.call(document.activeElement, new KeyboardEvent('keydown', {{ key: {key}, bubbles: true, cancelable: true }}))"
        ));
    }

    /// Complaints of the console, exceptions and requests elsewhere.
    fn complaints(&self, address: &str) -> Vec<String> {
        let base = address.split('#').next().unwrap();
        let complaint = |event: &Value| {
            let params = &event["params"];
            match event["method"].as_str().unwrap() {
                "Network.requestWillBeSent" => {
                    let url = params["request"]["url"].as_str().unwrap();
                    let is_own = url.starts_with(base) || url.starts_with("data:");
                    (!is_own).then(|| format!("request for {url}"))
                }
                "Runtime.consoleAPICalled" | "Runtime.exceptionThrown" => Some(event.to_string()),
                _ => None,
            }
        };
        self.browser.events.iter().filter_map(complaint).collect()
    }

    fn look(&mut self, name: &str) {
        let Some(folder) = std::env::var_os("DRAPE_LAB_LOOK") else { return };
        let whole = json!({ "format": "png", "captureBeyondViewport": true });
        let answer = self.browser.call("Page.captureScreenshot", &whole);
        let bytes = BASE64_STANDARD.decode(answer["data"].as_str().unwrap()).unwrap();
        std::fs::write(Path::new(&folder).join(name), bytes).unwrap();
    }
}

/// What a person sees who does nothing: one explodes, one stands still, one falls.
#[test]
fn the_lab_opens_with_three_panes_and_three_verdicts() {
    let Some(chromium) = chromium() else { return };
    for (width, scheme) in [(DESK, "light"), (DESK, "dark"), (PHONE, "light"), (PHONE, "dark")] {
        let (address, _) = serve();
        let features = [("prefers-color-scheme", scheme)];
        let mut page = Page::open(&chromium, &address, width, &features);
        page.wait_until("document.querySelectorAll('.pane').length === 3");
        page.wait_until("document.getElementById('play').textContent === 'Play again'");
        assert_eq!(page.verdicts(), json!(["diverged", "locked", "stable"]));
        let whys = page.value(
            "[...document.querySelectorAll('.verdict')].every((e) => e.lastChild.textContent.length > 20)",
        );
        assert_eq!(whys, json!(true));
        // Every picture shows something: not all of its points have one colour.
        let drawn = page.value(
            "[...document.querySelectorAll('canvas.view, canvas.plot')].map((c) => { const d = new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer); return new Set(d).size > 3; })",
        );
        assert_eq!(drawn, json!([true, true, true, true, true, true]), "{width} {scheme}");
        let overflow =
            "document.documentElement.scrollWidth - document.documentElement.clientWidth";
        assert_eq!(page.value(overflow), json!(0), "the page scrolls sideways at {width}");
        assert_eq!(page.complaints(&address), Vec::<String>::new());
        page.look(&format!("{width}-{scheme}.png"));
    }
}

#[test]
fn knobs_change_what_they_say_and_the_address_repeats_them() {
    let Some(chromium) = chromium() else { return };
    let (address, runs) = serve();
    let mut page = Page::open(&chromium, &address, DESK, &[]);
    page.wait_until("document.querySelectorAll('.pane').length === 3");
    // A short step for all: no method explodes, and plain IMEX moves.
    page.enter("#shared [data-knob=duration]", "0.05");
    page.enter("#shared [data-knob=stiffness]", "1e4");
    page.enter("#shared [data-knob=step]", "0.001");
    page.wait_until("decodeURIComponent(location.hash).includes('step=0.001')");
    page.wait_until("document.getElementById('play').textContent === 'Play again'");
    page.wait_until(
        "[...document.querySelectorAll('.verdict strong')].every((e) => e.textContent === 'stable')",
    );
    // A value out of range is refused with a sentence, and the set-up stays.
    let before = page.value("location.hash");
    page.enter("#shared [data-knob=step]", "-3");
    page.wait_until("document.getElementById('message').textContent.includes('Time step')");
    assert_eq!(page.value("location.hash"), before);
    // The knob of one pane leaves the others.
    page.enter(".pane:nth-child(2) [data-knob=particles]", "5");
    page.wait_until("location.hash.match(/particles/g)?.length === 1");
    page.wait_until("document.getElementById('play').textContent === 'Play again'");
    let said =
        page.value("document.querySelectorAll('.pane')[1].querySelectorAll('dd')[6].textContent");
    page.click(".pane:nth-child(2) .head button");
    page.wait_until("document.getElementById('repeat').open");
    let command = page.value("document.getElementById('command').textContent");
    assert!(command.as_str().unwrap().contains("hanging-textile-1e6.json --method imex-euler"));
    let scene =
        page.value("JSON.parse(document.getElementById('scene').textContent).cloth.grid.rows");
    assert_eq!(scene, json!(5));
    page.click("#close");
    // Another page with the same address shows the same.
    let hash = page.value("location.hash");
    let link = format!("{address}{}", hash.as_str().unwrap());
    let mut other = Page::open(&chromium, &link, DESK, &[]);
    other.wait_until("document.getElementById('play')?.textContent === 'Play again'");
    assert_eq!(other.value("location.hash"), hash);
    let again = "document.querySelectorAll('.pane')[1].querySelectorAll('dd')[6].textContent";
    assert_eq!(other.value(again), said);
    assert_eq!(other.verdicts(), page.verdicts());
    let energies = "[...document.querySelectorAll('table')].map((e) => e.innerText).filter((t) => t.includes('total')).join()";
    assert_eq!(other.value(energies), page.value(energies));
    drop((page, other));
    let begin = Instant::now();
    while runs.count() > 0 {
        assert!(begin.elapsed() < PATIENCE, "{} runs are left", runs.count());
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn the_keyboard_plays_steps_restarts_and_turns_the_camera() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    // The lab starts at rest for a person who asks for little motion.
    let pane =
        |method| format!("&pane=scene=hanging-textile-1e6;method={method};step=0.01;duration=60");
    let link =
        format!("{address}#rate=0.5{}{}{}", pane("xpbd"), pane("imex-euler"), pane("imex-updated"));
    let mut page = Page::open(&chromium, &link, DESK, &[("prefers-reduced-motion", "reduce")]);
    page.wait_until("document.querySelectorAll('.pane').length === 3");
    page.wait_until("document.getElementById('message').textContent.includes('Paused')");
    let step = "[...document.querySelectorAll('.pane')].map((e) => e.querySelectorAll('dd')[1].textContent).join()";
    page.wait_until(&format!("{step} === '0,0,0'"));
    page.key(".");
    page.wait_until(&format!("{step} === '1,1,1'"));
    page.value("document.getElementById('step').focus()");
    page.browser.press_enter();
    page.wait_until(&format!("{step} === '2,2,2'"));
    page.value("document.activeElement.blur()");
    page.key(" ");
    page.wait_until(
        "Number(document.querySelectorAll('.pane')[2].querySelectorAll('dd')[1].textContent) > 5",
    );
    page.key(" ");
    page.wait_until("document.getElementById('play').textContent === 'Play'");
    let picture = "document.querySelectorAll('canvas.view')[2].toDataURL()";
    let before = page.value(picture);
    page.value("document.querySelectorAll('canvas.view')[0].focus()");
    page.key("ArrowRight");
    page.wait_until(&format!("{picture} !== {before}"));
    // Back to the start, and forward again.
    page.value("{ const e = document.getElementById('back'); e.value = 0; e.dispatchEvent(new Event('input')); }");
    page.wait_until(&format!("{step} === '0,0,0'"));
    page.key(".");
    page.wait_until(
        "Number(document.querySelectorAll('.pane')[2].querySelectorAll('dd')[1].textContent) > 5",
    );
    assert_eq!(page.complaints(&address), Vec::<String>::new());
}

/// A page without its server says so.
#[test]
fn a_lost_server_is_said() {
    let Some(chromium) = chromium() else { return };
    let server = Server::bind(0).unwrap();
    let address = server.address();
    let (end, ended) = tokio::sync::oneshot::channel::<()>();
    let serve = std::thread::spawn(move || {
        let ended = async move {
            let _ = ended.await;
        };
        server.serve(ended).unwrap();
    });
    let mut page = Page::open(&chromium, &address, DESK, &[]);
    page.wait_until("document.querySelectorAll('.pane').length === 3");
    end.send(()).unwrap();
    serve.join().unwrap();
    page.wait_until("document.getElementById('message').textContent.includes('does not answer')");
}

/// Texts whose contrast to their ground is below 4.5 : 1.
const CONTRAST: &str = "(() => { \
        const rgb = (c) => { const m = c.match(/[\\d.]+/g).map(Number); return m.length > 3 && m[3] === 0 ? null : m.slice(0, 3); }; \
        const light = (c) => { const [r, g, b] = c.map((v) => v / 255).map((v) => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); return 0.2126 * r + 0.7152 * g + 0.0722 * b; }; \
        const ground = (e) => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor); if (c) return c; } return [255, 255, 255]; }; \
        const bad = []; \
        for (const e of document.querySelectorAll('body *')) { \
            const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()) || e.matches('input, select'); \
            if (!own || e.matches('canvas, option, :disabled, noscript') || e.closest('dialog:not([open])')) continue; \
            const [a, b] = [light(rgb(getComputedStyle(e).color)), light(ground(e))]; \
            const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05); \
            if (ratio < 4.5) bad.push(e.tagName + ' ' + e.textContent.slice(0, 30) + ' ' + ratio.toFixed(2)); \
        } return bad; })()";

/// Text and its ground differ by 4.5 : 1 or more, light and dark.
#[test]
fn every_text_has_enough_contrast() {
    let Some(chromium) = chromium() else { return };
    for scheme in ["light", "dark"] {
        let (address, _) = serve();
        let mut page = Page::open(&chromium, &address, DESK, &[("prefers-color-scheme", scheme)]);
        page.wait_until("document.getElementById('play')?.textContent === 'Play again'");
        page.value("document.querySelectorAll('details').forEach((e) => e.open = true)");
        assert_eq!(page.value(CONTRAST), json!([]), "{scheme}");
    }
}

/// A teacher's link opens the lesson with its panes; a wrong answer gets its hint, a right one is
/// accepted.
#[test]
fn a_lesson_opens_by_its_address_and_marks_answers() {
    let Some(chromium) = chromium() else { return };
    let id = "backward-euler";
    let (_, lesson) = drape_harness::lessons::find(id).unwrap();
    for (width, scheme) in [(DESK, "light"), (PHONE, "dark")] {
        let (address, _) = serve();
        let link = format!("{address}#lesson={id}");
        let mut page = Page::open(&chromium, &link, width, &[("prefers-color-scheme", scheme)]);
        page.wait_until("document.getElementById('lesson-answer') !== null");
        page.wait_until("document.querySelectorAll('.pane').length === 2");
        page.wait_until(
            "decodeURIComponent(location.hash).includes('scene=oscillator;method=backward-euler')",
        );
        let hash = page.value("location.hash");
        assert!(hash.as_str().unwrap().contains("lesson=backward-euler"), "{hash}");
        let text = page.value("document.getElementById('lesson').innerText");
        let text = text.as_str().unwrap();
        for part in [lesson.title, lesson.idea, "drape run oscillator --method backward-euler"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert!(text.contains(&lesson.code().unwrap()), "{text}");
        // The keyboard is enough: type, and press Enter.
        let trap = lesson.traps[0];
        for (value, kind, said) in [
            ((trap.value)(&lesson.setting).to_string(), "wrong", trap.hint),
            ("much".to_owned(), "wrong", "Expected a number"),
            (lesson.answer().to_string(), "right", "Right"),
        ] {
            page.value(&format!(
                "{{ const e = document.getElementById('lesson-answer'); e.value = {}; e.focus(); }}",
                json!(value)
            ));
            page.browser.press_enter();
            page.wait_until(&format!(
                "document.getElementById('lesson-mark').className === {} && document.getElementById('lesson-mark').textContent.includes({})",
                json!(kind), json!(said)
            ));
        }
        page.wait_until("document.getElementById('play').textContent === 'Play again'");
        // The energy that the person reads is the answer: it starts with 1 J.
        let total = page.value(
            "[...document.querySelectorAll('.pane')[0].querySelectorAll('tr')].find((e) => e.textContent.startsWith('total')).cells[1].textContent",
        );
        let total: f64 = total.as_str().unwrap().trim_end_matches(" J").parse().unwrap();
        assert!(lesson.mark(100.0 * total).unwrap().is_right, "{total} J");
        let overflow =
            "document.documentElement.scrollWidth - document.documentElement.clientWidth";
        assert_eq!(page.value(overflow), json!(0), "the page scrolls sideways at {width}");
        page.value("document.querySelectorAll('details').forEach((e) => e.open = true)");
        assert_eq!(page.value(CONTRAST), json!([]), "{scheme}");
        page.look(&format!("lesson-{width}-{scheme}.png"));
        // Another lesson from the list brings its panes; the closed panel leaves the address.
        page.enter("#lesson-choice", "leapfrog");
        page.wait_until("decodeURIComponent(location.hash).includes('method=leapfrog')");
        page.wait_until("location.hash.includes('lesson=leapfrog')");
        page.click("#lesson-close");
        page.wait_until(
            "document.getElementById('lesson').hidden && !location.hash.includes('lesson=')",
        );
        assert_eq!(page.value("document.activeElement.id"), json!("lessons"));
        page.click("#lessons");
        page.wait_until("location.hash.includes('lesson=leapfrog')");
        assert_eq!(page.complaints(&address), Vec::<String>::new());
    }
}

/// A link to a lesson that does not exist says so, and the lab works on.
#[test]
fn a_lesson_that_does_not_exist_is_said() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    let mut page = Page::open(&chromium, &format!("{address}#lesson=magic"), DESK, &[]);
    page.wait_until("document.getElementById('message').textContent.includes('no lesson `magic`')");
    page.wait_until("document.querySelectorAll('.pane').length === 3");
    page.wait_until("[...document.querySelectorAll('#lesson-choice option')].some((e) => e.value === 'leapfrog')");
}
