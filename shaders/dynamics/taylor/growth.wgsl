// The growth of tangent vectors over a forcing period. Twin: src/dynamics/taylor/growth.rs.

// A tangent vector within a forcing period, and the logarithm of all divisors of its length so far.
struct Carried {
    vector: Vector,
    log_length: Real,
}

// The second vector, the area that both have spanned since the period began, and the logarithm of all divisors of the area.
struct Area {
    second: Vector,
    product: Real,
    log_product: Real,
}

// A vector, and the area that it spans with the second.
struct Settled {
    carried: Carried,
    area: Area,
}

// The first vector at length 1, and the logarithm of its growth.
struct Closed {
    vector: Vector,
    growth: Real,
}

fn is_comfortable(value: Real) -> Mask {
    return (Real(1.0 / COMFORTABLE) < value) & (value < Real(COMFORTABLE));
}

// The divisor of a length, or of an area, that is far from 1. It is 1 for other values, for 0 and for no number, and in lanes
// that do not go on.
fn divisor(value: Real, goes_on: Mask) -> Real {
    let is_number = (Real(0.0) < value) & (value < Real(LARGEST_LENGTH));
    return select(Real(1.0), value, is_number & goes_on & !is_comfortable(value));
}

fn carried_new(vector: Vector) -> Carried {
    return Carried(vector, Real(0.0));
}

// Brings the vector to a length of about 1 if its length is far from 1. The area that it spans stays the same.
fn carried_settle(carried: Carried, area: Area, goes_on: Mask) -> Settled {
    let length = divisor(abs(carried.vector.x) + abs(carried.vector.y), goes_on);
    if (!is_any(length != Real(1.0))) {
        return Settled(carried, area);
    }
    let second = Vector(area.second.x * length, area.second.y * length);
    return Settled(carried_divide(carried, length), Area(second, area.product, area.log_product));
}

fn carried_divide(carried: Carried, length: Real) -> Carried {
    let inverse = 1.0 / length;
    let vector = Vector(carried.vector.x * inverse, carried.vector.y * inverse);
    return Carried(vector, carried.log_length + log(length));
}

// Ends the period: the vector at length 1 in units of tau, and the logarithm of its growth. Within the period, the speed of a
// vector is in the scheme's unit of time, of which `inverse_unit` is the inverse.
fn carried_close(carried: Carried, inverse_unit: Real) -> Closed {
    let x = carried.vector.x;
    let y = carried.vector.y * inverse_unit;
    // a vector of length 0 stays a vector of length 0; an overflow remains visible
    let measured = fma(x, x, y * y);
    let square = select(measured, Real(SMALLEST_SQUARE), measured < Real(SMALLEST_SQUARE));
    let inverse = 1.0 / sqrt(square);
    return Closed(Vector(x * inverse, y * inverse), fma(Real(0.5), log(square), carried.log_length));
}

// Begins a period: the second vector spans the area 1 with the first.
fn area_new(first: Vector) -> Area {
    return Area(across(first), Real(1.0), Real(0.0));
}

// Replaces the second vector; the area that the old one spans goes into the product.
fn renew(area: Area, first: Vector, goes_on: Mask) -> Area {
    let product = area.product * spanned(first, area.second);
    let by = divisor(product, goes_on);
    return Area(across(first), product / by, area.log_product + log(by));
}

// The logarithm of the ratio of the area that the vectors span at the period's end to that at its beginning.
fn area_close(area: Area, first: Vector) -> Real {
    let measured = area.product * spanned(first, area.second);
    return area.log_product + log(select(measured, Real(SMALLEST_SQUARE), measured < Real(SMALLEST_SQUARE)));
}

// The area that two vectors span.
fn spanned(first: Vector, second: Vector) -> Real {
    return fma(first.x, second.y, -(first.y * second.x));
}

// The vector perpendicular to the first that spans the area 1 with it.
fn across(first: Vector) -> Vector {
    let measured = fma(first.x, first.x, first.y * first.y);
    let inverse = 1.0 / select(measured, Real(SMALLEST_SQUARE), measured < Real(SMALLEST_SQUARE));
    return Vector(-(first.y * inverse), first.x * inverse);
}
