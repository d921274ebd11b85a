//! `fuzz [--inputs N] [--seconds S] [--seed K]`: tries broken scenes, systems, meshes, settings,
//! records, journals and messages; see [`drape_tests::fuzz`].
//!
//! Without options it tries 20 000 inputs. The same seed gives the same inputs on every machine.
//! Exit code 1 and one line a fault; `fuzz --show NUMBER` prints an input.

use drape_report::tell;
use drape_tests::fuzz::{Fuzzer, Tally};
use std::io::Write as _;
use std::process::ExitCode;
use std::time::{Duration, Instant};

const USAGE: &str = "usage: fuzz [--inputs N] [--seconds S] [--seed K] [--show NUMBER]";

struct Options {
    inputs: u64,
    seconds: u64,
    seed: u64,
    show: Option<u64>,
}

fn options() -> Option<Options> {
    let mut options = Options { inputs: 20_000, seconds: u64::MAX, seed: 1, show: None };
    let mut arguments = std::env::args().skip(1);
    while let Some(key) = arguments.next() {
        let value: u64 = arguments.next()?.parse().ok()?;
        match key.as_str() {
            "--inputs" => options.inputs = value,
            "--seconds" => (options.seconds, options.inputs) = (value, u64::MAX),
            "--seed" => options.seed = value,
            "--show" => options.show = Some(value),
            _ => return None,
        }
    }
    Some(options)
}

fn main() -> ExitCode {
    let Some(options) = options() else {
        tell!("{USAGE}");
        return ExitCode::from(2);
    };
    let folder = std::env::temp_dir().join(format!("drape-fuzz-{}", std::process::id()));
    if let Err(error) = std::fs::create_dir_all(&folder) {
        tell!("fuzz: {}: {error}", folder.display());
        return ExitCode::from(2);
    }
    let results = drape_tests::equations::root().join("results");
    let fuzzer = match Fuzzer::new(options.seed, folder.clone(), &results) {
        Ok(fuzzer) => fuzzer,
        Err(error) => {
            tell!("fuzz: {error}");
            return ExitCode::from(2);
        }
    };
    if let Some(number) = options.show {
        let (kind, input) = fuzzer.input(number);
        tell!("{kind:?}");
        let shown = std::io::stdout().write_all(&input);
        return if shown.is_ok() { ExitCode::SUCCESS } else { ExitCode::from(2) };
    }
    // A panic is counted, not printed.
    std::panic::set_hook(Box::new(|_| ()));
    let (start, limit) = (Instant::now(), Duration::from_secs(options.seconds));
    let (mut tally, mut faults) = (Tally::default(), 0_u64);
    for number in 0..options.inputs {
        if start.elapsed() > limit {
            break;
        }
        if let Err(fault) = fuzzer.try_one(number, &mut tally) {
            tell!("seed {}, input {number}, {:?}: {}", options.seed, fault.kind, fault.what);
            faults += 1;
        }
    }
    let _ = std::fs::remove_dir_all(folder);
    let Tally { tried, accepted, skipped } = tally;
    tell!(
        "seed {}: {tried} inputs, {accepted} accepted, {skipped} too large to try, {faults} faults",
        options.seed
    );
    ExitCode::from(u8::from(faults > 0))
}
