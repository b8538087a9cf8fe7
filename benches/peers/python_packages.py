"""Python packages at the same work: this project's, pynamicalsys and heyoka, point by point.

Each computes the maximal exponent at the points of `work.POINTS`: 300 forcing periods to settle, and 1000 that are
measured, in f64, on one core. This project's `Model.point` measures more besides: both exponents, their errors, the
period, the class. The errors are those against the multipliers of the cycles by heyoka at tolerance 1e-15, at the
regular points. Compilation is left out, and told apart.
"""

import argparse
import json
import os
import statistics
import time

os.environ["RAYON_NUM_THREADS"] = "1"

import numpy as np

import work

# the last periods of the first phase turn the tangent vector into its direction, where a package lets one do that
SETTLE, ALIGN, MEASURE = 300, 50, 1000

# the chaotic point, the last one, has no exponent that two programs could agree on
REGULAR = slice(0, len(work.POINTS) - 1)


class Tribochaos:
    name = "tribochaos, Model.point"
    packages = ("tribochaos",)

    def __init__(self):
        import tribochaos as tc

        self.model = tc.Model(transient_periods=SETTLE, align_periods=ALIGN, periods=MEASURE, backend="cpu")

    def exponents(self, zeta_k, h1):
        return [self.model.point(zeta_k=z, h1=h, progress=False).lyapunov for z, h in zip(zeta_k, h1)]


class Together(Tribochaos):
    name = "tribochaos, Model.points"
    early = False

    def __init__(self):
        super().__init__()
        self.model = self.model.replace(decide_early=self.early)

    def exponents(self, zeta_k, h1):
        return self.model.points({"zeta_k": zeta_k, "h1": h1}, progress=False).lyapunov.to_list()


class Early(Together):
    name = "tribochaos, Model.points, decided early"
    early = True


class Pynamicalsys:
    packages = ("pynamicalsys", "numba")

    def __init__(self, tolerance):
        from numba import njit
        from pynamicalsys import ContinuousDynamicalSystem

        eps, f0, alpha, beta, eps0 = work.EPS, work.F0, work.ALPHA, work.BETA, work.EPS0
        omega_0, omega_k, b = work.OMEGA_0, work.OMEGA_K, work.B

        @njit
        def motion(_time, u, parameters):
            zeta_k, h1 = parameters[0], parameters[1]
            x, y, phase = u[0], u[1], u[2]
            v = omega_k + zeta_k * np.sin(phase) - y
            s = np.sign(v) if abs(v) > eps0 else (2 - abs(v) / eps0) * v / eps0
            friction = f0 * s - alpha * v + beta * v**3
            return np.array([y, x - b * x**3 + eps * friction - eps * h1 * y, omega_0])

        @njit
        def jacobian(_time, u, parameters):
            zeta_k, h1 = parameters[0], parameters[1]
            x, y, phase = u[0], u[1], u[2]
            v = omega_k + zeta_k * np.sin(phase) - y
            slope = 0.0 if abs(v) > eps0 else 2 * (1 - abs(v) / eps0) / eps0
            rise = f0 * slope - alpha + 3 * beta * v**2
            out = np.zeros((3, 3))
            out[0, 1] = 1
            out[1, 0] = 1 - 3 * b * x**2
            out[1, 1] = -eps * rise - eps * h1
            out[1, 2] = eps * rise * zeta_k * np.cos(phase)
            return out

        self.name = f"pynamicalsys, RK45 at {tolerance:g}"
        self.system = ContinuousDynamicalSystem(
            equations_of_motion=motion, jacobian=jacobian, system_dimension=3, number_of_parameters=2
        )
        self.system.integrator("rk45", atol=tolerance, rtol=tolerance)

    def exponents(self, zeta_k, h1):
        found = []
        for parameters in zip(zeta_k, h1):
            spectrum = self.system.lyapunov(
                [*work.START, 0.0],
                (SETTLE + MEASURE) * work.PERIOD,
                parameters=list(parameters),
                transient_time=SETTLE * work.PERIOD,
                num_exponents=3,
            )
            # the trivial exponent is among the three
            found.append(float(max(np.delete(spectrum, np.argmin(np.abs(spectrum))))))
        return found


