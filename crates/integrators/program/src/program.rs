//! The programs that this process knows.

use crate::description::kept;
use crate::message::{HELLO, Hello, read_hello};
use crate::process::Process;
use crate::step::Session;
use drape_integrator::{Integrator, Method, Registration, SettingError, Settings, Stepper};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

/// Prefix of the id of a program; the command follows.
pub const PREFIX: &str = "program:";

/// Time in which a program must say hello for the first time.
const FIRST_HELLO: Duration = Duration::from_secs(60);
/// A program that was killed so often because it hung is not started again.
const MOST_HANGS: u32 = 3;

/// Milliseconds that no answer may exceed in this process, whatever the settings say.
static MOST_WAIT: AtomicU64 = AtomicU64::new(u64::MAX);

/// A limit on the time of each answer. It holds as long as this value lives.
#[derive(Debug)]
#[must_use = "the limit holds while it lives"]
pub struct AnswerLimit {
    /// The limit before, ms.
    before: u64,
}

/// Limits the time for each answer of a program in runs that begin from now on. The limit also
/// holds if `start_timeout` and `step_timeout` allow more. Set it if the run must end in time. It
/// does not limit the answer to `hello`.
pub fn answer_within(limit: Duration) -> AnswerLimit {
    let limit = u64::try_from(limit.as_millis()).unwrap_or(u64::MAX);
    AnswerLimit { before: MOST_WAIT.swap(limit.max(1), Ordering::Relaxed) }
}

impl Drop for AnswerLimit {
    fn drop(&mut self) {
        MOST_WAIT.store(self.before, Ordering::Relaxed);
    }
}

/// A limit of the settings, and that of [`answer_within`].
fn at_most(limit: Duration) -> Duration {
    limit.min(Duration::from_millis(MOST_WAIT.load(Ordering::Relaxed)))
}

/// A program that has said hello.
#[derive(Debug)]
pub(crate) struct Program {
    command: &'static str,
    /// The program and its arguments.
    words: Vec<String>,
    hello: Hello,
    pub(crate) method: &'static Method,
    hangs: AtomicU32,
    registration: Registration,
}

static PROGRAMS: Mutex<Vec<&'static Program>> = Mutex::new(Vec::new());

/// What a session is made of.
#[derive(Clone, Debug)]
pub(crate) struct ProgramSettings {
    pub(crate) program: &'static Program,
    pub(crate) start: Duration,
    pub(crate) step: Duration,
}

/// Starts the program of a command such as `./mine.py` or `python3 mine.py fast`, asks what it is
/// and returns its method, whose id is the command behind [`PREFIX`]. Each command is started and
/// asked only once.
///
/// Spaces separate the arguments; quotes (`'` or `"`) keep them together.
///
/// # Errors
/// A sentence that names the program and its failure.
pub fn load(command: &str) -> Result<&'static Registration, String> {
    let command = command.trim();
    if let Some(known) = find(command) {
        return Ok(&known.registration);
    }
    let words = words(command).map_err(|wrong| format!("program `{command}`: {wrong}"))?;
    let mut process = Process::start(command, &words)?;
    let hello = greet(&mut process, FIRST_HELLO)?;
    let id = format!("{PREFIX}{command}");
    let method = hello.method(&id, command).map_err(|wrong| process.failed(&wrong))?;
    let registration =
        Registration { method, build, is_portable: |_| false, follows_springs: |_| true };
    let (command, hangs) = (kept(command), AtomicU32::new(0));
    let program: &'static Program =
        Box::leak(Box::new(Program { command, words, hello, method, hangs, registration }));
    let mut programs = PROGRAMS.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    programs.push(program);
    Ok(&program.registration)
}

fn find(command: &str) -> Option<&'static Program> {
    let programs = PROGRAMS.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    programs.iter().copied().find(|program| program.command == command)
}

fn greet(process: &mut Process, limit: Duration) -> Result<Hello, String> {
    let hello = read_hello(process.ask("at `hello`", HELLO, limit)?);
    hello.map_err(|did| process.failed(&did))
}

impl Program {
    /// Starts it for a run.
    pub(crate) fn start(&self, limit: Duration) -> Result<Process, String> {
        if self.hangs.load(Ordering::Relaxed) >= MOST_HANGS {
            return Err(format!(
                "program `{}` was killed {MOST_HANGS} times because it did not answer, and is not \
                 started again",
                self.command
            ));
        }
        let mut process = Process::start(self.command, &self.words)?;
        let hello = greet(&mut process, limit);
        self.count(&process);
        if hello? != self.hello {
            return Err(process.failed("describes itself otherwise than at its first start"));
        }
        Ok(process)
    }

    /// Counts a program that hung.
    pub(crate) fn count(&self, process: &Process) {
        if process.has_hung() {
            self.hangs.fetch_add(1, Ordering::Relaxed);
        }
    }
}

fn build(settings: &Settings) -> Result<Box<dyn Integrator>, SettingError> {
    let command = settings.word("command");
    let program = find(command).ok_or_else(|| SettingError::Unknown {
        method: "program",
        key: command.to_owned(),
        known: "programs that were loaded".to_owned(),
    })?;
    let seconds = |key| Duration::from_secs_f64(settings.number(key));
    let (start, step) = (at_most(seconds("start_timeout")), at_most(seconds("step_timeout")));
    Ok(Box::new(Stepper::<Session>::new(ProgramSettings { program, start, step })))
}

/// The words of a command.
fn words(command: &str) -> Result<Vec<String>, String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in command.chars() {
        match (quote, c) {
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (Some(open), c) if open == c => quote = None,
            (None, c) if c.is_whitespace() => words.extend(word.take()),
            (_, '\0') => return Err("the command holds a zero byte".to_owned()),
            (_, c) => word.get_or_insert_default().push(c),
        }
    }
    if let Some(open) = quote {
        return Err(format!("the quote {open} is not closed"));
    }
    words.extend(word);
    if words.is_empty() {
        return Err("the command is empty; expected `program:./mine.py`".to_owned());
    }
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn a_command_is_split_at_spaces_outside_quotes() {
        let split = |text| words(text).map_err(|_| ());
        let own = |list: &[&str]| Ok(list.iter().map(|word| (*word).to_owned()).collect());
        assert_eq!(split("./mine.py"), own(&["./mine.py"]));
        assert_eq!(split(" a  b=1 "), own(&["a", "b=1"]));
        assert_eq!(split("'a b' \"c'd\" e'f g'h ''"), own(&["a b", "c'd", "ef gh", ""]));
        for wrong in ["", "  ", "'a", "a \"b", "a\0b"] {
            assert_eq!(split(wrong), Err(()), "{wrong:?}");
        }
    }
}
