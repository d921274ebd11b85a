//! The lab in a browser: Chromium opens it, and a person's clicks are made.
//!
//! Without Chromium these tests say that they were skipped. With DRAPE_BROWSER=required they fail
//! instead. DRAPE_LAB_LOOK names a folder for screenshots.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

use crate::devtools::{Browser, chromium};
use base64::prelude::{BASE64_STANDARD, Engine as _};
use drape_lab::{Pane, Runs, Server, Setup};
use serde_json::{Value, json};
use std::path::Path;
use std::time::{Duration, Instant};

/// Longest wait. A busy machine that draws in software may need so long.
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
        Self::open_after("", chromium, address, width, features)
    }

    /// Opens a page in which a script runs before its own.
    fn open_after(
        script: &str,
        chromium: &Path,
        address: &str,
        width: u32,
        features: &[(&str, &str)],
    ) -> Self {
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
        browser.call("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": script }));
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
                let said = self.value("document.body.innerText");
                panic!("{expression}\n{said}\n{:?}", self.complaints("http"));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Waits until the runs are over and the page shows their last numbers and pictures, which the
    /// next animation frame brings.
    fn wait_for_the_end(&mut self) {
        self.wait_until("document.getElementById('play')?.textContent === 'Play again'");
        self.value("isShown = false; requestAnimationFrame(() => { isShown = true; }); null");
        self.wait_until("isShown");
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

    /// Errors on the console, exceptions, and requests to other servers.
    fn complaints(&self, address: &str) -> Vec<String> {
        let base = address.split('#').next().unwrap();
        let complaint = |event: &Value| {
            let params = &event["params"];
            match event["method"].as_str().unwrap() {
                "Network.requestWillBeSent" => {
                    let url = params["request"]["url"].as_str().unwrap();
                    let is_own = url.starts_with(base)
                        || url.starts_with("data:")
                        || url.starts_with("blob:") && base.starts_with("file:");
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

/// The share of a picture's points that are painted.
const PAINTED: &str = "(c) => { const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
    let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return 4 * n / d.length; }";

/// A person who opens the lab and does nothing sees one cloth explode, one stand still and one
/// fall.
#[test]
fn the_lab_opens_with_three_panes_and_three_verdicts() {
    let Some(chromium) = chromium() else { return };
    for (width, scheme) in [(DESK, "light"), (DESK, "dark"), (PHONE, "light"), (PHONE, "dark")] {
        let (address, _) = serve();
        let features = [("prefers-color-scheme", scheme)];
        let mut page = Page::open(&chromium, &address, width, &features);
        page.wait_until("document.querySelectorAll('.pane').length === 3");
        page.wait_for_the_end();
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
        // A cloth that explodes does not paint its picture over. How little is left of it depends on
        // the number of pictures for which the browser had time; the others are in full view.
        let painted =
            page.value(&format!("[...document.querySelectorAll('canvas.view')].map({PAINTED})"));
        let shares: Vec<_> = (0..3).map(|pane| painted[pane].as_f64().unwrap()).collect();
        assert!(shares.iter().all(|share| *share < 0.5), "{shares:?}");
        assert!(shares[1..].iter().all(|share| *share > 0.001), "{shares:?}");
        // All three cloths are visible without scrolling.
        let top =
            page.value("document.querySelector('canvas.view').getBoundingClientRect().bottom");
        assert!(top.as_f64().unwrap() < 900.0, "{top} at {width}");
        let overflow =
            "document.documentElement.scrollWidth - document.documentElement.clientWidth";
        assert_eq!(page.value(overflow), json!(0), "the page scrolls sideways at {width}");
        assert_eq!(page.complaints(&address), Vec::<String>::new());
        page.look(&format!("{width}-{scheme}.png"));
    }
}

/// A busy browser draws its first picture late. What the cameras show is decided by the start of the
/// scene, not by a cloth that has exploded by then.
#[test]
fn a_late_first_picture_shows_every_cloth_that_has_not_exploded_from_near() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    let hold = "const waiting = []; let isHeld = true; const draw = requestAnimationFrame.bind(window); \
        window.requestAnimationFrame = (f) => isHeld ? waiting.push(f) : draw(f); \
        window.letDraw = () => { isHeld = false; waiting.splice(0).forEach(draw); };";
    let mut page = Page::open_after(hold, &chromium, &address, DESK, &[]);
    let ended = "document.getElementById('play')?.textContent === 'Play again'";
    page.wait_until(ended);
    page.value("letDraw(); null");
    page.wait_for_the_end();
    let painted =
        page.value(&format!("[...document.querySelectorAll('canvas.view')].map({PAINTED})"));
    let shares: Vec<_> = (0..3).map(|pane| painted[pane].as_f64().unwrap()).collect();
    assert!(shares[1..].iter().all(|share| *share > 0.01), "{shares:?}");
    page.look("late.png");
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
    page.wait_for_the_end();
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
    page.wait_for_the_end();
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
    other.wait_for_the_end();
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

/// The page hears of the end of a run after its step was asked for, and perhaps after all else.
#[test]
fn a_run_that_ends_by_a_single_step_can_be_played_again() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    let link = format!(
        "{address}#pane=scene=hanging-textile-1e6;method=backward-euler;particles=100;step=0.01;duration=0.01"
    );
    let mut page = Page::open(&chromium, &link, DESK, &[("prefers-reduced-motion", "reduce")]);
    page.wait_until("document.getElementById('message').textContent.includes('Paused')");
    page.wait_until("document.querySelectorAll('.pane dd')[1]?.textContent === '0'");
    page.key(".");
    page.wait_for_the_end();
}

/// Gives files to the page, as a person who drops them does.
fn drop_files(page: &mut Page, files: &[(&str, &str)]) {
    let files: Vec<_> = files.iter().map(|(name, text)| json!([name, text])).collect();
    page.value(&format!(
        "{{ const dt = new DataTransfer(); \
         for (const [name, text] of {}) dt.items.add(new File([text], name)); \
         document.body.dispatchEvent(new DragEvent('drop', {{ dataTransfer: dt, bubbles: true, cancelable: true }})); }}",
        json!(files)
    ));
}

const STRIP: &str = "v 0 0 1\nv 1 0 1\nv 2 0 1\nv 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 5 4\nf 2 3 6 5\n";
const MESSAGE: &str = "document.getElementById('message').textContent";

#[test]
fn a_dropped_mesh_is_shown_and_a_broken_one_says_what_is_wrong() {
    let Some(chromium) = chromium() else { return };
    for width in [DESK, PHONE] {
        let (address, _) = serve();
        let mut page = Page::open(&chromium, &address, width, &[]);
        page.wait_until("document.querySelectorAll('.pane').length === 3");
        drop_files(&mut page, &[("broken strip.obj", &STRIP.replace("f 2 3 6 5", "f 2 3 6 99"))]);
        page.wait_until(&format!("{MESSAGE}.includes('broken strip.obj')"));
        let said = page.value(MESSAGE);
        let said = said.as_str().unwrap();
        assert!(said.contains("line 8") && said.contains("99"), "{said}");
        assert_eq!(page.value("location.hash.includes('broken')"), json!(false));
        page.look(&format!("{width}-broken.png"));
        drop_files(&mut page, &[("strip.obj", STRIP)]);
        page.wait_until("decodeURIComponent(decodeURIComponent(location.hash)).match(/file:strip.obj/g)?.length === 3");
        page.wait_until(&format!("{MESSAGE}.includes('held by its highest particles')"));
        page.wait_until("[...document.querySelectorAll('[data-knob=scene]')].every((e) => e.value === 'file:strip.obj')");
        page.wait_for_the_end();
        page.wait_until("[...document.querySelectorAll('.verdict strong')].every((e) => e.textContent !== 'refused')");
        page.click(".pane:nth-child(2) .head button");
        page.wait_until("document.getElementById('repeat').open");
        let said = page.value("document.getElementById('file').textContent");
        assert!(said.as_str().unwrap().contains("reads strip.json"), "{said}");
        assert!(said.as_str().unwrap().contains("beside strip.obj"), "{said}");
        page.look(&format!("{width}-repeat.png"));
        page.click("#close");
        let overflow =
            "document.documentElement.scrollWidth - document.documentElement.clientWidth";
        assert_eq!(page.value(overflow), json!(0), "the page scrolls sideways at {width}");
        assert_eq!(page.complaints(&address), Vec::<String>::new());
        // A scene with its mesh, dropped together in the wrong order.
        let scene = r#"{ "format": "drape-scene/1", "name": "two", "cloth": { "mesh": { "file": "two.obj",
            "areal_density_kg_m2": 0.2 } }, "effects": { "tension": { "stiffness_n_per_m": 50 } },
            "time": { "step_s": 0.01, "duration_s": 0.1 } }"#;
        drop_files(&mut page, &[("two.json", scene), ("two.obj", STRIP)]);
        page.wait_until("decodeURIComponent(decodeURIComponent(location.hash)).match(/file:two.json/g)?.length === 3");
        // A link alone does not have the file, and says so.
        let hash = page.value("location.hash");
        let link = format!("{address}{}", hash.as_str().unwrap());
        drop(page);
        let mut other = Page::open(&chromium, &link, width, &[]);
        other.wait_until(&format!("{MESSAGE}.includes('needs the file two.json again')"));
        other.wait_until("document.querySelector('.verdict p:nth-child(2)').textContent.includes('drop it here again')");
        drop_files(&mut other, &[("two.json", scene), ("two.obj", STRIP)]);
        other.wait_for_the_end();
        other.wait_until("[...document.querySelectorAll('.verdict strong')].every((e) => e.textContent !== 'refused')");
        assert_eq!(other.value("location.hash"), hash);
    }
}

