//! A running program: requests, answers, time limits and its end.

use crate::failures;
use crate::message::{Answer, shown};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, kill_process_group};
use std::collections::VecDeque;
use std::io::{ErrorKind, Read as _, Write as _};
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest line of an answer, bytes.
const MOST_LINE: usize = 1 << 16;
/// Bytes of its standard error that are passed on to the user.
const MOST_STDERR: usize = 1 << 16;
/// The end of its standard error that is kept for messages, bytes.
const LAST_WORDS: usize = 1 << 10;
/// Time that it has to end by itself, once its input is closed.
const FAREWELL: Duration = Duration::from_secs(2);
/// Between two looks at whether it has ended.
const LOOK: Duration = Duration::from_millis(2);

/// The process groups of the programs that run.
static RUNNING: Mutex<Vec<Pid>> = Mutex::new(Vec::new());

/// Kills all running programs and the processes that they started. It is for a process that is
/// about to end.
pub fn kill_all() {
    for group in RUNNING.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        // The group may be gone already.
        let _ = kill_process_group(group, Signal::KILL);
    }
}

/// A running program. Its process group is killed and waited for when this is dropped.
#[derive(Debug)]
pub(crate) struct Process {
    command: String,
    child: Child,
    input: Option<ChildStdin>,
    output: Option<ChildStdout>,
    errors: Option<ChildStderr>,
    /// What it has answered to the present request.
    inbox: Vec<u8>,
    last_words: VecDeque<u8>,
    passed_on: usize,
    has_hung: bool,
    /// The sentence about its end, if it failed.
    failure: Option<String>,
}

/// What a wait for the program saw.
#[derive(Clone, Copy, Default)]
struct Ready {
    input: bool,
    output: bool,
    errors: bool,
}

/// Tells from the line of an answer, and from when it came, how many bytes follow it.
type Announced<'a> = dyn FnMut(&[u8], &str) -> Result<usize, String> + 'a;

