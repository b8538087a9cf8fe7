"""The project's own benchmark and tuned numba in turn on one core: medians, ratios by round.

Machines differ and their clocks wander, so figures of different minutes say little. Here each run
of the project's benchmark stands between two timings of numba, by the same clock, and is divided
by their mean; numba lives in this process and is compiled once, before the first round.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time

import work
from numba_tuned import Tuned

PHASES = ("ns_motion_alone", "ns_with_vectors", "ns_per_instance_period")


def project(binary, scheme, precision, processor):
    """What the project's benchmark prints of its fastest kernel of the reduced model.

    It goes by the wall clock. For processor time its times are multiplied by the part of the run
    in which it had the core, since it cannot be known in which kernels it lost it.
    """
    command = [binary, "bench", "--backend", "cpu", "--json"]
    command += ["--scheme", scheme, "--precision", precision]
    before, started = os.times(), time.perf_counter()
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        after, wall = os.times(), time.perf_counter() - started
        printed = json.loads(done.stdout)
    except OSError as error:
        sys.exit(
            f"{binary}: {error.strerror}; build it by `cargo build --release`, or give --binary"
        )
    except subprocess.CalledProcessError as error:
        sys.exit(f"`{' '.join(command)}` failed:\n{error.stderr.strip()}")
    except json.JSONDecodeError as error:
        sys.exit(f"`{' '.join(command)}` printed no JSON: {error}")
    wanted = {"model": "reduced", "backend": "cpu", "precision": precision, "scheme": scheme}
    kernels = [
        with_mean(kernel)
        for kernel in printed.get("kernels", [])
        if all(kernel.get(key, value) == value for key, value in wanted.items())
    ]
    kernels = [kernel for kernel in kernels if kernel["ns_per_instance_period"] is not None]
    if not kernels:
        sys.exit(f"`{' '.join(command)}` printed no time of the reduced model on the CPU")
    # there is one for each instruction set; the program takes the fastest
    fastest = min(kernels, key=lambda kernel: kernel["ns_per_instance_period"])
    if processor:
        used = after.children_user + after.children_system
        used -= before.children_user + before.children_system
        share = min(1.0, used / wall)
        fastest |= {phase: fastest[phase] and share * fastest[phase] for phase in PHASES}
    return fastest | {"default": printed.get("default_scheme") == scheme}


def with_mean(kernel):
    """The kernel with all of PHASES: None what is missing and cannot be computed."""
    kernel = {phase: None for phase in PHASES} | kernel
    alone, vectors, mean = (kernel[phase] for phase in PHASES)
    if mean is None and alone is not None and vectors is not None:
        kernel["ns_per_instance_period"] = (alone + vectors) / 2
    return kernel


def version(binary):
    try:
        done = subprocess.run([binary, "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return binary
    return done.stdout.strip()


class Peer:
    """numba, with how much of the core it had."""

    def __init__(self, precisions, periods, processor):
        self.tuned = {precision: Tuned(precision) for precision in precisions}
        self.periods = periods
        self.clock = time.process_time if processor else time.perf_counter
        self.wall = self.processor = 0.0
        for tuned in self.tuned.values():
            tuned.time(self.periods)

    def time(self, precision):
        wall, processor = time.perf_counter(), time.process_time()
        alone, vectors = self.tuned[precision].time(self.periods, clock=self.clock)
        self.wall += time.perf_counter() - wall
        self.processor += time.process_time() - processor
        return dict(zip(PHASES, (alone, vectors, (alone + vectors) / 2)))


def compare(peer, binary, precision, scheme, processor):
    """One round: the project's kernel, and the mean of numba before and after it."""
    before = peer.time(precision)
    ours = project(binary, scheme, precision, processor)
    after = peer.time(precision)
    return ours, {phase: (before[phase] + after[phase]) / 2 for phase in PHASES}


def median(rounds, phase):
    values = [values[phase] for values in rounds if values.get(phase) is not None]
    return f"{statistics.median(values):.0f}" if values else "-"


def ratios(rounds, phase="ns_per_instance_period"):
    """Median and extremes of ours over numba's, round by round."""
    values = [ours[phase] / numba[phase] for ours, numba in rounds]
    return f"{statistics.median(values):.3f} ({min(values):.3f} .. {max(values):.3f})"


def error(kernel, key):
    value = kernel.get(key)
    return "-" if value is None else f"{value:.0e}"


def table(results):
    """The Markdown table of {(precision, scheme): [(ours, numba), ...]}."""
    lines = [
        "| | number type | motion alone | with vectors | mean | mean over numba's, by round "
        "| error of the exponent: median | 99 % |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for precision in dict.fromkeys(precision for precision, _ in results):
        numba = [n for (p, _), rounds in results.items() if p == precision for _, n in rounds]
        times = " | ".join(median(numba, phase) for phase in PHASES)
        lines.append(f"| numba tuned, RK4 | {precision} | {times} | 1 | as rk4 | as rk4 |")
        for (_, scheme), rounds in ((k, r) for k, r in results.items() if k[0] == precision):
            ours = [kernel for kernel, _ in rounds]
            times = " | ".join(median(ours, phase) for phase in PHASES)
            errors = " | ".join(
                error(ours[-1], key) for key in ("exponent_error_median", "exponent_error_p99")
            )
            name = f"tribochaos, {scheme}" + (" (the default)" if ours[-1]["default"] else "")
            lines.append(f"| {name} | {precision} | {times} | {ratios(rounds)} | {errors} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument(
        "--binary", default="target/release/tribochaos", help="the project's program"
    )
    parser.add_argument("--rounds", type=int, default=5, help="rounds of all that is compared")
    parser.add_argument(
        "--schemes",
        nargs="+",
        default=["taylor"],
        metavar="SCHEME",
        help="of the project: taylor, rk4",
    )
    parser.add_argument(
        "--precisions",
        nargs="+",
        default=["f64", "f32"],
        choices=("f64", "f32"),
        help="number types",
    )
    parser.add_argument(
        "--periods",
        type=int,
        default=100,
        help="periods of each phase that a timing of numba takes",
    )
    parser.add_argument(
        "--clock",
        choices=("wall", "processor"),
        default="wall",
        help="processor: an estimate where the core is shared with other programs",
    )
    parser.add_argument("--core", type=int, help="core for both [default: the last one there is]")
    options = parser.parse_args()

    affinity = hasattr(os, "sched_getaffinity")
    if options.core is None and affinity:
        options.core = max(os.sched_getaffinity(0))
    work.pin(options.core)

    processor = options.clock == "processor"
    peer = Peer(options.precisions, options.periods, processor)
    results = {(p, s): [] for p in options.precisions for s in options.schemes}
    for number in range(1, options.rounds + 1):
        for (precision, scheme), rounds in results.items():
            rounds.append(compare(peer, options.binary, precision, scheme, processor))
            last = ratios(rounds[-1:]).split()[0]
            print(f"round {number}: {scheme} {precision} over numba {last}", file=sys.stderr)

    core = f"core {options.core}" if affinity else "bound to no core"
    print(f"{work.today()}, {work.cpu_name()}, {core}; {version(options.binary)}; ", end="")
    print(f"{work.versions('numba', 'numpy')}; {options.rounds} rounds, {options.clock} clock.")
    share = peer.processor / peer.wall
    if share < 0.97:
        print(
            f"The core was shared: numba had it for {share:.0%} of the time. Repeat this when idle."
        )
    print("\nns for one forcing period of one instance, on one core; medians of the rounds.\n")
    print(table(results))


if __name__ == "__main__":
    main()
