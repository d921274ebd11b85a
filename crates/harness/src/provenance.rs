//! Where results come from.

use drape_model::SystemSpec;
use drape_report::Provenance;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::BufWriter;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new_with_prefix(bytes))
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a frozen system's compact JSON text.
pub fn system_hash(spec: &SystemSpec) -> String {
    // The text of a large system would take more memory than the system.
    let mut hash = BufWriter::new(Sha256::new());
    // A specification is lists of numbers and strings, which always serialise.
    match (serde_json::to_writer(&mut hash, spec), hash.into_inner()) {
        (Ok(()), Ok(hash)) => hexadecimal(hash),
        _ => String::new(),
    }
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git")
        .args(["-C", env!("CARGO_MANIFEST_DIR")])
        .args(arguments)
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn cpu() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    cpu_name(&info).unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// Name of the first processor in `/proc/cpuinfo`, with the numbers that distinguish generations.
fn cpu_name(info: &str) -> Option<String> {
    let value = |key: &str| {
        info.lines().find_map(|line| {
            let (name, value) = line.split_once(':')?;
            (name.trim() == key).then(|| value.trim().to_owned())
        })
    };
    let name = value("model name")?;
    Some(match (value("cpu family"), value("model")) {
        (Some(family), Some(model)) => format!("{name} (family {family}, model {model})"),
        _ => name,
    })
}

/// Provenance of a record that is written now.
pub fn provenance(scene_sha256: BTreeMap<String, String>) -> Provenance {
    let commit = git(&["rev-parse", "HEAD"]);
    let changes = git(&["status", "--porcelain", "--", ":/", ":(exclude,top)results"]);
    Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        dirty: commit.as_ref().and(changes).map(|changes| !changes.is_empty()),
        commit,
        cargo_lock_sha256: sha256(include_bytes!("../../../Cargo.lock")),
        rustc: env!("DRAPE_RUSTC").to_owned(),
        build: env!("DRAPE_BUILD").to_owned(),
        cpu: cpu(),
        threads: rayon::current_num_threads(),
        scene_sha256,
        seed: None,
        date: date(SystemTime::now()),
    }
}

/// A moment in UTC, ISO 8601. A clock may show any year: those outside 0 to 9999 get a sign and six
/// digits.
fn date(moment: SystemTime) -> String {
    const DAY: i64 = 86_400;
    let whole = |seconds: u64| i64::try_from(seconds).unwrap_or(i64::MAX);
    let seconds = match moment.duration_since(UNIX_EPOCH) {
        Ok(after) => whole(after.as_secs()),
        Err(error) => {
            let before = error.duration();
            -whole(before.as_secs()) - i64::from(before.subsec_nanos() > 0)
        }
    };
    let (days, second) = (seconds.div_euclid(DAY), seconds.rem_euclid(DAY));
    // Years from March on end with the leap day. 400 of them have 146 097 days; day 0 of the clock
    // is 719 468 days after the first of March of the year 0.
    let since = days + 719_468;
    let (era, day) = (since.div_euclid(146_097), since.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // From March on, five months have 153 days.
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let year = 400 * era + year + next;
    let year =
        if (0..=9999).contains(&year) { format!("{year:04}") } else { format!("{year:+07}") };
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::{cpu_name, date};
    use std::time::{Duration, SystemTime, UNIX_EPOCH};

    /// Dates that GNU date prints, and the last moments that a clock can show.
    #[test]
    fn every_moment_has_a_date() {
        let after = |seconds| UNIX_EPOCH + Duration::from_secs(seconds);
        let before = |millis| UNIX_EPOCH - Duration::from_millis(millis);
        let cases: [(SystemTime, &str); 12] = [
            (UNIX_EPOCH, "1970-01-01T00:00:00Z"),
            (after(1_709_210_096), "2024-02-29T12:34:56Z"),
            (after(951_868_799), "2000-02-29T23:59:59Z"),
            (after(4_107_542_400), "2100-03-01T00:00:00Z"),
            (after(253_402_300_799), "9999-12-31T23:59:59Z"),
            (after(253_402_300_800), "+010000-01-01T00:00:00Z"),
            (before(1), "1969-12-31T23:59:59Z"),
            (before(1000), "1969-12-31T23:59:59Z"),
            (before(2_208_988_800_000), "1900-01-01T00:00:00Z"),
            (before(62_167_219_200_000), "0000-01-01T00:00:00Z"),
            (before(62_167_219_201_000), "-000001-12-31T23:59:59Z"),
            (after(8_000_000_000_000_000_000), "+253509910024-06-28T14:13:20Z"),
        ];
        for (moment, expected) in cases {
            assert_eq!(date(moment), expected);
        }
        // Day after day the calendar goes on.
        let mut days: Vec<_> = (0..200_000).map(|day| date(after(86_400 * day))).collect();
        assert!(days.is_sorted());
        days.dedup();
        assert_eq!(days.len(), 200_000);
        assert_eq!(days[199_999], "2517-07-31T00:00:00Z");
    }

    #[test]
    fn processors_of_the_same_name_are_told_apart() {
        let info = "processor\t: 0\ncpu family\t: 26\nmodel\t\t: 2\nmodel name\t: Some CPU\n\nmodel\t: 7\n";
        assert_eq!(cpu_name(info).as_deref(), Some("Some CPU (family 26, model 2)"));
        assert_eq!(cpu_name("model name : Another\n").as_deref(), Some("Another"));
        assert_eq!(cpu_name("Features : fp asimd\n"), None);
    }
}
