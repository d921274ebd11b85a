//! Programs that hang, die, lie or print garbage: each becomes one sentence, and nothing is left.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

use drape_integrator::{Integrator, PhaseClock, PrepareError, Settings, StepError, TimeStep};
use drape_model::{State, System, Vec3, parse};
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Two particles on a spring, the first pinned.
const SCENE: &str = r#"{ "format": "drape-system/1",
    "particles": { "mass_kg": [1, 2], "position_m": [[0, 0, 0], [0.5, 0, 0]],
        "velocity_m_s": [[0, 0, 0], [0.25, 0, 0]] },
    "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 0.5,
        "stiffness_n_per_m": 4 }],
    "pins": [{ "particle": 0 }] }"#;

const HELLO: &str = r#"{"protocol":"drape-method/1","name":"test","order":1,"class":"dissipative","implicit":false,"supports":["tension","gravity","pins","moving pins"]}"#;

fn scene() -> (System, State) {
    parse("scene", SCENE).unwrap().spec().build().unwrap()
}

/// A folder with a shell script that says hello, takes the system, reads the line of the first step
/// and then goes on as told.
fn script(rest: &str) -> (tempfile::TempDir, String) {
    whole_script(&format!(
        "read line\necho '{HELLO}'\nread line || exit 0\necho '{{\"ok\":true}}'\nread line || exit 0\n{rest}\n"
    ))
}

fn whole_script(text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("mine.sh");
    std::fs::write(&path, format!("#!/bin/sh\n{text}")).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    let command = format!("sh '{}'", path.display());
    (folder, command)
}

fn integrator(command: &str, pairs: &[(&str, &str)]) -> Box<dyn Integrator> {
    let registration = drape_program::load(command).unwrap();
    let method = registration.method;
    let settings = Settings::new(method.id, method.settings, pairs.iter().copied()).unwrap();
    (registration.build)(&settings).unwrap()
}

/// What comes of the first step; the state is compared with the start where it fails.
fn step(command: &str, pairs: &[(&str, &str)]) -> Result<State, String> {
    let (system, mut state) = scene();
    let before = state.clone();
    let h = TimeStep::new(0.1).unwrap();
    let mut integrator = integrator(command, pairs);
    integrator.prepare(&system, h).map_err(|error| error.to_string())?;
    match integrator.step(&system, &mut state, h, &mut PhaseClock::off()) {
        Ok(_) => Ok(state),
        Err(StepError::Outside(sentence)) => {
            assert_eq!(state, before, "the state is as it was");
            let again = integrator.step(&system, &mut state, h, &mut PhaseClock::off());
            assert!(matches!(again, Err(StepError::Outside(same)) if same == sentence));
            assert!(!sentence.contains('\n'), "{sentence}");
            assert!(sentence.starts_with(&format!("program `{command}` ")), "{sentence}");
            Err(sentence)
        }
        Err(other) => panic!("{other}"),
    }
}

fn sentence(rest: &str, pairs: &[(&str, &str)]) -> String {
    let (_folder, command) = script(rest);
    let sentence = step(&command, pairs).unwrap_err();
    assert_no_zombie();
    sentence
}

