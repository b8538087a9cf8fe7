"""Peak memory of scans of 10^4 to 10^8 points, measured and drawn.

    python benches/memory.py target/release/tribochaos FOLDER [most points]

Writes FOLDER/memory.csv, and with matplotlib FOLDER/memory.png. The scans have the shortest runs, in f32 on the CPU; the stores are
removed again. 10^8 points take half an hour on two cores, and 2.3 GB of disk.
"""

import csv
import os
import pathlib
import shutil
import subprocess
import sys

SIDES = [(100, 100), (400, 250), (1000, 1000), (4000, 2500), (10000, 10000)]
SHORTEST = "--precision f32 --backend cpu --transient-periods 0 --align-periods 0 --periods 16 --max-period 1 --quiet".split()


def peak(program, store, x, y):
    """Peak resident memory in MB of a scan of x by y points, and the size of its store in MB."""
    axes = ["--x", f"zeta_k=3:5:{x}", "--x", f"h1=0:1.5:{y}"]
    process = subprocess.Popen([program, "scan", *axes, *SHORTEST, "--out", str(store)], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"the scan of {x * y} points failed")
    size = sum(file.stat().st_size for file in store.rglob("*") if file.is_file())
    shutil.rmtree(store)
    return usage.ru_maxrss / 1024, size / 1e6


def draw(rows, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    points = [row[0] for row in rows]
    axes.plot(points, [row[1] for row in rows], "o-", label="peak memory of the program")
    axes.plot(points, [row[2] for row in rows], "s--", label="size of the store")
    axes.set(xscale="log", yscale="log", xlabel="points of the scan", ylabel="MB")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=150)


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    most = float(sys.argv[3]) if len(sys.argv) > 3 else 1e8
    folder.mkdir(parents=True, exist_ok=True)
    rows = [(x * y, *peak(program, folder / "memory.zarr", x, y)) for x, y in SIDES if x * y <= most]
    with open(folder / "memory.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["points", "memory_mb", "store_mb"])
        writer.writerows(rows)
    try:
        draw(rows, folder / "memory.png")
    except ImportError:
        print("matplotlib is not installed: no picture")


if __name__ == "__main__":
    main()
