"""What single calls return: a point, an onset, Mel'nikov's function, devices."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Iterator, Mapping

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

NAN = float("nan")


@dataclass(frozen=True, repr=False)
class Point:
    """Everything that is measured of one point.

    All quantities are dimensionless, and numbers that do not apply are NaN. ``point["lyapunov"]`` is the same as
    ``point.lyapunov``; the quantity ``class`` is the attribute ``class_``, since ``class`` is a word of Python.

    Attributes
    ----------
    parameters : mapping
        The value of every parameter, by its name.
    settings : mapping
        How it was integrated, and what was sampled.
    status : str
        ``ok``; ``runaway`` if the orbit ran away, at ``runaway_time``; ``under_resolved`` if no scheme could follow
        it. Without ``ok`` nothing else is measured.
    class_ : str or None
        ``chaotic``, ``regular``, ``quasi_periodic``, ``undecided`` or ``unstable``; None where the motion is
        transient, since the contact wears.
    lyapunov, lyapunov_error : float
        The maximal Lyapunov exponent but for the trivial zero, per unit of tau, and its standard error, which
        contains ``scheme_error``, the share of the integration.
    lyapunov_second, divergence : float
        The second exponent, and the mean divergence, which is the sum of the two.
    period : int or None
        After how many forcing periods the motion repeats; None if it does not, or if that is not certain.
    backend : str
        Where it was integrated: ``cpu_f64``, ``cpu_f32`` or ``gpu_f32``.
    """

    parameters: Mapping[str, float]
    settings: Mapping[str, Any]
    status: str
    class_: str | None = None
    lyapunov: float = NAN
    lyapunov_error: float = NAN
    scheme_error: float = NAN
    lyapunov_second: float = NAN
    divergence: float = NAN
    lyapunov_birkhoff: float = NAN
    lyapunov_interval: float = NAN
    period: int | None = None
    x: float = NAN
    y: float = NAN
    x_min: float = NAN
    x_max: float = NAN
    chaotic_fraction: float = NAN
    attractors: int | None = None
    unsettled_fraction: float = NAN
    contact_status: str | None = None
    contact_time: float = NAN
    peak_pressure: float = NAN
    peak_pressure_time: float = NAN
    final_wear: float = NAN
    peak_temperature: float = NAN
    runaway_time: float = NAN
    integrated_periods: int | None = None
    backend: str | None = None

    @classmethod
    def _from_json(cls, text: str) -> Point:
        found = json.loads(text)
        measured: dict[str, Any] = {}
        for name, value in found["measured"].items():
            if name in ("period", "attractors", "integrated_periods"):
                measured[name] = None if value is None else int(value)
            elif name in ("class", "status", "contact_status", "backend"):
                measured["class_" if name == "class" else name] = value
            else:
                measured[name] = NAN if value is None else float(value)
        parameters = {name: _number(value) for name, value in found["parameters"].items()}
        return cls(parameters, found["settings"], **measured)

    def __getitem__(self, name: str) -> Any:
        attribute = "class_" if name == "class" else name
        if name.startswith("_") or attribute not in self.__dataclass_fields__:
            raise KeyError(name)
        return getattr(self, attribute)

    def keys(self) -> Iterator[str]:
        """Names of all quantities, so that ``dict(point)`` works."""
        names = (name for name in self.__dataclass_fields__ if name not in ("parameters", "settings"))
        return ("class" if name == "class_" else name for name in names)

    def __repr__(self) -> str:
        varied = ", ".join(f"{name}={value:g}" for name, value in self.parameters.items())
        if self.status == "runaway":
            motion = f"ran away at tau = {self.runaway_time:.3f}"
        elif self.status != "ok":
            motion = "under-resolved, nothing was measured"
        else:
            error = f" +- {self.lyapunov_error:.6f}" if self.lyapunov_error == self.lyapunov_error else " (finite time)"
            motion = "\n".join(
                line
                for line in (
                    f"class               {self.class_ or 'none: the motion is transient'}",
                    f"maximal exponent    {self.lyapunov:.6f}{error} per tau",
                    _line("second exponent    ", self.lyapunov_second),
                    _line("mean divergence    ", self.divergence),
                    f"period              {self.period or 'none found'}",
                    f"x, y                {self.x:.9f}, {self.y:.9f} (last stroboscopic state)",
                    f"extremes of x       {self.x_min:.6f}, {self.x_max:.6f}",
                    _line("contact lost at    ", self.contact_time),
                    f"integrated on       {self.backend}",
                )
                if line
            )
        return f"Point({varied})\n{motion}"


def _line(words: str, value: float) -> str:
    return f"{words} {value:.6f}" if value == value else ""


def _number(value: float | None) -> float:
    # JSON has no infinity; the only parameter that may be infinite is ramp_rate
    return float("inf") if value is None else float(value)


@dataclass(frozen=True)
class Bound:
    """Where chaos begins or ends.

    Attributes
    ----------
    value : float
        The first value with lasting chaos, in the unit of the parameter.
    lyapunov, lyapunov_error : float
        The exponent there over 100 forcing periods, per unit of tau.
    confirmed, confirmed_error : float
        The exponent there over 2000 forcing periods.
    initial_state : tuple of float
        The (x, y) that leads to chaos.
    is_beyond : bool
        Whether this is the end of the range, so that chaos may go on beyond it.
    """

    value: float
    lyapunov: float
    lyapunov_error: float
    confirmed: float
    confirmed_error: float
    initial_state: tuple[float, float]
    is_beyond: bool


@dataclass(frozen=True)
class Onset:
    """Where chaos begins and ends along a parameter.

    Attributes
    ----------
    name, units : str
        The parameter, and its unit.
    onset, end : Bound or None
        The least and the greatest value with lasting chaos; None if there is none.
    spacing : float
        The distance of the values that were tried: the error of both.
    unmeasured : int
        Points before them that ran away or are under-resolved.
    """

    name: str
    units: str
    onset: Bound | None
    end: Bound | None
    spacing: float
    unmeasured: int

    @classmethod
    def _from_json(cls, text: str) -> Onset:
        found = json.loads(text)

        def bound(row: dict[str, Any]) -> Bound | None:
            at = row["found"]
            if at is None:
                return None
            state = (at["initial_state"][0], at["initial_state"][1])
            numbers = (at["value"], at["lyapunov"], at["lyapunov_error"], at["confirmed"], at["confirmed_error"])
            return Bound(*numbers, state, row["is_beyond"])

        return cls(
            found["coordinate"],
            found["units"],
            bound(found["onset"]),
            bound(found["end"]),
            found["spacing"],
            found["onset"]["unmeasured"],
        )

    def __str__(self) -> str:
        if self.onset is None or self.end is None:
            return f"no chaos along {self.name}"
        begins = "is there at the lowest value" if self.onset.is_beyond else "begins at"
        ends = "is there at the highest value" if self.end.is_beyond else "ends at"
        return (
            f"chaos {begins} {self.name} = {self.onset.value:g} +- {self.spacing:g}, "
            f"and {ends} {self.end.value:g} +- {self.spacing:g}"
        )


@dataclass(frozen=True)
class Threshold:
    """Where Mel'nikov's function begins or ceases to change sign along a parameter.

    Attributes
    ----------
    name : str
        The parameter.
    kind : str
        ``begins``, ``ceases``, ``always`` or ``never``.
    value : float or None
        Where, for the first two.
    """

    name: str
    kind: str
    value: float | None


@dataclass(frozen=True)
class Melnikov:
    """Mel'nikov's function of the homoclinic orbit (section 4 of the paper).

    A change of sign is a necessary condition for chaos of small perturbations, and not a sufficient one.

    Attributes
    ----------
    tau_0, values : array, shape (samples,)
        Arguments over one forcing period, and the values M(tau_0).
    minimum, minimum_at, maximum, maximum_at : float
        The extremes, and where they are.
    changes_sign : bool
        Whether the function does.
    threshold : Threshold or None
        Where it begins or ceases to do so, if that was asked for.
    """

    tau_0: npt.NDArray[np.float64] = field(repr=False)
    values: npt.NDArray[np.float64] = field(repr=False)
    minimum: float
    minimum_at: float
    maximum: float
    maximum_at: float
    changes_sign: bool
    threshold: Threshold | None = None


@dataclass(frozen=True)
class Devices:
    """What can compute on a machine.

    Attributes
    ----------
    cpu : str
        The CPU in words.
    instruction_sets : tuple of str
        Those that are built in and that the CPU has, the one that is used first.
    adapters : tuple of str
        GPU adapters, hardware first.
    auto : str
        What ``backend="auto"`` takes.
    """

    cpu: str
    instruction_sets: tuple[str, ...]
    adapters: tuple[str, ...]
    auto: str
