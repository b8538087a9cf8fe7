"""The package as it is installed: types, command, documentation."""

import doctest
import importlib
import inspect
import os
import subprocess
import sys
from pathlib import Path

import pytest
import tribochaos as tc

HERE = Path(__file__).parent
SAMPLE = """
import numpy as np
import pandas as pd
import tribochaos as tc

model = tc.Model("paper", k_w=0.0, scheme="radau")
ds = model.map(zeta_k=np.linspace(3, 5, 3), h1=[0.5, 1.0], gamma="log:1e-3:1:20", b=1.0)
exponent: float = model.point(zeta_k=3.9).lyapunov
frame: pd.DataFrame = model.points(pd.DataFrame({"zeta_k": [3.0]}))
period: int | None = model.point().period
end = model.onset("zeta_k").end
value = None if end is None else end.value + 1.0
"""


@pytest.mark.parametrize("module", ["mypy", "mypy.stubtest"])
def test_types_are_whole(module, tmp_path):
    sample = tmp_path / "sample.py"
    sample.write_text(SAMPLE)
    arguments = {
        "mypy": ["--strict", "-p", "tribochaos"],
        "mypy.stubtest": ["tribochaos._native"],
    }[module]
    ran = subprocess.run([sys.executable, "-m", module, *arguments], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    if module == "mypy":
        ran = subprocess.run([sys.executable, "-m", "mypy", "--strict", str(sample)], capture_output=True, text=True)
        assert ran.returncode == 0, ran.stdout + ran.stderr


def test_the_command_is_there(program):
    command = Path(sys.executable).with_name("tribochaos")
    version = subprocess.run([command, "--version"], capture_output=True, text=True)
    assert version.stdout.strip() == f"tribochaos {tc.__version__}"
    for arguments in (["point", "--set", "zeta_k=2"], ["map", "--bad"], ["point", "--set", "h1=1e9"]):
        ours, theirs = (subprocess.run([path, *arguments], capture_output=True) for path in (command, program))
        assert (ours.returncode, ours.stdout, ours.stderr) == (theirs.returncode, theirs.stdout, theirs.stderr)


def test_only_numpy_is_needed_to_import():
    code = "import sys, tribochaos as tc; tc.Model().point(zeta_k=2.0); " + (
        "print([name for name in ('xarray', 'pandas', 'matplotlib', 'tqdm') if name in sys.modules])"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout == "[]\n"


def test_datasets_that_xarray_opens_have_the_accessor():
    code = """
import tribochaos as tc
tc.Model(transient_periods=60, periods=32, align_periods=20).map(zeta_k=[3, 4], h1=[0.5, 1], store="m.zarr")
"""
    subprocess.run([sys.executable, "-c", code], check=True)
    code = "import tribochaos.accessor, xarray; print(xarray.open_zarr('m.zarr').tc.plot().get_xlabel())"
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, "MPLBACKEND": "Agg"}
    )
    assert ran.stdout.startswith("amplitude"), ran.stderr


def test_everything_public_is_documented():
    for name in tc.__all__:
        item = getattr(tc, name)
        if not (inspect.isclass(item) or inspect.isfunction(item)):
            continue
        assert inspect.getdoc(item), name
        for method, function in inspect.getmembers(item, inspect.isfunction) if inspect.isclass(item) else ():
            if method.startswith("_"):
                continue
            text = inspect.getdoc(function)
            assert text, f"{name}.{method}"
            for parameter in inspect.signature(function).parameters:
                if parameter != "self":
                    assert parameter in text, f"{name}.{method}: {parameter} is not explained"


@pytest.mark.parametrize("module", ["tribochaos", "tribochaos._model", "tribochaos._machine"])
def test_examples_of_docstrings_run(module):
    failed, tried = doctest.testmod(importlib.import_module(module))
    assert failed == 0 and (tried > 0 or module.endswith("_machine"))
