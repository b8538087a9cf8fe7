"""What calls of the Python package cost beside the program: a short call, and a list of points.

    python benches/python_calls.py --program target/release/tribochaos

A call that computes next to nothing shows what the way into the library and back costs. A list of points is measured by
the package and by `scan` in turn; the program's time includes its start and the writing of its store.
"""

import argparse
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

import tribochaos as tc


def seconds(call):
    """Wall-clock time of a call."""
    started = time.perf_counter()
    call()
    return time.perf_counter() - started


def short_calls(rounds):
    """Milliseconds of the shortest point, map and list, medians."""
    model = tc.Model(transient_periods=0, align_periods=0, periods=16, backend="cpu")
    axis, rows = np.array([3.0, 4.0]), pd.DataFrame({"zeta_k": [3.0, 4.0]})
    calls = {
        "point": lambda: model.point(progress=False),
        "map of two points": lambda: model.map(zeta_k=axis, progress=False),
        "list of two points": lambda: model.points(rows, progress=False),
    }
    return {name: 1e3 * statistics.median(seconds(call) for _ in range(rounds)) for name, call in calls.items()}


def list_of_points(program, count, rounds):
    """Seconds of the package and of the program, and their ratio round by round."""
    rng = np.random.default_rng(1)
    rows = pd.DataFrame({"zeta_k": rng.uniform(0, 12, count), "h1": rng.uniform(0, 2, count)})
    model = tc.Model(backend="cpu")
    with tempfile.TemporaryDirectory() as folder:
        rows.to_csv(f"{folder}/points.csv", index=False)
        command = [program, "scan", "--points", "points.csv", "--backend", "cpu", "--quiet", "--force", "--out", "scan.zarr"]
        ours, theirs = [], []
        for _ in range(rounds):
            theirs.append(seconds(lambda: subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)))
            ours.append(seconds(lambda: model.points(rows, progress=False)))
    return ours, theirs


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="target/release/tribochaos", help="the program to compare with")
    parser.add_argument("--points", type=int, default=100_000, help="rows of the list")
    parser.add_argument("--rounds", type=int, default=5, help="rounds of the list")
    options = parser.parse_args()
    program = str(Path(options.program).resolve())
    for name, milliseconds in short_calls(200).items():
        print(f"{name}: {milliseconds:.2f} ms, with 16 forcing periods of each point")
    ours, theirs = list_of_points(program, options.points, options.rounds)
    ratio = statistics.median(one / other for one, other in zip(ours, theirs))
    print(
        f"{options.points} points: package {statistics.median(ours):.2f} s, program {statistics.median(theirs):.2f} s; "
        f"ratio by round {ratio:.2f}"
    )


if __name__ == "__main__":
    main()
