//! The method against its own mathematics.

mod motion;
mod sheet;
mod tableaux;

use crate::{Rosenbrock, RosenbrockSettings, Scheme};
use drape_integrator::{Integrator, MethodSettings, Settings};
use drape_model::{State, System};
use drape_oracle::Run;

/// The words of the setting `tableau`.
const NAMES: [(&str, Scheme); 5] = [
    ("ros2", Scheme::Ros2),
    ("ros3p", Scheme::Ros3p),
    ("rodas3", Scheme::Rodas3),
    ("ros34pw2", Scheme::Ros34pw2),
    ("rodas4", Scheme::Rodas4),
];

/// The method with settings as on the command line.
fn method(text: &str) -> Rosenbrock {
    let pairs = text.split(',').filter_map(|pair| pair.split_once('='));
    let method = &crate::ROSENBROCK;
    let settings = Settings::new(method.id, method.settings, pairs).expect("settings");
    Rosenbrock::new(RosenbrockSettings::of(&settings).expect("settings"))
}

fn boxed(text: &str) -> Box<dyn Integrator> {
    Box::new(method(text))
}

fn run(text: &str, start: (System, State), h: f64) -> Run {
    Run::new(boxed(text), start, h)
}