impl Process {
    /// Starts a program in a process group of its own.
    pub(crate) fn start(command: &str, words: &[String]) -> Result<Self, String> {
        let mut child = Command::new(&words[0])
            .args(&words[1..])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0)
            .spawn()
            .map_err(|error| refusal(command, &words[0], &error))?;
        if let Some(group) = group(&child) {
            RUNNING.lock().unwrap_or_else(PoisonError::into_inner).push(group);
        }
        let (input, output, errors) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let mut process = Self {
            command: command.to_owned(),
            child,
            input,
            output,
            errors,
            inbox: Vec::with_capacity(MOST_LINE),
            last_words: VecDeque::with_capacity(LAST_WORDS),
            passed_on: 0,
            has_hung: false,
            failure: None,
        };
        match process.set_nonblocking() {
            Ok(()) => Ok(process),
            Err(error) => {
                Err(process.failed(&format!("has pipes that cannot be set up ({error})")))
            }
        }
    }

    fn set_nonblocking(&self) -> rustix::io::Result<()> {
        self.input.as_ref().map_or(Ok(()), |pipe| rustix::io::ioctl_fionbio(pipe, true))?;
        self.output.as_ref().map_or(Ok(()), |pipe| rustix::io::ioctl_fionbio(pipe, true))?;
        self.errors.as_ref().map_or(Ok(()), |pipe| rustix::io::ioctl_fionbio(pipe, true))
    }

    /// Makes room for answers with so many bytes behind their line.
    pub(crate) fn reserve(&mut self, bytes: usize) {
        self.inbox.reserve(MOST_LINE + bytes + 1);
    }

    /// Whether it was killed because it did not answer in time.
    pub(crate) fn has_hung(&self) -> bool {
        self.has_hung
    }

    /// Kills the program and says what it did: `did` follows its name.
    pub(crate) fn failed(&mut self, did: &str) -> String {
        if let Some(failure) = &self.failure {
            return failure.clone();
        }
        self.listen();
        self.kill();
        self.listen();
        let last = self.last_words();
        let last = if last.is_empty() {
            String::new()
        } else {
            format!("; the last line on its standard error: `{last}`")
        };
        let sentence = format!("program `{}` {did}{last}", self.command);
        failures::note(&sentence);
        self.failure = Some(sentence.clone());
        sentence
    }

    /// Sends a request and waits for its answer, one line of JSON without bytes behind it. `when`
    /// says in messages which request it is.
    pub(crate) fn ask(
        &mut self,
        when: &str,
        request: &[u8],
        limit: Duration,
    ) -> Result<&[u8], String> {
        let line = self.exchange(when, request, limit, &mut |_, _| Ok(0))?;
        Ok(&self.inbox[..line])
    }

    /// As [`ask`](Self::ask), for an answer that says `ok`, or carries so many `bytes` in which the
    /// new state stands.
    pub(crate) fn request(
        &mut self,
        when: &str,
        request: &[u8],
        bytes: usize,
        limit: Duration,
    ) -> Result<(Answer, &[u8]), String> {
        let mut answer = Answer::default();
        let line = self.exchange(when, request, limit, &mut |line, when| {
            answer = Answer::read(line, when, bytes)?;
            Ok(bytes)
        })?;
        Ok((answer, &self.inbox[line + 1..]))
    }

    /// Sends a request and reads its answer: a line, and as many bytes as `rest` says of it.
    /// Returns the length of the line.
    fn exchange(
        &mut self,
        when: &str,
        request: &[u8],
        limit: Duration,
        rest: &mut Announced<'_>,
    ) -> Result<usize, String> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        self.inbox.clear();
        if self.receive(1) {
            let what = self.end(when);
            return Err(self.failed(&what));
        }
        if !self.inbox.is_empty() {
            let what = format!("had written more than it announced before it was asked {when}");
            return Err(self.failed(&what));
        }
        let deadline = Instant::now() + limit;
        let mut sent = 0;
        // Length of the line, and of all of the answer.
        let mut found: Option<(usize, usize)> = None;
        loop {
            if let Some((line, all)) = found {
                if self.inbox.len() > all {
                    let what = format!("wrote more {when} than it announced");
                    return Err(self.failed(&what));
                }
                if self.inbox.len() == all && sent == request.len() {
                    self.listen();
                    return Ok(line);
                }
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                self.has_hung = true;
                let what = format!(
                    "did not answer {when} within {} s and was killed",
                    limit.as_secs_f64()
                );
                return Err(self.failed(&what));
            }
            let ready = self.wait(sent < request.len(), left);
            if ready.errors {
                self.listen();
            }
            if ready.input {
                sent += self.send(&request[sent..]);
            }
            if !ready.output {
                continue;
            }
            let most = found.map_or(MOST_LINE, |(_, all)| all) + 1;
            let has_ended = self.receive(most);
            if found.is_none() {
                match self.inbox.iter().position(|&byte| byte == b'\n') {
                    Some(line) => match rest(&self.inbox[..line], when) {
                        Ok(bytes) => found = Some((line, line + 1 + bytes)),
                        Err(what) => return Err(self.failed(&what)),
                    },
                    None if self.inbox.len() >= MOST_LINE => {
                        let what = format!(
                            "wrote {MOST_LINE} bytes {when} without an end of line; it began with \
                             `{}`",
                            shown(&self.inbox[..200], 60)
                        );
                        return Err(self.failed(&what));
                    }
                    None => {}
                }
            }
            // A program may end with its answer: that is seen at the next request.
            let is_whole = found.is_some_and(|(_, all)| self.inbox.len() >= all);
            if has_ended && !(is_whole && sent == request.len()) {
                let what = self.end(when);
                return Err(self.failed(&what));
            }
        }
    }

    /// Waits until a pipe is ready, at most `left`.
    fn wait(&self, is_sending: bool, left: Duration) -> Ready {
        let mut fds = Vec::with_capacity(3);
        let mut roles = Vec::with_capacity(3);
        if let (Some(pipe), true) = (&self.input, is_sending) {
            fds.push(PollFd::new(pipe, PollFlags::OUT));
            roles.push(0);
        }
        if let Some(pipe) = &self.output {
            fds.push(PollFd::new(pipe, PollFlags::IN));
            roles.push(1);
        }
        if let Some(pipe) = &self.errors {
            fds.push(PollFd::new(pipe, PollFlags::IN));
            roles.push(2);
        }
        let time = Timespec {
            tv_sec: left.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: left.subsec_nanos().into(),
        };
        let mut ready = Ready::default();
        // An interrupted wait is tried again by the caller, who looks at the clock.
        if poll(&mut fds, Some(&time)).is_err() {
            return ready;
        }
        for (fd, role) in fds.iter().zip(roles) {
            let is_ready = !fd.revents().is_empty();
            match role {
                0 => ready.input = is_ready,
                1 => ready.output = is_ready,
                _ => ready.errors = is_ready,
            }
        }
        ready
    }

    /// Writes what the pipe takes. A program that no longer reads is seen when its output ends.
    fn send(&mut self, rest: &[u8]) -> usize {
        let Some(pipe) = &mut self.input else { return 0 };
        match pipe.write(rest) {
            Ok(count) => count,
            Err(error) if is_passing(&error) => 0,
            Err(_) => {
                self.input = None;
                0
            }
        }
    }

    /// Reads what is there, up to `most` bytes in the inbox. Returns whether the output has ended.
    fn receive(&mut self, most: usize) -> bool {
        let Some(pipe) = &mut self.output else { return true };
        let mut piece = [0; 1 << 14];
        while self.inbox.len() < most {
            let room = piece.len().min(most - self.inbox.len());
            match pipe.read(&mut piece[..room]) {
                Ok(0) => return true,
                Ok(count) => self.inbox.extend_from_slice(&piece[..count]),
                Err(error) if is_passing(&error) => return false,
                Err(_) => return true,
            }
        }
        false
    }

    /// Passes its standard error on to the user, and keeps the end of it.
    fn listen(&mut self) {
        let Some(pipe) = &mut self.errors else { return };
        let mut piece = [0; 1 << 12];
        // A program that writes without end is heard again at the next look.
        for _ in 0..16 {
            let count = match pipe.read(&mut piece) {
                Ok(0) => {
                    self.errors = None;
                    return;
                }
                Ok(count) => count,
                Err(error) if is_passing(&error) => return,
                Err(_) => {
                    self.errors = None;
                    return;
                }
            };
            let heard = &piece[..count];
            let room = MOST_STDERR.saturating_sub(self.passed_on).min(count);
            if room > 0 {
                // If the user cannot be told, nothing else is lost.
                let _ = std::io::stderr().lock().write_all(&heard[..room]);
                self.passed_on += room;
            }
            for &byte in heard {
                if self.last_words.len() == LAST_WORDS {
                    self.last_words.pop_front();
                }
                self.last_words.push_back(byte);
            }
        }
    }

    fn last_words(&self) -> String {
        let bytes: Vec<u8> = self.last_words.iter().copied().collect();
        let text = String::from_utf8_lossy(&bytes);
        let line = text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default();
        shown(line.as_bytes(), 200)
    }

    /// What became of a program whose output has ended.
    fn end(&mut self, when: &str) -> String {
        let begun = Instant::now();
        let status = loop {
            self.listen();
            match self.child.try_wait() {
                Ok(Some(status)) => break Some(status),
                Ok(None) if begun.elapsed() < FAREWELL => std::thread::sleep(LOOK),
                _ => break None,
            }
        };
        match status {
            Some(status) => format!("ended {when} {}", in_words(status)),
            None => format!("closed its standard output {when}"),
        }
    }

    /// Kills the whole group and waits for the program.
    fn kill(&mut self) {
        self.input = None;
        if let Some(group) = group(&self.child) {
            // Before it is waited for: its number may then be given to another.
            let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
            running.retain(|other| *other != group);
            // The group may be gone already.
            let _ = kill_process_group(group, Signal::KILL);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.output = None;
    }
}

