"""What there is: parameters, quantities, classes, devices."""

from __future__ import annotations

import json
from dataclasses import dataclass
from types import MappingProxyType
from typing import Mapping

from . import _native
from ._results import Devices


@dataclass(frozen=True)
class ParameterInfo:
    """A row of the table of parameters.

    Attributes
    ----------
    name, symbol, meaning : str
        The name in this package and in stores, the symbol in the paper, and what it is.
    default, low, high : float
        The value where none is set, and the range of what may be set, both ends included.
    source : str
        The equation of Awrejcewicz and Pyryev (2006) in which it enters.
    """

    name: str
    symbol: str
    meaning: str
    default: float
    low: float
    high: float
    source: str


@dataclass(frozen=True)
class QuantityInfo:
    """A row of the table of quantities.

    Attributes
    ----------
    name, long_name, units : str
        The name in datasets, what it is, and its unit: ``tau``, ``1/tau``, or ``1`` for a pure number.
    codes : tuple of str
        If the quantity is a code, the names that 0, 1, ... stand for; else empty.
    """

    name: str
    long_name: str
    units: str
    codes: tuple[str, ...]


def _parameters() -> Mapping[str, ParameterInfo]:
    rows = json.loads(_native.parameters())
    return MappingProxyType(
        {
            name: ParameterInfo(
                name,
                row["symbol"],
                row["meaning"],
                float(row["default"]),
                float(row["low"]),
                float(row["high"]),
                row["source"],
            )
            for name, row in rows.items()
        }
    )


def _quantities() -> Mapping[str, QuantityInfo]:
    rows = json.loads(_native.quantities())
    return MappingProxyType(
        {
            name: QuantityInfo(name, row["long_name"], row["units"], tuple(row.get("flag_meanings", "").split()))
            for name, row in rows.items()
        }
    )


PARAMETERS: Mapping[str, ParameterInfo] = _parameters()
"""The dimensionless parameters and components of the initial state, by their names."""

QUANTITIES: Mapping[str, QuantityInfo] = _quantities()
"""The quantities that are measured, by their names."""

CLASSES: tuple[str, ...] = tuple(_native.classes())
"""The names of the classes of motion, in the order of their codes."""

CHAOTIC, REGULAR, QUASI_PERIODIC, UNDECIDED, UNSTABLE = range(5)

NO_CODE = 255
"""The code of a point that is not computed, or to which the code does not apply."""

__version__: str = _native.program().split()[-1]


def devices() -> Devices:
    """Find what can compute on this machine.

    Returns
    -------
    Devices
        The CPU with its instruction sets, the GPU adapters, and what ``backend="auto"`` takes.
    """
    found = json.loads(_native.devices())
    return Devices(
        cpu=found["cpu"],
        instruction_sets=tuple(found["instruction_sets"]),
        adapters=tuple(found["adapters"]),
        auto=found["auto"],
    )