/// No child of this process has ended without being waited for. Other tests may just be at it.
fn assert_no_zombie() {
    let own = std::process::id().to_string();
    let zombies = || {
        let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let stats =
            processes.filter_map(|entry| std::fs::read_to_string(entry.path().join("stat")).ok());
        let is_zombie = |stat: &String| {
            let fields = stat.rsplit(") ").next().unwrap_or_default();
            let mut fields = fields.split(' ');
            fields.next() == Some("Z") && fields.next() == Some(own.as_str())
        };
        stats.filter(is_zombie).count()
    };
    let begun = Instant::now();
    while zombies() > 0 {
        assert!(begun.elapsed() < Duration::from_secs(10), "a zombie is left");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// 96 bytes are the state of two particles, 24 the place of the pin.
const ECHO: &str = "echo '{\"bytes\":96}'\nhead -c 96\nhead -c 24 >/dev/null";

#[test]
fn a_program_that_answers_is_taken_at_its_word() {
    let (_folder, command) = script(ECHO);
    let (_, start) = scene();
    let state = step(&command, &[]).unwrap();
    assert_eq!((state.x, state.v), (start.x, start.v));
    assert_eq!(state.t, 0.1);
    assert_no_zombie();
}

/// The request ends with the place where the pin is at the end of the step, and the pin is there.
#[test]
fn a_pin_that_is_led_is_at_its_place_after_each_step() {
    let led = r#""pins": [{ "particle": 0,
        "path": [{ "time_s": 1, "offset_m": [0, 0, 0.5] }] }]"#;
    let text = SCENE.replace(r#""pins": [{ "particle": 0 }]"#, led);
    let (system, mut state) = parse("scene", &text).unwrap().spec().build().unwrap();
    // The pin's old place is left out, its new one is put before the rest of the state.
    let step = "echo '{\"bytes\":96}'\nhead -c 24 >/dev/null\nhead -c 72 >\"$0.rest\"\nhead -c 24\n\
                cat \"$0.rest\"";
    let (_folder, command) = script(&format!("{step}\nread line || exit 0\n{step}"));
    let h = TimeStep::new(0.25).unwrap();
    let mut integrator = integrator(&command, &[]);
    integrator.prepare(&system, h).unwrap();
    for height in [0.125, 0.25] {
        integrator.step(&system, &mut state, h, &mut PhaseClock::off()).unwrap();
        assert_eq!(state.x, [Vec3::z() * height, Vec3::x() * 0.5]);
        assert_eq!(state.v, [Vec3::z() * 0.5, Vec3::x() * 0.25]);
    }
}

/// The answer and the end of the output come in one reading, or in two.
#[test]
fn a_program_may_end_right_after_its_answer() {
    let rest =
        "{ echo '{\"bytes\":96}'; head -c 96 /dev/zero; } >\"$0.answer\"\nexec cat \"$0.answer\"";
    let (_folder, command) = script(rest);
    for _ in 0..50 {
        let said = step(&command, &[]);
        assert!(said.is_ok(), "{said:?}");
    }
    let (system, mut state) = scene();
    let h = TimeStep::new(0.1).unwrap();
    let mut integrator = integrator(&command, &[]);
    integrator.prepare(&system, h).unwrap();
    let mut step = || integrator.step(&system, &mut state, h, &mut PhaseClock::off());
    assert!(step().is_ok());
    let Err(StepError::Outside(said)) = step() else { panic!("the program has ended") };
    assert!(said.contains("ended in a step"), "{said}");
}

#[test]
fn a_program_that_hangs_is_killed_with_all_that_it_started() {
    let folder = tempfile::tempdir().unwrap();
    let note = folder.path().join("child");
    let begun = Instant::now();
    let rest = format!("sleep 1000 &\necho $! > '{}'\nwait", note.display());
    let said = sentence(&rest, &[("step_timeout", "0.5")]);
    assert!(said.contains("did not answer in a step within 0.5 s and was killed"), "{said}");
    assert!(begun.elapsed() < Duration::from_secs(60));
    let child = std::fs::read_to_string(note).unwrap();
    let stat = PathBuf::from("/proc").join(child.trim()).join("stat");
    if PathBuf::from("/proc/self/stat").exists() {
        let begun = Instant::now();
        let lives = || {
            let text = std::fs::read_to_string(&stat).unwrap_or_default();
            text.rsplit(") ").next().is_some_and(|rest| !rest.is_empty() && !rest.starts_with('Z'))
        };
        while lives() {
            assert!(begun.elapsed() < Duration::from_secs(10), "its child lives on");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn a_program_that_hung_three_times_is_not_started_again() {
    let (_folder, command) = script("sleep 1000");
    for _ in 0..3 {
        let said = step(&command, &[("step_timeout", "0.2")]).unwrap_err();
        assert!(said.contains("did not answer"), "{said}");
    }
    let said = step(&command, &[]).unwrap_err();
    assert!(said.contains("was killed 3 times"), "{said}");
}

#[test]
fn a_death_is_told_with_its_cause_and_the_last_words() {
    let said = sentence("echo one >&2\necho 'ValueError: two' >&2\nexit 7", &[]);
    assert!(said.contains("ended in a step with exit code 7"), "{said}");
    assert!(said.ends_with("the last line on its standard error: `ValueError: two`"), "{said}");
    let said = sentence("kill -9 $$", &[]);
    assert!(said.contains("ended in a step by signal 9"), "{said}");
    // It closes its output and lives on.
    let said = sentence("exec >&-\nsleep 1000", &[]);
    assert!(said.contains("closed its standard output in a step"), "{said}");
    // It dies between two steps.
    let said = sentence("exit 0", &[]);
    assert!(said.contains("ended in a step with exit code 0"), "{said}");
}

#[test]
fn garbage_is_quoted() {
    let said = sentence("echo 'iteration 1: residual 0.5'\nsleep 1000", &[]);
    assert!(said.contains("`iteration 1: residual 0.5`, which is no answer in JSON"), "{said}");
    let said = sentence("printf '\\377\\000\\033[31m\\n'\nsleep 1000", &[]);
    assert!(said.contains("no answer in JSON") && !said.contains('\u{1b}'), "{said}");
    let said = sentence("echo '{\"bytes\":96,\"iterations\":3}'\nsleep 1000", &[]);
    assert!(said.contains("unknown field `iterations`"), "{said}");
}

#[test]
fn wrong_sizes_are_told_with_the_right_ones() {
    for (rest, expected) in [
        ("echo '{\"bytes\":48}'\nsleep 1000", "announced 48 bytes in a step; expected 96"),
        ("echo '{\"bytes\":960000000000}'\nsleep 1000", "announced 960000000000 bytes"),
        ("echo '{\"ok\":true}'\nsleep 1000", "announced no `bytes` in a step; expected 96"),
        ("echo '{}'\nsleep 1000", "announced no `bytes`"),
        ("echo '{\"bytes\":96}'\nhead -c 120", "wrote more in a step than it announced"),
        ("echo '{\"bytes\":96}'\nhead -c 95\nexit 0", "ended in a step with exit code 0"),
    ] {
        let said = sentence(rest, &[]);
        assert!(said.contains(expected), "{rest}: {said}");
    }
    let rest = "echo '{\"bytes\":96}'\nhead -c 95\nsleep 1000";
    let said = sentence(rest, &[("step_timeout", "0.3")]);
    assert!(said.contains("did not answer in a step within 0.3 s"), "{said}");
}

#[test]
fn an_endless_output_is_read_no_further_than_an_answer_goes() {
    for flood in ["yes | tr -d '\\n'", "while :; do echo '{\"ok\":true}'; done", "yes >&2"] {
        let begun = Instant::now();
        let said = sentence(flood, &[("step_timeout", "2")]);
        let expected = match flood {
            "yes >&2" => "did not answer in a step",
            "yes | tr -d '\\n'" => "wrote 65536 bytes in a step without an end of line",
            _ => "announced no `bytes`",
        };
        assert!(said.contains(expected) && said.len() < 1000, "{said}");
        assert!(begun.elapsed() < Duration::from_secs(60));
    }
}

#[test]
fn an_error_of_the_program_is_handed_on() {
    let said = sentence("echo '{\"error\":\"the matrix is singular\"}'\nsleep 1000", &[]);
    assert!(said.contains("reported an error in a step: the matrix is singular"), "{said}");
}

#[test]
fn nan_is_handed_on_for_the_run_to_see() {
    // The pin stays; the free particle is nowhere.
    let nan = "\\000\\000\\000\\000\\000\\000\\370\\177";
    let rest = format!(
        "echo '{{\"bytes\":96}}'\nhead -c 24\nhead -c 96 >/dev/null\nprintf '{}'\nsleep 1000",
        nan.repeat(9)
    );
    let (_folder, command) = script(&rest);
    let state = step(&command, &[]).unwrap();
    assert!(state.x[1].iter().all(|c| c.is_nan()) && !state.is_finite());
    assert_eq!(state.x[0], Vec3::zeros());
}

#[test]
fn a_pin_that_is_moved_is_named() {
    let ones = "\\000\\000\\000\\000\\000\\000\\360\\077".repeat(12);
    let said = sentence(&format!("echo '{{\"bytes\":96}}'\nprintf '{ones}'\nsleep 1000"), &[]);
    assert!(said.contains("put the pinned particle 0 at [1.0, 1.0, 1.0] m"), "{said}");
}

#[test]
fn a_program_that_does_not_say_what_it_is_is_refused() {
    let load = |text: &str| {
        let (_folder, command) = whole_script(text);
        let said = drape_program::load(&command).unwrap_err();
        assert!(
            said.starts_with(&format!("program `{command}` ")) && !said.contains('\n'),
            "{said}"
        );
        said
    };
    let said = load("exit 3");
    assert!(said.contains("ended at `hello` with exit code 3"), "{said}");
    let said = load("read line\necho hello\nread line");
    assert!(said.contains("answered `hello` with `hello`"), "{said}");
    let said = load(&format!(
        "read line\necho '{}'\nread line",
        HELLO.replace("\"order\":1", "\"order\":9")
    ));
    assert!(said.contains("`order` 9; expected 1, 2, 3 or 4"), "{said}");
    let said = load(&format!("read line\necho '{}'\nread line", HELLO.replace("/1", "/7")));
    assert!(said.contains("expected \"drape-method/1\""), "{said}");
    for (command, expected) in [
        ("./there-is-none.py", "cannot be started"),
        ("there-is-no-such-program", "expected a program in PATH"),
        ("'", "the quote ' is not closed"),
        (" ", "the command is empty"),
    ] {
        let said = drape_program::load(command).unwrap_err();
        assert!(said.contains(expected), "{said}");
    }
    assert_no_zombie();
}

#[test]
fn what_is_not_supported_is_refused_by_name_before_the_run() {
    let (_folder, command) = script(ECHO);
    let h = TimeStep::new(0.1).unwrap();
    let shear = SCENE.replace("\"tension\"", "\"shear\"");
    let curved = SCENE.replace(
        "\"stiffness_n_per_m\": 4",
        "\"stiffness_n_per_m\": 4, \"compression_stiffness_n_per_m\": 1",
    );
    for (text, expected) in [(shear, "shear"), (curved, "springs with pieces")] {
        let (system, _) = parse("scene", &text).unwrap().spec().build().unwrap();
        let refused = integrator(&command, &[]).prepare(&system, h);
        let Err(PrepareError::Unsupported { what, .. }) = refused else { panic!("{refused:?}") };
        assert!(what.contains(expected), "{what}");
    }
}

/// It is seen at the next request, before or after it is sent.
#[test]
fn what_is_written_after_an_answer_is_no_answer_to_the_next_request() {
    let (_folder, command) = script(&format!("{ECHO}\necho extra\nsleep 1000"));
    let (system, mut state) = scene();
    let h = TimeStep::new(0.1).unwrap();
    let mut integrator = integrator(&command, &[]);
    integrator.prepare(&system, h).unwrap();
    integrator.step(&system, &mut state, h, &mut PhaseClock::off()).unwrap();
    let said = integrator.step(&system, &mut state, h, &mut PhaseClock::off());
    let said = said.unwrap_err().to_string();
    let is_seen = said.contains("before it was asked in a step") || said.contains("`extra`");
    assert!(is_seen, "{said}");
}

/// The system is sent again when it changes, and `restart` where only the state did.
#[test]
fn changes_and_restarts_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log");
    let text = format!(
        "while read line; do\n echo \"$line\" | head -c 30 >> '{0}'; echo >> '{0}'\n case \"$line\" in\n \
         *hello*) echo '{HELLO}';;\n *'\"step\"'*) {1};;\n *) echo '{{\"ok\":true}}';;\n esac\ndone",
        log.display(),
        ECHO.replace('\n', "; ")
    );
    let (_script, command) = whole_script(&text);
    let mut integrator = integrator(&command, &[]);
    std::fs::remove_file(&log).unwrap();
    let (mut system, mut state) = scene();
    let h = TimeStep::new(0.1).unwrap();
    integrator.prepare(&system, h).unwrap();
    let clock = &mut PhaseClock::off();
    integrator.step(&system, &mut state, h, clock).unwrap();
    integrator.step(&system, &mut state, h, clock).unwrap();
    integrator.restart(&state);
    integrator.step(&system, &mut state, h, clock).unwrap();
    assert!(system.scale_stiffness(drape_model::EffectKind::Tension, 2.0));
    integrator.step(&system, &mut state, h, clock).unwrap();
    drop(integrator);
    let said = std::fs::read_to_string(&log).unwrap();
    let requests: Vec<&str> = said
        .lines()
        .filter(|line| !line.is_empty())
        .map(|line| line.split('"').nth(3).unwrap())
        .collect();
    assert_eq!(requests, ["hello", "system", "step", "step", "restart", "step", "system", "step"]);
    assert_no_zombie();
}
