//! Vectors and matrices of order three over lanes, for the three nodes of a collocation step.
//!
//! Owns their products and inverse, no more; nalgebra works on its own scalar types, not on lanes. Twin: WGSL's built-in
//! `mat3x3`.

use crate::lanes::Real;

/// The values of an expression at the three nodes; it contains the index of the node. A macro, because a closure might not be
/// compiled for the caller's instruction set.
macro_rules! at_nodes {
    ($node:ident => $value:expr) => {
        [
            {
                let $node = 0usize;
                $value
            },
            {
                let $node = 1usize;
                $value
            },
            {
                let $node = 2usize;
                $value
            },
        ]
    };
}
pub(crate) use at_nodes;

pub type Vector<R> = [R; 3];
/// Rows.
pub type Matrix<R> = [[R; 3]; 3];

#[inline(always)]
pub fn dot<R: Real>(a: Vector<R>, b: Vector<R>) -> R {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

#[inline(always)]
pub fn apply<R: Real>(a: &Matrix<R>, b: Vector<R>) -> Vector<R> {
    [dot(a[0], b), dot(a[1], b), dot(a[2], b)]
}

#[inline(always)]
pub fn product<R: Real>(a: &Matrix<R>, b: &Matrix<R>) -> Matrix<R> {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = dot(a[i], [b[0][j], b[1][j], b[2][j]]);
        }
    }
    out
}

/// a d - b c.
#[inline(always)]
fn cofactor<R: Real>(a: R, b: R, c: R, d: R) -> R {
    a.mul_add(d, -(b * c))
}

/// The inverse by cofactors. This is accurate enough here: the matrices are near the identity, or dominated by damping.
#[inline(always)]
pub fn inverse<R: Real>(m: &Matrix<R>) -> Matrix<R> {
    let first = [
        cofactor(m[1][1], m[1][2], m[2][1], m[2][2]),
        cofactor(m[1][2], m[1][0], m[2][2], m[2][0]),
        cofactor(m[1][0], m[1][1], m[2][0], m[2][1]),
    ];
    let scale = R::splat(1.0) / dot(m[0], first);
    [
        [
            first[0] * scale,
            cofactor(m[0][2], m[0][1], m[2][2], m[2][1]) * scale,
            cofactor(m[0][1], m[0][2], m[1][1], m[1][2]) * scale,
        ],
        [
            first[1] * scale,
            cofactor(m[0][0], m[0][2], m[2][0], m[2][2]) * scale,
            cofactor(m[0][2], m[0][0], m[1][2], m[1][0]) * scale,
        ],
        [
            first[2] * scale,
            cofactor(m[0][1], m[0][0], m[2][1], m[2][0]) * scale,
            cofactor(m[0][0], m[0][1], m[1][0], m[1][1]) * scale,
        ],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_the_identity() {
        let m = [[3.0, -1.0, 0.5], [0.25, 2.0, -0.75], [1.5, 0.3, 4.0]];
        let identity = product(&m, &inverse(&m));
        for (i, row) in identity.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
