"""The work that every program in this folder does: the model, the grid, the timing, the report.

    x' = y
    y' = x - b x^3 + eps F(v) - eps h1 y        v = omega_k + zeta_k sin(omega_0 tau) - y
    F(v) = f0 s(v) - alpha v + beta v^3
    s(v) = sgn v for |v| > eps0, else (2 - |v|/eps0) v/eps0

with its tangent

    X' = Y
    Y' = (1 - 3 b x^2) X - (eps F'(v) + eps h1) Y

over 64 x 64 values of zeta_k and h1, from x = 0.1, y = 0: 100 forcing periods of the motion alone,
then 100 with one tangent vector, from (1, 0). The maximal exponent is the vector's growth over
these 100.
"""

import argparse
import datetime
import json
import math
import os
import platform
import statistics
import time
from importlib import metadata

import numpy as np

# the model, section 3 of Awrejcewicz and Pyryev (2006)
F0, ALPHA, BETA = 0.3, 0.3, 0.3
OMEGA_0, OMEGA_K = 2.0, 0.4
B, EPS, EPS0 = 1.0, 0.1, 0.01
PERIOD = 2 * math.pi / OMEGA_0
START = (0.1, 0.0)

# the paper's fixed step
STEPS = 628

# the length of the work
PERIODS_ALONE = 100
PERIODS_TANGENT = 100

SIDE = 64

# (zeta_k, h1) at which exponents are printed; all but the last are regular, so that programs can be
# compared there: at the last, a chaotic one, they agree only to about 0.03
POINTS = (
    (1.0, 0.2),
    (2.0, 0.5),
    (3.0, 1.0),
    (3.5, 0.5),
    (6.0, 2.0),
    (8.0, 0.1),
    (12.0, 0.5),
    (4.0, 0.1),
)


def grid():
    """zeta_k and h1 of the 4096 instances, h1 running fastest."""
    zeta_k, h1 = np.meshgrid(np.linspace(0, 12, SIDE), np.linspace(0, 2, SIDE), indexing="ij")
    return zeta_k.ravel(), h1.ravel()


def grid_part(count):
    """`count` instances spread evenly over the grid; an odd stride meets all rows and columns."""
    zeta_k, h1 = grid()
    stride = max(1, zeta_k.size // count) | 1
    return zeta_k[::stride][:count], h1[::stride][:count]


def points():
    """zeta_k and h1 of `POINTS`."""
    return tuple(np.array(values) for values in zip(*POINTS))


def drive_table(steps=STEPS):
    """sin(omega_0 tau) at the beginning and the middle of each step, and at the period's end."""
    return np.sin(2 * np.pi * np.arange(2 * steps + 1) / (2 * steps))


def error_quantiles(errors):
    """Median and 90 % of what `errors` returns; nothing where it lacks a package."""
    try:
        median, most = np.quantile(errors(), (0.5, 0.9))
    except ImportError:
        return {}
    return {"exponent_error_median": float(median), "exponent_error_p90": float(most)}


def cpu_name():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def versions(*packages):
    """Python and the packages, with their versions, in one line."""
    return ", ".join(
        [f"Python {platform.python_version()}"] + [f"{p} {metadata.version(p)}" for p in packages]
    )


def today():
    return datetime.date.today().isoformat()


def pin(core):
    """Binds this process, and those it starts, to one core, where the system can do that."""
    if core is not None and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {core})


class Stopwatch:
    """Adds up time: by default the process's own, without what other processes take of its core."""

    def __init__(self, clock=time.process_time):
        self.seconds = 0.0
        self._clock = clock

    def __enter__(self):
        self._start = self._clock()
        return self

    def __exit__(self, *_):
        self.seconds += self._clock() - self._start

    def ns(self, instances, periods):
        """ns for one forcing period of one instance."""
        return self.seconds / instances / periods * 1e9


def arguments(description, rounds=5, instances=None, precision=True):
    """The command line that the programs share, for each to add its own options to."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    if precision:
        parser.add_argument(
            "--precision", choices=("f64", "f32"), default="f64", help="number type"
        )
    if instances:
        parser.add_argument(
            "--instances", type=int, default=instances, help="instances of the grid that are timed"
        )
    parser.add_argument("--rounds", type=int, default=rounds, help="timings; medians are printed")
    parser.add_argument("--core", type=int, help="core that the process is bound to")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def report(program, options, alone, tangent, exponents, packages, **more):
    """Prints what a program measured.

    `alone` and `tangent` hold ns per instance-period, one number a round; `exponents` are those at
    `POINTS`, or at the first of them.
    """
    result = {
        "program": program,
        "precision": getattr(options, "precision", "f64"),
        "date": today(),
        "cpu": cpu_name(),
        "versions": versions(*packages),
        "ns_motion_alone": statistics.median(alone),
        "ns_with_vectors": statistics.median(tangent),
        "ns_per_instance_period": statistics.median((a + t) / 2 for a, t in zip(alone, tangent)),
        "rounds": len(alone),
        **more,
        "exponents": [
            {"zeta_k": z, "h1": h, "exponent": float(e)} for (z, h), e in zip(POINTS, exponents)
        ],
    }
    if options.json:
        print(json.dumps(result, indent=2))
        return
    print(
        f"{program}, {result['precision']}; {result['date']}, {result['cpu']}, {result['versions']}"
    )
    for key, value in more.items():
        value = f"{value:.2g}" if isinstance(value, float) else value
        print(f"  {key.replace('_', ' ')}: {value}")
    print("ns for one forcing period of one instance, on one core:")
    print(f"  motion alone     {result['ns_motion_alone']:10.0f}")
    print(f"  with the tangent {result['ns_with_vectors']:10.0f}")
    print(f"  mean of both     {result['ns_per_instance_period']:10.0f}")
    print("zeta_k   h1   exponent")
    for point in result["exponents"]:
        print(f"{point['zeta_k']:6.2f} {point['h1']:4.2f} {point['exponent']:10.6f}")
