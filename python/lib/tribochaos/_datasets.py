"""Results as datasets and tables with labels."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

from . import _native
from ._tables import NO_CODE, QUANTITIES

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# attributes of a store that say nothing about its results
_OF_STORES = ("coordinates", "files_crc32", "crc32")


def open(path: str | os.PathLike[str], quantities: Sequence[str] | None = None) -> xr.Dataset:
    """Read a store that the program or this package has written.

    Every value is checked against its checksum. ``xarray.open_zarr`` reads the same stores, piece by piece: use it for
    those that do not fit into memory.

    Parameters
    ----------
    path : path
        The folder ``NAME.zarr``.
    quantities : sequence of str, optional
        Names of the quantities to read; all that the store has by default.

    Returns
    -------
    xarray.Dataset
        As :meth:`Model.map` gives it, with a dimension for each axis; a list of points has the one dimension ``point``, and
        its columns are coordinates. Points that are not computed yet are NaN.

    Raises
    ------
    FileNotFoundError
        If there is no store at ``path``.
    ValueError
        If it is no store of tribochaos, was written by a newer version, is damaged, or lacks a quantity.
    """
    return dataset(_native.open(Path(path), named(quantities)))


def named(quantities: Sequence[str] | None) -> list[str] | None:
    """Names of quantities as a list."""
    if quantities is None:
        return None
    if isinstance(quantities, str) or not all(isinstance(name, str) for name in quantities):
        raise ValueError(f"quantities = {quantities!r}: a list of names is needed")
    return list(quantities)


def dataset(arrays: dict[str, Any]) -> xr.Dataset:
    """Make a Dataset from what the native part returns."""
    import xarray as xr

    register()

    def labelled(kind: str) -> dict[str, Any]:
        return {name: (tuple(dims), values, json.loads(attrs)) for name, (dims, values, attrs) in arrays[kind].items()}

    attrs = json.loads(arrays["attrs"])
    kept = {name: value for name, value in attrs.items() if name not in _OF_STORES}
    return xr.Dataset(labelled("variables"), labelled("coords"), kept)


_MEANINGS = {
    "x": "angle of the bush",
    "y": "angular speed of the bush",
    "v": "sliding speed",
    "p": "contact pressure",
    "u_w": "wear",
    "theta": "temperature of the contact surface",
}


def variables_of(**columns: tuple[Any, Any]) -> dict[str, Any]:
    """Variables of a motion with their labels, each from its dimensions and values."""
    return {
        name: (dims, values, {"long_name": _MEANINGS[name], "units": "1"}) for name, (dims, values) in columns.items()
    }


def of_analysis(
    kind: str, request: _native.Request, variables: dict[str, Any], coords: dict[str, Any], attrs: dict[str, Any]
) -> xr.Dataset:
    """Make the Dataset of an analysis, which tells its kind and its experiment."""
    import xarray as xr

    register()
    own = {"program": _native.program(), "experiment": request.toml(), "kind": kind}
    return xr.Dataset(variables, coords, {**own, **attrs})


def table(arrays: dict[str, Any], index: pd.Index[Any]) -> pd.DataFrame:
    """Make a DataFrame from what the native part returns for a list of points."""
    import pandas as pd

    columns: dict[str, Any] = {name: values for name, (_, values, _) in arrays["coords"].items()}
    for name, (_, values, _) in arrays["variables"].items():
        codes = QUANTITIES[name].codes if name in QUANTITIES else ()
        if codes:
            numbers = values.astype(np.int16)
            numbers[values == NO_CODE] = -1
            values = pd.Categorical.from_codes(numbers, pd.Index(codes))
        columns[name] = values
    return pd.DataFrame(columns, index=index)


def register_if_loaded() -> None:
    """Give datasets the accessor ``tc`` if xarray is loaded already; else the first dataset of this package does."""
    if "xarray" in sys.modules:
        register()


def register() -> None:
    """Give datasets the accessor ``tc``."""
    from . import _plot  # noqa: F401