/// A page with one pane.
fn single(address: &str, knobs: &str) -> String {
    format!("{address}#rate=1&pane=scene=hanging-textile-1e6;method=imex-euler;step=0.01;{knobs}")
}

impl Page {
    /// Presses, moves or releases the mouse.
    fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let buttons = u8::from(kind != "mouseReleased");
        let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
        self.browser.call("Input.dispatchMouseEvent", &event);
    }

    /// The value of a cell of the first pane.
    fn cell(&mut self, label: &str) -> String {
        let label = json!(label);
        let found = self.value(&format!(
            "[...document.querySelectorAll('.pane dt')].find((e) => e.textContent === {label}).nextSibling.textContent"
        ));
        found.as_str().unwrap().to_owned()
    }
}

/// A cell of the first pane as a number.
fn number(cell: &str) -> String {
    format!(
        "Number([...document.querySelectorAll('.pane dt')].find((e) => e.textContent === '{cell}').nextSibling.textContent.split(' ')[0])"
    )
}

#[test]
fn a_particle_that_is_dragged_moves_the_cloth_and_the_hand_is_repeated() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    // Without gravity nothing but the hand moves the cloth.
    let link = single(&address, "duration=600;gravity=0");
    let mut page = Page::open(&chromium, &link, DESK, &[]);
    page.wait_until("document.querySelectorAll('.pane').length === 1");
    page.wait_until(&format!("{} > 3", number("steps")));
    page.wait_until(&format!("{} < 0.1", number("greatest stretch")));
    let middle = page.value(
        "(() => { const c = document.querySelector('canvas.view'); c.scrollIntoView({ block: 'center' }); const b = c.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()",
    );
    let at = |k: usize| middle[k].as_f64().unwrap();
    let (x, y) = (at(0) + 0.5 * at(2), at(1) + 0.5 * at(3));
    // The picture shows the middle of the space into which the cloth will fall; look for the cloth.
    let led = "document.querySelector('canvas.view').dataset.led !== undefined";
    let mut start = None;
    for (right, up) in
        (0..6).flat_map(|up| [0.0, 20.0, -20.0].map(|right| (right, 40.0 * f64::from(up))))
    {
        let place = (x + right, y - up);
        page.mouse("mousePressed", place.0, place.1);
        if page.value(led) == json!(true) {
            start = Some(place);
            break;
        }
        page.mouse("mouseReleased", place.0, place.1);
    }
    let (x, y) = start.expect("a particle under the mouse");
    for n in 1..=20 {
        page.mouse("mouseMoved", x + 4.0 * f64::from(n), y + 3.0 * f64::from(n));
        std::thread::sleep(Duration::from_millis(30));
    }
    page.wait_until(&format!("{} > 0.5", number("greatest stretch")));
    page.look("dragged.png");
    page.mouse("mouseReleased", x + 80.0, y + 60.0);
    page.wait_until("document.querySelector('canvas.view').dataset.led === undefined");
    // Time goes on, and is not counted from the touch.
    let before: f64 = page.cell("steps").parse().unwrap();
    page.wait_until(&format!("{} > {before} + 3", number("steps")));
    page.click(".pane .head button");
    page.wait_until("document.getElementById('repeat').open");
    let note = page.value("document.getElementById('note').textContent");
    assert!(note.as_str().unwrap().contains("moved by hand"), "{note}");
    let command = page.value("document.getElementById('command').textContent");
    assert!(command.as_str().unwrap().contains("-from-step-"), "{command}");
    let way = page.value("document.getElementById('way-command').textContent");
    assert!(way.as_str().unwrap().contains("-by-hand.json"), "{way}");
    page.look("dragged-repeat.png");
    page.click("#close");
    // The same by keys.
    page.click("#restart");
    page.wait_until(&format!("{} < 0.1", number("greatest stretch")));
    page.wait_until(&format!("{} > 3", number("steps")));
    page.value("document.querySelector('canvas.view').focus()");
    page.key("g");
    page.wait_until(led);
    for _ in 0..5 {
        page.key("ArrowDown");
    }
    page.wait_until(&format!("{} > 0.5", number("greatest stretch")));
    page.key("g");
    page.wait_until("document.querySelector('canvas.view').dataset.led === undefined");
    assert_eq!(page.complaints(&address), Vec::<String>::new());
}