impl Drop for Process {
    /// Closes its input, which asks it to end, and kills it if it does not.
    fn drop(&mut self) {
        self.input = None;
        self.output = None;
        let begun = Instant::now();
        while begun.elapsed() < FAREWELL {
            self.listen();
            match self.child.try_wait() {
                Ok(None) => std::thread::sleep(LOOK),
                _ => break,
            }
        }
        self.kill();
    }
}

/// The group that a program was started in.
fn group(child: &Child) -> Option<Pid> {
    i32::try_from(child.id()).ok().and_then(Pid::from_raw)
}

/// Whether a pipe only has to be tried again.
fn is_passing(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn in_words(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("with exit code {code}"),
        (None, Some(signal)) => format!("by signal {signal}"),
        (None, None) => "for an unknown reason".to_owned(),
    }
}

fn refusal(command: &str, file: &str, error: &std::io::Error) -> String {
    let advice = match error.kind() {
        ErrorKind::NotFound if file.contains('/') => {
            "expected the path of a program whose first line, if it is a script, names an \
             interpreter that is installed"
        }
        ErrorKind::NotFound => "expected a program in PATH, or a path such as `./mine.py`",
        ErrorKind::PermissionDenied => {
            "make the file executable, or name its interpreter: `program:python3 mine.py`"
        }
        _ => "expected a program that this machine can start",
    };
    format!("program `{command}` cannot be started ({error}); {advice}")
}
