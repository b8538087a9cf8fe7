// The growth of tangent vectors over a forcing period. Twin: src/dynamics/taylor/growth.rs.

// The second vector, and the area that both have spanned since the period began.
struct Area {
    second: Vector,
    product: Real,
}

// The first vector at length 1, and the logarithms of both vectors' growth.
struct Closed {
    vector: Vector,
    growth: Growth,
}

// The first vector at length 1, and the logarithm of its growth.
struct ClosedFirst {
    vector: Vector,
    growth: Real,
}

// With a second vector that spans the area 1 with the first.
fn area_new(first: Vector) -> Area {
    return Area(across(first), Real(1.0));
}

// Replaces the second vector; the area that it had spanned goes into the product.
fn renew(area: Area, first: Vector) -> Area {
    return Area(across(first), area.product * spanned(first, area.second));
}

// Ends the period. Vectors have speeds in units of time, whose inverse is given.
fn close(area: Area, first: Vector, inverse_unit: Real) -> Closed {
    let measured = area.product * spanned(first, area.second);
    let product = select(measured, Real(SMALLEST_SQUARE), measured < Real(SMALLEST_SQUARE));
    let closed = close_first(first, inverse_unit);
    return Closed(closed.vector, Growth(closed.growth, log(product) - closed.growth));
}

// The first vector at length 1 at the end of a period, and the logarithm of its growth.
fn close_first(first: Vector, inverse_unit: Real) -> ClosedFirst {
    let y = first.y * inverse_unit;
    // what has shrunk below the smallest number is taken as that small; what has overflowed shows
    let measured = fma(first.x, first.x, y * y);
    let square = select(measured, Real(SMALLEST_SQUARE), measured < Real(SMALLEST_SQUARE));
    let inverse = 1.0 / sqrt(square);
    return ClosedFirst(Vector(first.x * inverse, y * inverse), 0.5 * log(square));
}

// The area that two vectors span.
fn spanned(first: Vector, second: Vector) -> Real {
    return fma(first.x, second.y, -(first.y * second.x));
}

// The vector across the first that spans the area 1 with it.
fn across(first: Vector) -> Vector {
    let measured = fma(first.x, first.x, first.y * first.y);
    let inverse = 1.0 / select(measured, Real(SMALLEST_SQUARE), measured < Real(SMALLEST_SQUARE));
    return Vector(-(first.y * inverse), first.x * inverse);
}
