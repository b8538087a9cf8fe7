"""The accessor ``tc`` of datasets: pictures as the program draws them, on the user's matplotlib axes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from . import _native
from ._tables import NO_CODE, PARAMETERS, QUANTITIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_Floats = npt.NDArray[np.float64]


@xr.register_dataset_accessor("tc")  # type: ignore[no-untyped-call, unused-ignore]
class Accessor:
    """Pictures of datasets of this package: ``ds.tc.plot()``."""

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset

    def plot(
        self,
        quantity: str | None = None,
        *,
        ax: Axes | None = None,
        limits: tuple[float, float] | None = None,
        colours: str = "blue-red",
        bins: int | None = None,
        legend: bool = True,
        colorbar: bool = True,
    ) -> Axes:
        """Draw the dataset on matplotlib axes.

        Parameters
        ----------
        quantity : str, optional
            What is drawn: of a map, a quantity such as ``"period"`` (``"lyapunov"`` by default); of a bifurcation
            diagram, ``"x"`` (by default) or ``"y"``; of a trajectory, any of its variables (``"x"``).
        ax : matplotlib.axes.Axes, optional
            Where; the current axes by default. It can be changed afterwards.
        limits : (low, high), optional
            Values at the ends of the colour bar of a map, or of the vertical axis of others.
        colours : {"blue-red", "purple-green"}, optional
            The colour scales; both are told apart by readers who do not see red and green.
        bins : int, optional
            Cells along each side in which the states of a section or a bifurcation diagram are counted; by default
            about as many as the axes have pixels.
        legend, colorbar : bool, optional
            Whether colours are explained.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ValueError
            If the dataset is no map of two axes with more than one value each, or lacks the quantity.
        """
        import matplotlib.pyplot as plt

        ax = plt.gca() if ax is None else ax
        kind = self._dataset.attrs.get("kind")
        if kind == "section":
            _draw_section(self._dataset, ax, colours, bins)
        elif kind == "bifurcation":
            _draw_bifurcation(self._dataset, quantity or "x", ax, limits, colours, bins)
        elif kind == "trajectory":
            _draw_trajectory(self._dataset, quantity or "x", ax, limits)
        else:
            _draw_map(self._dataset, quantity or "lyapunov", ax, limits, colours, legend, colorbar)
        return ax


def _draw_map(
    dataset: xr.Dataset,
    quantity: str,
    ax: Axes,
    limits: tuple[float, float] | None,
    colours: str,
    legend: bool,
    colorbar: bool,
) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.patches import Patch

    if quantity not in dataset:
        raise ValueError(f"the dataset has no {quantity}: it has {', '.join(map(str, dataset.data_vars))}")
    squeezed = dataset.squeeze(drop=True)
    dims = squeezed[quantity].dims
    if len(dims) != 2 or min(squeezed[quantity].shape) < 2:
        sizes = dict(zip(dims, squeezed[quantity].shape))
        raise ValueError(f"a map has two axes, and this has {sizes}: choose values of the others by .sel or .isel")
    # cells lie in rising order, whatever the order of the values; codes have the same
    squeezed = squeezed.sortby(list(dims))
    squeezed = squeezed.drop_vars([name for name, other in squeezed.data_vars.items() if set(other.dims) != set(dims)])
    squeezed = squeezed.transpose(*dims)
    y, x = (squeezed[dim] for dim in dims)
    if quantity == "period" and "class" not in squeezed:
        raise ValueError("a picture of periods needs the class of each point: ask for the quantity class as well")
    values = _plane(squeezed[quantity])
    classes = _code(squeezed, "class", values, np.nan)
    status = _code(squeezed, "status", values, 0.0)
    limits = None if limits is None else (float(limits[0]), float(limits[1]))
    pixels, meaning = _native.shades(quantity, values, classes, status, limits, colours)
    found = json.loads(meaning)
    ax.pcolormesh(_edges(x.to_numpy()), _edges(y.to_numpy()), pixels / 255.0, rasterized=True)
    for axis, coordinate in ((ax.xaxis, x), (ax.yaxis, y)):
        if _is_logarithmic(coordinate.to_numpy()):
            getattr(ax, f"set_{axis.axis_name}scale")("log")
        axis.set_label_text(_label(coordinate))
    missing = bool((pixels[..., 3] == 0).any())
    if missing:
        ax.patch.set_hatch("////")
        ax.patch.set_edgecolor("0.6")
    if colorbar and found["bar"] is not None:
        bar = found["bar"]
        mappable = ScalarMappable(
            Normalize(bar["low"], bar["high"]), ListedColormap(np.asarray(bar["colours"]) / 255.0)
        )
        extend = {(True, True): "both", (True, False): "min", (False, True): "max"}.get(
            (bar["below"], bar["above"]), "neither"
        )
        ax.figure.colorbar(mappable, ax=ax, label=bar["label"], extend=extend)
    if legend:
        signs = [Patch(facecolor=_hex(colour), edgecolor="0.5", label=name) for colour, name in found["legend"]]
        if missing:
            signs.append(Patch(facecolor="white", edgecolor="0.6", hatch="////", label="not computed"))
        if signs:
            title = found["heading"].rstrip(":") or None
            ax.legend(
                handles=signs,
                title=title,
                loc="upper left",
                bbox_to_anchor=(0.0, -0.16),
                ncols=min(len(signs), 4),
                frameon=False,
                borderaxespad=0.0,
                fontsize="small",
                alignment="left",
            )


def _hex(colour: list[int]) -> str:
    return "#" + bytes(colour).hex()


def _plane(variable: xr.DataArray) -> _Floats:
    """A variable as a table of numbers, with NaN where a code is none."""
    if variable.dtype.kind not in "fiub":
        raise ValueError(f"{variable.name} has the type {variable.dtype}: numbers are drawn")
    values: _Floats = variable.to_numpy().astype(np.float64)
    name = str(variable.name)
    if name in QUANTITIES and QUANTITIES[name].codes:
        values[values == NO_CODE] = np.nan
    return np.ascontiguousarray(values)


def _code(dataset: xr.Dataset, name: str, like: _Floats, missing: float) -> _Floats:
    """A code at the points of a map; `missing` everywhere if the dataset does not have it."""
    return _plane(dataset[name]) if name in dataset else np.full(like.shape, missing)


def _pixels(ax: Axes) -> tuple[int, int]:
    """Width and height of axes in pixels: more cells would not be seen, and fewer would look coarse."""
    box = ax.get_window_extent()
    width, height = (min(max(int(side), 100), 2000) for side in (box.width, box.height))
    return width, height


def _widened(values: _Floats) -> tuple[float, float]:
    """The range of values with a margin, so that none lies on the frame."""
    if not np.isfinite(values).any():
        raise ValueError("there is no state to draw: all orbits ran away or were given up")
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.03 * (high - low) if high > low else 0.5
    return (low - margin, high + margin)


def _draw_section(dataset: xr.Dataset, ax: Axes, colours: str, bins: int | None) -> None:
    from matplotlib.colors import LogNorm

    x, y = dataset["x"].to_numpy(), dataset["y"].to_numpy()
    cells = _pixels(ax) if bins is None else (bins, bins)
    counts, x_edges, y_edges = np.histogram2d(x, y, bins=cells, range=(_widened(x), _widened(y)))
    shown = np.ma.masked_equal(counts.T, 0)
    norm = LogNorm(1, max(2.0, float(counts.max())))
    ax.pcolormesh(x_edges, y_edges, shown, cmap=_ramp(colours), norm=norm, rasterized=True)
    ax.set_xlabel("angle of the bush x")
    ax.set_ylabel("angular speed y")


def _draw_bifurcation(
    dataset: xr.Dataset, quantity: str, ax: Axes, limits: tuple[float, float] | None, colours: str, bins: int | None
) -> None:
    from matplotlib.colors import LogNorm

    if quantity not in ("x", "y"):
        raise ValueError(f"a bifurcation diagram shows x or y, and not {quantity}")
    dataset = dataset.sortby(str(dataset[quantity].dims[0]))
    along = dataset[str(dataset[quantity].dims[0])]
    states = dataset[quantity].to_numpy()
    low, high = _widened(states) if limits is None else limits
    edges = np.linspace(low, high, (_pixels(ax)[1] if bins is None else bins) + 1)
    counts = np.array([np.histogram(row[np.isfinite(row)], edges)[0] for row in states])
    shown = np.ma.masked_equal(counts.T, 0)
    norm = LogNorm(1, max(2.0, float(counts.max())))
    ax.pcolormesh(_edges(along.to_numpy()), edges, shown, cmap=_ramp(colours), norm=norm, rasterized=True)
    ax.set_xlabel(_label(along))
    ax.set_ylabel("angle of the bush x" if quantity == "x" else "angular speed y")


def _draw_trajectory(dataset: xr.Dataset, quantity: str, ax: Axes, limits: tuple[float, float] | None) -> None:
    if quantity not in dataset:
        raise ValueError(f"the dataset has no {quantity}: it has {', '.join(map(str, dataset.data_vars))}")
    ax.plot(dataset["tau"], dataset[quantity], linewidth=1.0)
    ax.set_xlabel("time τ")
    ax.set_ylabel(f"{dataset[quantity].attrs.get('long_name', '')} {quantity}".strip())
    if limits is not None:
        ax.set_ylim(*limits)


def _ramp(colours: str) -> Any:
    from matplotlib.colors import ListedColormap

    # the palest colours would not be seen on white
    return ListedColormap(np.asarray(_native.ramp(colours, 256)[48:]) / 255.0)


def _is_logarithmic(values: _Floats) -> bool:
    """Whether rising values lie at equal ratios, and not at equal distances."""
    if values.size < 3 or values[0] <= 0.0:
        return False
    ratios = np.diff(np.log(values))
    return bool(np.allclose(ratios, ratios[0], rtol=1e-6)) and not bool(
        np.allclose(np.diff(values), values[1] - values[0])
    )


def _edges(values: _Floats) -> _Floats:
    """The edges of cells around rising values: half-way to the neighbours, on a logarithmic axis in ratio."""
    if _is_logarithmic(values):
        return np.asarray(np.exp(_edges(np.log(values))))
    if values.size < 2:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middles = 0.5 * (values[1:] + values[:-1])
    first, last = values[0] - (middles[0] - values[0]), values[-1] + (values[-1] - middles[-1])
    return np.concatenate([[first], middles, [last]])


def _label(values: xr.DataArray) -> str:
    """The meaning of a coordinate with its symbol and unit."""
    name = str(values.name)
    meaning = values.attrs.get("long_name", name)
    symbol = values.attrs.get("symbol") or (PARAMETERS[name].symbol if name in PARAMETERS else "")
    units = values.attrs.get("units", "1")
    return f"{meaning} {symbol}".strip() + ("" if units in ("1", "") else f" ({units})")
