//! The lines of the protocol `drape-method/1`.

use drape_integrator::StepReport;
use drape_solvers::SolveStatus;
use serde::Deserialize;

/// Name of the protocol.
pub(crate) const PROTOCOL: &str = "drape-method/1";

/// The first request.
pub(crate) const HELLO: &[u8] = b"{\"do\":\"hello\",\"protocol\":\"drape-method/1\"}\n";
/// Forget what you remember of former steps.
pub(crate) const RESTART: &[u8] = b"{\"do\":\"restart\"}\n";

/// The answer to the first request.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hello {
    pub(crate) protocol: String,
    pub(crate) name: String,
    #[serde(default)]
    pub(crate) source: String,
    #[serde(default)]
    pub(crate) theory: String,
    pub(crate) order: u32,
    pub(crate) class: String,
    #[serde(default)]
    pub(crate) conserves: Vec<String>,
    pub(crate) implicit: bool,
    pub(crate) supports: Vec<String>,
}

/// The answer to any other request.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Answer {
    #[serde(default)]
    pub(crate) ok: bool,
    #[serde(default)]
    pub(crate) error: Option<String>,
    #[serde(default)]
    pub(crate) bytes: Option<u64>,
    #[serde(default)]
    force_evaluations: Option<u32>,
    #[serde(default)]
    newton_iterations: u32,
    #[serde(default)]
    cg_iterations: u32,
    #[serde(default)]
    matvecs: u32,
    #[serde(default)]
    factorisations: u32,
    #[serde(default)]
    substeps: Option<u32>,
    #[serde(default)]
    converged: Option<bool>,
}

/// Reads the answer to the first request.
pub(crate) fn read_hello(line: &[u8]) -> Result<Hello, String> {
    serde_json::from_slice(line)
        .map_err(|error| format!("answered `hello` with `{}`: {error}", shown(line, 80)))
}

impl Answer {
    /// Reads an answer that says `ok`, or announces so many `bytes`. `when` says in messages to
    /// which request.
    pub(crate) fn read(line: &[u8], when: &str, bytes: usize) -> Result<Self, String> {
        let answer: Self = serde_json::from_slice(line).map_err(|error| {
            format!(
                "answered {when} with `{}`, which is no answer in JSON ({error}); what is printed \
                 for people belongs on standard error",
                shown(line, 80)
            )
        })?;
        match (&answer.error, answer.bytes) {
            (Some(error), _) => {
                Err(format!("reported an error {when}: {}", shown(error.as_bytes(), 300)))
            }
            (None, Some(found)) if found == bytes as u64 && bytes > 0 => Ok(answer),
            (None, Some(found)) => Err(format!("announced {found} bytes {when}; expected {bytes}")),
            (None, None) if bytes > 0 => {
                Err(format!("announced no `bytes` {when}; expected {bytes}"))
            }
            (None, None) if !answer.ok => Err(format!("answered {when} without `\"ok\":true`")),
            (None, None) => Ok(answer),
        }
    }

    /// The costs that the program states. A step that states no force evaluation counts as one.
    pub(crate) fn report(&self) -> StepReport {
        let is_solved = self.converged != Some(false);
        StepReport {
            force_evaluations: self.force_evaluations.unwrap_or(1),
            newton_iterations: self.newton_iterations,
            cg_iterations: self.cg_iterations,
            matvecs: self.matvecs,
            factorisations: self.factorisations,
            substeps: self.substeps.unwrap_or(1),
            solve: if is_solved { SolveStatus::Converged } else { SolveStatus::IterationLimit },
            ..StepReport::default()
        }
    }
}

/// Reads a line that a program wrote, as the answer to `hello` (`bytes` is `None`), or as the
/// answer to another request that announces `bytes` bytes. It is meant for tools that try broken
/// messages.
///
/// # Errors
/// The sentence with which drape would end the program.
pub fn try_line(line: &[u8], bytes: Option<usize>) -> Result<(), String> {
    match bytes {
        None => read_hello(line)?.description().map(|_| ()),
        Some(bytes) => Answer::read(line, "in a step", bytes).map(|answer| {
            let _ = answer.report();
        }),
    }
}

/// Text of a program in one line that a terminal can show: at most `most` characters.
pub(crate) fn shown(bytes: &[u8], most: usize) -> String {
    let text = String::from_utf8_lossy(bytes);
    let mut shown: String =
        text.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).take(most).collect();
    if text.trim().chars().count() > most {
        shown.push('…');
    }
    shown
}
