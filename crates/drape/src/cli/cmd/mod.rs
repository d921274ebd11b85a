//! The subcommands, each in a file of its own.

pub(crate) mod claim;
pub(crate) mod experiment;
pub(crate) mod frames;
pub(crate) mod list;
pub(crate) mod picture;
pub(crate) mod report;
pub(crate) mod reproduce;
pub(crate) mod run;
pub(crate) mod schema;
pub(crate) mod system;
