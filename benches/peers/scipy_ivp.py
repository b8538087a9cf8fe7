"""scipy's solve_ivp, by the best of its methods, at a few points only.

The equations are those of the paper, friction branches included, in plain floats; the tangent
vector is renormalised once a period. Of all methods LSODA reaches any error of the exponents in
the shortest time (`--survey` tries them), and the tolerance is the loosest power of ten at which
their median error is that of the project's default scheme, about 1e-7. With `--tolerance 1e-5` it
is that of RK4 at 628 steps.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

import work

METHOD, TOLERANCE = "LSODA", 1e-7

METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)


def friction(v):
    """F(v) and F'(v)."""
    if abs(v) > work.EPS0:
        s, slope = math.copysign(1.0, v), 0.0
    else:
        part = abs(v) / work.EPS0
        s, slope = (2 - part) * v / work.EPS0, 2 / work.EPS0 * (1 - part)
    square = v * v
    return (
        work.F0 * s + v * (work.BETA * square - work.ALPHA),
        work.F0 * slope - work.ALPHA + 3 * work.BETA * square,
    )


def motion(tau, state, zeta_k, h1):
    x, y = state.tolist()
    force, _ = friction(work.OMEGA_K + zeta_k * math.sin(work.OMEGA_0 * tau) - y)
    return y, x - work.B * x**3 + work.EPS * (force - h1 * y)


def motion_and_tangent(tau, state, zeta_k, h1):
    x, y, u, w = state.tolist()
    force, slope = friction(work.OMEGA_K + zeta_k * math.sin(work.OMEGA_0 * tau) - y)
    return (
        y,
        x - work.B * x**3 + work.EPS * (force - h1 * y),
        w,
        (1 - 3 * work.B * x * x) * u - work.EPS * (slope + h1) * w,
    )


def run(zeta_k, h1, alone, periods, method, tolerance):
    """The time of either phase, and the exponents."""

    def end(rhs, state, span, point):
        solution = solve_ivp(
            rhs, (0, span), state, method, (span,), args=point, rtol=tolerance, atol=tolerance
        )
        return solution.y[:, -1]

    first, second = work.Stopwatch(), work.Stopwatch()
    exponents = []
    for point in zip(zeta_k.tolist(), h1.tolist()):
        state = np.array(work.START)
        with first:
            if alone:
                state = end(motion, state, alone * work.PERIOD, point)
        state, growth = np.append(state, (1.0, 0.0)), 0.0
        with second:
            for _ in range(periods):
                state = end(motion_and_tangent, state, work.PERIOD, point)
                norm = math.hypot(*state[2:])
                growth += math.log(norm)
                state[2:] /= norm
        exponents.append(growth / (periods * work.PERIOD))
    times = first.ns(zeta_k.size, max(alone, 1)), second.ns(zeta_k.size, periods)
    return times, np.array(exponents)


def errors(part, method, tolerance):
    """Errors of the exponents over the first periods; needs heyoka."""
    from heyoka_events import ERROR_PERIODS, reference

    return np.abs(run(*part, 0, ERROR_PERIODS, method, tolerance)[1] - reference(*part))


def survey(part, periods):
    """Prints time and error of every method by its tolerance."""
    print("| method | tolerance | ns, mean of both phases | error: median | 90 % |")
    print("| --- | --- | --- | --- | --- |")
    for method in METHODS:
        for tolerance in TOLERANCES:
            times, _ = run(*part, periods, periods, method, tolerance)
            median, most = np.quantile(errors(part, method, tolerance), (0.5, 0.9))
            print(
                f"| {method} | {tolerance:g} | {sum(times) / 2:.0f} | {median:.0e} | {most:.0e} |"
            )


def main():
    parser = work.arguments(__doc__.splitlines()[0], rounds=3, instances=16, precision=False)
    parser.add_argument(
        "--periods", type=int, default=10, help="periods of each phase that a round times"
    )
    parser.add_argument("--method", choices=METHODS, default=METHOD, help="of solve_ivp")
    parser.add_argument("--tolerance", type=float, default=TOLERANCE, help="relative and absolute")
    parser.add_argument(
        "--survey", action="store_true", help="time all methods instead, by tolerance; minutes"
    )
    options = parser.parse_args()
    work.pin(options.core)
    part = work.grid_part(options.instances)
    if options.survey:
        survey(part, options.periods)
        return
    how = options.method, options.tolerance
    timings = [run(*part, options.periods, options.periods, *how)[0] for _ in range(options.rounds)]
    alone, tangent = zip(*timings)
    _, exponents = run(*work.points(), work.PERIODS_ALONE, work.PERIODS_TANGENT, *how)
    work.report(
        f"scipy solve_ivp {options.method}",
        options,
        alone,
        tangent,
        exponents,
        ("scipy", "numpy"),
        instances=part[0].size,
        tolerance=options.tolerance,
        **work.error_quantiles(lambda: errors(part, *how)),
    )


if __name__ == "__main__":
    main()
