//! Records what the compiler and the build were, for the provenance of results.

use std::process::Command;

fn main() {
    let variable = |name| std::env::var(name).unwrap_or_default();
    let rustc = Command::new(variable("RUSTC")).arg("-Vv").output().map_or_else(
        |_| "unknown".to_owned(),
        |output| String::from_utf8_lossy(&output.stdout).trim().replace('\n', "; "),
    );
    let flags = variable("CARGO_ENCODED_RUSTFLAGS").replace('\u{1f}', " ");
    let build = format!(
        "profile {}, opt-level {}, target {}, flags [{flags}]",
        variable("PROFILE"),
        variable("OPT_LEVEL"),
        variable("TARGET")
    );
    println!("cargo:rustc-env=DRAPE_RUSTC={rustc}");
    println!("cargo:rustc-env=DRAPE_BUILD={build}");
    println!("cargo:rerun-if-changed=build.rs");
}
