//! Counts the instructions of the hot kernels with Callgrind. A noisy machine does not change them.
//!
//! Each kernel runs once under `valgrind --tool=callgrind`, which counts only inside [`measured`].
//! The bench compares the counts with `instructions.json` beside this crate's manifest. A count
//! that is higher by more than [`TOLERANCE`] is a regression, and the bench fails. After an
//! intended change, `cargo bench -p drape-benches --bench instructions -- --save` writes the counts
//! anew. The bench shows counts of another compiler, but does not judge them. Valgrind offers the
//! program at most AVX2, so kernels for wider vectors are counted in their AVX2 form. Without
//! valgrind the bench says so and passes.

use drape_benches::{Mesh, Prepared};
use drape_harness::{Source, provenance};
use drape_model::Vec3;
use drape_report::tell;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::hint::black_box;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

/// Relative rise of a count that passes.
const TOLERANCE: f64 = 0.02;
/// Names the kernel for a run under Callgrind.
const KERNEL: &str = "DRAPE_KERNEL";
/// Lets the C library fill and copy memory by vectors. Callgrind counts an instruction for each
/// byte of `rep stosb`, and the compiler alone decides whether a loop becomes a call that uses it.
const VECTORS: &str = "glibc.cpu.x86_rep_stosb_threshold=1000000000:\
                       glibc.cpu.x86_rep_movsb_threshold=1000000000";
const SIDE: u32 = 52;
const STEPS: usize = 5;

/// Where a kernel works.
#[derive(Clone, Copy)]
enum Place {
    /// The hanging sheet with [`SIDE`] particles along an edge.
    Sheet(Mesh),
    /// A bundled scene.
    Scene(&'static str),
}

impl Place {
    fn name(self) -> &'static str {
        match self {
            Self::Sheet(mesh) => mesh.name(),
            Self::Scene(name) => name,
        }
    }
}

const GRID: Place = Place::Sheet(Mesh::Grid);
const GENERAL: Place = Place::Sheet(Mesh::General);
/// A cloth with projected damping, hinges and wind.
const FLAG: Place = Place::Scene("flag");

/// Method, or `forces`, and place.
const KERNELS: [(&str, Place); 26] = [
    ("forces", GRID),
    ("forces", GENERAL),
    ("forces", FLAG),
    ("symplectic-euler", GRID),
    ("baraff-witkin", FLAG),
    ("leapfrog:damping=explicit", GRID),
    ("imex-euler:preconditioner=none", GRID),
    ("imex-euler:preconditioner=jacobi", GRID),
    ("imex-euler:preconditioner=jacobi", GENERAL),
    ("imex-euler", GRID),
    ("imex-euler", GENERAL),
    ("imex-euler:solver=cholesky", GRID),
    ("imex-updated", GRID),
    ("baraff-witkin", GRID),
    ("backward-euler", GRID),
    ("backward-euler", GENERAL),
    ("backward-euler:solver=multigrid", GRID),
    ("backward-euler:residual=1e-3,solver=cholesky", GRID),
    ("bdf2", GRID),
    ("xpbd:substeps=4", GRID),
    ("xpbd:substeps=4", GENERAL),
    ("xpbd:substeps=4,sweep=coloured", GRID),
    ("xpbd-lines", GRID),
    ("xpbd-lines", GENERAL),
    ("vbd:sweeps=4", GRID),
    ("vbd:sweeps=4", FLAG),
];

/// Counts of instructions by kernel, of one compiler.
#[derive(Debug, Serialize, Deserialize)]
struct Counts {
    rustc: String,
    instructions: BTreeMap<String, u64>,
}

fn name((method, place): (&str, Place)) -> String {
    format!("{method}, {}", place.name())
}

/// The counted work: forces once, or a few steps.
#[inline(never)]
fn measured(kernel: &str, prepared: &mut Prepared, out: &mut [Vec3]) {
    if kernel == "forces" {
        let Prepared { system, state, .. } = prepared;
        system.forces(state.level(), out);
    } else {
        (0..STEPS).for_each(|_| prepared.step());
    }
}

