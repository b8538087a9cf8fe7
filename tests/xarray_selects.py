"""Every value of an axis is selected by the decimal that a user types."""

import sys

import xarray as xr

data = xr.open_zarr(sys.argv[1])
assert dict(data.sizes) == {"zeta_k": 201, "h1": 301}, data.sizes
for i in range(301):
    typed = float(f"{5 * i}e-3")
    assert data.sel(h1=typed).h1 == typed
for i in range(201):
    typed = float(f"{300 + i}e-2")
    assert data.sel(zeta_k=typed).zeta_k == typed
assert data.sel(h1=0.3, zeta_k=3.81).lyapunov.shape == ()
