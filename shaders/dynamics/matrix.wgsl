// Matrices of order three, for the three nodes of a collocation step: what WGSL does not have built in.
// Twin: src/dynamics/matrix.rs.

// The inverse by cofactors: the matrices here are near the identity, or dominated by what damps.
fn inverse(m: mat3x3<f32>) -> mat3x3<f32> {
    let first = cross(m[1], m[2]);
    let rows = mat3x3(first, cross(m[2], m[0]), cross(m[0], m[1]));
    return transpose(rows) * (1.0 / dot(m[0], first));
}
