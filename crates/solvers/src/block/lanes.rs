//! Blocks times vectors in registers of four numbers: the three coordinates, and one that does not
//! count.
//!
//! Each number has the order of operations of `block * vector`, so the bits are the same.

use crate::{Mat3, Vec3};
use drape_kernels::lanes::Four;

/// The columns of a block.
#[inline(always)]
fn columns<F: Four>(four: F, block: &Mat3) -> [F::Numbers; 3] {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = block.data.0;
    // Three numbers and the one that follows them in memory are one read.
    [four.load([xx, yx, zx, xy]), four.load([xy, yy, zy, xz]), four.load([xz, yz, zz, 0.0])]
}

/// `block · x`.
#[inline(always)]
pub(crate) fn times<F: Four>(four: F, block: &Mat3, x: &Vec3) -> F::Numbers {
    let [a, b, c] = columns(four, block);
    let two = four.add(four.mul(a, four.splat(x.x)), four.mul(b, four.splat(x.y)));
    four.add(two, four.mul(c, four.splat(x.z)))
}

/// `sum + block · x`, added column by column.
#[inline(always)]
pub(crate) fn add_times<F: Four>(four: F, sum: F::Numbers, block: &Mat3, x: &Vec3) -> F::Numbers {
    let [a, b, c] = columns(four, block);
    let sum = four.add(sum, four.mul(a, four.splat(x.x)));
    let sum = four.add(sum, four.mul(b, four.splat(x.y)));
    four.add(sum, four.mul(c, four.splat(x.z)))
}

/// A vector from a register.
#[inline(always)]
pub(crate) fn vector<F: Four>(four: F, numbers: F::Numbers) -> Vec3 {
    let [x, y, z, _] = four.store(numbers);
    Vec3::new(x, y, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use drape_kernels::lanes::{four_wide, vectorised};
    use drape_kernels::testing::{Random, assert_same_bits};

    #[test]
    fn registers_give_the_bits_of_the_products_of_blocks() {
        let mut random = Random::new(5);
        for _ in 0..100 {
            let numbers = random.vectors(5);
            let block = Mat3::from_columns(&numbers[..3]);
            let (x, start) = (numbers[3], numbers[4]);
            let found = vectorised!(four_wide(), [four,
                block: &'k Mat3 = &block, x: Vec3 = x, start: Vec3 = start,
            ] -> [Vec3; 2] {
                let sum = four.load([start.x, start.y, start.z, 0.0]);
                [
                    vector(four, times(four, block, &x)),
                    vector(four, add_times(four, sum, block, &x)),
                ]
            });
            let mut sum = start;
            for column in 0..3 {
                sum += block.column(column) * x[column];
            }
            assert_same_bits("product", &[block * x, sum], &found);
        }
    }
}
