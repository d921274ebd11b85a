//! Which form runs next, and which stop: the rules of the race, apart from what a run is.
//!
//! The run that is predicted to be the cheapest goes first, so the first form that meets the target
//! is near the best one. A form is *dominated* once its next run would take more than three times
//! as long a frame as the best one. Then it stops. Only the first run of a form that the user names
//! is made in any case, so that every such form has a result. A form that meets the target stops,
//! too, once its last failure and its success are near each other, or once it cannot win even with
//! one step more than that failure.

use super::facts::End;
use crate::HarnessError;

/// A form that takes this many times as long as the best is dominated.
pub const DOMINATED: f64 = 3.0;
/// A run that takes this many times as long as predicted is put off.
const LATE: f64 = 3.0;
/// A number of steps a frame between a failure and a success is tried if the two differ by more
/// than this factor.
const WIDE: f64 = 1.15;

/// The result of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lap {
    /// Time a frame, s; a guess for a run that was stopped.
    pub(super) frame_s: f64,
    /// Whether it meets the target.
    pub(super) is_good: bool,
    /// Why the run was stopped, or the form refused.
    pub(super) end: Option<End>,
    /// Whether it was put off. Then only its time a frame so far is known.
    pub(super) is_late: bool,
}

impl Lap {
    /// The result of a form that its method refuses.
    pub(super) fn refused() -> Self {
        Self { frame_s: 0.0, is_good: false, end: Some(End::Refused), is_late: false }
    }
}

/// When a run stops before its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// The time a frame from which it is dominated, s.
    pub(super) most: f64,
    /// The time, over the number of all frames, at which it is put off, s.
    pub(super) late: f64,
}

impl Limits {
    /// It runs to its end.
    pub(super) const NONE: Self = Self { most: f64::INFINITY, late: f64::INFINITY };
}

/// What makes the runs.
pub(super) trait Track {
    /// Runs a form with so many steps a frame.
    fn lap(&mut self, form: usize, substeps: u32, limits: Limits) -> Result<Lap, HarnessError>;

    /// Whether there is time for such a run, which takes about `frame_s` seconds a frame.
    fn has_time(&self, form: usize, substeps: u32, frame_s: f64) -> bool;
}

/// A form in the race.
#[derive(Clone, Debug)]
pub(super) struct Entrant {
    /// Steps a frame, coarse to fine.
    ladder: Vec<u32>,
    /// Place in the ladder of the next run.
    next: usize,
    /// Time of one step of the next run, s, as far as known.
    step_s: f64,
    /// Most steps a frame that failed, so far.
    failed: u32,
    /// Whether its first run is made even where it is dominated.
    pub(super) is_owed: bool,
    /// Fewest steps a frame that met the target, and the time a frame, s.
    pub(super) good: Option<(u32, f64)>,
    /// Why it runs no more.
    pub(super) end: Option<End>,
}

impl Entrant {
    /// A form that takes about `step_s` seconds a step.
    pub(super) fn new(ladder: Vec<u32>, step_s: f64) -> Self {
        Self { ladder, next: 0, step_s, failed: 0, is_owed: false, good: None, end: None }
    }

    /// Steps a frame of the next run and its predicted time a frame, s.
    fn prediction(&self) -> Option<(u32, f64)> {
        if self.end.is_some() {
            return None;
        }
        let substeps = match self.good {
            Some((good, _)) => u32::midpoint(self.failed, good),
            None => self.ladder.get(self.next).copied()?,
        };
        Some((substeps, f64::from(substeps) * self.step_s))
    }

    /// The least time a frame that the form could still reach with fewer steps, s.
    fn hope(&self) -> Option<f64> {
        let (good, frame_s) = self.good?;
        Some(frame_s * f64::from(self.failed + 1) / f64::from(good))
    }

