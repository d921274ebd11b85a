//! The time that a thread spends on a processor. Other programs disturb it less than wall time.

use std::time::Duration;

/// Time that the calling thread has spent on a processor so far; `None` where the operating system
/// does not report it.
pub(crate) fn spent() -> Option<Duration> {
    #[cfg(target_os = "linux")]
    {
        use rustix::time::{ClockId, clock_gettime};
        let time = clock_gettime(ClockId::ThreadCPUTime);
        let seconds = u64::try_from(time.tv_sec).ok()?;
        Some(Duration::new(seconds, u32::try_from(time.tv_nsec).ok()?))
    }
    #[cfg(not(target_os = "linux"))]
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thread that sleeps spends no time. A thread that works spends at most the wall time.
    #[test]
    fn sleep_costs_no_time_of_the_processor_and_work_does() {
        let Some(before) = spent() else { return };
        std::thread::sleep(Duration::from_millis(50));
        let slept = spent().expect("a clock") - before;
        assert!(slept < Duration::from_millis(20), "{slept:?}");
        let (begin, before) = (std::time::Instant::now(), spent().expect("a clock"));
        let mut sum = 0.0_f64;
        while spent().expect("a clock") - before < Duration::from_millis(5) {
            sum += std::hint::black_box(1.0);
        }
        assert!(begin.elapsed() >= Duration::from_millis(5) && sum > 0.0);
    }
}
