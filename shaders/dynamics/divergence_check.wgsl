// The check of the exponents' sum against the mean divergence, in some of the measured periods.
// Twin: src/dynamics/divergence_check.rs.

override CHECKED_EVERY: f32;
// Whether this kernel advances through checked periods, with both tangent vectors.
override IS_CHECKED: bool;

// Growth over a period with one tangent vector: that of the second is the divergence less that of the first.
fn growth_of_first(first: Real, divergence: Real) -> Growth {
    return Growth(first, divergence - first);
}

// Growth over a checked period. The defect is the growth of both vectors less the divergence; it counts for all periods up to the
// next checked one.
fn checked_growth(both: Growth, divergence: Real) -> Growth {
    let defect = both.first + both.second - divergence;
    return Growth(both.first, fma(Real(CHECKED_EVERY), defect, divergence - both.first));
}
