"""What a model computes, and in which form."""

import dataclasses
import inspect

import numpy as np
import pandas as pd
import pytest
import tribochaos as tc
import xarray as xr
from tribochaos import _native


def test_a_map_has_labels_units_and_the_experiment():
    ds = tc.Model(h1=0.5).map(zeta_k=np.linspace(3, 5, 9), h1=np.array([0.5, 1.0]))
    assert ds.lyapunov.dims == ("h1", "zeta_k") and ds.lyapunov.shape == (2, 9)
    assert ds.lyapunov.dtype == np.float64 and ds["class"].dtype == np.uint8
    assert ds.lyapunov.attrs["units"] == "1/tau" and "Lyapunov" in ds.lyapunov.attrs["long_name"]
    assert list(ds.zeta_k.to_numpy()) == list(np.linspace(3, 5, 9))
    assert "zeta_k" in ds.attrs["experiment"]
    chaotic = ds.where(ds["class"] == tc.CHAOTIC)
    assert (chaotic.lyapunov.max() > 0.0) and not (chaotic.lyapunov < 0.0).any()


def test_any_array_may_be_an_axis():
    model = tc.Model(transient_periods=60, periods=32, align_periods=20)
    unordered = np.array([4.0, 3.0, 3.5])
    ds = model.map(zeta_k=unordered, gamma=0.0, h1=np.geomspace(0.1, 1.0, 4))
    assert (ds.zeta_k.to_numpy() == unordered).all() and (ds.h1.to_numpy() == np.geomspace(0.1, 1.0, 4)).all()
    sorted_too = model.map(zeta_k=np.sort(unordered), h1=np.geomspace(0.1, 1.0, 4))
    xr.testing.assert_identical(ds.sortby("zeta_k").lyapunov, sorted_too.lyapunov)
    # integers, single precision, views that are not contiguous, and lists
    integers = model.map(zeta_k=np.arange(3, 6))
    for axis in (np.float32([3, 4, 5]), np.arange(3.0, 6.0, 0.5)[::2], [3, 4, 5], range(3, 6)):
        xr.testing.assert_equal(model.map(zeta_k=axis).lyapunov, integers.lyapunov)
    three = model.map(zeta_k=[3, 4], h1=[0.5, 1], omega_0=[1.5, 2, 2.5])
    assert three.lyapunov.dims == ("omega_0", "h1", "zeta_k")


def test_axes_are_written_as_briefly_as_the_program_does():
    model = tc.Model(transient_periods=60, periods=32, align_periods=20)
    even = model.map(zeta_k=np.linspace(0, 12, 25))
    assert "count = 25" in even.attrs["experiment"] and "values" not in even.attrs["experiment"]
    text = model.map(zeta_k="0:12:25")
    xr.testing.assert_identical(even, text)


def test_points_come_back_as_rows():
    rows = pd.DataFrame({"zeta_k": [2.0, 3.9, 4.2], "b": [1.0, 1.0, 1.1]}, index=["a", "b", "c"])
    out = tc.Model(h1=0.5).points(rows)
    assert list(out.index) == ["a", "b", "c"] and list(out.columns[:2]) == ["zeta_k", "b"]
    assert out["class"].tolist() == ["regular", "chaotic", "chaotic"]
    assert out.loc["a", "period"] == 1.0 and np.isnan(out.loc["b", "period"])
    point = tc.Model(h1=0.5, decide_early=True).point(zeta_k=3.9)
    assert out.loc["b", "lyapunov"] == point.lyapunov
    same = tc.Model(h1=0.5).points({"zeta_k": [2.0, 3.9, 4.2], "b": np.array([1, 1, 1.1])}, quantities=["lyapunov"])
    assert same.lyapunov.tolist() == out.lyapunov.tolist()


