"""The paper's scheme in numba, tuned: what a good programmer gets out of it.

RK4 at 628 steps a period. What makes it fast:

- Instances go by blocks, and the innermost loop runs over the instances of a block, so that the
  compiler makes vectors of them. Their state lies in one array at constant distances: there are no
  pointers to be told apart at run time.
- The drive comes from one table for all instances, where most programs call a sine.
- The friction has no branch: with c = v clamped to [-eps0, eps0], s(v) = c (2/eps0 - |c|/eps0^2).
- x by Nystrom's form of the scheme, the damping folded into the friction's linear term, and what
  the motion and the tangent share computed once: with p = 1 - x^2 (b = 1), q = 2/eps0 - |c|/eps0^2
  and r = beta v^2 + ..., 1 - 3 x^2 = 3 p - 2 and F' is linear in q and r.
- The chain of operations that wait for each other is short from stage to stage: v is formed from
  the force before in one operation.
- The tangent vector is renormalised every 157 steps, by a product; one logarithm a period.
- With AVX-512 the compiler is told to keep two vectors in flight in the motion alone.
"""

import numba
import numpy as np
from llvmlite import binding

import work

# instances of a block; its state stays in the nearest cache
LANES = {"f64": 64, "f32": 128}

# steps between renormalisations; divides STEPS
RENORMALISE = 157

# vectors in flight in the loop over a block's instances; 0 leaves the choice to the compiler. Two
# make the motion alone a tenth faster with AVX-512 and its 32 registers, and a tenth slower with
# AVX2 and its 16; with the tangent they never pay.
INTERLEAVE_ALONE = 2 if binding.get_host_cpu_features().get("avx512f") else 0
INTERLEAVE_TANGENT = 0