    fn took(&mut self, substeps: u32, lap: Lap) {
        if lap.frame_s.is_finite() {
            self.step_s = lap.frame_s / f64::from(substeps);
        }
        if lap.is_late {
            return;
        }
        self.next += 1;
        self.is_owed = false;
        if lap.is_good && lap.end.is_none() {
            self.good = Some((substeps, lap.frame_s));
        } else {
            self.failed = substeps;
        }
        self.end = match (lap.end, self.good) {
            // A run between the two that is stopped does not undo the success of its form.
            (Some(_), Some(_)) => Some(End::Good),
            (Some(end), None) => Some(end),
            (None, Some((good, _))) => {
                let is_wide = f64::from(good) > WIDE * f64::from(self.failed);
                let is_between = self.failed > 0 && good > self.failed + 1 && is_wide;
                (!is_between).then_some(End::Good)
            }
            (None, None) => (self.next == self.ladder.len()).then_some(End::Exhausted),
        };
    }
}

/// Least time a frame that meets the target, s.
fn best(entrants: &[Entrant]) -> Option<f64> {
    entrants.iter().filter_map(|entrant| Some(entrant.good?.1)).reduce(f64::min)
}

/// Whether a run that takes so long a frame, s, is dominated.
fn is_dominated(frame_s: f64, best: Option<f64>, factor: f64) -> bool {
    best.is_some_and(|best| frame_s > factor * best)
}

