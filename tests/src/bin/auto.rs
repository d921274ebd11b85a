//! Writes what follows from the record of `work-precision` for `--method auto`: the table in the
//! source, and the page that holds the rule against the study: `cargo run -p drape-tests --bin auto`.

use drape_report::tell;
use drape_tests::auto::{FILES, written};
use drape_tests::equations::root;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (file, text) in FILES.into_iter().zip(written(&root())?) {
        std::fs::write(root().join(file), text)?;
        tell!("wrote {file}");
    }
    Ok(())
}