#[test]
fn the_reference_is_laid_over_and_measured() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    let link = single(&address, "duration=0.2");
    let mut page = Page::open(&chromium, &link, DESK, &[]);
    page.wait_until("document.querySelectorAll('.pane').length === 1");
    page.wait_for_the_end();
    assert_eq!(page.cell("off the reference"), "–");
    let picture = "document.querySelector('canvas.view').toDataURL()";
    let before = page.value(picture);
    page.click("#ghost");
    page.wait_until(&format!("{} > 10", number("off the reference")));
    page.wait_until(&format!("{picture} !== {before}"));
    assert_eq!(page.value("location.hash.includes('ghost=yes')"), json!(true));
    // The locked cloth stands still and the reference falls: about half of g t².
    let fallen = 0.5 * 9.81 * 0.2_f64.powi(2) * 1e3;
    let off: f64 = page.cell("off the reference").split(' ').next().unwrap().parse().unwrap();
    assert!(off > 0.4 * fallen && off < fallen, "{off} mm; free fall is {fallen} mm");
    page.look("reference.png");
    page.click("#ghost");
    page.wait_until(&format!("{picture} === {before}"));
    assert_eq!(page.cell("off the reference"), "–");
    assert_eq!(page.complaints(&address), Vec::<String>::new());
}

