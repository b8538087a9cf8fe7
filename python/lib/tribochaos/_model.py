"""The model, and what can be computed of it."""

from __future__ import annotations

import json
import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Mapping, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._checks import (
    SETTINGS,
    add_axis,
    check_name,
    number,
    only,
    range_of,
    refuse_masked,
    set_all,
    states,
    whole,
    with_setting,
)
from ._datasets import dataset, named, of_analysis, variables_of
from ._datasets import table as as_table
from ._machine import Machine
from ._progress import Progress, observed
from ._results import Melnikov, Onset, Point, Threshold
from ._tables import PARAMETERS
from ._warnings import StoppedWarning, TribochaosWarning

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Axis = Union[npt.ArrayLike, str]
"""Values along an axis: an array, or a text of the program such as ``"0:12:300"`` or ``"log:1e-3:1:20"``."""

# more make a table that nobody opens
_MOST_SAMPLES = 1_000_000


class Model:
    """The bush-shaft system with some of its parameters and settings chosen.

    A model computes nothing by itself and is never changed: :meth:`replace` gives another one.

    Parameters
    ----------
    base : str or Machine, optional
        ``"paper"`` for the values of section 5 of the paper (with heat and wear), or a machine in SI units.
    scheme : {"taylor", "radau", "rk4"}, optional
        How it is integrated; by default ``taylor``, and ``radau`` with frictional heat or wear.
    steps_per_period, modes, tolerance, renormalise_every : optional
        Details of the scheme: steps in a forcing period, heat modes, error of a step of ``radau``, steps between
        normalisations of the tangent vectors of ``rk4``.
    precision : {"f64", "f32"}, optional
        The number type; ``f64`` on the CPU, ``f32`` on a GPU.
    periods, transient_periods : int, optional
        Forcing periods that are measured (250), and those before them (300).
    align_periods : int, optional
        The last of the transient, in which the tangent vector turns into its direction (50).
    decide_early : bool, optional
        Whether points may end as soon as their motion is certain; True for maps and lists, False else.
    period_tolerance, max_period : optional
        Distance at which two stroboscopic states are the same (2e-4), and the longest period that is found (64).
    initial_states : int, optional
        Initial states that are tried for each point (1), the first at (x0, y0), the others in ``initial_box``.
    initial_box : mapping, optional
        ``{"x": [low, high], "y": [low, high]}``; both from -2 to 2 by default.
    seed : int, optional
        Of all that is random (1).
    backend : {"auto", "cpu", "gpu"}, optional
        Where it is computed. ``auto`` takes a GPU if there is one; analyses of single points take the CPU.
    adapter : str, optional
        Part of the name of the GPU.
    **values : float
        Parameters by their names (:data:`PARAMETERS`), or quantities of the machine.

    Raises
    ------
    ValueError
        If a name is unknown, a value is out of its range, or a parameter follows from the machine.

    Examples
    --------
    >>> import tribochaos as tc
    >>> tc.Model("paper", k_w=0.0, gamma=0.02)
    Model('paper', gamma=0.02, k_w=0.0)
    """

    def __init__(
        self,
        base: str | Machine | None = None,
        /,
        *,
        scheme: Literal["taylor", "radau", "rk4"] | None = None,
        steps_per_period: int | None = None,
        modes: int | None = None,
        tolerance: float | None = None,
        renormalise_every: int | None = None,
        precision: Literal["f32", "f64"] | None = None,
        periods: int | None = None,
        transient_periods: int | None = None,
        align_periods: int | None = None,
        decide_early: bool | None = None,
        period_tolerance: float | None = None,
        max_period: int | None = None,
        initial_states: int | None = None,
        initial_box: Mapping[str, Sequence[float]] | None = None,
        seed: int | None = None,
        backend: Literal["auto", "cpu", "gpu"] | None = None,
        adapter: str | None = None,
        **values: float,
    ) -> None:
        given = locals()
        self._base = base
        self._settings: dict[str, Any] = {name: given[name] for name in SETTINGS if given[name] is not None}
        self._values = {name: number(name, value) for name, value in values.items()}
        self._request(self._values)
        # settings are checked here and now, whatever the values will be
        bare = _native.Request()
        set_all(bare, self._settings)
        bare.warnings()

    @property
    def values(self) -> Mapping[str, float]:
        """The values that were given, by the names of the parameters or quantities."""
        return dict(self._values)

    @property
    def settings(self) -> Mapping[str, Any]:
        """The settings that were given, by their names."""
        return dict(self._settings)

    def replace(self, **changes: Any) -> Model:
        """Return a model in which some values or settings are others.

        Parameters
        ----------
        **changes
            As the keywords of :class:`Model`.
        """
        return Model(self._base, **{**self._settings, **self._values, **changes})

    def __repr__(self) -> str:
        base = [] if self._base is None else [repr(self._base) if isinstance(self._base, str) else "machine"]
        order = [name for name in PARAMETERS if name in self._values]
        order += [name for name in self._values if name not in PARAMETERS]
        given = [f"{name}={self._values[name]!r}" for name in order]
        given += [f"{name}={value!r}" for name, value in self._settings.items()]
        return f"Model({', '.join(base + given)})"

    def map(
        self,
        *,
        quantities: Sequence[str] | None = None,
        store: str | os.PathLike[str] | None = None,
        force: bool = False,
        alone: bool = False,
        progress: Progress = None,
        **axes: Axis | float,
    ) -> xr.Dataset:
        """Measure every combination of the values of some parameters.

        Parameters
        ----------
        quantities : sequence of str, optional
            What is returned, by the names in :data:`QUANTITIES`; by default all that can differ from point to point.
        store : path, optional
            A folder ``NAME.zarr`` into which the results are written, unit by unit. The same call goes on where an
            earlier one stopped, and several processes with the same store share the work.
        force : bool, optional
            Replace a store of another experiment, and compute one of the same experiment again.
        alone : bool, optional
            No other process uses the store: for file systems without locks.
        progress : bool or callable, optional
            False for no bar; a function that is called with the part that is done, from 0 to 1. By default there is a
            bar in terminals and notebooks, if tqdm is installed.
        **axes : array_like, shape (n,), or str, or float
            Two or more values for each axis, in any order; a text such as ``"0:12:300"`` or ``"log:1e-3:1:20"`` is
            read as the program reads it. A single number sets a value. The first axis varies fastest, and is
            horizontal in pictures. At least one axis is needed.

        Returns
        -------
        xarray.Dataset
            With a dimension for each axis, the first axis last, so that ``ds.lyapunov.plot()`` draws it as the
            program does. Units are in the attributes ``units``: exponents are per unit of tau. Codes such as ``class``
            are numbers (:data:`CHAOTIC` and others), and 255 where there is none. ``ds.attrs["experiment"]`` is the
            whole experiment in TOML, which the program reads.

        Raises
        ------
        ValueError
            If an axis is empty, has a value twice, NaN or out of its range, or is no array of one dimension; if a name
            is unknown; or if the store has the results of another experiment.
        KeyboardInterrupt
            By Ctrl-C with ``store``, which keeps what is finished. Without a store what is finished is returned, with a
            :class:`StoppedWarning`, and the rest is NaN; only if nothing or all is finished, the exception is raised.

        References
        ----------
        Awrejcewicz and Pyryev (2006), sections 3 and 5; the exponent is that of the tangent vector of largest growth.

        Examples
        --------
        >>> import numpy as np
        >>> import tribochaos as tc
        >>> ds = tc.Model().map(zeta_k=np.linspace(3, 5, 8), h1=[0.5, 1.0, 1.5])
        >>> ds.lyapunov.dims, ds.lyapunov.shape
        (('h1', 'zeta_k'), (3, 8))
        """
        values, given = self._parted(axes)
        if not given:
            raise ValueError("a map needs an axis: give an array for at least one parameter, or call point")
        request = self._request(values)
        for name, axis in given.items():
            add_axis(request, name, axis)
        return dataset(_ran(request, quantities, True, store, force, alone, progress))

    def points(
        self,
        table: pd.DataFrame | Mapping[str, npt.ArrayLike],
        *,
        quantities: Sequence[str] | None = None,
        store: str | os.PathLike[str] | None = None,
        force: bool = False,
        alone: bool = False,
        progress: Progress = None,
        **values: float,
    ) -> pd.DataFrame:
        """Measure points one by one: a row in, a row out.

        Parameters
        ----------
        table : pandas.DataFrame or mapping of array_like, shape (n,)
            A column for each parameter or quantity of the machine that varies, with its name.
        quantities, store, force, alone, progress : optional
            As in :meth:`map`; by default the exponent with its error, the period, the class, the status and the
            backend, and more with heat or wear.
        **values : float
            What all points have in common, if it is not the model's.

        Returns
        -------
        pandas.DataFrame
            With the index of ``table``, its columns, and those of the quantities. Codes are categories with names.

        Raises
        ------
        ValueError
            If a column is unknown or not of numbers, or a value is NaN or out of its range: all faults are named, with
            rows counted from 1.
        """
        import pandas as pd

        if not isinstance(table, (pd.DataFrame, Mapping)):
            raise ValueError(f"a list of points is a DataFrame or a mapping of arrays, and not {type(table).__name__}")
        if not isinstance(table, pd.DataFrame):
            for name, column in table.items():
                refuse_masked(f"the column {name}", column)
        # columns with an index are brought into line by it
        frame = table if isinstance(table, pd.DataFrame) else pd.DataFrame(dict(table))
        if not frame.columns.is_unique:
            raise ValueError("two columns have one name: leave one of them out")
        for name in frame.columns:
            if not isinstance(name, str):
                raise ValueError(f"the column {name!r} has no name: name it after a parameter")
            check_name(name)
            if name in values:
                raise ValueError(f"{name} is a column, and set to a value as well: leave one of the two out")
            if frame[name].dtype.kind not in "fiu":
                raise ValueError(f"the column {name} has the type {frame[name].dtype}: numbers are needed")
        rows = np.ascontiguousarray(frame.to_numpy(dtype=np.float64))
        request = self._request(self._set(values, without=list(frame.columns)))
        request.points([str(name) for name in frame.columns], rows)
        return as_table(_ran(request, quantities, False, store, force, alone, progress), frame.index)

    def point(self, *, progress: Progress = None, **values: float) -> Point:
        """Measure one point.

        Parameters
        ----------
        progress : bool or callable, optional
            As in :meth:`map`.
        **values : float
            Values that are not the model's.

        Returns
        -------
        Point
            With the attributes ``lyapunov``, ``lyapunov_error``, ``class_``, ``period`` and others. It prints well.

        Examples
        --------
        >>> import tribochaos as tc
        >>> tc.Model(h1=0.5).point(zeta_k=2.0).period
        1
        """
        request = self._request(self._set(values), "point")
        _warn(request)
        with observed(progress, "point") as observer:
            return Point._from_json(_native.point(request, observer))

    def trajectory(self, *, periods: int = 30, samples: int = 128, **values: float) -> xr.Dataset:
        """Follow a point over time, from its initial state, by the scheme ``radau`` in f64.

        Parameters
        ----------
        periods : int, optional
            Forcing periods that are followed.
        samples : int, optional
            Samples in each period, from 4 to 4096; at most a million in all.
        **values : float
            Values that are not the model's.

        Returns
        -------
        xarray.Dataset
            Over the dimension ``tau``: ``x`` and ``y``, angle and speed of the bush; ``v``, the sliding speed; ``p``, the
            contact pressure, which is 1 without heat and wear and 0 after contact is lost; ``u_w``, the wear;
            ``theta``, the temperature of the surface. All are dimensionless. For a machine, the attributes ``scale_time``,
            ``scale_pressure`` and others lead to SI units. ``attrs["status"]`` tells how it ended: ``ok``, ``runaway`` or
            ``under_resolved``.
        """
        samples = whole("samples", samples, 4, 4096)
        periods = whole("periods", periods, 1, _MOST_SAMPLES // samples)
        own = ("scheme", "backend", "precision", "adapter")
        request = self._request(self._set(values), "trajectory", without=own)
        _warn(request)
        columns, end = _native.trajectory(request, periods, samples)
        tau = ("tau", columns.pop("tau"), {"long_name": "time", "units": "tau"})
        variables = variables_of(**{name: ("tau", column) for name, column in columns.items()})
        ended = json.loads(end)
        scales = ended.pop("scales") or {}
        attrs = {name: value for name, value in ended.items() if value is not None}
        attrs.update({f"scale_{name}": value for name, value in scales.items()})
        return of_analysis("trajectory", request, variables, {"tau": tau}, attrs)

    def section(self, *, points: int = 100_000, progress: Progress = None, **values: float) -> xr.Dataset:
        """Compute the stroboscopic section of an attractor: states at drive phase 0.

        They come after 500 forcing periods, unless the model says otherwise. How many periods are measured follows from
        ``points``, whatever the model's ``periods``.

        Parameters
        ----------
        points : int, optional
            Number of states. They come from up to 2048 orbits that begin within 0.001 of (x0, y0).
        progress : bool or callable, optional
            As in :meth:`map`.
        **values : float
            Values that are not the model's.

        Returns
        -------
        xarray.Dataset
            ``x`` and ``y`` over the dimension ``point``. ``attrs["runaways"]`` is the number of orbits that ran away or
            were given up.

        Raises
        ------
        ValueError
            With wear, which leaves no attractor.
        """
        points = whole("points", points, 1, 200_000_000)
        request = self._request(self._set(values), "section")
        _warn(request)
        with observed(progress, "section") as observer:
            x, y, runaways, orbits = _native.section(request, points, observer)
        attrs = {"orbits": orbits, "runaways": runaways}
        return of_analysis("section", request, variables_of(x=("point", x), y=("point", y)), {}, attrs)

    def bifurcation(
        self,
        *,
        starts: Sequence[tuple[float, float]] | None = None,
        follow: Literal["up", "down"] | None = None,
        progress: Progress = None,
        **axis: Axis | float,
    ) -> xr.Dataset:
        """Compute stroboscopic states over one parameter: the bifurcation diagram.

        Parameters
        ----------
        starts : sequence of (x, y), optional
            Initial states, in place of the model's: (x0, y0), and others with ``initial_states``.
        follow : {"up", "down"}, optional
            Begin at each value with the states at the next lower, or next higher, value. Where the two differ,
            attractors coexist.
        progress : bool or callable, optional
            As in :meth:`map`.
        **axis : array_like, shape (n,), or str, or float
            One axis, as in :meth:`map`, and values that are not the model's.

        Returns
        -------
        xarray.Dataset
            ``x`` and ``y`` with a row for each value and a column for each ``state``: 200 states of each initial state
            after 300 forcing periods, unless the model says otherwise. Rows with fewer states end with NaN.
        """
        if follow not in (None, "up", "down"):
            raise ValueError(f"follow = {follow!r}: up and down are the directions")
        values, given = self._parted(axis)
        name, axis_values = only(given, "a bifurcation diagram")
        request = self._request(values, "bifurcation")
        add_axis(request, name, axis_values)
        _warn(request)
        with observed(progress, "bifurcation") as observer:
            found = _native.bifurcation(request, states(starts), follow, observer)
        along, labels, x, y, runaways = found
        coords = {name: (name, along, json.loads(labels))}
        dims = (name, "state")
        attrs: dict[str, Any] = {"runaways": runaways}
        if starts is not None:
            attrs["starts"] = np.asarray(states(starts)).ravel()
        if follow is not None:
            attrs["follow"] = follow
        return of_analysis("bifurcation", request, variables_of(x=(dims, x), y=(dims, y)), coords, attrs)

    def onset(
        self,
        name: str,
        /,
        *,
        within: tuple[float, float] | None = None,
        starts: Sequence[tuple[float, float]] | None = None,
        spacing: float | None = None,
        progress: Progress = None,
        **values: float,
    ) -> Onset:
        """Find where chaos begins and where it ends along a parameter.

        A value counts as chaotic if the exponent is above 0.005 over 100 periods after 380, and the motion is chaotic
        over 2000 periods, too.

        Parameters
        ----------
        name : str
            The parameter, such as ``"zeta_k"``.
        within : (low, high), optional
            The range that is searched; (0, 12) for ``zeta_k``, and needed for others.
        starts : sequence of (x, y), optional
            Initial states, any of which may lead to chaos. By default they are the model's, if it has x0, y0 or
            ``initial_states``, and else (0.1, 0), (1, 0) and (-1, 0).
        spacing : float, optional
            The distance of the values that are tried; 0.0025 for ``zeta_k``, and about a thousandth of the range for
            others.
        progress : bool or callable, optional
            As in :meth:`map`.
        **values : float
            Values that are not the model's.

        Returns
        -------
        Onset
        """
        check_name(name)
        if name in values:
            raise ValueError(f"{name} is searched, and set to a value as well: leave one of the two out")
        if within is None and name != "zeta_k":
            raise ValueError(f"the search along {name} needs a range: give within=(low, high)")
        low, high = (0.0, 12.0) if within is None else range_of(within)
        own = self._set(values, without=(name,))
        request = self._request(own, "point")
        request.axis_text(name, f"{low!r}:{high!r}:2")
        _warn(request)
        is_chosen = bool({"x0", "y0"} & own.keys()) or "initial_states" in self._settings or self._base == "paper"
        distance = None if spacing is None else number("spacing", spacing)
        with observed(progress, "onset") as observer:
            return Onset._from_json(_native.onset(request, states(starts), is_chosen, distance, observer))

    def melnikov(
        self,
        *,
        along: str | None = None,
        within: tuple[float, float] | None = None,
        samples: int = 512,
        **values: float,
    ) -> Melnikov:
        """Evaluate Mel'nikov's function of the homoclinic orbit (section 4 of the paper).

        Parameters
        ----------
        along : str, optional
            A parameter along which it is searched where the function begins or ceases to change sign.
        within : (low, high), optional
            The range of that search; (0, 20) by default, or the part of it that the parameter may have.
        samples : int, optional
            Samples of the function over one forcing period.
        **values : float
            Values that are not the model's.

        Returns
        -------
        Melnikov

        Raises
        ------
        ValueError
            With heat or wear, or for b <= 0, where there is no homoclinic orbit.
        """
        samples = whole("samples", samples, 1, _MOST_SAMPLES)
        if within is not None and along is None:
            raise ValueError("within is the range of a search: give along, too")
        if along is not None:
            check_name(along)
        request = self._request(self._set(values))
        tau_0, function, rest = _native.melnikov(request, samples)
        threshold = None
        if along is not None:
            ends = None if within is None else range_of(within)
            threshold = Threshold(along, *_native.melnikov_threshold(request, along, ends))
        return Melnikov(tau_0, function, **json.loads(rest), threshold=threshold)

    def _request(
        self, values: Mapping[str, float], analysis: str | None = None, without: Sequence[str] = ()
    ) -> _native.Request:
        """A request with the model's base and settings and the given values; other settings are those of the analysis."""
        request = _native.Request(analysis)
        if isinstance(self._base, Machine):
            request.machine(self._base.to_toml())
        elif isinstance(self._base, str):
            request.preset(self._base)
        elif self._base is not None:
            raise ValueError(f"a model begins with the name of a preset or a Machine, and not with {self._base!r}")
        set_all(request, {name: value for name, value in self._settings.items() if name not in without})
        for name, value in values.items():
            try:
                request.set(name, value)
            except ValueError as error:
                raise ValueError(with_setting(name, str(error))) from None
        return request

    def _set(self, values: Mapping[str, float], without: Sequence[str] = ()) -> dict[str, float]:
        """The model's values with others in their place, and without those that vary."""
        own = {**self._values, **{name: number(name, value) for name, value in values.items()}}
        return {name: value for name, value in own.items() if name not in without}

    def _parted(self, keywords: Mapping[str, Any]) -> tuple[dict[str, float], dict[str, Any]]:
        """Values and axes among keywords: what has no dimension is a value."""
        axes = {name: value for name, value in keywords.items() if isinstance(value, str) or np.ndim(value) > 0}
        values = {name: value for name, value in keywords.items() if name not in axes}
        return self._set(values, without=tuple(axes)), axes


def _ran(
    request: _native.Request,
    quantities: Sequence[str] | None,
    as_map: bool,
    store: str | os.PathLike[str] | None,
    force: bool,
    alone: bool,
    progress: Progress,
) -> dict[str, Any]:
    """Run a design, and tell how it ended."""
    names = named(quantities)
    path = None if store is None else Path(store)
    if path is not None and path.suffix != ".zarr":
        raise ValueError(f"{path} is no store: its name should end in .zarr")
    _warn(request)
    with observed(progress, "map" if as_map else "points") as observer:
        arrays = _native.run(request, names, as_map, observer, path, force, alone)
    if arrays["note"] is not None:
        warnings.warn(arrays["note"], TribochaosWarning, stacklevel=3)
    stopped: BaseException | None = arrays["stopped"]
    if stopped is None:
        return arrays
    part = f"{arrays['finished']:.0%} of the units"
    # where nothing or all is finished there is nothing to save, and a loop of short runs is to stop
    if not isinstance(stopped, KeyboardInterrupt) or (path is None and arrays["finished"] in (0.0, 1.0)):
        raise stopped
    if path is not None:
        raise KeyboardInterrupt(f"{part} are finished and kept in {path}: the same call goes on from there") from None
    warnings.warn(f"stopped by Ctrl-C: {part} are finished, and the rest is NaN", StoppedWarning, stacklevel=3)
    return arrays


def _warn(request: _native.Request) -> None:
    for text in request.warnings():
        warnings.warn(text, TribochaosWarning, stacklevel=3)
