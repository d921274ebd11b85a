//! What the workspace builds on may be used and passed on.

use cargo_metadata::{MetadataCommand, Package};
use spdx::{Expression, ParseMode};
use std::collections::{BTreeMap, BTreeSet};

#[derive(serde::Deserialize)]
struct Deny {
    licenses: Licenses,
    bans: Bans,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Bans {
    multiple_versions: String,
    skip: Vec<String>,
}

#[derive(serde::Deserialize)]
struct Licenses {
    allow: Vec<String>,
}

fn deny() -> Deny {
    let path = drape_tests::equations::root().join("deny.toml");
    let text = std::fs::read_to_string(path).expect("deny.toml");
    toml::from_str(&text).expect("licences and bans")
}

/// Whether an expression can be met by allowed licences alone.
fn is_met(expression: &str, allowed: &[String]) -> bool {
    let parsed = Expression::parse_mode(expression, ParseMode::LAX);
    parsed.is_ok_and(|parsed| {
        parsed.evaluate(|asked| allowed.iter().any(|licence| *licence == asked.to_string()))
    })
}

#[test]
fn every_dependency_has_an_allowed_licence_and_comes_from_the_registry() {
    let metadata = MetadataCommand::new().exec().unwrap_or_else(|error| panic!("{error}"));
    let allowed = deny().licenses.allow;
    let (ours, others): (Vec<&Package>, Vec<&Package>) =
        metadata.packages.iter().partition(|package| package.source.is_none());
    assert!(ours.len() > 20 && others.len() > 100, "{} and {}", ours.len(), others.len());
    let is_ours = |package: &&&Package| package.manifest_path.starts_with(&metadata.workspace_root);
    assert_eq!(ours.iter().filter(is_ours).count(), ours.len(), "a path outside the workspace");
    let wrong: Vec<_> = metadata
        .packages
        .iter()
        .filter(|package| !package.license.as_deref().is_some_and(|text| is_met(text, &allowed)))
        .map(|package| format!("{} {}: {:?}", package.name, package.version, package.license))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let foreign: Vec<_> = others
        .iter()
        .filter(|package| !package.source.as_ref().is_some_and(|source| source.is_crates_io()))
        .map(|package| package.name.as_str())
        .collect();
    assert!(foreign.is_empty(), "{foreign:?}");
}

#[test]
fn no_dependency_comes_in_two_versions_but_those_that_are_named() {
    let metadata = MetadataCommand::new().exec().unwrap_or_else(|error| panic!("{error}"));
    let Bans { multiple_versions, skip } = deny().bans;
    assert_eq!(multiple_versions, "deny");
    let mut versions = BTreeMap::<String, u32>::new();
    for package in &metadata.packages {
        *versions.entry(package.name.to_string()).or_default() += 1;
    }
    let twice: BTreeSet<_> =
        versions.into_iter().filter(|(_, count)| *count > 1).map(|(name, _)| name).collect();
    let named: BTreeSet<_> = skip.into_iter().collect();
    let new: Vec<_> = twice.difference(&named).collect();
    assert!(new.is_empty(), "several versions, not named in deny.toml: {new:?}");
    let old: Vec<_> = named.difference(&twice).collect();
    assert!(old.is_empty(), "named in deny.toml, but only one version: {old:?}");
}

#[test]
fn a_choice_is_met_by_one_licence_and_a_sum_by_all() {
    let allowed: Vec<_> = ["MIT", "Zlib"].map(str::to_owned).into();
    for (expression, met) in [
        ("MIT", true),
        ("MIT/Apache-2.0", true),
        ("GPL-3.0-only", false),
        ("GPL-3.0-only OR Zlib", true),
        ("GPL-3.0-only AND Zlib", false),
        ("nonsense", false),
    ] {
        assert_eq!(is_met(expression, &allowed), met, "{expression}");
    }
}
