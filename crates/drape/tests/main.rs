//! Tests of the command.

mod answers;
mod command_line;
mod common;
mod compare;
mod examples;
mod interrupt;
mod lab;
mod material;
mod programs;
mod resume;
mod shards;
mod starts;
mod sweep;
mod tables;
mod timings;
mod view;
