//! The subcommands, each in a file of its own.

pub(crate) mod claim;
pub(crate) mod compare;
pub(crate) mod experiment;
pub(crate) mod export;
pub(crate) mod frames;
pub(crate) mod inspect;
pub(crate) mod lab;
pub(crate) mod list;
pub(crate) mod material;
pub(crate) mod merge;
pub(crate) mod picture;
mod probe;
mod readings;
pub(crate) mod report;
pub(crate) mod reproduce;
pub(crate) mod run;
pub(crate) mod scene;
pub(crate) mod schema;
pub(crate) mod system;

use drape_model::Violation;
use std::fmt::Display;

/// The refusal of an option's value.
fn refusal(option: &str, value: impl Display, expected: impl Into<String>) -> Violation {
    Violation { path: option.to_owned(), value: value.to_string(), expected: expected.into() }
}
