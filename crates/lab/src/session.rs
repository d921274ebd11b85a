//! The session of one page: its panes, and the clock that they share.

use crate::engine::{Pane, Phase, Snapshot};
use crate::files::Files;
use crate::ghost::{Ghost, distance};
use crate::lessons;
use crate::limits;
use crate::messages::{Of, Reply, Request, dropped, file, frame, hello, scenery};
use crate::setup::{Setup, Touch};
use crate::work::{LATE, Runs};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// Most time that passes in one tick, s, so that a page that was asleep does not jump.
const LONGEST_TICK: f64 = 0.1;
/// Least number of steps in which a led particle reaches the place of the hand.
const LEAD_STEPS: f64 = 2.0;
/// Time in which a led particle reaches the place of the hand, s of the person's time.
const LEAD_S: f64 = 0.066;

/// A message to the page.
#[derive(Clone, Debug, PartialEq)]
pub enum Out {
    /// JSON.
    Text(String),
    /// Positions.
    Binary(Vec<u8>),
}

/// A pane, and the messages about it that the page has got.
#[derive(Debug)]
struct Shown {
    pane: Pane,
    run: u32,
    has_scenery: bool,
    /// Number of the last state that was sent, from 1.
    seen: u64,
    /// Whether that state was the last of the run.
    is_over: bool,
    /// Index of its reference among those of the session.
    ghost: Option<usize>,
    /// Whether the last state was sent with the positions or the refusal of its reference.
    has_ghost: bool,
    /// Position of the led particle when it was gripped, m.
    grip: Option<[f64; 3]>,
}

/// A hand that leads a particle.
#[derive(Clone, Copy, Debug)]
struct Hand {
    particle: u32,
    /// Its displacement since the grip, m.
    by: [f64; 3],
    /// Whether the panes follow it already.
    is_known: bool,
    lets_go: bool,
}

/// The panes of a page and their clock.
#[derive(Debug)]
pub struct Session {
    runs: Runs,
    files: Arc<Files>,
    setups: Vec<Setup>,
    panes: Vec<Shown>,
    wants_ghosts: bool,
    ghosts: Vec<Ghost>,
    hand: Option<Hand>,
    /// Number of the last run.
    last: u32,
    clock: f64,
    playing: bool,
    rate: f64,
    wait: bool,
    /// Whether the page must be told the clock.
    is_clock_new: bool,
}

fn text(reply: &Reply<'_>) -> Out {
    // All keys are texts, so this cannot fail.
    Out::Text(serde_json::to_string(reply).unwrap_or_default())
}

impl Session {
    /// A session without panes.
    pub fn new(runs: Runs) -> Self {
        Self {
            runs,
            files: Arc::default(),
            setups: Vec::new(),
            panes: Vec::new(),
            wants_ghosts: false,
            ghosts: Vec::new(),
            hand: None,
            last: 0,
            clock: 0.0,
            playing: false,
            rate: 1.0,
            wait: true,
            is_clock_new: true,
        }
    }

    /// The first message to the page.
    pub fn greet(&self) -> Out {
        // The message is the same for all pages, and takes a while: it reads every bundled scene.
        static HELLO: OnceLock<Out> = OnceLock::new();
        HELLO.get_or_init(|| text(&hello())).clone()
    }

    /// Handles a request of the page and returns the answers.
    pub fn receive(&mut self, message: &str) -> Vec<Out> {
        let done = serde_json::from_str(message)
            .map_err(|error| format!("the message is no request: {error}"))
            .and_then(|request| self.act(request));
        match done {
            Ok(replies) => replies,
            Err(sentence) => vec![text(&Reply::Refused { sentence })],
        }
    }

    /// Takes a file: the length of its name (u32, little-endian), the name, the content.
    pub fn receive_file(&mut self, bytes: &[u8]) -> Out {
        let Some((name, content)) = file(bytes) else {
            let sentence = "the message is no request: expected text, or bytes with the length of \
                            a name, the name and the content of a file";
            return text(&Reply::Refused { sentence: sentence.to_owned() });
        };
        // Panes that still read the previous files keep them.
        match Arc::make_mut(&mut self.files).add(name, content) {
            Ok(taken) => text(&dropped(name, taken)),
            Err(error) => text(&Reply::Refused { sentence: error.to_string() }),
        }
    }

