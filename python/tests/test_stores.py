"""Results in stores: those of the program, bit for bit."""

import json
import subprocess

import numpy as np
import pandas as pd
import pytest
import tribochaos as tc
import xarray as xr

BRIEF = dict(transient_periods=60, periods=32, align_periods=20)
OPTIONS = ["--transient-periods", "60", "--periods", "32", "--align-periods", "20", "--backend", "cpu"]


def identical(one, other):
    """Whether two datasets are the same to the last bit, NaN included."""
    xr.testing.assert_identical(one, other)
    for name in one.variables:
        assert one[name].dtype == other[name].dtype
        assert one[name].to_numpy().tobytes() == other[name].to_numpy().tobytes(), name


def test_a_map_is_that_of_the_program_bit_for_bit(program):
    axes = ["--x", "zeta_k=3:5:40", "--y", "h1=0:1.5:30"]
    subprocess.run([program, "map", *axes, *OPTIONS, "--out", "m"], check=True, capture_output=True)
    ds = tc.Model(backend="cpu", **BRIEF).map(zeta_k="3:5:40", h1="0:1.5:30")
    identical(ds.drop_attrs(deep=False), tc.open("m.zarr").drop_attrs(deep=False))
    assert ds.attrs["experiment"] == tc.open("m.zarr").attrs["experiment"]
    with xr.open_zarr("m.zarr") as lazy:
        xr.testing.assert_equal(lazy.load()[list(ds.data_vars)], ds)


def test_points_are_those_of_a_scan_bit_for_bit(program):
    rng = np.random.default_rng(1)
    columns = {"zeta_k": rng.uniform(0, 6, 200), "h1": rng.uniform(0, 2, 200), "b": rng.uniform(0.5, 2, 200)}
    rows = zip(*columns.values())
    with open("p.csv", "w") as file:
        file.write(",".join(columns) + "\n")
        file.writelines(",".join(map(repr, map(float, row))) + "\n" for row in rows)
    subprocess.run([program, "scan", "--points", "p.csv", *OPTIONS, "--out", "p.zarr"], check=True, capture_output=True)
    out = tc.Model(backend="cpu", **BRIEF).points(columns)
    stored = tc.open("p.zarr")
    for name in ("lyapunov", "lyapunov_error", "period"):
        assert out[name].to_numpy().tobytes() == stored[name].to_numpy().tobytes()


def test_a_section_is_that_of_the_program_bit_for_bit(program):
    subprocess.run([program, "poincare", "--points", "300", "--out", "p"], check=True, capture_output=True)
    with open("p.csv") as file:
        rows = [line.split(",") for line in file if not line.startswith("#")]
    states = pd.DataFrame(rows[1:], columns=["x", "y"], dtype=float)
    # a model's periods are those of its maps
    section = tc.Model(periods=100).section(points=300)
    assert (states.x.to_numpy() == section.x.to_numpy()).all() and (states.y.to_numpy() == section.y.to_numpy()).all()


def test_an_onset_is_that_of_the_program(program):
    options = ["--x", "zeta_k=3:4:11", "--onset-spacing", "0.05", "--set", "h1=0.2", "--initial-states", "8"]
    told = subprocess.run([program, "lyapunov", *options, "--json"], check=True, capture_output=True, text=True)
    found = tc.Model(h1=0.2, initial_states=8).onset("zeta_k", within=(3, 4), spacing=0.05)
    theirs = json.loads(told.stdout)["onset"]
    assert (found.onset.value, found.onset.lyapunov) == (theirs["value"], theirs["lyapunov"])
    assert found.onset.initial_state == tuple(theirs["initial_state"])


def test_a_store_is_gone_on_with_and_belongs_to_one_experiment(program):
    model = tc.Model(**BRIEF)
    ds = model.map(zeta_k=np.linspace(3, 5, 20), store="s.zarr")
    identical(ds, tc.open("s.zarr"))
    # nothing is left to do
    parts = []
    again = model.map(zeta_k=np.linspace(3, 5, 20), store="s.zarr", progress=parts.append)
    identical(ds, again)
    with pytest.raises(ValueError, match="another experiment .*: give another store, or force"):
        model.map(zeta_k=np.linspace(3, 6, 20), store="s.zarr")
    replaced = model.map(zeta_k=np.linspace(3, 6, 20), store="s.zarr", force=True)
    identical(replaced, tc.open("s.zarr"))
    told = subprocess.run([program, "status", "s.zarr", "--json"], check=True, capture_output=True, text=True)
    assert json.loads(told.stdout)["points"] == 20


def test_what_is_no_store_is_told():
    for name in ("nowhere.zarr", "run--b.zarr", "my--out.zarr"):
        with pytest.raises(FileNotFoundError, match=f"no store at {name}"):
            tc.open(name)
    tc.Model(**BRIEF).map(zeta_k=[3, 4], store="s.zarr")
    with pytest.raises(ValueError, match="does not hold contact_time"):
        tc.open("s.zarr", quantities=["contact_time"])
    with pytest.raises(ValueError, match="there is no quantity `lyapunof`"):
        tc.open("s.zarr", quantities=["lyapunof"])
    assert set(tc.open("s.zarr", quantities=["lyapunov"]).data_vars) == {"lyapunov", "status"}
    with open("s.zarr/zarr.json") as file:
        text = file.read()
    newer = json.loads(text)
    newer["attributes"]["format_version"] = 99
    with open("s.zarr/zarr.json", "w") as file:
        json.dump(newer, file)
    with pytest.raises(ValueError, match="version 99"):
        tc.open("s.zarr")
    with pytest.raises(ValueError, match="should end in .zarr"):
        tc.Model(**BRIEF).map(zeta_k=[3, 4], store="s.nc")
