"""Opens the store of a list of points that tests/xarray.rs wrote; notices a changed bit of its values."""

import pathlib
import sys
import warnings

import numpy as np
import xarray as xr

warnings.simplefilter("error")
path = pathlib.Path(sys.argv[1])
data = xr.open_zarr(path)

assert dict(data.sizes) == {"point": 34}, data.sizes
assert set(data.coords) == {"zeta_k", "h1"}, data.coords
assert data.h1.dims == data.lyapunov.dims == ("point",)
np.testing.assert_array_equal(data.zeta_k, np.arange(34) / 10)
np.testing.assert_array_equal(data.lyapunov, -np.arange(34) / 8)
assert set(data.data_vars) == {"lyapunov", "status"}, data.data_vars

chunk = path / "lyapunov" / "c" / "1"
values = bytearray(chunk.read_bytes())
values[9] ^= 1
chunk.write_bytes(values)
try:
    xr.open_zarr(path).lyapunov.load()
except ValueError as error:
    assert "checksum" in str(error), error
else:
    raise AssertionError("a changed bit was not noticed")
