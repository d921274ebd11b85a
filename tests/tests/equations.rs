//! Every equation of the paper has its place in the code, and the committed index says where.

use drape_tests::equations::{EQUATIONS, INDEX, collect, render, root, scan};

#[test]
fn every_equation_of_the_paper_is_implemented_by_a_named_item() {
    let items = collect(&root()).expect("readable sources");
    for (label, meaning) in EQUATIONS {
        let places = items.iter().filter(|item| item.equation() == Some(label));
        assert!(places.count() > 0, "no item has #[doc(alias = \"EEH {label}\")]: {meaning}");
    }
    for item in &items {
        assert!(!item.path.ends_with(':'), "{item:?}: which item is it?");
        let Some(equation) = item.equation() else { continue };
        let known = EQUATIONS.iter().any(|(label, _)| *label == equation);
        // Sections of the paper may be named beside its equations.
        assert!(known || equation.starts_with("section "), "{item:?}: no such equation");
    }
}

/// A reader who knows a method of today by its name or by its authors finds it.
#[test]
fn every_crate_of_a_method_published_since_has_a_name_in_the_index() {
    let items = collect(&root()).expect("readable sources");
    let crates = [
        "midpoint",
        "generalized_alpha",
        "dirk",
        "energy_momentum",
        "rosenbrock",
        "imex_rk",
        "exponential",
        "rkc",
        "srkn4",
        "multirate",
        "projective",
        "vbd",
        "xpbd",
        "xpbd_lines",
    ];
    for name in crates {
        let path = format!("drape_{name}::");
        let mut names = items.iter().filter(|item| item.equation().is_none());
        assert!(names.any(|item| item.path.starts_with(&path)), "drape_{name} has no alias");
    }
}

#[test]
fn the_committed_index_is_the_one_that_the_code_gives() {
    let items = collect(&root()).expect("readable sources");
    let committed = std::fs::read_to_string(root().join(INDEX)).expect("the index is there");
    let hint = "run `cargo run -p drape-tests --bin equation-index`";
    assert_eq!(committed, render(&items), "{INDEX} is out of date: {hint}");
}

/// What the index is made from: attributes on functions, methods and types, also several on one.
#[test]
fn aliases_are_attributed_to_the_item_below_them() {
    let text = r#"
#[doc(alias = "EEH 1")]
#[doc(alias = "EEH 2")]
/// Text about a fn of another name.
pub(crate) const fn free() {}

impl<'a> Display for Thing<'a> {
    #[doc(alias = "EEH 3")]
    #[must_use]
    pub fn method(&self) {}
}

#[doc(alias = "TR-BDF2")]
pub struct Thing<'a> {
"#;
    let found: Vec<_> = scan("crates/integrators/a-b/src/c/mod.rs", text)
        .into_iter()
        .map(|i| (i.label, i.path))
        .collect();
    let expected = [
        ("EEH 1", "drape_a_b::c::free"),
        ("EEH 2", "drape_a_b::c::free"),
        ("EEH 3", "drape_a_b::c::Thing::method"),
        ("TR-BDF2", "drape_a_b::c::Thing"),
    ];
    assert_eq!(found, expected.map(|(label, path)| (label.to_owned(), path.to_owned())));
}