class Heyoka:
    packages = ("heyoka",)

    def __init__(self, tolerance):
        from heyoka_events import Events

        self.name = f"heyoka with events at {tolerance:g}, in batches"
        self.events = Events("f64", tolerance)

    def batches(self, zeta_k, h1):
        """The parameters in batches, with how many of each count."""
        lanes = self.events.alone.lanes
        fill = (0, -zeta_k.size % lanes)
        padded = [np.pad(values, fill, mode="edge") for values in (zeta_k, h1)]
        for start in range(0, zeta_k.size, lanes):
            yield [values[start : start + lanes] for values in padded], min(lanes, zeta_k.size - start)

    def settle(self, parameters, periods):
        """States after some periods of the motion alone."""
        alone = self.events.alone
        alone.load(*parameters, *work.START)
        for _ in range(periods):
            alone.period()
        return alone.state[:2].copy()

    def exponents(self, zeta_k, h1):
        found, tangent = [], self.events.tangent
        for parameters, count in self.batches(zeta_k, h1):
            tangent.load(*parameters, *self.settle(parameters, SETTLE - ALIGN))
            growth = np.zeros(tangent.lanes)
            for period in range(ALIGN + MEASURE):
                tangent.period()
                length = tangent.renormalise()
                growth += length if period >= ALIGN else 0.0
            found += list(growth[:count] / (MEASURE * work.PERIOD))
        return found

    def multipliers(self, zeta_k, h1, most=64):
        """Exponents of cycles of at most `most` periods, by the eigenvalues of the map over one turn."""
        found, tangent = [], self.events.tangent
        for parameters, count in self.batches(zeta_k, h1):
            on_cycle = self.settle(parameters, SETTLE + MEASURE)
            columns, states = [], []
            for vector in ((1.0, 0.0), (0.0, 1.0)):
                tangent.load(*parameters, *on_cycle)
                tangent.state[2:] = np.array(vector)[:, None]
                turns = []
                for _ in range(most):
                    tangent.period()
                    turns.append(tangent.state.copy())
                columns.append([turn[2:] for turn in turns])
                states = [turn[:2] for turn in turns]
            for lane in range(count):
                apart = [np.abs(state[:, lane] - on_cycle[:, lane]).max() for state in states]
                period = next(n for n, distance in enumerate(apart, 1) if distance < 1e-9)
                turn = np.column_stack([column[period - 1][:, lane] for column in columns])
                found.append(np.log(np.abs(np.linalg.eigvals(turn)).max()) / (period * work.PERIOD))
        return found


def main():
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=3, help="timings; medians are printed")
    parser.add_argument("--core", type=int, help="core that the process is bound to")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    work.pin(options.core)
    points = work.points()
    peers = [Tribochaos(), Together(), Early(), Pynamicalsys(1e-9), Heyoka(1e-6)]
    results = []
    exact = np.array(Heyoka(1e-15).multipliers(*(values[REGULAR] for values in points)))
    for peer in peers:
        before = time.perf_counter()
        peer.exponents(*(values[:1] for values in points))
        compiled = time.perf_counter() - before
        seconds = []
        for _ in range(options.rounds):
            watch = work.Stopwatch(time.perf_counter)
            with watch:
                exponents = peer.exponents(*points)
            seconds.append(watch.seconds / len(work.POINTS))
        errors = np.abs(np.array(exponents)[REGULAR] - exact)
        results.append(
            {
                "program": peer.name,
                "versions": work.versions(*peer.packages),
                "seconds_per_point": statistics.median(seconds),
                "first_call_seconds": compiled,
                "error_median": float(np.median(errors)),
                "error_greatest": float(errors.max()),
            }
        )
    if options.json:
        print(json.dumps({"cpu": work.cpu_name(), "date": work.today(), "results": results}, indent=2))
        return
    print(f"{work.today()}, {work.cpu_name()}; one core, {SETTLE} + {MEASURE} forcing periods")
    print("| | ms for a point | first call, s | error of the exponent, median | greatest |")
    print("| --- | --- | --- | --- | --- |")
    for row in results:
        print(
            f"| {row['program']} | {1e3 * row['seconds_per_point']:.3g} | {row['first_call_seconds']:.2g} "
            f"| {row['error_median']:.0e} | {row['error_greatest']:.0e} |"
        )
    print("versions: " + "; ".join(dict.fromkeys(row["versions"] for row in results)))


if __name__ == "__main__":
    main()
