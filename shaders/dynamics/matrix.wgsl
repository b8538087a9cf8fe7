// Functions of matrices of order three, for the three nodes of a collocation step, that are not built into WGSL.
// Twin: src/dynamics/matrix.rs.

// The inverse by cofactors. It is exact enough: the matrices here are near the identity, or dominated by damping.
fn inverse(m: mat3x3<f32>) -> mat3x3<f32> {
    let first = cross(m[1], m[2]);
    let rows = mat3x3(first, cross(m[2], m[0]), cross(m[0], m[1]));
    return transpose(rows) * (1.0 / dot(m[0], first));
}
