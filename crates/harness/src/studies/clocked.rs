//! Timings: repetitions of a run, and the probe beside them that tells whether another program
//! disturbed the machine.

use crate::HarnessError;
use crate::load::probe_s;
use drape_report::number::{median, significant};
use std::sync::{Mutex, PoisonError};

/// Number of repetitions of a timed run.
pub(super) const REPETITIONS: usize = 3;

/// A timing beside which the probe took longer than this, over the least time of a probe so far, was
/// disturbed. It is taken again, up to so many times in all.
const DISTURBED: f64 = 1.2;
const TRIES: usize = 4;

/// The times of a run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Taken {
    /// Seconds of each repetition.
    pub(super) samples_s: Vec<f64>,
    /// Their median.
    pub(super) seconds: f64,
    /// Seconds of the probe before or after them, whichever is longer.
    pub(super) probe_s: f64,
}

/// Times a run. A repetition of at least `long_s` seconds is the last. Of timings that were
/// disturbed, the one beside the fastest probe counts.
pub(super) fn samples(
    long_s: f64,
    mut once: impl FnMut() -> Result<f64, HarnessError>,
) -> Result<Taken, HarnessError> {
    static LEAST: Mutex<f64> = Mutex::new(f64::INFINITY);
    let mut least = LEAST.lock().unwrap_or_else(PoisonError::into_inner);
    undisturbed(|| repeated(long_s, &mut once), probe_s, &mut least)
}

/// As [`samples`], with the repetitions, a probe, and the least time of the probe so far.
fn undisturbed(
    mut repeated: impl FnMut() -> Result<Vec<f64>, HarnessError>,
    mut probe: impl FnMut() -> f64,
    least: &mut f64,
) -> Result<Taken, HarnessError> {
    let mut best: Option<Taken> = None;
    for _ in 0..TRIES {
        let before = probe();
        let samples_s = repeated()?;
        let after = probe();
        *least = before.min(after).min(*least);
        let probe_s = before.max(after);
        if best.as_ref().is_none_or(|best| probe_s < best.probe_s) {
            let seconds = median(samples_s.iter().copied()).unwrap_or(0.0);
            best = Some(Taken { samples_s, seconds, probe_s });
        }
        if probe_s <= DISTURBED * *least {
            break;
        }
    }
    Ok(best.unwrap_or(Taken { samples_s: Vec::new(), seconds: 0.0, probe_s: 0.0 }))
}

/// Seconds of each repetition.
fn repeated(
    long_s: f64,
    mut once: impl FnMut() -> Result<f64, HarnessError>,
) -> Result<Vec<f64>, HarnessError> {
    let mut samples: Vec<f64> = Vec::new();
    while samples.len() < REPETITIONS && samples.iter().all(|&seconds| seconds < long_s) {
        samples.push(once()?);
    }
    Ok(samples)
}

/// How the probe is used, for the text about a study's timings.
pub(super) fn about_probe() -> String {
    format!(
        "A fixed loop of a few milliseconds is timed before and after each run. If it takes more \
         than {DISTURBED} times its least time so far, another program disturbs the machine, and \
         the run is timed again, at most {TRIES} times in all; the timing beside the fastest loop \
         counts."
    )
}

/// How far the machine was disturbed while rows were timed, in a sentence, from the times of the
/// probe beside them. `None` if no row has one.
pub(super) fn disturbance(probes_s: impl Iterator<Item = Option<f64>>) -> Option<String> {
    let probes: Vec<f64> = probes_s.flatten().collect();
    let least = probes.iter().copied().reduce(f64::min)?;
    let most = probes.iter().copied().fold(0.0, f64::max);
    let disturbed = probes.iter().filter(|&&probe| probe > DISTURBED * least).count();
    Some(format!(
        "Beside the timings that count, the loop took up to {} times its least time, and more than \
         {DISTURBED} times beside {disturbed} of {}.",
        significant(most / least, 3),
        probes.len()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_run_is_timed_thrice_and_a_long_one_once() {
        let mut seconds = [0.02, 0.01, 0.03].into_iter();
        let short = samples(0.05, || Ok(seconds.next().unwrap_or(0.02))).expect("samples");
        assert_eq!(short.samples_s.len(), 3);
        assert_eq!(short.seconds, 0.02);
        let long = samples(0.05, || Ok(0.1)).expect("samples");
        assert_eq!((long.samples_s, long.seconds), (vec![0.1], 0.1));
    }

    #[test]
    fn a_disturbed_run_is_timed_again_and_the_quietest_timing_counts() {
        let time = |probes: &[f64], least: &mut f64| {
            let (mut runs, mut probes) = (0.0, probes.iter().copied());
            let once = || {
                runs += 1.0;
                Ok(vec![runs])
            };
            let taken = undisturbed(once, || probes.next().expect("a probe"), least);
            let Taken { seconds, probe_s, .. } = taken.expect("samples");
            (seconds, probe_s)
        };
        // The second timing is quiet.
        let mut least = 1.0;
        assert_eq!(time(&[1.0, 2.0, 1.1, 1.0], &mut least), (2.0, 1.1));
        // None is quiet: the third of four is the least disturbed.
        let probes = [1.9, 1.8, 1.7, 1.8, 1.5, 1.4, 1.6, 1.5];
        assert_eq!(time(&probes, &mut least), (3.0, 1.5));
        // A faster probe than all before is the new measure.
        assert_eq!(time(&[0.8, 0.9, 0.7, 0.8], &mut least), (1.0, 0.9));
        assert_eq!(least, 0.8);
    }

    #[test]
    fn a_sentence_tells_how_far_timings_were_disturbed() {
        assert_eq!(disturbance([None, None].into_iter()), None);
        let said = disturbance([Some(1.0), None, Some(1.1), Some(1.55)].into_iter());
        let said = said.expect("a sentence");
        assert!(said.contains("up to 1.55 times") && said.contains("beside 1 of 3."), "{said}");
    }
}