/// Runs one kernel, from a cloth that has moved for a few steps.
fn run(kernel: &str, place: Place) {
    let method = if kernel == "forces" { "baraff-witkin" } else { kernel };
    let warm_up = if method == "symplectic-euler" { 0 } else { 5 };
    let mut prepared = match place {
        Place::Sheet(mesh) => Prepared::on_sheet(SIDE, mesh, method, warm_up),
        Place::Scene(scene) => Prepared::new(scene, method, warm_up),
    };
    let mut out = vec![Vec3::zeros(); prepared.system.len()];
    measured(black_box(kernel), black_box(&mut prepared), &mut out);
    black_box((&prepared, &out));
}

/// Runs this program under Callgrind; the count, or why there is none.
fn count(kernel: &str) -> Result<u64, String> {
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    // Its own file, which nobody reads: as root no device may be named to be written.
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let output = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg(format!("--callgrind-out-file={}", folder.path().join("out").display()))
        .args(["--collect-atstart=no", "--toggle-collect=*instructions*measured*"])
        .arg(own)
        .env(KERNEL, kernel)
        .env("RAYON_NUM_THREADS", "1")
        .env("GLIBC_TUNABLES", VECTORS)
        .output()
        .map_err(|error| format!("valgrind: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let collected = said.lines().find_map(|line| line.split_once("Collected :"));
    let counted = collected.and_then(|(_, number)| number.trim().parse().ok());
    counted.filter(|count| output.status.success() && *count > 0).ok_or_else(|| {
        format!("{kernel}: nothing was counted ({}): {}", output.status, said.trim())
    })
}

fn expected() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("instructions.json")
}

fn compare(save: bool) -> Result<bool, String> {
    let rustc = provenance(&Source::default(), BTreeMap::new()).rustc;
    let text = std::fs::read_to_string(expected()).unwrap_or_default();
    let before: Option<Counts> = serde_json::from_str(&text).ok();
    let judged = before.as_ref().filter(|before| before.rustc == rustc);
    if judged.is_none() && !save {
        tell!("instructions: no counts of this compiler ({rustc}): nothing is judged");
    }
    let mut instructions = BTreeMap::new();
    let mut passed = true;
    for kernel in KERNELS.map(name) {
        let counted = count(&kernel)?;
        let known = before.as_ref().and_then(|before| before.instructions.get(&kernel));
        let change = known.map(|known| counted as f64 / *known as f64 - 1.0);
        let verdict = match change {
            None => "new".to_owned(),
            Some(change) if judged.is_some() && change > TOLERANCE => {
                passed = false;
                format!("{:+.2} %: more than before", 100.0 * change)
            }
            Some(change) => format!("{:+.2} %", 100.0 * change),
        };
        tell!("{kernel:<45} {counted:>12} {verdict}");
        instructions.insert(kernel, counted);
    }
    if save {
        let counts = Counts { rustc, instructions };
        let text = serde_json::to_string_pretty(&counts).map_err(|error| error.to_string())?;
        std::fs::write(expected(), text + "\n").map_err(|error| error.to_string())?;
        tell!("wrote {}", expected().display());
    }
    Ok(passed || save)
}

fn main() -> ExitCode {
    if let Ok(kernel) = std::env::var(KERNEL) {
        if let Some((method, place)) = KERNELS.into_iter().find(|entry| name(*entry) == kernel) {
            run(method, place);
        }
        return ExitCode::SUCCESS;
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        tell!("instructions: skipped, since there is no valgrind on this machine");
        return ExitCode::SUCCESS;
    }
    match compare(std::env::args().any(|argument| argument == "--save")) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            tell!(
                "instructions: some kernels need more of them than before; --save if that is meant"
            );
            ExitCode::FAILURE
        }
        Err(error) => {
            tell!("instructions: {error}");
            ExitCode::FAILURE
        }
    }
}
