// Comparisons of numbers that are not negative; NaN fails them. Compilers may assume that no float is NaN, but they cannot assume
// this of integers. Therefore the bit patterns are compared: those of such floats are in the order of their values, with infinity
// and NaN above all.

fn is_below(a: f32, b: f32) -> bool {
    return bitcast<u32>(a) < bitcast<u32>(b);
}

fn are_below(a: vec3<f32>, b: vec3<f32>) -> vec3<bool> {
    return bitcast<vec3<u32>>(a) < bitcast<vec3<u32>>(b);
}