    fn act(&mut self, request: Request) -> Result<Vec<Out>, String> {
        self.is_clock_new = true;
        match request {
            Request::Open { panes, keep } => {
                let most = limits::PANES;
                if panes.is_empty() || panes.len() > most {
                    return Err(format!("{} panes; expected 1 to {most}", panes.len()));
                }
                let before = std::mem::replace(&mut self.setups, panes);
                if !(keep && self.go_on(&before)) {
                    self.start()?;
                }
            }
            Request::Restart {} => self.start()?,
            Request::Play {} => self.playing = true,
            Request::Pause {} => self.playing = false,
            Request::Step {} => {
                self.playing = false;
                let next = self.panes.iter().filter_map(|shown| shown.pane.next());
                let next = next.fold(f64::INFINITY, f64::min);
                if next.is_finite() {
                    self.clock = next;
                    self.go();
                }
            }
            Request::Rate { rate } => {
                let (least, most) = limits::RATE;
                if !(least..=most).contains(&rate) {
                    return Err(format!("rate {rate}; expected a number from {least} to {most}"));
                }
                self.rate = rate;
            }
            Request::Wait { wait } => self.wait = wait,
            Request::Lessons {} => return Ok(vec![text(&lessons::list())]),
            Request::Lesson { id } => return Ok(vec![text(&lessons::tell(&id)?)]),
            Request::Answer { lesson, value } => {
                return Ok(vec![text(&lessons::mark(&lesson, value)?)]);
            }
            Request::Repeat { pane } => {
                let shown = self.panes.get(pane);
                let shown = shown.ok_or_else(|| format!("pane {pane}; there is none"))?;
                let scenery = shown.pane.scenery();
                let scenery = scenery.ok_or_else(|| format!("pane {pane} has no scene yet"))?;
                let (_, phase, snapshot) = shown.pane.look();
                let step = if phase.is_over() { 0 } else { snapshot.step };
                let repeat = scenery.stage.repeat(step).map_err(|error| error.to_string())?;
                return Ok(vec![text(&Reply::Repeat { pane, repeat: Box::new(repeat) })]);
            }
            Request::Lead { particle, by } => self.lead(particle, by)?,
            Request::LetGo {} => {
                if let Some(hand) = &mut self.hand {
                    (hand.lets_go, hand.is_known) = (true, false);
                }
            }
            Request::Ghost { on } => {
                self.wants_ghosts = on;
                self.start_ghosts();
            }
        }
        Ok(Vec::new())
    }

    /// Notes a movement of the hand; the next tick makes the panes follow it.
    fn lead(&mut self, particle: u32, by: [f64; 3]) -> Result<(), String> {
        let most = limits::WAY_M;
        if let Some(way) = by.iter().find(|way| way.is_nan() || way.abs() > most) {
            return Err(format!("the way of the hand is {way} m; expected at most {most} m"));
        }
        if self.hand.is_some_and(|hand| hand.particle != particle) {
            let known = self.hand.map_or(particle, |hand| hand.particle);
            return Err(format!("particle {particle}; expected {known}, which is led"));
        }
        self.hand = Some(Hand { particle, by, is_known: false, lets_go: false });
        self.playing = true;
        Ok(())
    }

    /// Makes the panes follow the hand, once every pane has moved since the last movement.
    fn follow_hand(&mut self) {
        let Some(hand) = self.hand.filter(|hand| !hand.is_known) else { return };
        let has_moved = |shown: &Shown| {
            let (_, phase, snapshot) = shown.pane.look();
            let is_fresh = shown.pane.scenery().is_some_and(|s| !s.stage.is_touched());
            let may_go = is_fresh || hand.lets_go || snapshot.step > 0;
            phase.is_over() || phase == Phase::Ready && may_go
        };
        if !self.panes.iter().all(has_moved) {
            return;
        }
        for shown in &mut self.panes {
            let (_, phase, snapshot) = shown.pane.look();
            let (Some(known), Some(state)) = (shown.pane.scenery(), &snapshot.state) else {
                continue;
            };
            if phase != Phase::Ready {
                continue;
            }
            let (stage, steps) = (&known.stage, snapshot.step);
            let next = if hand.lets_go {
                shown.grip = None;
                if !stage.is_led() {
                    continue;
                }
                stage.let_go(state, steps)
            } else {
                let Some(place) = state.x.get(hand.particle as usize) else { continue };
                let grip = *shown.grip.get_or_insert((*place).into());
                let to = [0, 1, 2].map(|axis| grip[axis] + hand.by[axis]);
                let leg = (LEAD_S * self.rate).max(LEAD_STEPS * stage.time.step_s);
                stage.led(state, steps, hand.particle, to, leg)
            };
            // A pane that cannot follow, because its run is over, stays as it is.
            if let Some(pane) = next.ok().and_then(|stage| Pane::resume(stage, &self.runs)) {
                // The reference knows nothing of the hand.
                (shown.pane, shown.seen, shown.ghost) = (pane, 0, None);
            }
        }
        self.end_lonely_ghosts();
        self.go();
        self.hand = (!hand.lets_go).then_some(Hand { is_known: true, ..hand });
    }

