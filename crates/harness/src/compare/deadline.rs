//! When a part of a comparison must end.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The moment at which the time is over, which the user may bring forward by an interruption.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deadline {
    at: Instant,
    interrupt: Option<&'static AtomicBool>,
}

impl Deadline {
    pub(super) fn new(at: Instant, interrupt: Option<&'static AtomicBool>) -> Self {
        Self { at, interrupt }
    }

    /// The time that is left; zero after an interruption.
    pub(super) fn left(self) -> Duration {
        if self.interrupt.is_some_and(|interrupt| interrupt.load(Ordering::Relaxed)) {
            return Duration::ZERO;
        }
        self.at.saturating_duration_since(Instant::now())
    }

    /// Whether the time is over.
    pub(super) fn is_over(self) -> bool {
        self.left() == Duration::ZERO
    }

    /// The moment at which a share of the time that is left is over.
    pub(super) fn after(self, share: f64) -> Self {
        Self { at: Instant::now() + self.left().mul_f64(share), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::Deadline;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, Instant};

    #[test]
    fn an_interruption_ends_the_time_and_every_share_of_it() {
        static INTERRUPT: AtomicBool = AtomicBool::new(false);
        let deadline = Deadline::new(Instant::now() + Duration::from_secs(600), Some(&INTERRUPT));
        let half = deadline.after(0.5);
        assert!(!deadline.is_over() && !half.is_over() && half.left() < deadline.left());
        INTERRUPT.store(true, Ordering::Relaxed);
        assert!(deadline.is_over() && half.is_over() && deadline.after(0.5).is_over());
        assert!(Deadline::new(Instant::now(), None).is_over());
    }
}
