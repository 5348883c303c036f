"""What pictures of scenes have in common: a camera, a light, a size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ._arrays import Doubles, expect, finite, numbers, whole
from ._env import EnvMap
from ._sh import Sh

Picture = npt.NDArray[np.float32]

MAX_SIDE = 16384
"""Pixels at most along a side."""


@dataclass(frozen=True)
class Camera:
    """An eye and where it looks, in the world of the scene, z up."""

    eye: tuple[float, float, float] | None = None
    """None: in front of the scene, so far away that all of it is in view."""
    target: tuple[float, float, float] | None = None
    """None: the middle of the scene."""
    fov: float = 40.0
    """The angle from the bottom to the top of the picture, in degrees."""

    def _view(self) -> tuple[list[float] | None, list[float] | None, float]:
        if not 0.0 < self.fov < 180.0:
            raise ValueError(f"fov: expected an angle above 0 and below 180 degrees, found {self.fov}")
        if self.eye is None and self.target is not None:
            raise ValueError("target: only with an eye")
        return _point(self.eye, "eye"), _point(self.target, "target"), float(np.radians(self.fov))


def _point(values: npt.ArrayLike | None, what: str) -> list[float] | None:
    if values is None:
        return None
    array = numbers(values, what).astype(np.float64)
    if array.shape != (3,) or not np.all(np.isfinite(array)):
        raise ValueError(f"{what}: expected three finite numbers")
    point: list[float] = array.tolist()
    return point


@dataclass(frozen=True)
class Traced:
    """A path traced picture."""

    mean: Picture
    """Radiance, (height, width, 3)."""
    variance: Picture
    """The variance of the means, (height, width, 3): the square of their standard error."""


def checked(light: EnvMap | Sh, camera: Camera | None) -> Camera:
    """The camera, where the light is one."""
    expect(light, (EnvMap, Sh), "light", "an EnvMap or an Sh")
    expect(camera, (Camera, type(None)), "camera", "a Camera")
    return camera or Camera()


def colors_of(light: Sh) -> Doubles:
    """The colors of one function, (n², 3)."""
    if light.shape:
        raise ValueError(f"light: expected one function, found a batch of shape {light.shape}")
    c = finite(light.coefficients.astype(np.float64), "light")
    return np.ascontiguousarray(c if light.is_color else np.repeat(c[:, None], 3, axis=1))


def size_of(width: int, height: int) -> tuple[int, int]:
    """Columns and rows of a picture."""
    return whole(width, "width", 1, MAX_SIDE), whole(height, "height", 1, MAX_SIDE)
