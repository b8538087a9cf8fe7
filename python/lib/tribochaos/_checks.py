"""What a user gives, checked and put into a request."""

from __future__ import annotations

import difflib
import json
from typing import Any, Mapping

import numpy as np

from . import _native
from ._tables import PARAMETERS

SETTINGS = tuple(_native.settings())

# of methods
KEYWORDS = ("quantities", "store", "force", "alone", "progress", "points", "samples", "starts", "follow", "within")


def set_all(request: _native.Request, settings: Mapping[str, Any]) -> None:
    """Put settings into a request."""
    for name, value in settings.items():
        try:
            request.setting(name, json.dumps(value, default=_plain, allow_nan=False))
        except ValueError as error:
            words = str(error)
            raise ValueError(words if name in words else f"the setting {name} = {value!r}: {words}") from None


def add_axis(request: _native.Request, name: str, values: Any) -> None:
    """Put an axis into a request."""
    check_name(name)
    if isinstance(values, str):
        request.axis_text(name, values)
        return
    refuse_masked(f"the axis of {name}", values)
    array = np.asarray(values)
    if array.ndim != 1:
        raise ValueError(f"the axis of {name} has the shape {array.shape}: an array of one dimension is needed")
    if array.size > 0 and array.dtype.kind not in "fiu":
        raise ValueError(f"the axis of {name} has the type {array.dtype}: numbers are needed")
    request.axis(name, np.ascontiguousarray(array, dtype=np.float64))


def only(axes: Mapping[str, Any], what: str) -> tuple[str, Any]:
    """The one axis, with its name."""
    if len(axes) != 1:
        names = f": {', '.join(axes)}" if axes else ""
        raise ValueError(f"{what} needs one axis, and there are {len(axes)}{names}")
    return next(iter(axes.items()))


def range_of(within: Any) -> tuple[float, float]:
    """The ends of a range."""
    low, high = within
    return (number("within", low), number("within", high))


def states(starts: Any) -> list[tuple[float, float]] | None:
    """Initial states as pairs."""
    if starts is None:
        return None
    pairs = np.asarray(starts)
    if pairs.size and (pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "fiu"):
        raise ValueError(f"starts = {starts!r}: a list of pairs (x, y) is needed, such as [(0.1, 0.0)]")
    return [(float(x), float(y)) for x, y in pairs.reshape(-1, 2)]


def number(name: str, value: Any) -> float:
    """A number of any kind, but no truth value."""
    if not isinstance(value, (str, bytes, bool)):
        array = np.asarray(value)
        if array.ndim == 0 and array.dtype.kind in "fiu":
            return float(array)
    raise ValueError(with_setting(name, f"{name} = {value!r} is no number"))


def whole(name: str, value: Any, low: int, high: int) -> int:
    """A whole number within its range."""
    given = number(name, value)
    if given != int(given) or not low <= given <= high:
        raise ValueError(f"{name} = {value} is out of range: it must be a whole number from {low} to {high}")
    return int(given)


def refuse_masked(what: str, values: Any) -> None:
    """Refuse arrays of which values are masked: numpy would compute with what is behind the mask."""
    if np.ma.isMaskedArray(values) and np.ma.is_masked(values):
        raise ValueError(f"{what} has masked values: leave them out")


def check_name(name: str) -> None:
    """Check that a name is one of a parameter or a quantity of a machine."""
    try:
        _native.check_name(name)
    except ValueError as error:
        raise ValueError(with_setting(name, str(error))) from None


def _plain(value: Any) -> Any:
    """A setting of a numpy type as one that JSON has."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise ValueError(f"{value!r} is no value of a setting")


def with_setting(name: str, message: str) -> str:
    """A message on a name that is unknown among the parameters; it may be a setting that is misspelt."""
    if name in PARAMETERS or "did you mean" in message:
        return message
    near = difflib.get_close_matches(name, [*SETTINGS, *KEYWORDS], n=1, cutoff=0.75)
    return f"{message}; or did you mean {near[0]}?" if near else message
