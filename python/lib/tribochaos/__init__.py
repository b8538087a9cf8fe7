"""Chaos-threshold maps of a rubbing, heating, wearing oscillator.

The system is the bush-shaft system of J. Awrejcewicz and Y. Pyryev, "Regular and chaotic motion of a bush-shaft
system with tribological processes", Mathematical Problems in Engineering 2006, article 86594. In dimensionless form

    x' = y
    y' = x - b x^3 + epsilon p F(v) - epsilon h1 y        v = omega_k + zeta_k sin(omega_0 tau) - y
    F(v) = f_0 s(v) - alpha v + beta v^3                  s = sgn, made smooth for |v| < epsilon_0

Begin with :class:`Model`:

>>> import tribochaos as tc
>>> model = tc.Model(h1=0.5)
>>> point = model.point(zeta_k=2.0)
>>> point.class_
'regular'

What there is besides:

- :class:`Machine`: a machine in SI units, which gives the parameters;
- :func:`open`: a store that the program or this package has written;
- :func:`devices`: what can compute here;
- :data:`PARAMETERS` and :data:`QUANTITIES`: what can be set, and what is measured;
- :data:`CHAOTIC`, :data:`REGULAR`, :data:`QUASI_PERIODIC`, :data:`UNDECIDED`, :data:`UNSTABLE`: the codes in
  ``ds["class"]``; :data:`NO_CODE` where there is none;
- ``ds.tc.plot()`` on every dataset of this package.
"""

import os as _os
import tempfile as _tempfile

# graphics drivers look for the folder of a desktop session, and print an error where there is none
if _os.name == "posix":
    _os.environ.setdefault("XDG_RUNTIME_DIR", _tempfile.gettempdir())

from ._datasets import open, register_if_loaded
from ._machine import Machine
from ._model import Model
from ._results import Devices, Melnikov, Onset, Point, Threshold
from ._tables import (
    CHAOTIC,
    CLASSES,
    NO_CODE,
    PARAMETERS,
    QUANTITIES,
    QUASI_PERIODIC,
    REGULAR,
    UNDECIDED,
    UNSTABLE,
    ParameterInfo,
    QuantityInfo,
    __version__,
    devices,
)
from ._warnings import StoppedWarning, TribochaosWarning

register_if_loaded()

__all__ = [
    "CHAOTIC",
    "CLASSES",
    "NO_CODE",
    "PARAMETERS",
    "QUANTITIES",
    "QUASI_PERIODIC",
    "REGULAR",
    "UNDECIDED",
    "UNSTABLE",
    "Devices",
    "Machine",
    "Melnikov",
    "Model",
    "Onset",
    "ParameterInfo",
    "Point",
    "QuantityInfo",
    "StoppedWarning",
    "Threshold",
    "TribochaosWarning",
    "__version__",
    "devices",
    "open",
]
