//! Writes what follows from the facts: the words of each record, the numbers of the pages, and the
//! figure of the engine.

use drape_report::file::write_atomically;
use drape_report::tell;
use drape_tests::engine;
use drape_tests::equations::root;
use drape_tests::splice::{facts, pages, splice};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for study in drape_harness::studies::all() {
        if study.reword(&root().join("results"))? {
            tell!("wrote the words of {}", study.name());
        }
    }
    for (name, content) in engine::figure(&root().join("results"))? {
        write_atomically(&root().join("results").join(name), content.bytes())?;
    }
    let facts = facts(&root().join("results"))?;
    for page in pages(&root())? {
        let text = std::fs::read_to_string(&page)?;
        let spliced = splice(&text, &facts).map_err(|e| format!("{}: {e}", page.display()))?;
        if spliced != text {
            std::fs::write(&page, spliced)?;
            tell!("wrote {}", page.display());
        }
    }
    Ok(())
}
