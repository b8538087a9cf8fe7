// Exponential decay over a step, and the part of a source, a polynomial of time, that is left at its end.
// Twin: src/dynamics/decay.rs.

// Below this z the moments come from their series, above it from a recursion; at it, both are exact to rounding.
const SERIES_BOUND = 0.5;

// e^-z is taken as 0 beyond this.
const LARGEST_DECAY = 40.0;

// A mode of rate z over a step of length 1.
struct Decay {
    // e^-z.
    factor: f32,
    // I_k = Int_0^1 e^{-z(1-s)} s^k ds for k = 0, 1, 2.
    moments: vec3<f32>,
}

// The decay of a mode of rate `z` >= 0 (rate times length of the step), given 1/z as well.
fn decay(z: f32, inverse_z: f32) -> Decay {
    let slow = z < SERIES_BOUND;
    // for a fast mode the series gives e^{-z/64}: the error of the built-in function may be too large for the pressure
    let series = by_series(select(min(z, LARGEST_DECAY) * (1.0 / 64.0), z, slow));
    if (slow) {
        return series;
    }
    return by_recursion(series.factor, inverse_z);
}

// I_2 = sum_n (-z)^n 2!/(n+3)!, then downwards by I_{k-1} = (1 - z I_k)/k, which is stable for small z.
fn by_series(z: f32) -> Decay {
    var second = fma(z, 1.0 / 181440.0, -1.0 / 20160.0);
    second = fma(second, z, 1.0 / 2520.0);
    second = fma(second, z, -1.0 / 360.0);
    second = fma(second, z, 1.0 / 60.0);
    second = fma(second, z, -1.0 / 12.0);
    second = fma(second, z, 1.0 / 3.0);
    let first = (1.0 - z * second) * 0.5;
    let zeroth = 1.0 - z * first;
    return Decay(1.0 - z * zeroth, vec3(zeroth, first, second));
}

// e^-z = (e^{-z/64})^64 and I_0 = (1 - e^-z)/z, then upwards by I_k = (1 - k I_{k-1})/z, which is stable for large z.
fn by_recursion(part: f32, inverse_z: f32) -> Decay {
    var factor = part * part;
    factor *= factor;
    factor *= factor;
    factor *= factor;
    factor *= factor;
    factor *= factor;
    let zeroth = (1.0 - factor) * inverse_z;
    let first = (1.0 - zeroth) * inverse_z;
    return Decay(factor, vec3(zeroth, first, (1.0 - first - first) * inverse_z));
}
