//! The method against its own mathematics.

mod motion;
mod sheet;
mod tableaux;

use crate::{ImexRk, ImexRkSettings, Pair};
use drape_integrator::{Integrator, MethodSettings, Settings};
use drape_model::{State, System};
use drape_oracle::Run;

/// The words of the setting `tableau`.
const NAMES: [(&str, Pair); 4] = [
    ("ars222", Pair::Ars222),
    ("ars443", Pair::Ars443),
    ("ark3", Pair::Ark3),
    ("ark4", Pair::Ark4),
];

/// The method with settings as on the command line.
fn method(text: &str) -> ImexRk {
    let pairs = text.split(',').filter_map(|pair| pair.split_once('='));
    let id = crate::IMEX_RK.id;
    let settings = Settings::new(id, crate::IMEX_RK.settings, pairs).expect("settings");
    ImexRk::new(ImexRkSettings::of(&settings).expect("settings"))
}

fn boxed(text: &str) -> Box<dyn Integrator> {
    Box::new(method(text))
}

fn run(text: &str, start: (System, State), h: f64) -> Run {
    Run::new(boxed(text), start, h)
}