#[test]
fn settings_are_knobs_and_a_verdict_leads_to_the_line_that_decides() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    let mut page = Page::open(&chromium, &single(&address, "duration=60"), DESK, &[]);
    page.wait_until("document.querySelectorAll('.pane').length === 1");
    let title = "document.querySelector('.pane h2').textContent";
    page.enter(".pane [data-knob=set-forcing_term]", "0.05");
    page.wait_until(&format!("{title} === 'imex-euler:forcing_term=0.05'"));
    page.enter(".pane [data-knob=set-preconditioner]", "jacobi");
    page.wait_until(&format!("{title} === 'imex-euler:forcing_term=0.05,preconditioner=jacobi'"));
    page.wait_until(&format!("{} > 3", number("steps")));
    // The server runs what the title says.
    page.click(".pane .head button");
    page.wait_until("document.getElementById('repeat').open");
    let command = page.value("document.getElementById('command').textContent");
    let command = command.as_str().unwrap();
    assert!(
        command.contains("forcing_term=0.05") && command.contains("preconditioner=jacobi"),
        "{command}"
    );
    page.click("#close");
    // Out of range; then back to the default, which the line leaves out.
    page.enter(".pane [data-knob=set-forcing_term]", "7");
    page.wait_until(&format!("{MESSAGE}.includes('forcing term: expected')"));
    let default = page.value(
        "[...document.querySelector('[data-knob=set-preconditioner]').options].map((o) => o.value)",
    );
    assert!(default.as_array().unwrap().contains(&json!("ic0")), "{default}");
    page.enter(".pane [data-knob=set-preconditioner]", "ic0");
    page.wait_until(&format!("{title} === 'imex-euler:forcing_term=0.05'"));
    page.enter(".pane [data-knob=gravity]", "1.62");
    page.enter(".pane [data-knob=wind]", "0, 2, 0");
    page.wait_until("decodeURIComponent(location.hash).includes('gravity=1.62;wind=0,2,0')");
    page.wait_until(&format!("{} > 3", number("steps")));
    page.wait_until("document.querySelector('.verdict strong').textContent !== 'refused'");
    page.wait_until("!document.querySelector('.verdict a').hidden");
    let link = page.value("document.querySelector('.verdict a').href");
    let link = link.as_str().unwrap().to_owned();
    assert!(link.starts_with(&address) && link.contains("judgement.rs.html#L"), "{link}");
    let mut source = Page::open(&chromium, &link, DESK, &[]);
    let line = source.value("document.querySelector(':target').textContent");
    assert!(line.as_str().unwrap().contains("Judged::"), "{line}");
}

