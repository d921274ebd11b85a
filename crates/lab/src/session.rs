//! What one page sees: its panes, and the clock that they share.

use crate::engine::{Pane, Phase, Runs};
use crate::lessons;
use crate::limits;
use crate::messages::{Reply, Request, frame, hello, scenery};
use crate::setup::Setup;
use std::sync::OnceLock;
use std::time::Duration;

/// Time that passes in one tick at most, s: a page that was asleep does not jump.
const LONGEST_TICK: f64 = 0.1;
/// Share of a step by which a pane may be late and still counts as being in time.
const LATE: f64 = 1e-6;

/// A message to the page.
#[derive(Clone, Debug, PartialEq)]
pub enum Out {
    /// JSON.
    Text(String),
    /// Positions.
    Binary(Vec<u8>),
}

/// A pane with what the page knows of it.
#[derive(Debug)]
struct Shown {
    pane: Pane,
    run: u32,
    has_scenery: bool,
    /// Number of the last state that was sent, from 1.
    seen: u64,
}

/// The panes of a page and their clock.
#[derive(Debug)]
pub struct Session {
    runs: Runs,
    setups: Vec<Setup>,
    panes: Vec<Shown>,
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
    // All keys are texts, so nothing can fail.
    Out::Text(serde_json::to_string(reply).unwrap_or_default())
}

impl Session {
    /// A session without panes.
    pub fn new(runs: Runs) -> Self {
        Self {
            runs,
            setups: Vec::new(),
            panes: Vec::new(),
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
        // It is the same for all pages, and takes a while: every bundled scene is read.
        static HELLO: OnceLock<Out> = OnceLock::new();
        HELLO.get_or_init(|| text(&hello())).clone()
    }

    /// Does what the page asks for.
    pub fn receive(&mut self, message: &str) -> Vec<Out> {
        let done = serde_json::from_str(message)
            .map_err(|error| format!("the message is no request: {error}"))
            .and_then(|request| self.act(request));
        match done {
            Ok(replies) => replies,
            Err(sentence) => vec![text(&Reply::Refused { sentence })],
        }
    }

    /// A message in a form that the protocol does not have.
    pub fn refuse_binary(&self) -> Out {
        let sentence = "the message is no request: expected text, found bytes".to_owned();
        text(&Reply::Refused { sentence })
    }

    fn act(&mut self, request: Request) -> Result<Vec<Out>, String> {
        self.is_clock_new = true;
        match request {
            Request::Open { panes } => {
                let most = limits::PANES;
                if panes.is_empty() || panes.len() > most {
                    return Err(format!("{} panes; expected 1 to {most}", panes.len()));
                }
                self.setups = panes;
                self.start()?;
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
                let step = if phase.is_over() { 0 } else { snapshot.numbers.step };
                let repeat = scenery.stage.repeat(step).map_err(|error| error.to_string())?;
                return Ok(vec![text(&Reply::Repeat { pane, repeat })]);
            }
        }
        Ok(Vec::new())
    }

    fn start(&mut self) -> Result<(), String> {
        self.panes.clear();
        self.clock = 0.0;
        for setup in &self.setups {
            self.last = self.last.wrapping_add(1);
            let Some(pane) = Pane::start(setup.clone(), &self.runs) else {
                self.panes.clear();
                return Err(
                    "too many runs at a time; close other pages of the lab, or wait until \
                            slow steps of closed runs end"
                        .to_owned(),
                );
            };
            self.panes.push(Shown { pane, run: self.last, has_scenery: false, seen: 0 });
        }
        Ok(())
    }

    fn go(&self) {
        self.panes.iter().for_each(|shown| shown.pane.go_until(self.clock));
    }

    /// Lets so much time pass, and tells what is new.
    pub fn tick(&mut self, elapsed: Duration) -> Vec<Out> {
        if self.playing {
            self.advance(elapsed.as_secs_f64().min(LONGEST_TICK) * self.rate);
        }
        let mut told = Vec::new();
        for (pane, shown) in self.panes.iter_mut().enumerate() {
            let (version, phase, snapshot) = shown.pane.look();
            let Some(known) = shown.pane.scenery().filter(|_| version > 0) else {
                if let Phase::Refused(_) = phase
                    && version > shown.seen
                {
                    told.push(status(pane, shown.run, &phase, &snapshot, 0.0));
                    shown.seen = version;
                }
                continue;
            };
            if !shown.has_scenery {
                told.push(text(&scenery(pane, shown.run, known)));
                shown.has_scenery = true;
            }
            if version > shown.seen {
                shown.seen = version;
                let time = snapshot.numbers.time;
                if !snapshot.shown.is_empty() {
                    told.push(Out::Binary(frame(pane, shown.run, time, &snapshot.shown)));
                }
                let behind = if phase.is_over() { 0.0 } else { (self.clock - time).max(0.0) };
                told.push(status(pane, shown.run, &phase, &snapshot, behind));
            }
        }
        let is_over = |shown: &Shown| shown.pane.look().1.is_over();
        if self.playing && !self.panes.is_empty() && self.panes.iter().all(is_over) {
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
        let must_wait =
            self.panes.iter().any(is_preparing) || self.wait && self.panes.iter().any(is_late);
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

fn status(
    pane: usize,
    run: u32,
    phase: &Phase,
    snapshot: &crate::engine::Snapshot,
    behind: f64,
) -> Out {
    let (numbers, verdict) = (&snapshot.numbers, snapshot.opinion.as_ref());
    text(&Reply::Status { pane, run, phase, numbers, verdict, behind })
}
