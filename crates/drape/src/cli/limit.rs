//! The memory that a command may take.

use drape_harness::methods::Choice;
use drape_model::{SceneError, SceneFile, Size, Violation};
use drape_report::tell;

#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct LimitArguments {
    /// Limit of the estimated memory of the command, MiB [default: three quarters of the available
    /// memory in /proc/meminfo; no limit without that file]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 40))]
    max_memory: Option<u64>,
}

const MIB: u64 = 1 << 20;
/// Estimates above this are told, bytes.
const MUCH_MEMORY: u64 = 1 << 30;
/// Estimates above this are told, floating-point operations of a factorisation.
const MUCH_WORK: f64 = 1e11;

impl LimitArguments {
    /// Loads a scene or a frozen system, if it and a run with `choice` fit into the memory.
    pub(crate) fn load(
        &self,
        scene: &str,
        choice: Option<&Choice>,
    ) -> Result<SceneFile, SceneError> {
        drape_model::load_within(scene, |size| self.check(scene, size, choice))
    }

    /// Tells an estimate that is large, or that the user set a limit for, and refuses it above the
    /// limit.
    fn check(&self, scene: &str, size: &Size, choice: Option<&Choice>) -> Result<(), Violation> {
        let is_read = size.particles > 0;
        let need = choice.filter(|_| is_read).map(|choice| choice.need(size));
        let bytes = need.map_or(size.bytes_to_load(), |need| need.bytes);
        let limit = self.max_memory.map(|limit| limit.saturating_mul(MIB)).or_else(three_quarters);
        let contents = if is_read {
            format!("{} particles, {} springs", size.particles, size.springs)
        } else {
            format!("{} bytes of text", size.file)
        };
        if let Some(limit) = limit.filter(|limit| bytes > *limit) {
            let origin = match self.max_memory {
                Some(_) => "",
                None => ", three quarters of what is free",
            };
            return Err(Violation {
                path: "--max-memory".to_owned(),
                value: format!("{} MiB{origin}", limit / MIB),
                expected: format!(
                    "{} MiB or more, the estimate for {contents}{}: use fewer particles or another \
                     method, or raise the limit",
                    bytes.div_ceil(MIB),
                    choice
                        .map_or_else(String::new, |choice| format!(" with {}", choice.method().id)),
                ),
            });
        }
        let work = need.and_then(|need| need.factorisation);
        let is_large = bytes > MUCH_MEMORY || work.is_some_and(|work| work > MUCH_WORK);
        if is_read && (is_large || self.max_memory.is_some()) {
            let work = work.map_or_else(String::new, |work| {
                format!(", and each factorisation {work:.0e} floating-point operations")
            });
            tell!(
                "drape: {scene}: {contents} take about {} MiB of memory{work}",
                bytes.div_ceil(MIB)
            );
        }
        Ok(())
    }
}

/// Three quarters of the memory that is free, bytes; `None` where the system does not tell.
fn three_quarters() -> Option<u64> {
    available(&std::fs::read_to_string("/proc/meminfo").ok()?).map(|bytes| bytes / 4 * 3)
}

/// `MemAvailable` of `/proc/meminfo`, bytes.
fn available(info: &str) -> Option<u64> {
    let value = info.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    value.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::available;

    #[test]
    fn the_free_memory_is_read_or_unknown() {
        let info = "MemTotal:       24576 kB\nMemAvailable:   2048 kB\n";
        assert_eq!(available(info), Some(2048 * 1024));
        for unknown in ["", "MemAvailable: 12 MB", "MemAvailable: many kB", "MemTotal: 1 kB"] {
            assert_eq!(available(unknown), None, "{unknown}");
        }
    }
}
