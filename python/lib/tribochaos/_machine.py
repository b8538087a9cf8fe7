"""A machine in SI units."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Mapping

from . import _native


class Machine:
    """A machine in SI units, from which the dimensionless parameters follow (table 1 of the paper).

    Make one by :meth:`from_toml`, and give it to :class:`Model`. Its quantities can then be set or varied by their
    names, such as ``shaft_speed_amplitude``, and the parameters that follow from it cannot.
    """

    def __init__(self, text: str) -> None:
        found: dict[str, Any] = json.loads(_native.machine(text))
        self._text = text
        self._found = found

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Machine:
        """Read a machine from a file.

        Parameters
        ----------
        path : path
            A file as :meth:`template` gives it.

        Raises
        ------
        ValueError
            If a quantity is missing, unknown or out of its range.
        """
        return cls(Path(path).read_text(encoding="utf-8"))

    @staticmethod
    def template() -> str:
        """Return a complete file with comments: change its numbers, and read it by :meth:`from_toml`."""
        return _native.machine_template()

    @property
    def quantities(self) -> Mapping[str, tuple[float, str]]:
        """Values and units of the machine's quantities, by their names."""
        return {name: (row["value"], row["units"]) for name, row in self._found["quantities"].items()}

    @property
    def parameters(self) -> Mapping[str, float]:
        """The dimensionless parameters, by their names; those that do not follow from the machine have their defaults."""
        return {name: float(value) for name, value in self._found["parameters"].items()}

    @property
    def scales(self) -> Mapping[str, float]:
        """What a dimensionless time, speed, pressure, length and temperature are multiplied by to be in SI units."""
        return dict(self._found["scales"])

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is not plausible about the machine."""
        return tuple(self._found["warnings"])

    def to_toml(self) -> str:
        """Return the text from which the machine was made."""
        return self._text

    def __repr__(self) -> str:
        rows = (f"  {name} = {value:.6g} {units}" for name, (value, units) in self.quantities.items())
        return "Machine\n" + "\n".join(rows)