/// A change begins again, or goes on where the cloth is, as a person chooses.
#[test]
fn a_change_goes_on_if_a_person_wants_it_and_the_verdict_leads_to_the_lesson() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    let mut page = Page::open(&chromium, &single(&address, "duration=600"), DESK, &[]);
    page.wait_until("document.querySelectorAll('.pane').length === 1");
    page.wait_until(&format!("{} > 10", number("steps")));
    let command = |page: &mut Page| {
        page.click(".pane .head button");
        page.wait_until("document.getElementById('repeat').open");
        let command = page.value("document.getElementById('command').textContent");
        page.click("#close");
        command.as_str().unwrap().to_owned()
    };
    page.click("#keep");
    let before: f64 = page.cell("steps").parse().unwrap();
    page.enter(".pane [data-knob=stiffness]", "1e4");
    page.wait_until("decodeURIComponent(location.hash).includes('keep=yes')");
    page.wait_until("decodeURIComponent(location.hash).includes('stiffness=10000')");
    page.wait_until(&format!("{} === 1", number("h²k/m")));
    assert!(page.cell("steps").parse::<f64>().unwrap() >= before);
    let said = command(&mut page);
    assert!(said.contains("-from-step-"), "{said}");
    // The page can still show the past.
    page.value("{ const e = document.getElementById('back'); e.value = 0; e.dispatchEvent(new Event('input')); }");
    page.wait_until(&format!("{} < 5", number("steps")));
    assert_eq!(page.cell("h²k/m"), "100");
    page.click("#keep");
    page.enter(".pane [data-knob=stiffness]", "1e5");
    page.wait_until(&format!("{} === 10", number("h²k/m")));
    assert!(!command(&mut page).contains("-from-step-"));
    page.click(".pane .link");
    page.wait_until("document.getElementById('lesson-choice').value === 'imex-euler'");
    page.wait_until("location.hash.includes('lesson=imex-euler')");
    assert_eq!(page.value("document.activeElement.id"), json!("lesson-choice"));
    assert_eq!(page.value("document.querySelectorAll('.pane').length"), json!(1));
    assert_eq!(page.cell("h²k/m"), "10");
    assert_eq!(page.complaints(&address), Vec::<String>::new());
}

