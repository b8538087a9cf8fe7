// The exponents' sum against the mean divergence, in some of the measured periods. Twin: src/dynamics/divergence_check.rs.

override CHECKED_EVERY: f32;
// Whether this kernel goes through a checked period, with both tangent vectors.
override IS_CHECKED: bool;

// Growth over a period with one tangent vector: the second one's is what the divergence leaves to it.
fn growth_of_first(first: Real, divergence: Real) -> Growth {
    return Growth(first, divergence - first);
}

// Growth over a checked period: by how much that of both misses the divergence counts for all periods up to the next such
// one.
fn checked_growth(both: Growth, divergence: Real) -> Growth {
    let defect = both.first + both.second - divergence;
    return Growth(both.first, fma(Real(CHECKED_EVERY), defect, divergence - both.first));
}