def test_a_point_has_every_quantity_and_prints_well():
    point = tc.Model(h1=0.5).point(zeta_k=3.9)
    names = {"class_" if name == "class" else name for name in tc.QUANTITIES}
    fields = {field.name for field in dataclasses.fields(tc.Point)}
    assert fields == names | {"parameters", "settings"}
    assert dict(point)["lyapunov"] == point.lyapunov == point["lyapunov"]
    assert point.class_ == "chaotic" and point.lyapunov > 3 * point.lyapunov_error > 0
    assert point.period is None and point.parameters["h1"] == 0.5
    assert abs(point.lyapunov + point.lyapunov_second - point.divergence) < 1e-6
    assert "chaotic" in str(point) and f"{point.lyapunov:.6f}" in str(point)
    gone = tc.Model(b=-1.0, epsilon=0.0).point()
    assert gone.status == "runaway" and gone.runaway_time > 0 and "ran away" in str(gone)


def test_the_exponents_of_a_linear_well_are_exact():
    # roots of s^2 + epsilon h1 s + 2 = 0
    well = tc.Model(f_0=0, alpha=0, beta=0, omega_k=0, zeta_k=0, epsilon=1, h1=2, x0=0.5)
    point = well.point()
    assert abs(point.lyapunov + 1.0) < 1e-6 and abs(point.lyapunov_second + 1.0) < 1e-6


def test_a_trajectory_is_followed_with_heat_and_wear():
    model = tc.Model("paper")
    run = model.trajectory(zeta_k=3.9, periods=30, samples=64)
    assert {"x", "y", "v", "p", "u_w", "theta"} == set(run.data_vars)
    assert run.p.isel(tau=0) == 1.0 and run.u_w.isel(tau=-1) > 0 and run.theta.max() > 0
    assert (
        run.attrs["contact_time"] < run.tau[-1]
        and (run.p.where(run.tau > run.attrs["contact_time"], drop=True) == 0).all()
    )
    free = tc.Model(zeta_k=3.9, scheme="taylor").trajectory(periods=2, samples=16)
    assert free.sizes["tau"] == 33 and (free.p == 1).all()
    rate = np.gradient(tc.Model(zeta_k=3.9).trajectory(periods=2, samples=4096).x, free.tau[-1].item() / 8192)
    assert np.abs(rate[5:-5] - tc.Model(zeta_k=3.9).trajectory(periods=2, samples=4096).y[5:-5]).max() < 1e-3


def test_sections_and_diagrams_have_their_states():
    section = tc.Model(h1=0.5).section(zeta_k=3.9, points=5000)
    assert section.sizes == {"point": 5000} and section.attrs["runaways"] == 0
    diagram = tc.Model(periods=40).bifurcation(zeta_k=np.linspace(2, 4, 5))
    assert diagram.x.dims == ("zeta_k", "state") and diagram.x.shape == (5, 40)
    assert np.ptp(diagram.x.sel(zeta_k=2.0).values) < 1e-6 and np.ptp(diagram.x.sel(zeta_k=4.0).values) > 0.1
    followed = tc.Model(periods=40).bifurcation(zeta_k=[2, 3], follow="up", starts=[(0.1, 0.0), (1.0, 0.0)])
    assert followed.x.shape == (2, 80)


def test_the_onset_of_chaos_is_that_of_the_program():
    found = tc.Model(h1=0.5).onset("zeta_k", within=(3.0, 4.2), spacing=0.1)
    assert found.name == "zeta_k" and found.spacing == 0.1
    assert 3.0 <= found.onset.value <= found.end.value <= 4.2 and found.onset.confirmed > 0.005
    assert "chaos" in str(found)
    none = tc.Model(h1=10.0).onset("zeta_k", within=(0.0, 1.0), spacing=0.5)
    assert none.onset is None and str(none) == "no chaos along zeta_k"


def test_melnikov_s_function_changes_sign_beyond_its_threshold():
    at = tc.Model(h1=0.5).melnikov(zeta_k=3.9, along="zeta_k")
    assert at.changes_sign and at.minimum < 0 < at.maximum
    assert at.values.min() >= at.minimum - 1e-9 and at.values.max() <= at.maximum + 1e-9
    assert at.threshold.kind == "begins" and 0 < at.threshold.value < 3.9
    below = tc.Model(h1=0.5).melnikov(zeta_k=0.9 * at.threshold.value)
    assert not below.changes_sign