/// A cloth that stretches out of its picture stays in it.
#[test]
fn the_picture_follows_a_cloth_that_falls_far() {
    let Some(chromium) = chromium() else { return };
    let (address, _) = serve();
    let knobs =
        "pane=scene=hanging-textile-1e4;method=imex-updated;step=0.01;duration=2;stiffness=4e3";
    let mut page = Page::open(&chromium, &format!("{address}#{knobs}"), DESK, &[]);
    page.wait_until("document.querySelectorAll('.pane').length === 1");
    page.wait_for_the_end();
    let edge = "(() => { const c = document.querySelector('canvas.view'); const d = (y) => c.getContext('2d').getImageData(0, y, c.width, 1).data; return [d(0), d(c.height - 1)].every((row) => row.every((v) => v === 0)); })()";
    let look = |page: &mut Page, back: f64| {
        page.value(&format!("{{ const e = document.getElementById('back'); e.value = {back}; e.dispatchEvent(new Event('input')); }}"));
    };
    // A slow browser has left pictures out; a few more let the frame grow as it should.
    let times = [0.2, 0.6, 0.8, 1.0, 1.2, 1.6, 2.0];
    times.iter().for_each(|&back| (0..4).for_each(|_| look(&mut page, back)));
    for back in times {
        look(&mut page, back);
        assert_eq!(page.value(edge), json!(true), "the cloth is cut off at {back} s");
    }
    let painted = page.value(&format!("({PAINTED})(document.querySelector('canvas.view'))"));
    assert!(painted.as_f64().unwrap() > 0.01, "{painted}");
}

/// A page that lost its connection says so, comes back by itself and shows its set-up again.
#[test]
fn a_lost_connection_is_said_and_the_page_comes_back() {
    let Some(chromium) = chromium() else { return };
    let (address, runs) = serve();
    let mut page = Page::open(&chromium, "about:blank", DESK, &[]);
    let remember = "window.sockets = []; const Real = WebSocket; window.WebSocket = class extends Real { constructor(url) { super(url); window.sockets.push(this); } };";
    page.browser.call("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": remember }));
    let link = single(&address, "duration=600;damping=7");
    page.browser.call("Page.navigate", &json!({ "url": link }));
    page.wait_until("document.querySelectorAll('.pane').length === 1");
    page.wait_until(&format!("{} > 10", number("steps")));
    page.value("window.sockets[0].close()");
    page.wait_until(&format!("{MESSAGE}.includes('does not answer')"));
    page.wait_until("window.sockets.length === 2");
    page.wait_until(&format!("{MESSAGE} === ''"));
    page.wait_until(&format!("{} > 3", number("steps")));
    page.wait_until("document.querySelector('.pane [data-knob=damping]').value === '7'");
    let begin = Instant::now();
    while runs.count() != 1 {
        assert!(begin.elapsed() < PATIENCE, "{} runs", runs.count());
        std::thread::sleep(Duration::from_millis(20));
    }
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
        page.wait_for_the_end();
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
        for part in [
            lesson.title,
            lesson.idea,
            "drape run oscillator --method backward-euler",
            "drape lab --setup lesson=backward-euler",
        ] {
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
        page.wait_for_the_end();
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

/// The committed page without a server, as it lies on the disk.
fn committed() -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results/lab.html");
    format!("file://{}", file.canonicalize().unwrap().display())
}

