//! Sheets that share nothing but the machine.

use crate::{METHOD, WARM_UP, turn};
use drape_benches::{Mesh, Prepared};
use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::Barrier;

/// One sheet a thread, together of about as many particles as one of `side × side`.
pub(crate) fn sheets(side: u32, threads: NonZero<usize>) -> Vec<Prepared> {
    let part = (f64::from(side) / (threads.get() as f64).sqrt()).round() as u32;
    (0..threads.get()).map(|_| Prepared::on_sheet(part, Mesh::Grid, METHOD, WARM_UP)).collect()
}

/// Particles that all sheets together step in a millisecond while each is at work on a thread of
/// its own.
pub(crate) fn particles_per_ms(sheets: &mut [Prepared], steps: u32) -> f64 {
    let start = Barrier::new(sheets.len());
    let rates = std::thread::scope(|scope| {
        let each = sheets.iter_mut().map(|sheet| {
            scope.spawn(|| {
                start.wait();
                let particles = sheet.system.len() as f64;
                particles / turn(sheet, steps).step
            })
        });
        let each: Vec<_> = each.collect();
        each.into_iter()
            .map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
            .collect::<Vec<_>>()
    });
    rates.iter().sum()
}
