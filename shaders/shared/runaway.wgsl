// Distinguishes bounded states from those that have run away.

override RUNAWAY_BOUND: f32;

// Whether |x| + |y| has reached the bound or is no number. Compilers may assume that no float is NaN, but they cannot assume this
// of integers. Therefore the bit patterns are compared: those of positive floats are in the order of their values, with infinity
// and NaN above all.
fn has_run_away(x: Real, y: Real) -> Mask {
    return bitcast<Word>(abs(x) + abs(y)) >= Word(bitcast<u32>(RUNAWAY_BOUND));
}
