"""Opens the store that tests/xarray.rs wrote and checks labels, types and values."""

import sys
import warnings

import numpy as np
import xarray as xr

warnings.simplefilter("error")
data = xr.open_zarr(sys.argv[1])

assert dict(data.sizes) == {"x0": 5, "zeta_k": 7}, data.sizes
assert set(data.coords) == {"zeta_k", "x0"}, data.coords
assert len(data.data_vars) == 26, list(data.data_vars)
np.testing.assert_array_equal(data.zeta_k, np.linspace(0, 12, 7))
np.testing.assert_array_equal(data.x0, np.linspace(1, -1, 5))
assert data.zeta_k.attrs == {"long_name": "amplitude of the shaft's speed", "symbol": "ζₖ", "units": "1"}

assert data.attrs["format"] == "tribochaos results" and data.attrs["format_version"] == 2
assert data.attrs["program"].startswith("tribochaos ")
assert 'parameter = "zeta_k"' in data.attrs["experiment"]

exponent = data.lyapunov
assert exponent.dims == ("x0", "zeta_k") and exponent.dtype == np.float64
assert exponent.attrs["units"] == "1/tau" and "Lyapunov" in exponent.attrs["long_name"]
expected = -np.arange(35).reshape(5, 7) / 8
expected[:2] = np.nan  # the unit that was not written
expected[4, 6] = np.nan  # the runaway
np.testing.assert_array_equal(exponent, expected)
assert exponent.sel(x0=0, zeta_k=8) == -18 / 8

assert data.period.dtype == np.float32
np.testing.assert_array_equal(data.period[2], [4, np.nan, 4, np.nan, 4, np.nan, 4])
assert data.x.dims == data.x_min.dims == ("x0", "zeta_k") and data.x[2, 2] == 0.25

for name, meanings in {
    "contact_status": "held lost",
    "class": "chaotic regular quasi_periodic undecided unstable",
    "status": "ok runaway under_resolved",
    "backend": "cpu_f64 cpu_f32 gpu_f32",
}.items():
    codes = data[name]
    assert codes.dtype == np.uint8, (name, codes.dtype)
    assert codes.attrs["flag_meanings"] == meanings, codes.attrs
    assert list(codes.attrs["flag_values"]) == list(range(len(meanings.split())))
    assert (codes[:2] == 255).all()
assert data["class"][2, 3] == 1 and data["class"][4, 6] == 255
assert data.status[4, 6] == 1 and data.runaway_time[4, 6] == 100
assert data.backend[4, 6] == 2 and data.backend[4, 5] == 0
