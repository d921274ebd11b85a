//! The loops of a sweep: the same few operations for every element of slices that have one length and do not overlap,
//! which is what a compiler turns into vector instructions. It believes that slices do not overlap where they are
//! arguments of their own; hence the long lists.

use super::super::diagonals::Diagonal;
use super::{COLLAPSED, Law};

/// Coordinates of both ends of a row of springs.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a> {
    pub(super) near: [&'a [f64]; 3],
    pub(super) far: [&'a [f64]; 3],
}

/// `f = g (x − x2)` for a row of springs.
#[inline(always)]
pub(super) fn spring_forces(
    d: &Diagonal,
    law: impl Fn(f64, f64) -> f64,
    present: &[u8],
    Ends { near: [x, y, z], far: [x2, y2, z2] }: Ends<'_>,
    [fx, fy, fz]: [&mut [f64]; 3],
) {
    forces(d, law, present, x, y, z, x2, y2, z2, fx, fy, fz);
}

/// [`spring_forces`], and on the side [`take`].
#[inline(always)]
pub(super) fn spring_forces_and_take(
    d: &Diagonal,
    present: &[u8],
    Ends { near: [x, y, z], far: [x2, y2, z2] }: Ends<'_>,
    [fx, fy, fz]: [&mut [f64]; 3],
    sum: &mut [f64],
    [a, b, c, e]: [&[f64]; 4],
) {
    forces_and_four(d, present, x, y, z, x2, y2, z2, fx, fy, fz, sum, a, b, c, e);
}

/// [`spring_forces`], and on the side [`take_twice`].
#[inline(always)]
pub(super) fn spring_forces_and_take_twice(
    d: &Diagonal,
    present: &[u8],
    Ends { near: [x, y, z], far: [x2, y2, z2] }: Ends<'_>,
    [fx, fy, fz]: [&mut [f64]; 3],
    sum: &mut [f64],
    [a, b, c, e]: [&[f64]; 4],
    [a2, b2, c2, e2]: [&[f64]; 4],
) {
    forces_and_eight(d, present, x, y, z, x2, y2, z2, fx, fy, fz, sum, a, b, c, e, a2, b2, c2, e2);
}

/// Two incoming and two own springs: `sum + a + b − c − e`.
#[inline(always)]
pub(super) fn take(sum: &mut [f64], [a, b, c, e]: [&[f64]; 4]) {
    four(sum, a, b, c, e);
}

/// As [`take`], with force and damping.
#[inline(always)]
pub(super) fn take_twice(sum: &mut [f64], [a, b, c, e]: [&[f64]; 4], more: [&[f64]; 4]) {
    let [a2, b2, c2, e2] = more;
    eight(sum, a, b, c, e, a2, b2, c2, e2);
}

/// `f = w (x − x2)` where a spring is, else 0.
#[inline(always)]
pub(super) fn weighted_differences(
    w: f64,
    present: &[u8],
    Ends { near: [x, y, z], far: [x2, y2, z2] }: Ends<'_>,
    [fx, fy, fz]: [&mut [f64]; 3],
) {
    differences(w, present, x, y, z, x2, y2, z2, fx, fy, fz);
}

/// `sum += a m`.
#[inline(always)]
pub(super) fn add_scaled(sum: &mut [f64], m: &[f64], a: f64) {
    sum.iter_mut().zip(m).for_each(|(sum, m)| *sum += a * m);
}

#[inline(always)]
pub(super) fn take_from(sum: &mut [f64], a: &[f64]) {
    sum.iter_mut().zip(a).for_each(|(sum, a)| *sum += a);
}

#[inline(always)]
pub(super) fn give(sum: &mut [f64], a: &[f64]) {
    sum.iter_mut().zip(a).for_each(|(sum, a)| *sum -= a);
}

/// Vectors of `m` particles into one array a coordinate, `stride` apart.
#[inline(always)]
pub(in super::super) fn split(planes: &mut [f64], stride: usize, m: usize, from: &[f64]) {
    let (x, rest) = planes.split_at_mut(stride);
    let (y, z) = rest.split_at_mut(stride);
    split_three(&mut x[..m], &mut y[..m], &mut z[..m], &from[..3 * m]);
}

#[inline(always)]
fn split_three(x: &mut [f64], y: &mut [f64], z: &mut [f64], from: &[f64]) {
    for (((x, y), z), from) in x.iter_mut().zip(y).zip(z).zip(from.as_chunks::<3>().0) {
        (*x, *y, *z) = (from[0], from[1], from[2]);
    }
}

/// The inverse of [`split`].
#[inline(always)]
pub(in super::super) fn join(planes: &[f64], stride: usize, m: usize, to: &mut [f64]) {
    join_three(&planes[..m], &planes[stride..][..m], &planes[2 * stride..][..m], &mut to[..3 * m]);
}

#[inline(always)]
fn join_three(x: &[f64], y: &[f64], z: &[f64], to: &mut [f64]) {
    for (((x, y), z), to) in x.iter().zip(y).zip(z).zip(to.as_chunks_mut::<3>().0) {
        *to = [*x, *y, *z];
    }
}

/// `g` of one spring, 0 where there is none.
#[inline(always)]
fn factor(
    d: &Diagonal,
    law: impl Fn(f64, f64) -> f64,
    present: u8,
    dx: f64,
    dy: f64,
    dz: f64,
) -> f64 {
    let length = (dx * dx + dy * dy + dz * dz).sqrt();
    let is_long = length > COLLAPSED * d.rest_length;
    law(f64::from(present) * d.stiffness, if is_long { d.rest_length / length } else { 0.0 })
}

/// A sum with two incoming and two own springs.
#[inline(always)]
fn taken(sum: f64, a: f64, b: f64, c: f64, e: f64) -> f64 {
    sum + a + b - c - e
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "slices of their own are known not to overlap")]
fn differences(
    w: f64,
    present: &[u8],
    x: &[f64],
    y: &[f64],
    z: &[f64],
    x2: &[f64],
    y2: &[f64],
    z2: &[f64],
    fx: &mut [f64],
    fy: &mut [f64],
    fz: &mut [f64],
) {
    let m = present.len();
    let (x, y, z) = (&x[..m], &y[..m], &z[..m]);
    let (x2, y2, z2) = (&x2[..m], &y2[..m], &z2[..m]);
    let (fx, fy, fz) = (&mut fx[..m], &mut fy[..m], &mut fz[..m]);
    for t in 0..m {
        let w = f64::from(present[t]) * w;
        fx[t] = (x[t] - x2[t]) * w;
        fy[t] = (y[t] - y2[t]) * w;
        fz[t] = (z[t] - z2[t]) * w;
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "slices of their own are known not to overlap")]
fn forces(
    d: &Diagonal,
    law: impl Fn(f64, f64) -> f64,
    present: &[u8],
    x: &[f64],
    y: &[f64],
    z: &[f64],
    x2: &[f64],
    y2: &[f64],
    z2: &[f64],
    fx: &mut [f64],
    fy: &mut [f64],
    fz: &mut [f64],
) {
    let m = present.len();
    let (x, y, z) = (&x[..m], &y[..m], &z[..m]);
    let (x2, y2, z2) = (&x2[..m], &y2[..m], &z2[..m]);
    let (fx, fy, fz) = (&mut fx[..m], &mut fy[..m], &mut fz[..m]);
    for t in 0..m {
        let (dx, dy, dz) = (x[t] - x2[t], y[t] - y2[t], z[t] - z2[t]);
        let g = factor(d, &law, present[t], dx, dy, dz);
        (fx[t], fy[t], fz[t]) = (dx * g, dy * g, dz * g);
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "slices of their own are known not to overlap")]
fn forces_and_four(
    d: &Diagonal,
    present: &[u8],
    x: &[f64],
    y: &[f64],
    z: &[f64],
    x2: &[f64],
    y2: &[f64],
    z2: &[f64],
    fx: &mut [f64],
    fy: &mut [f64],
    fz: &mut [f64],
    sum: &mut [f64],
    a: &[f64],
    b: &[f64],
    c: &[f64],
    e: &[f64],
) {
    let m = present.len();
    let (x, y, z) = (&x[..m], &y[..m], &z[..m]);
    let (x2, y2, z2) = (&x2[..m], &y2[..m], &z2[..m]);
    let (fx, fy, fz) = (&mut fx[..m], &mut fy[..m], &mut fz[..m]);
    let sum = &mut sum[..m];
    let (a, b, c, e) = (&a[..m], &b[..m], &c[..m], &e[..m]);
    for t in 0..m {
        let (dx, dy, dz) = (x[t] - x2[t], y[t] - y2[t], z[t] - z2[t]);
        let g = factor(d, |k, q| Law::Spring.stiffness(k, q), present[t], dx, dy, dz);
        (fx[t], fy[t], fz[t]) = (dx * g, dy * g, dz * g);
        sum[t] = taken(sum[t], a[t], b[t], c[t], e[t]);
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "slices of their own are known not to overlap")]
fn forces_and_eight(
    d: &Diagonal,
    present: &[u8],
    x: &[f64],
    y: &[f64],
    z: &[f64],
    x2: &[f64],
    y2: &[f64],
    z2: &[f64],
    fx: &mut [f64],
    fy: &mut [f64],
    fz: &mut [f64],
    sum: &mut [f64],
    a: &[f64],
    b: &[f64],
    c: &[f64],
    e: &[f64],
    a2: &[f64],
    b2: &[f64],
    c2: &[f64],
    e2: &[f64],
) {
    let m = present.len();
    let (x, y, z) = (&x[..m], &y[..m], &z[..m]);
    let (x2, y2, z2) = (&x2[..m], &y2[..m], &z2[..m]);
    let (fx, fy, fz) = (&mut fx[..m], &mut fy[..m], &mut fz[..m]);
    let sum = &mut sum[..m];
    let (a, b, c, e) = (&a[..m], &b[..m], &c[..m], &e[..m]);
    let (a2, b2, c2, e2) = (&a2[..m], &b2[..m], &c2[..m], &e2[..m]);
    for t in 0..m {
        let (dx, dy, dz) = (x[t] - x2[t], y[t] - y2[t], z[t] - z2[t]);
        let g = factor(d, |k, q| Law::Spring.stiffness(k, q), present[t], dx, dy, dz);
        (fx[t], fy[t], fz[t]) = (dx * g, dy * g, dz * g);
        sum[t] = taken(taken(sum[t], a[t], b[t], c[t], e[t]), a2[t], b2[t], c2[t], e2[t]);
    }
}

#[inline(always)]
fn four(sum: &mut [f64], a: &[f64], b: &[f64], c: &[f64], e: &[f64]) {
    let m = sum.len();
    let (a, b, c, e) = (&a[..m], &b[..m], &c[..m], &e[..m]);
    for t in 0..m {
        sum[t] = taken(sum[t], a[t], b[t], c[t], e[t]);
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "slices of their own are known not to overlap")]
fn eight(
    sum: &mut [f64],
    a: &[f64],
    b: &[f64],
    c: &[f64],
    e: &[f64],
    a2: &[f64],
    b2: &[f64],
    c2: &[f64],
    e2: &[f64],
) {
    let m = sum.len();
    let (a, b, c, e) = (&a[..m], &b[..m], &c[..m], &e[..m]);
    let (a2, b2, c2, e2) = (&a2[..m], &b2[..m], &c2[..m], &e2[..m]);
    for t in 0..m {
        sum[t] = taken(taken(sum[t], a[t], b[t], c[t], e[t]), a2[t], b2[t], c2[t], e2[t]);
    }
}
