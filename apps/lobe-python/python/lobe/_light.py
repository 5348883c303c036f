"""Analytic lights as functions on the sphere."""

from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import MAX_ORDER, directions, numbers, whole
from ._conventions import EngineForm
from ._conventions import import_coefficients as coefficients_of
from ._sh import Sh


def light(
    kind: str,
    order: int = 3,
    *,
    direction: npt.ArrayLike = (0.0, 0.0, 1.0),
    half_angle: float | None = None,
    vertices: npt.ArrayLike | None = None,
    color: npt.ArrayLike = (1.0, 1.0, 1.0),
    normalize: str = "projected",
) -> Sh:
    """The radiance of a light, as the command `lobe light` makes it: functions of shape (n², 3).

    `kind` is "ambient", "directional", "cone" or "soft-cone" (a disc of `half_angle` radians in (0, π]; a ball of radius r at the distance d is
    the cone of asin r/d), "polygon" (its `vertices`, (k, 3), as seen from the place that is lit), "hemisphere" or "gradient". `direction` is
    the one towards the light, of the last two the zenith, of any length above zero. `color` is (3,); of a hemisphere (2, 3), zenith and nadir, and of a gradient
    (3, 3), zenith, horizon and nadir.

    `normalize` is the unit of colors: "projected", a white surface that faces the light and is lit by the expansion reflects the color;
    "analytic", one lit by the light itself does; "none", radiance inside the shape, of a directional light irradiance.
    """
    order = whole(order, "order", 1, MAX_ORDER)
    unit, of_direction = directions(direction)
    if of_direction:
        raise ValueError(f"direction: expected one vector, found an array of shape {np.shape(direction)}")
    if half_angle is None and kind in ("cone", "soft-cone"):
        raise ValueError(f"half_angle: expected the half angle of a {kind}, in radians")
    corners = numbers(np.empty((0, 3)) if vertices is None else vertices, "vertices")
    colors = np.atleast_2d(numbers(color, "color"))
    for array, what in ((corners, "vertices"), (colors, "color")):
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"{what}: expected rows of three numbers, found an array of shape {array.shape}")
    angle = 0.0 if half_angle is None else float(half_angle)
    return Sh(_lobe.light(kind, order, (unit[0].tolist(), angle), corners.tolist(), colors.tolist(), normalize))


def import_coefficients(path: str | os.PathLike[str], form: EngineForm) -> Sh:
    """The radiance of a light whose nine colors a file holds in the form of an engine, as `lobe import` reads them.

    The file is text with 27 numbers, such as cmgen's sh.txt; JSON with such a list, such as LightProbe.toJSON of
    three.js; a .ktx with the key sh; or a .env of Babylon.js.

        >>> import pathlib, tempfile
        >>> probe = pathlib.Path(tempfile.mkdtemp()) / "probe.json"
        >>> _ = probe.write_text(str([1.0] * 27))
        >>> lobe.import_coefficients(probe, "three")
        Sh(order 3, rgb float64)
    """
    return Sh(coefficients_of(path, form))
