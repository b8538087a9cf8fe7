"""Import this module to have ``ds.tc`` on datasets that xarray opens by itself.

Datasets of this package have it anyway. Without them, ``import tribochaos`` does not load xarray, which takes a while.
"""

from ._plot import Accessor

__all__ = ["Accessor"]
