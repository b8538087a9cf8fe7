"""Threads and processes at once, and Ctrl-C."""

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
import tribochaos as tc

BRIEF = dict(transient_periods=60, periods=32, align_periods=20, backend="cpu")


def exponents(h1):
    return tc.Model(h1=h1, **BRIEF).map(zeta_k=np.linspace(3, 5, 50)).lyapunov.to_numpy()


def on_a_gpu(_):
    try:
        tc.Model(**{**BRIEF, "backend": "gpu"}).map(zeta_k=[3, 4])
    except ValueError as error:
        return str(error)
    return "computed"


H1 = [0.2, 0.4, 0.6, 0.8]


def expected():
    return [exponents(h1) for h1 in H1]


def test_two_threads_at_once():
    with ThreadPoolExecutor(2) as threads:
        found = list(threads.map(exponents, H1))
    assert all((one == other).all() for one, other in zip(found, expected()))


# the interpreter warns that threads do not outlive a fork; those of this package are made anew
@pytest.mark.filterwarnings("ignore:.*use of fork.*:DeprecationWarning")
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_pool_of_processes(method):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {method} here")
    # the threads of this process are there before the pool is
    before = expected()
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as pool:
        found = list(pool.map(exponents, H1))
    assert all((one == other).all() for one, other in zip(found, before))


@pytest.mark.filterwarnings("ignore:.*use of fork.*:DeprecationWarning")
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_forked_process_does_not_touch_a_gpu():
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as pool:
        assert "made by fork cannot use a GPU" in next(pool.map(on_a_gpu, [0]))


def test_the_interpreter_is_free_while_a_run_goes_on():
    with ThreadPoolExecutor(1) as threads:
        run = threads.submit(tc.Model(**BRIEF).map, zeta_k=np.linspace(0, 12, 400), h1=np.linspace(0, 2, 60))
        counted = 0
        while not run.done():
            counted += 1
        assert counted > 1000 and run.result().lyapunov.size == 24_000


def test_progress_is_told():
    parts = []
    tc.Model(**BRIEF).map(zeta_k=np.linspace(0, 12, 400), h1=np.linspace(0, 2, 40), progress=parts.append)
    assert parts == sorted(parts) and all(0.0 <= part <= 1.0 for part in parts)

    def refuse(part):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        tc.Model(**BRIEF).map(zeta_k=np.linspace(0, 12, 400), h1=np.linspace(0, 2, 40), progress=refuse)


LONG = "tc.Model(decide_early=False, periods=500, backend='cpu').map(zeta_k=np.linspace(3, 5, 200), h1=np.linspace(0, 1.5, 100)"


def interrupted(program, after=0.0):
    """The output of a program that gets Ctrl-C once it has computed more than this part."""
    begun = f"""
    import sys, warnings
    import numpy as np, tribochaos as tc
    told = []
    def tell(part):
        if part > {after} and not told:
            told.append(part)
            print("begun", flush=True)
    {textwrap.indent(textwrap.dedent(program), "    ").strip()}
    """
    process = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(begun)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "begun\n", process.stderr.read()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    return process.returncode, out, err


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_ctrl_c_returns_what_is_finished():
    code, out, err = interrupted(
        f"""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            ds = {LONG}, progress=tell)
        missing = int(ds.lyapunov.isnull().sum())
        print(caught[-1].category.__name__, 0 < missing < ds.lyapunov.size)
        """,
        after=0.5,
    )
    assert (code, out) == (0, "StoppedWarning True\n"), err


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_ctrl_c_stops_what_is_kept_nowhere():
    for call in (
        "[tc.Model(transient_periods=60, periods=32, align_periods=20, backend='cpu').map(zeta_k=[3, 4]) for _ in range(10**6)]",
        "tc.Model().trajectory(periods=200_000, samples=4)",
        "tc.Model().melnikov(samples=1_000_000)",
        "tc.Model(periods=10**6).point()",
    ):
        code, out, err = interrupted(f"told.append(1)\nprint('begun', flush=True)\n{call}")
        assert code in (130, -signal.SIGINT) and "KeyboardInterrupt" in err, (call, err)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_ctrl_c_keeps_what_is_finished_in_the_store():
    code, out, err = interrupted(f"{LONG}, progress=tell, store='s.zarr')")
    assert code in (130, -signal.SIGINT) and "kept in s.zarr" in err
    assert tc.open("s.zarr").lyapunov.shape == (100, 200)


def test_a_bar_shows_progress_where_tqdm_is_there(monkeypatch):
    class Bar:
        total, n = 0, 0

        def __init__(self, total, desc, **_):
            Bar.total, Bar.n, Bar.desc, Bar.is_closed = total, 0, desc, False

        def update(self, more):
            Bar.n += more

        def close(self):
            Bar.is_closed = True

    monkeypatch.setattr("tqdm.auto.tqdm", Bar)
    tc.Model(**BRIEF).map(zeta_k=np.linspace(0, 12, 400), h1=np.linspace(0, 2, 40), progress=True)
    assert Bar.desc == "map" and 0 < Bar.n <= Bar.total and Bar.is_closed
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match="pip install tqdm"):
        tc.Model(**BRIEF).map(zeta_k=[3, 4], progress=True)
