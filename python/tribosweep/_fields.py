"""Fields on the grid."""

from __future__ import annotations

from typing import Any, Mapping

UNITS = {
    "x": "m", "y": "m", "pressure": "Pa", "traction_x": "Pa", "traction_y": "Pa",
    "gap": "m", "slip_x": "m", "slip_y": "m", "friction_work": "J/m²",
    "wear_depth": "m", "state": "",
}  # fmt: skip
MEANINGS = {
    "x": "centres of the elements along x",
    "y": "centres of the elements along y",
    "pressure": "pressure, positive in compression",
    "traction_x": "traction along x, of the punch on the foundation",
    "traction_y": "traction along y, of the punch on the foundation",
    "gap": "gap between the punch and the foundation",
    "slip_x": "slip along x of the foundation relative to the punch since the increment before",
    "slip_y": "slip along y of the foundation relative to the punch since the increment before",
    "friction_work": "energy lost to friction over the area since the increment before",
    "wear_depth": "depth that both surfaces have lost together along the path",
    "state": "0 outside the sole, 1 open, 2 stick, 3 slip",
}
GRIDS = [name for name in UNITS if name not in ("x", "y")]


def dataset(arrays: Mapping[str, Any], attributes: Mapping[str, Any]) -> Any:
    """Returns fields as an xarray.Dataset over y and x, or over increment, y and x, with units."""
    try:
        import xarray
    except ImportError:
        raise ImportError(
            "fields as a Dataset need xarray: pip install xarray; arrays() needs nothing"
        ) from None
    described = {
        name: {"units": UNITS[name], "long_name": MEANINGS[name]} for name in UNITS if UNITS[name]
    }
    described["state"] = {"flag_values": [0, 1, 2, 3], "flag_meanings": "outside open stick slip"}
    axes = ("increment", "y", "x")[-arrays["pressure"].ndim :]
    # Only a scene that wears has a depth of wear.
    present = [name for name in GRIDS if name in arrays]
    variables = {name: (axes, arrays[name], described[name]) for name in present}
    coordinates = {name: (name, arrays[name], described[name]) for name in ("x", "y")}
    if "increment" in axes:
        number = {"long_name": "number of the increment along the path"}
        numbers = range(1, 1 + len(arrays["pressure"]))
        coordinates["increment"] = ("increment", list(numbers), number)
    return xarray.Dataset(variables, coordinates, dict(attributes))