/// A person who opens the file sees the same as with a server.
#[test]
fn the_page_without_a_server_opens_from_the_disk() {
    let Some(chromium) = chromium() else { return };
    let address = committed();
    let mut page = Page::open(&chromium, &address, DESK, &[]);
    page.wait_until("document.querySelectorAll('.pane').length === 3");
    page.wait_for_the_end();
    assert_eq!(page.verdicts(), json!(["diverged", "locked", "stable"]));
    page.wait_until(
        "[...document.querySelectorAll('.pane a')].every((e) => e.href.startsWith('blob:'))",
    );
    let mesh = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    drop_files(&mut page, &[("quad.obj", mesh)]);
    page.wait_until("document.querySelectorAll('.pane').length === 3 && document.querySelector('#message').textContent.includes('quad')");
    let lesson = format!("{address}#lesson=imex-euler");
    page.browser.call("Page.navigate", &json!({ "url": lesson }));
    page.wait_until("document.getElementById('lesson').textContent.includes('imex-euler')");
    page.look("file.png");
    assert_eq!(page.complaints(&address), Vec::<String>::new());
}

/// Takes so many steps in the file with these methods, and reads the places of the particles and
/// their velocities; `None` for a method that no hand can lead.
fn places_in_the_file(chromium: &Path, setups: &[Setup], steps: u64) -> Vec<Option<[Value; 2]>> {
    let pane = |setup: &Setup| {
        let Setup { scene, method, stiffness, damping, step, .. } = setup;
        let [stiffness, damping, step] = [stiffness, damping, step].map(|knob| knob.unwrap());
        format!(
            "pane=scene={scene};method={method};stiffness={stiffness};damping={damping};step={step}"
        )
    };
    let panes: Vec<String> = setups.iter().map(pane).collect();
    let address = format!("{}#{}", committed(), panes.join("&"));
    // For a person who asks for little motion, the page starts paused.
    let still = [("prefers-reduced-motion", "reduce")];
    let mut page = Page::open(chromium, &address, DESK, &still);
    let count = setups.len();
    page.wait_until(&format!("document.querySelectorAll('.pane').length === {count}"));
    page.value(
        "window.isAt = (n) => [...document.querySelectorAll('.pane dt')].filter((e) => e.textContent === 'steps').every((e) => e.nextSibling.textContent === String(n))",
    );
    // The next step once every pane has taken the one before.
    page.value(&format!(
        "{{ let n = 0; const go = () => {{ if (n < {steps} && window.isAt(n)) {{ n++; document.getElementById('step').click(); }} setTimeout(go, 5); }}; go(); }}"
    ));
    page.wait_until(&format!("window.isAt({steps})"));
    // A touch freezes the state, and the scene that repeats a pane holds it.
    page.value("{ const make = URL.createObjectURL; URL.createObjectURL = (blob) => { blob.text().then((text) => window.saved = text); return make.call(URL, blob); }; }");
    page.value("document.querySelector('canvas.view').focus()");
    page.key("g");
    page.wait_until("document.getElementById('play').textContent !== 'Play'");
    page.key("g");
    let verdicts = page.verdicts();
    let mut read = |pane: usize| {
        if verdicts[pane] == "refused" {
            return None;
        }
        page.value("window.saved = undefined");
        page.value(&format!("[...document.querySelectorAll('.pane')][{pane}].querySelectorAll('button').forEach((e) => {{ if (e.textContent === 'Repeat') e.click(); }})"));
        page.wait_until("window.saved !== undefined");
        let saved = page.value("window.saved");
        let saved: Value = serde_json::from_str(saved.as_str().unwrap()).unwrap();
        Some(["position_m", "velocity_m_s"].map(|key| saved["particles"][key].clone()))
    };
    (0..count).map(&mut read).collect()
}

