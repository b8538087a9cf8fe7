"""Pictures on the user's axes."""

import io

import matplotlib.pyplot as plt
import numpy as np
import pytest
import tribochaos as tc
import xarray as xr


@pytest.fixture(scope="module")
def ds():
    return tc.Model(b=1.0).map(zeta_k=np.linspace(3, 5, 24), h1=np.linspace(0, 1.5, 16))


def rendered(figure):
    figure.savefig(io.BytesIO(), format="png")
    plt.close(figure)


def test_a_map_has_the_program_s_colours(ds):
    figure, ax = plt.subplots()
    assert ds.tc.plot(ax=ax) is ax
    colours = ax.collections[0].get_array().reshape(16, 24, -1)
    chaotic, regular = ds["class"] == tc.CHAOTIC, ds["class"] == tc.REGULAR
    assert (colours[chaotic.to_numpy()][:, 0] > colours[chaotic.to_numpy()][:, 2]).all(), "red"
    assert (colours[regular.to_numpy()][:, 2] > colours[regular.to_numpy()][:, 0]).all(), "blue"
    assert "shaft" in ax.get_xlabel() and "damping" in ax.get_ylabel()
    low, high = figure.axes[1].get_ylim()
    assert low == -high and figure.axes[1].get_ylabel().startswith("maximal Lyapunov exponent")
    rendered(figure)


def test_the_picture_of_periods_has_a_legend_of_kinds(ds):
    figure, ax = plt.subplots()
    ds.tc.plot("period", ax=ax)
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert "chaotic" in names and "1" in names and len(figure.axes) == 1
    rendered(figure)


def test_limits_and_scales_are_the_user_s(ds):
    figure, (one, other) = plt.subplots(1, 2)
    ds.tc.plot(ax=one, limits=(-0.5, 0.5))
    assert figure.axes[2].get_ylim() == (-0.5, 0.5)
    ds.tc.plot(ax=other, colours="purple-green", legend=False, colorbar=False)
    assert len(figure.axes) == 3 and other.get_legend() is None
    rendered(figure)
    with pytest.raises(ValueError, match="no colours"):
        ds.tc.plot(ax=other, colours="rainbow")


def test_what_is_not_computed_is_hatched(ds):
    partly = ds.copy(deep=True)
    partly["status"][:, :5] = tc.NO_CODE
    figure, ax = plt.subplots()
    partly.tc.plot(ax=ax)
    assert [text.get_text() for text in ax.get_legend().get_texts()][-1] == "not computed"
    rendered(figure)


def test_classes_belong_to_their_points(ds):
    drawn = []
    for same in (ds, ds.assign(period=ds.period.transpose("zeta_k", "h1")), ds.isel(h1=slice(None, None, -1))):
        figure, ax = plt.subplots()
        same.tc.plot("period", ax=ax)
        pixels = np.asarray(ax.collections[0].get_array())
        upright = pixels if ax.get_xlabel().startswith("amplitude") else pixels.transpose(1, 0, 2)
        drawn.append(upright)
        rendered(figure)
    assert all((one == drawn[0]).all() for one in drawn)
    with pytest.raises(ValueError, match="needs the class"):
        ds.drop_vars("class").tc.plot("period")
    wrong = ds.copy(deep=True)
    wrong["class"][0, 0] = 77
    with pytest.raises(ValueError, match="class has no code 77"):
        wrong.tc.plot()
    figure, ax = plt.subplots()
    ds[["lyapunov"]].tc.plot(ax=ax)
    rendered(figure)
    with pytest.raises(ValueError, match="by xarray"):
        ds.assign(own=2 * ds.lyapunov).tc.plot("own")


def test_a_dataset_without_states_is_told():
    gone = tc.Model(b=-1.0, epsilon=0.0).section(points=10)
    with pytest.raises(ValueError, match="no state to draw"):
        gone.tc.plot()


def test_slices_and_logarithmic_axes_are_drawn():
    four = tc.Model(transient_periods=60, periods=32, align_periods=20).map(
        zeta_k=np.linspace(3, 5, 6), epsilon_0="log:1e-3:1e-1:5", omega_0=[2.0, 1.0]
    )
    figure, ax = plt.subplots()
    with pytest.raises(ValueError, match="by .sel"):
        four.tc.plot(ax=ax)
    four.sel(omega_0=1.0).tc.plot(ax=ax)
    assert ax.get_yscale() == "log" and ax.get_xscale() == "linear"
    rendered(figure)
    with pytest.raises(ValueError, match="has no peak_pressure"):
        four.sel(omega_0=1.0).tc.plot("peak_pressure")


def test_the_other_datasets_are_drawn():
    model = tc.Model(h1=0.5)
    for made in (
        model.section(points=3000),
        model.replace(periods=20).bifurcation(zeta_k=np.linspace(2, 4, 12)),
        model.trajectory(periods=3),
    ):
        figure, ax = plt.subplots()
        made.tc.plot(ax=ax)
        assert ax.get_xlabel() and ax.get_ylabel()
        rendered(figure)
    assert isinstance(made, xr.Dataset)