def test_a_machine_gives_the_parameters_and_its_quantities_vary(tmp_path):
    path = tmp_path / "m.toml"
    path.write_text(tc.Machine.template())
    machine = tc.Machine.from_toml(path)
    assert machine.parameters["gamma"] > 0 and machine.quantities["shaft_speed_amplitude"][1] == "rad/s"
    model = tc.Model(machine, periods=30, x0=0.0)
    speed = machine.quantities["shaft_speed_amplitude"][0]
    with pytest.warns(tc.TribochaosWarning):
        ds = model.map(shaft_speed_amplitude=[0.5 * speed, speed])
    assert ds.shaft_speed_amplitude.attrs["units"] == "rad/s" and "pressure_scale" in ds
    with pytest.raises(ValueError, match="follows from the machine"):
        model.map(zeta_k=[1, 2])


def test_what_a_preset_sets_may_vary():
    model = tc.Model("paper", periods=20)
    assert model.map(h1=[0.1, 0.5], zeta_k=[3.0, 4.0]).lyapunov.shape == (2, 2)
    assert len(model.points({"k_w": [0.0, 0.01]})) == 2
    assert model.replace(k_w=0).melnikov(gamma=0, along="h1").threshold.name == "h1"


def test_numbers_of_any_kind_are_taken():
    model = tc.Model(transient_periods=60, periods=32, align_periods=20)
    ds = model.map(zeta_k=xr.DataArray([3.0, 4.0]), h1=pd.Series([0.5, 1.0]))
    assert ds.lyapunov.shape == (2, 2)
    exact = model.point(zeta_k=3.0).lyapunov
    for value in (np.float32(3), np.int64(3), np.array(3.0), ds.zeta_k[0], 3):
        assert model.point(zeta_k=value).lyapunov == exact
    assert model.melnikov(along="zeta_k", within=np.array([0.0, 5.0])).threshold.value > 0
    assert model.bifurcation(zeta_k=[3, 4], starts=np.array([[0.1, 0], [1, 0]])).attrs["starts"].tolist() == [
        0.1,
        0,
        1,
        0,
    ]


def test_columns_with_an_index_are_brought_into_line():
    columns = {"zeta_k": pd.Series([3.0, 4.0], index=["a", "b"]), "h1": pd.Series([1.0, 0.5], index=["b", "a"])}
    out = tc.Model(transient_periods=60, periods=32, align_periods=20).points(columns)
    assert out.loc["a", ["zeta_k", "h1"]].tolist() == [3.0, 0.5]


def test_what_a_machine_varies_has_its_labels(tmp_path):
    model = tc.Model(tc.Machine(tc.Machine.template()), wear_coefficient=0.0, wear_energy_share=1.0, periods=16)
    with pytest.warns(tc.TribochaosWarning):
        diagram = model.bifurcation(shaft_speed_amplitude=[115.0, 230.0])
    assert diagram.shaft_speed_amplitude.attrs["units"] == "rad/s"
    with pytest.warns(tc.TribochaosWarning):
        run = model.trajectory(periods=1)
    assert all(isinstance(value, (str, int, float)) for value in run.attrs.values()) and run.attrs["scale_time"] > 0


def test_models_are_replaced_and_not_changed():
    model = tc.Model(h1=0.5, periods=100)
    other = model.replace(h1=0.7, scheme="radau")
    assert repr(model) == "Model(h1=0.5, periods=100)"
    assert other.values == {"h1": 0.7} and other.settings == {"scheme": "radau", "periods": 100}
    assert repr(tc.Model("paper", k_w=0)) == "Model('paper', k_w=0.0)"


def test_every_setting_is_a_keyword():
    keywords = inspect.signature(tc.Model).parameters
    settings = [name for name in keywords if name not in ("base", "values")]
    assert sorted(settings) == sorted(_native.settings())


def test_the_tables_tell_what_there_is():
    assert tc.PARAMETERS["h1"].default == 0.5 and tc.PARAMETERS["ramp_rate"].high == np.inf
    assert (
        tc.QUANTITIES["class"].codes == tc.CLASSES == ("chaotic", "regular", "quasi_periodic", "undecided", "unstable")
    )
    assert (tc.CLASSES[tc.CHAOTIC], tc.CLASSES[tc.UNSTABLE]) == ("chaotic", "unstable")
    assert "CPU" in tc.devices().auto or "GPU" in tc.devices().auto or tc.devices().adapters
