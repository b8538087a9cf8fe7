"""Opens the store of a machine that tests/xarray.rs wrote: units of the axes, and scales that lead to SI units."""

import sys
import warnings

import numpy as np
import xarray as xr

warnings.simplefilter("error")
data = xr.open_zarr(sys.argv[1])

assert dict(data.sizes) == {"damping": 2, "interference": 3}, data.sizes
assert set(data.coords) == {"damping", "interference"}, data.coords
np.testing.assert_array_equal(data.damping, [0, 778])
assert data.damping.attrs["units"] == "N s/m²" and data.interference.attrs["units"] == "m"
assert "[machine]" in data.attrs["experiment"]

units = {"time_scale": "s", "temperature_scale": "K", "pressure_scale": "Pa", "length_scale": "m"}
assert set(units) <= set(data.data_vars), list(data.data_vars)
for name, unit in units.items():
    assert data[name].dims == ("damping", "interference") and data[name].attrs["units"] == unit
    assert np.isfinite(data[name]).all()
np.testing.assert_allclose(data.length_scale[1], [1e-9, 2e-9, 3e-9])
np.testing.assert_allclose(data.pressure_scale[0, 2], 3 * 365384.615, rtol=1e-8)
assert "peak_pressure" in data.pressure_scale.attrs["long_name"]
