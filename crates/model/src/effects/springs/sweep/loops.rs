//! Vectors to arrays of coordinates and back.

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