    /// Lets the cloth of every pane go on under its new set-up. Returns `false` and changes nothing
    /// if one of them cannot.
    fn go_on(&mut self, before: &[Setup]) -> bool {
        if self.panes.len() != self.setups.len() || before.len() != self.setups.len() {
            return false;
        }
        let has_hand = self.hand.is_some();
        let go_on = |((shown, old), new): ((&Shown, &Setup), &Setup)| {
            if old == new && !has_hand {
                return Some(None);
            }
            let (_, phase, snapshot) = shown.pane.look();
            let is_other = old.scene != new.scene || phase != Phase::Ready;
            let (known, state) = (shown.pane.scenery()?, snapshot.state.as_ref()?);
            let stage = (!is_other).then(|| new.stage_with(&self.files))?.ok()?;
            let stage = stage.going_on(&known.stage, state, snapshot.step).ok()?;
            Some(Some(Pane::resume(stage, &self.runs)?))
        };
        let pairs = self.panes.iter().zip(before).zip(&self.setups);
        let Some(panes) = pairs.map(go_on).collect::<Option<Vec<_>>>() else { return false };
        for (shown, pane) in self.panes.iter_mut().zip(panes) {
            // The page made the pane anew, so it needs all messages about it.
            (shown.seen, shown.has_scenery, shown.grip) = (0, false, None);
            if let Some(pane) = pane {
                (shown.pane, shown.ghost) = (pane, None);
            }
        }
        self.hand = None;
        self.end_lonely_ghosts();
        self.go();
        true
    }

    /// Ends the references if no pane has one.
    fn end_lonely_ghosts(&mut self) {
        if self.panes.iter().all(|shown| shown.ghost.is_none()) {
            self.ghosts.clear();
        }
    }

    /// Starts the references if they are wanted, or ends them all. Set-ups that differ only in
    /// their method share one.
    fn start_ghosts(&mut self) {
        self.ghosts.clear();
        let mut groups: Vec<Setup> = Vec::new();
        for (shown, setup) in self.panes.iter_mut().zip(&self.setups) {
            // The page gets the state again, with or without a reference.
            (shown.ghost, shown.has_ghost, shown.seen) = (None, false, 0);
            let is_touched = shown.pane.scenery().is_some_and(|s| s.stage.is_touched());
            if !self.wants_ghosts || is_touched {
                continue;
            }
            let scene = Setup { method: String::new(), ..setup.clone() };
            let place = match groups.iter().position(|known| *known == scene) {
                Some(place) => place,
                None => {
                    let Some(ghost) = Ghost::start(&scene, &self.files, &self.runs) else {
                        continue;
                    };
                    self.ghosts.push(ghost);
                    groups.push(scene);
                    groups.len() - 1
                }
            };
            shown.ghost = Some(place);
        }
        self.go();
    }

    fn start(&mut self) -> Result<(), String> {
        self.panes.clear();
        self.ghosts.clear();
        self.hand = None;
        self.clock = 0.0;
        for setup in &self.setups {
            self.last = self.last.wrapping_add(1);
            let Some(pane) = Pane::start_with(setup.clone(), self.files.clone(), &self.runs) else {
                self.panes.clear();
                return Err(
                    "too many runs at a time; close other pages of the lab, or wait until \
                            slow steps of closed runs end"
                        .to_owned(),
                );
            };
            self.panes.push(Shown {
                pane,
                run: self.last,
                has_scenery: false,
                seen: 0,
                is_over: false,
                ghost: None,
                has_ghost: false,
                grip: None,
            });
        }
        self.start_ghosts();
        Ok(())
    }

    fn go(&self) {
        self.panes.iter().for_each(|shown| shown.pane.go_until(self.clock));
        self.ghosts.iter().for_each(|ghost| ghost.go_until(self.clock));
    }

    /// Returns the messages about new states, and then lets so much time pass.
    pub fn tick(&mut self, elapsed: Duration) -> Vec<Out> {
        // Panes compute between two ticks. Reading all of them before they go on treats them alike.
        let told = self.tell();
        if self.playing {
            self.advance(elapsed.as_secs_f64().min(LONGEST_TICK) * self.rate);
        }
        self.follow_hand();
        told
    }