/// Runs until every entrant has ended. Forms dominated by `factor` stop.
pub(super) fn race(
    entrants: &mut [Entrant],
    track: &mut impl Track,
    factor: f64,
) -> Result<(), HarnessError> {
    loop {
        let best = best(entrants);
        for entrant in entrants.iter_mut() {
            let Some((_, predicted)) = entrant.prediction() else { continue };
            if let Some(hope) = entrant.hope() {
                if is_dominated(hope, best, 1.0) {
                    entrant.end = Some(End::Good);
                }
            } else if !entrant.is_owed && is_dominated(predicted, best, factor) {
                entrant.end = Some(End::Dominated);
            }
        }
        let waiting = entrants.iter().enumerate();
        let mut waiting: Vec<(usize, (u32, f64))> =
            waiting.filter_map(|(form, entrant)| Some((form, entrant.prediction()?))).collect();
        waiting.sort_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b));
        let Some(&(form, (substeps, predicted))) = waiting.first() else { return Ok(()) };
        if !track.has_time(form, substeps, predicted) {
            let is_good = entrants[form].good.is_some();
            entrants[form].end = Some(if is_good { End::Good } else { End::OutOfTime });
            continue;
        }
        let most = match best {
            Some(best) if !entrants[form].is_owed => factor * best,
            _ => f64::INFINITY,
        };
        // Where every form is run to its end, the order does not matter.
        let late = match waiting.get(1) {
            Some((_, (_, after))) if factor.is_finite() => after.max(LATE * predicted),
            _ => f64::INFINITY,
        };
        let lap = track.lap(form, substeps, Limits { most, late })?;
        entrants[form].took(substeps, lap);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For each form, the time of a step and the least number of steps a frame that is good.
    struct Synthetic {
        forms: Vec<(f64, u32)>,
        laps: Vec<(usize, u32)>,
        left_s: f64,
    }

    impl Track for Synthetic {
        fn lap(
            &mut self,
            form: usize,
            substeps: u32,
            Limits { most, late }: Limits,
        ) -> Result<Lap, HarnessError> {
            let (step_s, needed) = self.forms[form];
            let frame_s = f64::from(substeps) * step_s;
            self.left_s -= frame_s.min(most).min(late);
            let is_late = frame_s > late && late < most;
            if !is_late {
                self.laps.push((form, substeps));
            }
            let end = (frame_s > most && !is_late).then_some(End::Dominated);
            Ok(Lap { frame_s, is_good: end.is_none() && substeps >= needed, end, is_late })
        }

        fn has_time(&self, _form: usize, _substeps: u32, frame_s: f64) -> bool {
            frame_s <= self.left_s
        }
    }

    fn run(forms: &[(f64, u32)], left_s: f64, factor: f64) -> (Vec<Entrant>, Synthetic) {
        let mut track = Synthetic { forms: forms.to_vec(), laps: Vec::new(), left_s };
        let ladder = vec![1, 2, 4, 8, 16];
        // The prediction before the first run is wrong by a factor of two.
        let mut entrants: Vec<_> =
            forms.iter().map(|form| Entrant::new(ladder.clone(), 0.5 * form.0)).collect();
        race(&mut entrants, &mut track, factor).expect("synthetic runs do not fail");
        (entrants, track)
    }

    #[test]
    fn forms_dominated_by_a_factor_of_three_stop_and_others_go_on() {
        // Good at 4 ms, at 8 ms (a factor of two), and at 40 ms; the last never.
        let forms = [(1.0, 4), (4.0, 2), (5.0, 8), (1.0, 99)];
        let (entrants, track) = run(&forms, 1e9, DOMINATED);
        assert_eq!(entrants[0].good.map(|good| good.0), Some(4));
        assert_eq!(entrants[0].end, Some(End::Good));
        assert_eq!((entrants[1].good, entrants[1].end), (Some((2, 8.0)), Some(End::Good)));
        assert_eq!((entrants[2].good, entrants[2].end), (None, Some(End::Dominated)));
        assert_eq!((entrants[3].good, entrants[3].end), (None, Some(End::Dominated)));
        // No run was made that was predicted to take more than three times 4 ms.
        assert!(track.laps.iter().all(|&(form, n)| f64::from(n) * forms[form].0 <= 24.0));
        assert!(!track.laps.contains(&(2, 4)) && !track.laps.contains(&(3, 16)));
    }

    /// The second takes 50 ms with one step and is dominated by 4 ms; the third is no better.
    #[test]
    fn a_form_that_is_owed_a_run_has_one_and_no_more() {
        let forms = [(1.0, 4), (50.0, 99), (60.0, 1)];
        let mut track = Synthetic { forms: forms.to_vec(), laps: Vec::new(), left_s: 1e9 };
        let mut entrants: Vec<_> =
            forms.iter().map(|form| Entrant::new(vec![1, 2, 4, 8, 16], form.0)).collect();
        (entrants[1].is_owed, entrants[2].is_owed) = (true, true);
        race(&mut entrants, &mut track, DOMINATED).expect("synthetic runs do not fail");
        let of = |form: usize| track.laps.iter().filter(move |lap| lap.0 == form).count();
        assert_eq!((of(1), of(2)), (1, 1), "{:?}", track.laps);
        assert_eq!(entrants[1].end, Some(End::Dominated));
        assert_eq!((entrants[2].good, entrants[2].end), (Some((1, 60.0)), Some(End::Good)));
        // Once the time is over, even an owed run is not made.
        let mut track = Synthetic { forms: forms.to_vec(), laps: Vec::new(), left_s: 20.0 };
        let mut late = Entrant::new(vec![1, 2], 50.0);
        late.is_owed = true;
        let mut late = [Entrant::new(vec![1, 2, 4], 1.0), late];
        race(&mut late, &mut track, DOMINATED).expect("synthetic runs do not fail");
        assert_eq!(late[1].end, Some(End::OutOfTime));
    }

    /// Both are good with one step. The first is predicted to take 1 ms, but takes 500 ms. It is
    /// put off after 3 ms, and the second has its turn.
    #[test]
    fn a_run_that_takes_far_longer_than_predicted_waits_for_the_others() {
        let forms = [(500.0, 1), (2.0, 1)];
        let mut track = Synthetic { forms: forms.to_vec(), laps: Vec::new(), left_s: 20.0 };
        let mut entrants = [Entrant::new(vec![1, 2], 1.0), Entrant::new(vec![1, 2], 2.0)];
        race(&mut entrants, &mut track, DOMINATED).expect("synthetic runs do not fail");
        assert_eq!(track.laps, [(1, 1)]);
        assert!((track.left_s - (20.0 - 3.0 - 2.0)).abs() < 1e-9, "{}", track.left_s);
        let ends = entrants.map(|entrant| entrant.end);
        assert_eq!(ends, [Some(End::Dominated), Some(End::Good)]);
        // Alone, or where it is still the best to try, it runs.
        for forms in [vec![(500.0, 1)], vec![(500.0, 1), (600.0, 1)]] {
            let mut track = Synthetic { forms: forms.clone(), laps: Vec::new(), left_s: 1e9 };
            let mut entrants: Vec<_> =
                forms.iter().map(|form| Entrant::new(vec![1], form.0)).collect();
            entrants[0] = Entrant::new(vec![1], 1.0);
            race(&mut entrants, &mut track, DOMINATED).expect("synthetic runs do not fail");
            assert_eq!(track.laps[0], (0, 1));
            assert_eq!(entrants[0].good, Some((1, 500.0)));
        }
    }

    #[test]
    fn without_domination_every_form_runs_until_it_is_good_or_its_ladder_ends() {
        let (entrants, _) = run(&[(1.0, 4), (5.0, 8), (1.0, 99)], 1e9, f64::INFINITY);
        let ends: Vec<_> = entrants.iter().map(|e| e.end).collect();
        assert_eq!(ends, [Some(End::Good), Some(End::Good), Some(End::Exhausted)]);
    }

    #[test]
    fn a_winner_halves_the_way_between_failure_and_success() {
        // Good from 3 steps on: 2 fails, 4 is good, then 3.
        let (entrants, track) = run(&[(1.0, 3)], 1e9, DOMINATED);
        assert_eq!(track.laps, [(0, 1), (0, 2), (0, 4), (0, 3)]);
        assert_eq!(entrants[0].good, Some((3, 3.0)));
        // Good from 4 on: the try fails, and 4 stays.
        let (entrants, _) = run(&[(1.0, 4)], 1e9, DOMINATED);
        assert_eq!(entrants[0].good, Some((4, 4.0)));
        // Good from 11 on, which lies between 8 and 16; 10 and 11 are near enough.
        let (entrants, track) = run(&[(1.0, 11)], 1e9, DOMINATED);
        assert_eq!(track.laps[4..], [(0, 16), (0, 12), (0, 10), (0, 11)]);
        assert_eq!((entrants[0].good, entrants[0].end), (Some((11, 11.0)), Some(End::Good)));
    }

    #[test]
    fn a_form_that_cannot_win_by_fewer_steps_does_not_try() {
        // The second is good with 16 steps. With 9 it would take 9 ms a frame, more than 4 ms.
        let (entrants, track) = run(&[(1.0, 4), (1.0, 12)], 1e9, f64::INFINITY);
        assert_eq!(entrants[1].good, Some((16, 16.0)));
        assert!(track.laps.iter().all(|&(form, n)| form == 0 || n != 12), "{:?}", track.laps);
    }

    #[test]
    fn when_the_time_is_over_what_is_left_says_so() {
        let (entrants, track) = run(&[(1.0, 1), (1.0, 16)], 3.0, f64::INFINITY);
        assert_eq!(entrants[0].end, Some(End::Good));
        assert_eq!(entrants[1].end, Some(End::OutOfTime));
        assert!(track.left_s >= -1.0, "{}", track.left_s);
    }

    #[test]
    fn a_form_may_hope_for_one_step_more_than_failed() {
        let mut entrant = Entrant::new(vec![1, 2, 4, 8], 0.5);
        assert_eq!(entrant.hope(), None);
        (entrant.failed, entrant.good) = (4, Some((8, 4.0)));
        assert_eq!(entrant.hope(), Some(2.5));
    }
}
