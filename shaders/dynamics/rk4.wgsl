// The classical Runge-Kutta scheme of order 4 with a fixed step, written for x'' = f in Nystrom's form.
// Twin: src/dynamics/rk4.rs.

// Angle and angular speed of the bush.
struct State {
    x: Real,
    y: Real,
}

// Multiples of the step size h that the scheme uses.
struct StepSize {
    half: Real,
    quarter_square: Real,
    whole: Real,
    half_square: Real,
    sixth_square: Real,
    sixth: Real,
}

// Shaft speed at the start, the middle and the end of a step.
struct StageSpeeds {
    start: Real,
    middle: Real,
    end: Real,
}

struct StepWithTangent {
    state: State,
    bases: Bases,
    // The divergence integrated over the step.
    divergence: Real,
}

fn step_size_new(h: Real) -> StepSize {
    return StepSize(h / 2.0, h * h / 4.0, h, h * h / 2.0, h * h / 6.0, h / 6.0);
}

// Angle at the second stage, or a vector's x component there.
fn x2(h: StepSize, x: Real, y: Real) -> Real {
    return fma(y, h.half, x);
}

fn x3(h: StepSize, x2: Real, k1: Real) -> Real {
    return fma(k1, h.quarter_square, x2);
}

fn x4(h: StepSize, x: Real, y: Real, k2: Real) -> Real {
    return fma(k2, h.half_square, fma(y, h.whole, x));
}

fn x_end(h: StepSize, x: Real, y: Real, k1: Real, k2: Real, k3: Real) -> Real {
    return fma(k1 + k2 + k3, h.sixth_square, fma(y, h.whole, x));
}

// Simpson's weights: h (k1 + 2 k2 + 2 k3 + k4)/6 added to y.
fn y_end(h: StepSize, y: Real, k1: Real, k2: Real, k3: Real, k4: Real) -> Real {
    return fma(fma(Real(2.0), k2 + k3, k1 + k4), h.sixth, y);
}

// The shaft speeds less the speed of the bush at the start of the step.
fn less(speed: StageSpeeds, y: Real) -> StageSpeeds {
    return StageSpeeds(speed.start - y, speed.middle - y, speed.end - y);
}

// One step of the motion.
fn rk4_step(motion: Motion, h: StepSize, speed: StageSpeeds, state: State) -> State {
    let x = state.x;
    let y = state.y;
    let v = less(speed, y);
    let k1 = acceleration(motion, x, v.start, speed.start);
    let at_2 = x2(h, x, y);
    let k2 = acceleration(motion, at_2, fma(k1, -h.half, v.middle), speed.middle);
    let k3 = acceleration(motion, x3(h, at_2, k1), fma(k2, -h.half, v.middle), speed.middle);
    let k4 = acceleration(motion, x4(h, x, y, k2), fma(k3, -h.whole, v.end), speed.end);
    return State(x_end(h, x, y, k1, k2, k3), y_end(h, y, k1, k2, k3, k4));
}

// One step of the motion and of the tangent vectors (3.3) along it.
fn step_with_tangent(motion: Motion, h: StepSize, speed: StageSpeeds, state: State, bases: Bases) -> StepWithTangent {
    let x = state.x;
    let y = state.y;
    let first = bases.first;
    let second = bases.second;

    // every stage is used as soon as it is known, so that few values have to be held in registers
    let v = less(speed, y);
    let f1 = linearised(motion, x, v.start, speed.start);
    let a1 = rate(first, f1);
    let b1 = rate(second, f1);
    let at_2 = x2(h, x, y);
    let first_2 = Vector(x2(h, first.x, first.y), fma(a1, h.half, first.y));
    let second_2 = Vector(x2(h, second.x, second.y), fma(b1, h.half, second.y));

    let f2 = linearised(motion, at_2, fma(f1.acceleration, -h.half, v.middle), speed.middle);
    let a2 = rate(first_2, f2);
    let b2 = rate(second_2, f2);
    let at_3 = x3(h, at_2, f1.acceleration);
    let first_3 = Vector(x3(h, first_2.x, a1), fma(a2, h.half, first.y));
    let second_3 = Vector(x3(h, second_2.x, b1), fma(b2, h.half, second.y));

    let f3 = linearised(motion, at_3, fma(f2.acceleration, -h.half, v.middle), speed.middle);
    let a3 = rate(first_3, f3);
    let b3 = rate(second_3, f3);
    let at_4 = x4(h, x, y, f2.acceleration);
    let first_4 = Vector(x4(h, first.x, first.y, a2), fma(a3, h.whole, first.y));
    let second_4 = Vector(x4(h, second.x, second.y, b2), fma(b3, h.whole, second.y));

    let f4 = linearised(motion, at_4, fma(f3.acceleration, -h.whole, v.end), speed.end);
    let a4 = rate(first_4, f4);
    let b4 = rate(second_4, f4);
    let k1 = f1.acceleration;
    let k2 = f2.acceleration;
    let k3 = f3.acceleration;
    return StepWithTangent(
        State(x_end(h, x, y, k1, k2, k3), y_end(h, y, k1, k2, k3, f4.acceleration)),
        Bases(
            Vector(x_end(h, first.x, first.y, a1, a2, a3), y_end(h, first.y, a1, a2, a3, a4)),
            Vector(x_end(h, second.x, second.y, b1, b2, b3), y_end(h, second.y, b1, b2, b3, b4)),
        ),
        y_end(h, Real(0.0), f1.by_y, f2.by_y, f3.by_y, f4.by_y),
    );
}
