//! Writes the index from the paper's equations to the code.

use drape_tests::equations::{INDEX, collect, render, root};

fn main() -> std::io::Result<()> {
    let items = collect(&root())?;
    std::fs::write(root().join(INDEX), render(&items))
}
