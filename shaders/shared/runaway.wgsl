// Tells bounded states from those that have run away.

override RUNAWAY_BOUND: f32;

// Whether |x| + |y| has reached the bound or is no number. The bit patterns of positive floats are in the order of
// their values, with infinity and NaN above all: compilers may assume that there is no NaN, but not of integers.
fn has_run_away(x: Real, y: Real) -> Mask {
    return bitcast<Word>(abs(x) + abs(y)) >= Word(bitcast<u32>(RUNAWAY_BOUND));
}
