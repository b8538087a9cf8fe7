// Tangent vectors of the (x, y) block, their orthonormalisation and growth, equations (3.5) and (3.6).
// Twin: src/dynamics/tangent.rs.

// Smallest squared norm, in the range of normal numbers.
override SMALLEST_SQUARE: f32;

// A tangent vector (X, Y), with Z = 0.
struct Vector {
    x: Real,
    y: Real,
}

// The two tangent vectors that are carried along.
struct Bases {
    first: Vector,
    second: Vector,
}

// Logarithms of the two vectors' growth.
struct Growth {
    first: Real,
    second: Real,
}

struct Normalised {
    vector: Vector,
    norm: Real,
}

struct Orthonormalised {
    bases: Bases,
    growth: Growth,
}

// A vector of length 1, and the one perpendicular to it.
fn bases_along(first: Vector) -> Bases {
    return Bases(first, Vector(-first.y, first.x));
}

// Orthonormalises by Gram and Schmidt (3.5); the growth is the norms' logarithms, the summands of (3.6).
fn orthonormalise(bases: Bases) -> Orthonormalised {
    let first = normalised(bases.first);
    let along = fma(bases.second.x, first.vector.x, bases.second.y * first.vector.y);
    let rest = Vector(
        bases.second.x - along * first.vector.x,
        bases.second.y - along * first.vector.y,
    );
    let second = normalised(rest);
    return Orthonormalised(
        Bases(first.vector, second.vector),
        Growth(log(first.norm), log(second.norm)),
    );
}

// Y', the second row of (3.3); X' is Y.
fn rate(vector: Vector, motion: Linearised) -> Real {
    return fma(vector.x, motion.by_x, motion.by_y * vector.y);
}

fn normalised(vector: Vector) -> Normalised {
    // a vector that is shorter than the smallest number has lost its direction: its length is taken as the smallest number. A
    // vector that has overflowed stays NaN or infinite, so that the overflow remains visible
    let measured = fma(vector.x, vector.x, vector.y * vector.y);
    let square = select(measured, Real(SMALLEST_SQUARE), measured < Real(SMALLEST_SQUARE));
    let norm = sqrt(square);
    let inverse = 1.0 / norm;
    return Normalised(Vector(vector.x * inverse, vector.y * inverse), norm);
}
