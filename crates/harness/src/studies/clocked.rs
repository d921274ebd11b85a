//! Timings: repetitions of a run, and the probe beside them that tells whether another program
//! disturbed the machine.

use crate::HarnessError;
use crate::load::probe_s;
use drape_report::number::{median, significant};
use std::sync::{Mutex, PoisonError};

/// Number of repetitions of a timed run.
pub(super) const REPETITIONS: usize = 3;

/// A timing beside which the probe took longer than this, over its usual time, was disturbed. It is
/// taken again, up to so many times in all.
const DISTURBED: f64 = 1.3;
const TRIES: usize = 4;
/// Number of probes whose median is taken for the usual time.
const USUAL: usize = 8;

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
    static PROBES: Mutex<Vec<f64>> = Mutex::new(Vec::new());
    let mut probes = PROBES.lock().unwrap_or_else(PoisonError::into_inner);
    undisturbed(|| repeated(long_s, &mut once), probe_s, &mut probes)
}

/// As [`samples`], with the repetitions, a probe, and the times of the probe so far.
fn undisturbed(
    mut repeated: impl FnMut() -> Result<Vec<f64>, HarnessError>,
    mut probe: impl FnMut() -> f64,
    probes: &mut Vec<f64>,
) -> Result<Taken, HarnessError> {
    let mut take = |probes: &mut Vec<f64>| {
        let before = probe();
        let samples_s = repeated()?;
        let probe_s = before.max(probe());
        probes.push(probe_s);
        let seconds = median(samples_s.iter().copied()).unwrap_or(0.0);
        Ok::<_, HarnessError>(Taken { samples_s, seconds, probe_s })
    };
    let mut best = take(probes)?;
    for _ in 1..TRIES {
        let usual = median(probes.iter().copied()).filter(|_| probes.len() >= USUAL);
        if usual.is_none_or(|usual| best.probe_s <= DISTURBED * usual) {
            break;
        }
        let again = take(probes)?;
        if again.probe_s < best.probe_s {
            best = again;
        }
    }
    Ok(best)
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
         than {DISTURBED} times its usual time, the median so far, another program disturbs the \
         machine, and the run is timed again, at most {TRIES} times in all; the timing beside the \
         fastest loop counts."
    )
}

/// How far the machine was disturbed while rows were timed, in a sentence, from the times of the
/// probe beside them. `None` if no row has one.
pub(super) fn disturbance(probes_s: impl Iterator<Item = Option<f64>>) -> Option<String> {
    let probes: Vec<f64> = probes_s.flatten().collect();
    let least = probes.iter().copied().reduce(f64::min)?;
    let most = probes.iter().copied().fold(0.0, f64::max);
    let middle = median(probes.iter().copied())?;
    Some(format!(
        "Beside the timings that count, the loop took {} times its least time in the median, and \
         {} times at most; 1 is a quiet machine.",
        significant(middle / least, 3),
        significant(most / least, 3)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_run_is_timed_thrice_and_a_long_one_once() {
        let mut seconds = [0.02, 0.01, 0.03].into_iter();
        let short = || repeated(0.05, || Ok(seconds.next().unwrap_or(9.0)));
        let short = undisturbed(short, || 1.0, &mut Vec::new()).expect("samples");
        assert_eq!((short.samples_s, short.seconds), (vec![0.02, 0.01, 0.03], 0.02));
        let long = samples(0.05, || Ok(0.1)).expect("samples");
        assert_eq!((long.samples_s.len(), long.seconds), (1, 0.1));
    }

    #[test]
    fn a_disturbed_run_is_timed_again_and_the_quietest_timing_counts() {
        let time = |probes: &[f64], known: &mut Vec<f64>| {
            let (mut runs, mut probes) = (0.0, probes.iter().copied());
            let once = || {
                runs += 1.0;
                Ok(vec![runs])
            };
            let taken = undisturbed(once, || probes.next().expect("a probe"), known);
            let Taken { seconds, probe_s, .. } = taken.expect("samples");
            (seconds, probe_s)
        };
        // Nothing is usual yet.
        assert_eq!(time(&[1.0, 9.0], &mut vec![1.0]), (1.0, 9.0));
        let mut known = vec![1.0; 20];
        // The second timing is quiet.
        assert_eq!(time(&[1.0, 2.0, 1.1, 1.0], &mut known), (2.0, 1.1));
        // None is quiet: the third of four is the least disturbed.
        let probes = [1.9, 1.8, 1.7, 1.8, 1.5, 1.4, 1.6, 1.5];
        assert_eq!(time(&probes, &mut known), (3.0, 1.5));
        // What lasts becomes usual.
        known.extend([2.0; 30]);
        assert_eq!(time(&[2.0, 2.1], &mut known), (1.0, 2.1));
    }

    #[test]
    fn a_sentence_tells_how_far_timings_were_disturbed() {
        assert_eq!(disturbance([None, None].into_iter()), None);
        let said = disturbance([Some(1.0), None, Some(1.1), Some(1.55)].into_iter());
        let said = said.expect("a sentence");
        assert!(said.contains("took 1.10 times") && said.contains("and 1.55 times at"), "{said}");
    }
}
