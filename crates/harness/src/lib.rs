//! Runs one method on one scene, judges the result, and holds the studies that compare methods.
//!
//! Only this crate depends on the crate of every method ([`methods`]). A study writes its record,
//! and draws its figures from the facts in the record alone ([`studies`]).

pub mod auto;
mod bounds;
pub mod claims;
pub mod compare;
pub mod cost;
mod error;
pub mod export;
mod facts;
mod families;
mod film;
mod inspect;
mod journal;
pub mod judgement;
mod kept;
pub mod lessons;
mod load;
pub mod methods;
mod motion;
mod need;
mod ordered;
mod presets;
mod processor;
mod provenance;
pub mod record;
mod run;
mod scenes;
mod schedule;
mod shard;
mod spin;
mod stability;
pub mod studies;
mod team;
mod theory;
mod tunnel;
mod work;

pub use drape_report::Verdict;
pub use error::HarnessError;
pub use facts::{Difference, compare_folders};
pub use inspect::{
    Forecast, Foreseen, INSPECTION_FORMAT, Inspection, MethodForecast, STEPS_S, boundaries, groups,
    inspect,
};
pub use journal::{Joined, Journal, Unfinished};
pub use kept::{Kept, MotionCheck, Silent};
pub use motion::{LOCKED, Lever, Unforeseen};
pub use need::Need;
pub use ordered::{Moving, OrderedSimulation, Peak, Steps};
pub use presets::{Preset, presets};
pub use provenance::{Source, provenance, sha256, system_hash};
pub use run::{Counts, Divergence, Moment, Outcome, Runner, Simulation};
pub use scenes::{
    bundled, free_edge_midpoint, study_scene, time_span, with_damping_scaled,
    with_particles_a_side, with_stiffness,
};
pub use shard::{Missing, Shard};
pub use stability::{Energy, Rule, STABLE, judge, reference_energy};
pub use team::{Team, start_threads};
pub use tunnel::{Passage, Tunnels};
pub use work::{WorkBalance, is_driven};
