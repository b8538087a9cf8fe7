"""The paper's scheme in numba as most people write it.

RK4 at 628 steps a period, one instance after the other, the equations as they stand in the paper:
sines in every step, branches in the friction, the tangent vector renormalised after each step.
"""

import math

import numba
import numpy as np

import work


def compile_kernel(precision):
    """The function that integrates instances, with the tangent or without."""
    number = np.float64 if precision == "f64" else np.float32
    steps = work.STEPS
    h = number(work.PERIOD / steps)
    zero, half, one, two, three, six = (number(value) for value in (0, 0.5, 1, 2, 3, 6))
    f0, alpha, beta = number(work.F0), number(work.ALPHA), number(work.BETA)
    omega_0, omega_k = number(work.OMEGA_0), number(work.OMEGA_K)
    b, eps, eps0 = number(work.B), number(work.EPS), number(work.EPS0)

    @numba.njit(fastmath=True)
    def friction(v):
        if abs(v) > eps0:
            s = np.sign(v)
        else:
            s = (two - abs(v) / eps0) * v / eps0
        return f0 * s - alpha * v + beta * v**3

    @numba.njit(fastmath=True)
    def friction_slope(v):
        if abs(v) > eps0:
            s = zero
        else:
            s = two / eps0 * (one - abs(v) / eps0)
        return f0 * s - alpha + three * beta * v**2

    @numba.njit(fastmath=True)
    def shaft(tau, zeta_k):
        return omega_k + zeta_k * math.sin(omega_0 * tau)

    @numba.njit(fastmath=True)
    def motion(speed, x, y, h1):
        return y, x - b * x**3 + eps * friction(speed - y) - eps * h1 * y

    @numba.njit(fastmath=True)
    def variation(speed, x, y, u, w, h1):
        slope = friction_slope(speed - y)
        return w, (one - three * b * x**2) * u - (eps * slope + eps * h1) * w

    @numba.njit(fastmath=True)
    def integrate(zeta_ks, h1s, xs, ys, periods, with_tangent, growths):
        for i in range(zeta_ks.size):
            zeta_k, h1, x, y = zeta_ks[i], h1s[i], xs[i], ys[i]
            u, w, growth = one, zero, 0.0
            for _ in range(periods):
                for k in range(steps):
                    tau = number(k) * h
                    start = shaft(tau, zeta_k)
                    middle = shaft(tau + half * h, zeta_k)
                    end = shaft(tau + h, zeta_k)
                    a1, b1 = motion(start, x, y, h1)
                    x2, y2 = x + half * h * a1, y + half * h * b1
                    a2, b2 = motion(middle, x2, y2, h1)
                    x3, y3 = x + half * h * a2, y + half * h * b2
                    a3, b3 = motion(middle, x3, y3, h1)
                    x4, y4 = x + h * a3, y + h * b3
                    a4, b4 = motion(end, x4, y4, h1)
                    if with_tangent:
                        c1, d1 = variation(start, x, y, u, w, h1)
                        u2, w2 = u + half * h * c1, w + half * h * d1
                        c2, d2 = variation(middle, x2, y2, u2, w2, h1)
                        u3, w3 = u + half * h * c2, w + half * h * d2
                        c3, d3 = variation(middle, x3, y3, u3, w3, h1)
                        u4, w4 = u + h * c3, w + h * d3
                        c4, d4 = variation(end, x4, y4, u4, w4, h1)
                        u += h / six * (c1 + two * c2 + two * c3 + c4)
                        w += h / six * (d1 + two * d2 + two * d3 + d4)
                        norm = math.sqrt(u * u + w * w)
                        growth += math.log(norm)
                        u /= norm
                        w /= norm
                    x += h / six * (a1 + two * a2 + two * a3 + a4)
                    y += h / six * (b1 + two * b2 + two * b3 + b4)
            xs[i], ys[i], growths[i] = x, y, growth

    return integrate


class Plain:
    """The kernel of one number type, compiled, and instances for it."""

    def __init__(self, precision):
        self.number = np.float64 if precision == "f64" else np.float32
        self.integrate = compile_kernel(precision)
        self.run(np.ones(1), np.ones(1), 1, 1)

    def run(self, zeta_k, h1, alone, periods):
        """The time of either phase, and the exponents."""
        zeta_k, h1 = zeta_k.astype(self.number), h1.astype(self.number)
        x, y = (np.full(zeta_k.size, value, self.number) for value in work.START)
        growth = np.zeros(zeta_k.size)
        with work.Stopwatch() as first:
            self.integrate(zeta_k, h1, x, y, alone, False, growth)
        with work.Stopwatch() as second:
            self.integrate(zeta_k, h1, x, y, periods, True, growth)
        times = first.ns(zeta_k.size, alone), second.ns(zeta_k.size, periods)
        return times, growth / (periods * work.PERIOD)


def main():
    parser = work.arguments(__doc__.splitlines()[0], rounds=5, instances=256)
    parser.add_argument(
        "--periods", type=int, default=25, help="periods of each phase that a round times"
    )
    options = parser.parse_args()
    work.pin(options.core)
    plain = Plain(options.precision)
    part = work.grid_part(options.instances)
    timings = [plain.run(*part, options.periods, options.periods)[0] for _ in range(options.rounds)]
    alone, tangent = zip(*timings)
    _, exponents = plain.run(*work.points(), work.PERIODS_ALONE, work.PERIODS_TANGENT)
    work.report(
        "numba plain",
        options,
        alone,
        tangent,
        exponents,
        ("numba", "numpy"),
        instances=part[0].size,
    )


if __name__ == "__main__":
    main()
