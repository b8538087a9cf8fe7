// Exponential decay over a step, and what it leaves of a source that is a polynomial of time.
// Twin: src/dynamics/decay.rs.

// Below this the moments come from their series, above from recursion; both are good to rounding there.
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

// e^-z for z >= 0. The built-in function may be off by more than the pressure can bear.
fn exponential(z: f32) -> f32 {
    // e^-z = (e^{-z/64})^64, by the series of the inner one
    let x = min(z, LARGEST_DECAY) * (-1.0 / 64.0);
    var sum = fma(x, 1.0 / 7.0, 1.0);
    sum = fma(x * (1.0 / 6.0), sum, 1.0);
    sum = fma(x * (1.0 / 5.0), sum, 1.0);
    sum = fma(x * (1.0 / 4.0), sum, 1.0);
    sum = fma(x * (1.0 / 3.0), sum, 1.0);
    sum = fma(x * (1.0 / 2.0), sum, 1.0);
    sum = fma(x, sum, 1.0);
    sum *= sum;
    sum *= sum;
    sum *= sum;
    sum *= sum;
    sum *= sum;
    sum *= sum;
    return sum;
}

// The decay of a mode of rate `z` >= 0 (rate times length of the step), given 1/z as well.
fn decay(z: f32, inverse_z: f32) -> Decay {
    if (z < SERIES_BOUND) {
        return by_series(z);
    }
    return by_recursion(z, inverse_z);
}

// I_2 = sum_n (-z)^n 2!/(n+3)!, then downwards by I_{k-1} = (1 - z I_k)/k, which is stable for small z.
fn by_series(z: f32) -> Decay {
    var sum = fma(z, -1.0 / 9.0, 1.0);
    sum = fma(z * (-1.0 / 8.0), sum, 1.0);
    sum = fma(z * (-1.0 / 7.0), sum, 1.0);
    sum = fma(z * (-1.0 / 6.0), sum, 1.0);
    sum = fma(z * (-1.0 / 5.0), sum, 1.0);
    sum = fma(z * (-1.0 / 4.0), sum, 1.0);
    let second = sum * (1.0 / 3.0);
    let first = (1.0 - z * second) * 0.5;
    let zeroth = 1.0 - z * first;
    return Decay(1.0 - z * zeroth, vec3(zeroth, first, second));
}

// I_0 = (1 - e^-z)/z, then upwards by I_k = (1 - k I_{k-1})/z, which is stable for large z.
fn by_recursion(z: f32, inverse_z: f32) -> Decay {
    let factor = exponential(z);
    let zeroth = (1.0 - factor) * inverse_z;
    let first = (1.0 - zeroth) * inverse_z;
    return Decay(factor, vec3(zeroth, first, (1.0 - first - first) * inverse_z));
}
