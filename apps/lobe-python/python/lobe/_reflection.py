"""What surfaces reflect of light that comes evenly from everywhere."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, finite, numbers, whole

MAX_TABLE = 1024
"""Texels at most along a side of a table: above this it takes minutes, and linear interpolation gains nothing."""

PARAMETERS: dict[str, dict[str, tuple[float, float]]] = {
    "lambert": {"albedo": (0.0, 1.0)},
    "phong": {"exponent": (0.0, np.inf)},
    "ggx": {"alpha": (0.0, 1.0), "f0": (0.0, 1.0)},
}
"""The parameters of each reflectance function, and their ranges."""


def dfg(cos_view: npt.ArrayLike, alpha: npt.ArrayLike) -> Doubles:
    """The terms A and B of the split sum of GGX, by numerical integration: (..., 2) for arguments that broadcast to (...).

    Even light of radiance 1 is reflected by A F0 + B, where F0 is the reflectance along the normal. `cos_view` is the cosine of the
    angle between view and normal, 0 to 1; `alpha` the width of the slopes, 0 to 1, the square of the roughness.
    """
    cosines, widths = np.broadcast_arrays(_within(cos_view, "cos_view", 0.0, 1.0), _within(alpha, "alpha", 0.0, 1.0))
    rows = np.ascontiguousarray(np.stack([cosines.ravel(), widths.ravel()], axis=-1))
    return _lobe.dfg(rows).reshape((*cosines.shape, 2))


def dfg_table(size: int = 64) -> Doubles:
    """A and B of `dfg` as a table, (size, size, 2), as `lobe env dfg` writes it: at the center of texel (y, x) the cosine of the view is
    (x + ½)/size, and the roughness √alpha is (y + ½)/size."""
    return _lobe.dfg_table(whole(size, "size", 1, MAX_TABLE))


def directional_albedo(brdf: str, cos_view: npt.ArrayLike, **parameters: npt.ArrayLike) -> Doubles:
    """The share of light from one direction that a surface reflects: (...), what `lobe env ambient` calls reflectance.

    Under radiance L from everywhere the surface receives the irradiance π L and shows this times L. `brdf` is "lambert" with `albedo`,
    "phong" with `exponent`, or "ggx" with `alpha`, the width of the slopes, above 0, and `f0`, the reflectance along the normal.
    The cosine of the angle between view and normal, 0 to 1, and the parameters broadcast.
    """
    names = PARAMETERS.get(brdf) if isinstance(brdf, str) else None
    if names is None:
        raise ValueError(f"brdf: expected {', '.join(PARAMETERS)}, found {brdf!r}")
    if parameters.keys() != names.keys():
        raise TypeError(f"brdf {brdf}: expected {' and '.join(names)}, found {', '.join(parameters) or 'none'}")
    given = [_within(parameters[name], name, *bounds) for name, bounds in names.items()]
    if brdf == "ggx" and not np.all(given[0] > 0):
        raise ValueError("alpha: expected numbers above 0, found 0")
    cosines, *columns = np.broadcast_arrays(_within(cos_view, "cos_view", 0.0, 1.0), *given)
    rows = np.ascontiguousarray(np.stack([column.ravel() for column in columns], axis=-1))
    return _lobe.directional_albedo(brdf, np.ascontiguousarray(cosines.ravel()), rows).reshape(cosines.shape)


def _within(values: npt.ArrayLike, what: str, least: float, most: float) -> Doubles:
    array = finite(numbers(values, what).astype(np.float64, copy=False), what)
    if not np.all((array >= least) & (array <= most)):
        expected = f"{least:g} to {most:g}" if most < np.inf else f"{least:g} or more"
        found = array[(array < least) | (array > most)].flat[0]
        raise ValueError(f"{what}: expected numbers of {expected}, found {found}")
    return array
