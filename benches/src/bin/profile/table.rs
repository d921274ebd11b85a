//! The table of the profiles.

use crate::{Profile, bound};
use drape_benches::Machine;
use std::fmt::Write as _;

/// Methods so far above their bound have a reason.
const NEAR: f64 = 2.0;

pub(crate) fn text(machine: &Machine, profiles: &[Profile], cpu: &str) -> String {
    let mut text = String::from(HEAD);
    let Machine { root_and_quotient_s, flops_per_s, bytes_per_s } = machine;
    let _ = writeln!(
        text,
        "{cpu}, one thread: a square root and a quotient {:.2} ns, {:.1} Gflop/s, {:.0} GB/s in the second-level cache.\n",
        1e9 * root_and_quotient_s,
        1e-9 * flops_per_s,
        1e-9 * bytes_per_s
    );
    text += COLUMNS;
    for profile in profiles {
        let Profile { method, side, springs, step, shares, counts, .. } = profile;
        let shares: Vec<_> = shares.iter().map(|share| format!("{:.0}", 100.0 * share)).collect();
        let counted = [
            counts.force_evaluations,
            counts.products,
            counts.iterations,
            counts.newton,
            counts.factorisations.max(counts.setups),
        ];
        let counted: Vec<_> = counted.iter().map(|count| format!("{count:.1}")).collect();
        let bound = bound::seconds(machine, profile);
        let _ = writeln!(
            text,
            "| {method} | {side} | {} | {:.1} | {} | {} | {} | {:.1} |",
            microseconds(*step),
            1e9 * step / *springs as f64,
            shares.join(" | "),
            counted.join(" | "),
            microseconds(bound),
            step / bound
        );
    }
    let _ = writeln!(
        text,
        "\n## Why a step is more than twice above its bound\n\nA sweep over the springs takes {}: {}\n",
        sweeps(machine, profiles),
        bound::SPRINGS
    );
    let far = |p: &&Profile| p.step > NEAR * bound::seconds(machine, p);
    let mut named = Vec::new();
    for profile in profiles.iter().filter(far) {
        if !named.contains(&profile.method) {
            named.push(profile.method);
            let reason = bound::reason(profile.method).unwrap_or("no reason is known.");
            let _ = writeln!(text, "* `{}`: {reason}", profile.method);
        }
    }
    text
}

/// What a spring takes in a sweep, on each sheet.
fn sweeps(machine: &Machine, profiles: &[Profile]) -> String {
    let of_forces = profiles.iter().filter(|profile| profile.method == bound::SWEEP);
    let each = of_forces.map(|profile| {
        let spring = profile.step * profile.shares[0] / profile.springs as f64;
        let (ns, times) = (1e9 * spring, spring / machine.root_and_quotient_s);
        format!(
            "{ns:.2} ns a spring on {0} × {0}, {times:.1} times its root and quotient",
            profile.side
        )
    });
    each.collect::<Vec<_>>().join("; ")
}

/// What a step of a method with Newton iterations costs, however its linear systems are solved;
/// `peak` is the memory of the largest sheet, MiB.
pub(crate) fn converged(profiles: &[Profile], peak: Option<u64>) -> String {
    let mut text = String::from(CONVERGED);
    for Profile { method, side, stiffness, step, counts, .. } in profiles {
        let is_like = |p: &&Profile| p.side == *side && p.stiffness == *stiffness;
        let linearised = profiles.iter().find(|p| is_like(p) && p.method == "baraff-witkin");
        let ratio = linearised.map_or(f64::NAN, |linearised| step / linearised.step);
        let _ = writeln!(
            text,
            "| {method} | {side} | {stiffness:.0e} | {} | {ratio:.1} | {:.1} | {:.1} | {:.1} | {:.1} |",
            microseconds(*step),
            counts.newton,
            counts.factorisations,
            counts.iterations,
            counts.force_evaluations,
        );
    }
    if let Some(peak) = peak {
        let _ = writeln!(text, "\nThe program held {peak} MiB at most, with the largest sheet.");
    }
    text
}

const CONVERGED: &str = "\n## A converged step\n\n\
Methods with Newton iterations, h = 0.01 s, on the same sheet: what solves their linear systems. The residual at which a \
step of one method ends is the same for all settings. A step of Baraff-Witkin is linearised and solved less tightly; it is \
the unit of the fifth column.\n\n\
| settings | N | k/m | step, µs | steps of Baraff-Witkin | Newton | factorisations | CG iterations | force evaluations |\n\
|---|---|---|---|---|---|---|---|---|\n";

fn microseconds(seconds: f64) -> String {
    let us = 1e6 * seconds;
    if us < 99.95 { format!("{us:.1}") } else { format!("{us:.0}") }
}

const HEAD: &str = "\
# Where a step spends its time

Every method on the hanging sheet, N × N particles row by row, with tension, shear and bending springs, k/m = 1e4/s², its default settings unless the row has others, \
h = 0.01 s (explicit methods 0.001 s), one thread. Median of up to a hundred steps, the least of all rounds, in which the methods take turns; \
shares of another run with the phase clock on. The bound is \
the least time of the kernels that the step counts, from the speeds below; factorisations, solves with factors and preconditioners \
are not in it. `cargo run --release -p drape-benches --bin profile` makes this page; the docs of its module `bound` count the kernels.

";

const COLUMNS: &str = "\
| method | N | step, µs | ns a spring | forces, % | set-up | solve | contact | update | force sweeps | products | CG iterations | Newton | matrices made | bound, µs | over it |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|
";