    fn tell(&mut self) -> Vec<Out> {
        let mut told = Vec::new();
        for (pane, shown) in self.panes.iter_mut().enumerate() {
            let (version, phase, snapshot) = shown.pane.look();
            let Some(known) = shown.pane.scenery().filter(|_| version > 0) else {
                if let Phase::Refused(_) = phase
                    && version > shown.seen
                {
                    told.push(status(pane, shown.run, &phase, &snapshot, (0.0, None, None)));
                    shown.seen = version;
                    shown.is_over = true;
                }
                continue;
            };
            if !shown.has_scenery {
                told.push(text(&scenery(pane, shown.run, known)));
                shown.has_scenery = true;
            }
            let time = snapshot.numbers.time;
            let reference = shown.ghost.and_then(|ghost| self.ghosts.get(ghost));
            let refusal = reference.and_then(Ghost::refusal);
            let places = reference.and_then(|ghost| ghost.at(time));
            let is_told = places.is_some() || refusal.is_some();
            if version > shown.seen || is_told && !shown.has_ghost {
                shown.seen = version;
                shown.is_over = phase.is_over();
                shown.has_ghost = is_told;
                if !snapshot.shown.is_empty() {
                    told.push(Out::Binary(frame(Of::Pane, pane, shown.run, time, &snapshot.shown)));
                }
                let places = places.as_deref();
                if let Some(places) = places {
                    told.push(Out::Binary(frame(Of::Ghost, pane, shown.run, time, places)));
                }
                let apart = places.and_then(|places| distance(places, &snapshot.shown));
                let touch = known.stage.touch();
                let why = match refusal {
                    _ if !self.wants_ghosts => None,
                    None => touch.map(|touch| unknown_to_the_reference(touch).to_owned()),
                    refusal => refusal,
                };
                let behind = if phase.is_over() { 0.0 } else { (self.clock - time).max(0.0) };
                told.push(status(pane, shown.run, &phase, &snapshot, (behind, apart, why)));
            }
        }
        // A pane that ends now, after its look above, tells its end at the next tick. The clock must
        // not stop before, or the page would hear of a stop and not of the ends.
        if self.playing && !self.panes.is_empty() && self.panes.iter().all(|pane| pane.is_over) {
            self.playing = false;
            self.is_clock_new = true;
        }
        if std::mem::take(&mut self.is_clock_new) {
            let Self { clock: time, playing, rate, wait, .. } = *self;
            told.push(text(&Reply::Clock { time, playing, rate, wait }));
        }
        told
    }

    /// Moves the clock on, unless it waits for a slow pane.
    fn advance(&mut self, time: f64) {
        let is_late = |shown: &Shown| {
            let (_, phase, _) = shown.pane.look();
            match (phase.is_over(), shown.pane.scenery(), shown.pane.next()) {
                (true, ..) => false,
                (false, Some(scenery), Some(next)) => {
                    next <= self.clock - LATE * scenery.stage.time.step_s
                }
                (false, ..) => true,
            }
        };
        let is_preparing = |shown: &Shown| shown.pane.look().1 == Phase::Preparing;
        let is_behind = |ghost: &Ghost| ghost.is_behind(self.clock);
        let is_one_late = || self.panes.iter().any(is_late) || self.ghosts.iter().any(is_behind);
        let must_wait = self.panes.iter().any(is_preparing) || self.wait && is_one_late();
        if !must_wait {
            self.clock += time;
            self.go();
        }
    }

    /// The panes, in their order.
    pub fn panes(&self) -> impl Iterator<Item = &Pane> {
        self.panes.iter().map(|shown| &shown.pane)
    }
}

/// Why a pane that began from the state of another run has no reference.
fn unknown_to_the_reference(touch: Touch) -> &'static str {
    match touch {
        Touch::Hand => "the reference knows nothing of the hand: press Restart",
        Touch::Knob => "the reference knows nothing of a knob turned on the way: press Restart",
    }
}

fn status(
    pane: usize,
    run: u32,
    phase: &Phase,
    snapshot: &Snapshot,
    (behind, distance, ghost): (f64, Option<f64>, Option<String>),
) -> Out {
    let (numbers, verdict) = (&snapshot.numbers, snapshot.opinion.as_ref());
    text(&Reply::Status { pane, run, phase, numbers, verdict, behind, distance, ghost })
}
