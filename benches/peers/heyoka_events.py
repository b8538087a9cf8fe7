"""heyoka: adaptive Taylor series, in batches, with events at the boundaries of the friction layer.

Between v = -eps0, 0 and eps0 the friction is one polynomial, eps F(v) = a0 + a1 v + a2 v^2 + eps
beta v^3, whose coefficients are parameters of the system. A terminal event at each boundary ends
the step there and changes them. The tolerance is the loosest power of ten at which the exponents
are about as exact as those of the project's default scheme (median error 1e-7 in f64, 3e-7 in
f32): the program prints their error, so that this can be checked.
"""

import heyoka
import numpy as np

import work

# eps F by piece, from v < -eps0 to v > eps0: a0, a1, a2
_OUTER, _INNER = work.EPS * work.F0, 2 * work.EPS * work.F0 / work.EPS0
_LINEAR = -work.EPS * work.ALPHA
PIECES = np.array(
    [
        (-_OUTER, _LINEAR, 0),
        (0, _INNER + _LINEAR, _OUTER / work.EPS0**2),
        (0, _INNER + _LINEAR, -_OUTER / work.EPS0**2),
        (_OUTER, _LINEAR, 0),
    ]
)
BOUNDARIES = (-work.EPS0, 0.0, work.EPS0)

TOLERANCES = {"f64": 1e-6, "f32": 1e-5}

# the error of the exponent is measured over this many periods, from the initial state on
ERROR_PERIODS = 20


def equations(with_tangent):
    """The right-hand sides, and v; parameters are zeta_k, h1, a0, a1, a2."""
    x, y, u, w = heyoka.make_vars("x", "y", "u", "w")
    zeta_k, h1, a0, a1, a2 = (heyoka.par[i] for i in range(5))
    cubic = work.EPS * work.BETA
    v = work.OMEGA_K + zeta_k * heyoka.sin(work.OMEGA_0 * heyoka.time) - y
    friction = a0 + v * (a1 + v * (a2 + cubic * v))
    slope = a1 + v * (2 * a2 + 3 * cubic * v)
    square = work.B * x**2
    system = [(x, y), (y, x * (1 - square) + friction - work.EPS * h1 * y)]
    if with_tangent:
        system += [(u, w), (w, (1 - 3 * square) * u - (slope + work.EPS * h1) * w)]
    return system, v


class Integrator:
    """One batch of instances, of the motion alone or with its tangent."""

    def __init__(self, precision, tolerance, with_tangent):
        self.number = np.float64 if precision == "f64" else np.float32
        self.pieces = PIECES.astype(self.number)
        self.lanes = heyoka.recommended_simd_size(self.number)
        system, v = equations(with_tangent)
        self.integrator = heyoka.taylor_adaptive_batch(
            system,
            np.zeros((len(system), self.lanes), self.number),
            pars=np.zeros((5, self.lanes), self.number),
            tol=self.number(tolerance),
            fp_type=self.number,
            t_events=[
                heyoka.t_event_batch(v - at, fp_type=self.number, callback=self._crossing(below))
                for below, at in enumerate(BOUNDARIES)
            ],
        )
        self.state = self.integrator.state
        self.parameters = self.integrator.pars
        # a0, a1, a2 of each lane: views
        self.lane_parameters = list(self.parameters[2:].T)

    def _crossing(self, below):
        """What happens at the boundary above the piece `below`."""

        lower, upper = self.pieces[below], self.pieces[below + 1]

        def callback(_integrator, direction, lane):
            self.lane_parameters[lane][:] = upper if direction > 0 else lower
            return True

        return callback

    def load(self, zeta_k, h1, x, y):
        self.parameters[0], self.parameters[1] = zeta_k, h1
        self.state[0], self.state[1] = x, y
        self.state[2:] = np.array([[1], [0]])[: len(self.state) - 2]
        # v at the beginning of a period
        piece = np.searchsorted(BOUNDARIES, work.OMEGA_K - self.state[1])
        self.parameters[2:] = self.pieces[piece].T
        self.integrator.reset_cooldowns()

    def period(self):
        self.integrator.set_time(self.number(0))
        self.integrator.propagate_until(self.number(work.PERIOD))

    def renormalise(self):
        """The logarithm of the tangent vector's length, which becomes 1."""
        norm = np.hypot(self.state[2], self.state[3])
        self.state[2:] /= norm
        return np.log(norm)


class Events:
    """Both integrators of one number type, compiled."""

    def __init__(self, precision, tolerance):
        self.alone = Integrator(precision, tolerance, False)
        self.tangent = Integrator(precision, tolerance, True)

    def run(self, zeta_k, h1, alone, periods):
        """The time of either phase, and the exponents."""
        lanes, count = self.alone.lanes, zeta_k.size
        fill = (0, -count % lanes)
        zeta_k, h1 = (np.pad(values, fill, mode="edge") for values in (zeta_k, h1))
        growth = np.zeros(zeta_k.size)
        first, second = work.Stopwatch(), work.Stopwatch()
        for start in range(0, zeta_k.size, lanes):
            part = slice(start, start + lanes)
            with first:
                self.alone.load(zeta_k[part], h1[part], *work.START)
                for _ in range(alone):
                    self.alone.period()
            with second:
                self.tangent.load(zeta_k[part], h1[part], *self.alone.state)
                for _ in range(periods):
                    self.tangent.period()
                    growth[part] += self.tangent.renormalise()
        times = (
            first.ns(zeta_k.size, alone) if alone else 0.0,
            second.ns(zeta_k.size, periods),
        )
        return times, growth[:count] / (periods * work.PERIOD)


def reference(zeta_k, h1):
    """Exponents over the first periods, at a tolerance that leaves no error to speak of."""
    return Events("f64", 1e-15).run(zeta_k, h1, 0, ERROR_PERIODS)[1]


def main():
    parser = work.arguments(__doc__.splitlines()[0], rounds=3, instances=128)
    parser.add_argument(
        "--periods", type=int, default=20, help="periods of each phase that a round times"
    )
    parser.add_argument("--tolerance", type=float, help=f"of a step; by default {TOLERANCES}")
    options = parser.parse_args()
    work.pin(options.core)
    tolerance = options.tolerance or TOLERANCES[options.precision]
    events = Events(options.precision, tolerance)
    part = work.grid_part(options.instances)
    timings = [
        events.run(*part, options.periods, options.periods)[0] for _ in range(options.rounds)
    ]
    alone, tangent = zip(*timings)

    def errors():
        return np.abs(events.run(*part, 0, ERROR_PERIODS)[1] - reference(*part))

    _, exponents = events.run(*work.points(), work.PERIODS_ALONE, work.PERIODS_TANGENT)
    work.report(
        "heyoka with events",
        options,
        alone,
        tangent,
        exponents,
        ("heyoka", "numpy"),
        instances=part[0].size,
        tolerance=tolerance,
        **work.error_quantiles(errors),
    )


if __name__ == "__main__":
    main()