/// The file computes the same as drape. The test fails for an old file, or for another rounding.
#[test]
fn the_page_without_a_server_gives_the_same_bits() {
    let Some(chromium) = chromium() else { return };
    let setup = |method: &drape_integrator::Method| Setup {
        scene: "hanging-textile-1e4".to_owned(),
        method: method.id.to_owned(),
        stiffness: Some(1e3),
        damping: Some(1.0),
        step: Some(1e-3),
        ..Setup::default()
    };
    let setups: Vec<Setup> = drape_harness::methods::all().map(setup).collect();
    let (mut same, mut different, mut unseen) = (0, Vec::new(), Vec::new());
    for setups in setups.chunks(6) {
        let found = places_in_the_file(&chromium, setups, 100);
        for (setup, found) in setups.iter().zip(found) {
            let Some(found) = found else {
                unseen.push(setup.method.clone());
                continue;
            };
            let pane = Pane::start(setup.clone(), &Runs::default()).unwrap();
            pane.go_until(0.1);
            let begin = Instant::now();
            while pane.look().2.step < 100 {
                assert!(begin.elapsed() < PATIENCE, "{}: {:?}", setup.method, pane.look().1);
                std::thread::sleep(Duration::from_millis(2));
            }
            let state = pane.look().2.state.clone().unwrap();
            let native = [state.x, state.v]
                .map(|all| json!(all.iter().map(|&x| <[f64; 3]>::from(x)).collect::<Vec<_>>()));
            match found == native {
                true => same += 1,
                false => different.push(setup.method.clone()),
            }
        }
    }
    println!("same {same}, different {different:?}, not led {unseen:?}");
    assert_eq!(different, DIFFERENT);
    assert!(same >= 20, "{same}; not led: {unseen:?}");
}

/// Methods whose bits differ without a server.
const DIFFERENT: [&str; 0] = [];

/// Memory of this process that is in use, and of the objects of the page, MiB.
fn memory(page: &mut Page) -> [f64; 2] {
    page.browser.call("HeapProfiler.collectGarbage", &json!({}));
    let heap = page.browser.call("Runtime.getHeapUsage", &json!({}));
    let text = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: f64 = text.split(' ').nth(1).unwrap().parse().unwrap();
    let mib = f64::from(1 << 20);
    [pages * 4096.0 / mib, heap["usedSize"].as_f64().unwrap() / mib]
}

/// Six panes play for an hour (or DRAPE_LAB_MINUTES). After a third of that time, neither the
/// server nor the page needs more memory.
#[test]
#[ignore = "takes an hour"]
fn memory_is_flat_over_an_hour() {
    let Some(chromium) = chromium() else { return };
    let minutes = std::env::var("DRAPE_LAB_MINUTES").map_or(60.0, |text| text.parse().unwrap());
    let part = Duration::from_secs_f64(60.0 * minutes / 12.0);
    let (address, _) = serve();
    let methods =
        ["imex-euler", "imex-updated", "baraff-witkin", "backward-euler", "xpbd", "leapfrog"];
    let pane = |method| {
        let sheet = "scene=hanging-textile-1e4;step=0.01;duration=3600;stiffness=1e3";
        format!("pane={sheet};method={method}")
    };
    let mut page =
        Page::open(&chromium, &format!("{address}#{}", methods.map(pane).join("&")), DESK, &[]);
    // Otherwise each message to the page comes here, too, and takes memory.
    page.browser.call("Network.disable", &json!({}));
    page.wait_until("document.querySelectorAll('.pane').length === 6");
    let mut all = Vec::new();
    for n in 1..=12 {
        std::thread::sleep(part);
        // The messages to the page are no longer needed.
        page.browser.events.clear();
        let [server, heap] = memory(&mut page);
        let time = page.value("document.getElementById('clock').textContent");
        println!(
            "{:.1} min: server {server:.1} MiB, page {heap:.1} MiB, {time}",
            minutes / 12.0 * f64::from(n)
        );
        all.push([server, heap]);
    }
    for kind in [0, 1] {
        let most = |part: &[[f64; 2]]| part.iter().map(|memory| memory[kind]).fold(0.0, f64::max);
        let (early, late) = (most(&all[..4]), most(&all[4..]));
        assert!(late < 1.1 * early + 1.0, "{early} MiB, then {late} MiB");
    }
}