def compile_kernels(precision, lanes=None):
    """(alone, tangent, lanes): the two phases, which advance whole blocks of instances."""
    number = np.float64 if precision == "f64" else np.float32
    lanes = lanes or LANES[precision]
    steps, renormalise = work.STEPS, RENORMALISE
    assert work.B == 1 and steps % renormalise == 0

    h = work.PERIOD / steps
    half, full = number(h / 2), number(h)
    square_4, square_2, square_6 = number(h * h / 4), number(h * h / 2), number(h * h / 6)
    sixth = number(h / 6)
    one, two, three = number(1), number(2), number(3)
    layer = number(work.EPS0)
    omega_k = number(work.OMEGA_K)
    # eps f0 s(v) = c (q0 - q1 |c|)
    q0 = number(work.EPS * work.F0 * 2 / work.EPS0)
    q1 = number(work.EPS * work.F0 / work.EPS0**2)
    # eps (beta v^3 - alpha v), the linear term less the damping's
    cubic, linear = number(work.EPS * work.BETA), number(-work.EPS * work.ALPHA)

    # where a block keeps what
    X, Y, ZETA, DAMPING, U, W = (i * lanes for i in range(6))

    fast = {"nnan", "ninf", "nsz", "contract", "arcp"}
    kind = numba.from_dtype(np.dtype(number))
    blocks, values = kind[:, ::1], kind[::1]

    @numba.njit(inline="always", fastmath=fast)
    def force(x, v, damping, damped_drive):
        """y', and its parts p, q, r, which the tangent needs."""
        c = min(max(v, -layer), layer)
        p = one - x * x
        q = q0 - q1 * abs(c)
        r = cubic * (v * v) + (linear + damping)
        return c * q + (v * r + (x * p - damped_drive)), p, q, r

    @numba.njit(inline="always", fastmath=fast)
    def slope(u, w, p, q, r, rest):
        """The tangent's w', from the parts of the force and what else is in -eps F' - eps h1."""
        return u * (three * p - two) - w * (three * r + (two * q + rest))

    binding.set_option("numba", f"-force-vector-interleave={INTERLEAVE_ALONE}")

    @numba.njit((blocks, values, numba.int64), fastmath=fast, error_model="numpy")
    def alone(state, table, periods):
        for block in range(state.shape[0]):
            s = state[block]
            for _ in range(periods):
                for k in range(steps):
                    sin_0, sin_1, sin_2 = table[2 * k], table[2 * k + 1], table[2 * k + 2]
                    for j in range(lanes):
                        x, y, zeta, damping = s[X + j], s[Y + j], s[ZETA + j], s[DAMPING + j]
                        d0 = omega_k + zeta * sin_0
                        d1 = omega_k + zeta * sin_1
                        d2 = omega_k + zeta * sin_2
                        e1 = damping * d1
                        x_half, x_full, d1_y = x + half * y, x + full * y, d1 - y
                        k1, _p, _q, _r = force(x, d0 - y, damping, damping * d0)
                        k2, _p, _q, _r = force(x_half, d1_y - half * k1, damping, e1)
                        x3 = x_half + square_4 * k1
                        k3, _p, _q, _r = force(x3, d1_y - half * k2, damping, e1)
                        x4 = x_full + square_2 * k2
                        k4, _p, _q, _r = force(x4, (d2 - y) - full * k3, damping, damping * d2)
                        middle = k2 + k3
                        s[X + j] = x_full + square_6 * (k1 + middle)
                        s[Y + j] = y + sixth * ((k1 + middle) + (k4 + middle))

    binding.set_option("numba", f"-force-vector-interleave={INTERLEAVE_TANGENT}")

    @numba.njit(
        (blocks, values, numba.int64, numba.float64[::1]), fastmath=fast, error_model="numpy"
    )
    def tangent(state, table, periods, growth):
        for block in range(state.shape[0]):
            s = state[block]
            product = np.ones(lanes)
            for _ in range(periods):
                for part in range(steps // renormalise):
                    for k in range(part * renormalise, (part + 1) * renormalise):
                        sin_0, sin_1, sin_2 = table[2 * k], table[2 * k + 1], table[2 * k + 2]
                        for j in range(lanes):
                            x, y, zeta, damping = s[X + j], s[Y + j], s[ZETA + j], s[DAMPING + j]
                            u, w = s[U + j], s[W + j]
                            # 3 r holds the linear term and the damping three times, F' once
                            rest = -(q0 + two * (linear + damping))
                            d0 = omega_k + zeta * sin_0
                            d1 = omega_k + zeta * sin_1
                            d2 = omega_k + zeta * sin_2
                            e1 = damping * d1
                            x_half, x_full, d1_y = x + half * y, x + full * y, d1 - y
                            u_half, u_full = u + half * w, u + full * w
                            k1, p, q, r = force(x, d0 - y, damping, damping * d0)
                            g1 = slope(u, w, p, q, r, rest)
                            k2, p, q, r = force(x_half, d1_y - half * k1, damping, e1)
                            g2 = slope(u_half, w + half * g1, p, q, r, rest)
                            x3 = x_half + square_4 * k1
                            k3, p, q, r = force(x3, d1_y - half * k2, damping, e1)
                            u3 = u_half + square_4 * g1
                            g3 = slope(u3, w + half * g2, p, q, r, rest)
                            x4 = x_full + square_2 * k2
                            k4, p, q, r = force(x4, (d2 - y) - full * k3, damping, damping * d2)
                            u4 = u_full + square_2 * g2
                            g4 = slope(u4, w + full * g3, p, q, r, rest)
                            middle, g_middle = k2 + k3, g2 + g3
                            s[X + j] = x_full + square_6 * (k1 + middle)
                            s[Y + j] = y + sixth * ((k1 + middle) + (k4 + middle))
                            s[U + j] = u_full + square_6 * (g1 + g_middle)
                            s[W + j] = w + sixth * ((g1 + g_middle) + (g4 + g_middle))
                    for j in range(lanes):
                        norm = np.sqrt(s[U + j] * s[U + j] + s[W + j] * s[W + j])
                        product[j] *= norm
                        s[U + j] /= norm
                        s[W + j] /= norm
                for j in range(lanes):
                    growth[block * lanes + j] += np.log(product[j])
                    product[j] = 1.0

    return alone, tangent, lanes


class Tuned:
    """The kernels of one number type, compiled, and instances for them."""

    def __init__(self, precision, lanes=None):
        self.alone, self.tangent, self.lanes = compile_kernels(precision, lanes)
        self.number = np.float64 if precision == "f64" else np.float32
        self.table = work.drive_table().astype(self.number)

    def load(self, zeta_k, h1):
        """The instances at their initial states, by blocks; the last block is filled up."""
        blocks = -(-zeta_k.size // self.lanes)
        fill = (0, blocks * self.lanes - zeta_k.size)
        state = np.empty((blocks, 6, self.lanes), self.number)
        state[:, 0], state[:, 1] = work.START
        state[:, 2] = np.pad(zeta_k, fill, mode="edge").reshape(blocks, -1)
        state[:, 3] = np.pad(h1 * work.EPS, fill, mode="edge").reshape(blocks, -1)
        state[:, 4], state[:, 5] = 1, 0
        return state.reshape(blocks, -1)

    def exponents(self, zeta_k, h1, alone=work.PERIODS_ALONE, periods=work.PERIODS_TANGENT):
        state = self.load(zeta_k, h1)
        growth = np.zeros(state.shape[0] * self.lanes)
        self.alone(state, self.table, alone)
        self.tangent(state, self.table, periods, growth)
        return growth[: zeta_k.size] / (periods * work.PERIOD)

    def time(self, periods, **clock):
        """ns for one forcing period of one instance: of the motion alone, and with the tangent."""
        zeta_k, h1 = work.grid()
        state = self.load(zeta_k, h1)
        growth = np.zeros(zeta_k.size)
        with work.Stopwatch(**clock) as alone:
            self.alone(state, self.table, periods)
        with work.Stopwatch(**clock) as tangent:
            self.tangent(state, self.table, periods, growth)
        return alone.ns(zeta_k.size, periods), tangent.ns(zeta_k.size, periods)


def main():
    parser = work.arguments(__doc__.splitlines()[0], rounds=5)
    parser.add_argument(
        "--periods", type=int, default=50, help="periods of each phase that a round times"
    )
    parser.add_argument("--lanes", type=int, help="instances of a block")
    options = parser.parse_args()
    work.pin(options.core)
    tuned = Tuned(options.precision, options.lanes)
    timings = [tuned.time(options.periods) for _ in range(options.rounds)]
    alone, tangent = zip(*timings)
    exponents = tuned.exponents(*work.points())
    work.report("numba tuned", options, alone, tangent, exponents, ("numba", "numpy"))


if __name__ == "__main__":
    main()
