//! Writes what follows from the facts: the words of each record, and the numbers of the pages.

use drape_report::tell;
use drape_tests::equations::root;
use drape_tests::splice::{facts, pages, splice};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for study in drape_harness::studies::all() {
        if study.reword(&root().join("results"))? {
            tell!("wrote the words of {}", study.name());
        }
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
