//! `compare-facts FRESH COMMITTED`: do the facts under two results folders agree?
//!
//! Every fact below FRESH (a quick subset will do) must stand below COMMITTED with the same value:
//! bit for bit, or within 1e-9 where a library's factorisation took part. Exit code 1 and one line
//! a difference otherwise.

use drape_report::tell;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [fresh, committed] = arguments.as_slice() else {
        tell!("usage: compare-facts FRESH COMMITTED");
        return ExitCode::from(2);
    };
    match drape_harness::compare_folders(Path::new(fresh), Path::new(committed)) {
        Err(error) => {
            tell!("compare-facts: {error}");
            ExitCode::from(2)
        }
        Ok((facts, differences)) => {
            for difference in &differences {
                tell!("{difference}");
            }
            tell!("{facts} facts compared, {} differ", differences.len());
            ExitCode::from(u8::from(!differences.is_empty()))
        }
    }
}
