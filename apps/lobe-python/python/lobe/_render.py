"""Pictures of scenes, and how far two pictures are apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, expect, finite, numbers, whole
from ._bake import Path, Progress
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


def _checked(light: EnvMap | Sh, camera: Camera | None) -> Camera:
    """The camera, where the light is one."""
    expect(light, (EnvMap, Sh), "light", "an EnvMap or an Sh")
    expect(camera, (Camera, type(None)), "camera", "a Camera")
    return camera or Camera()


def _colors(light: Sh) -> Doubles:
    if light.shape:
        raise ValueError(f"light: expected one function, found a batch of shape {light.shape}")
    c = finite(light.coefficients.astype(np.float64), "light")
    return np.ascontiguousarray(c if light.is_color else np.repeat(c[:, None], 3, axis=1))


def _size(width: int, height: int) -> tuple[int, int]:
    return whole(width, "width", 1, MAX_SIDE), whole(height, "height", 1, MAX_SIDE)


def render(
    scene: Path,
    light: EnvMap | Sh,
    *,
    camera: Camera | None = None,
    width: int = 512,
    height: int = 384,
    rays: int = 2,
) -> Picture:
    """A baked .glb or .gltf under light from everywhere, by its transfer, at once: radiance of shape (height, width, 3), row 0 on top.

    Behind the scene is the map, or the expansion itself. `rays` squared rays are averaged for each pixel.
    """
    view = _checked(light, camera)._view()
    width, height = _size(width, height)
    background = light._map if isinstance(light, EnvMap) else None
    # Bands beyond those of the transfer count nothing; eight are the most that it has.
    colors = _colors(light.project(8) if isinstance(light, EnvMap) else light)
    return _lobe.render_baked(scene, colors, background, view, width, height, whole(rays, "rays", 1, 64))


def trace(
    scene: Path,
    light: EnvMap | Sh,
    *,
    camera: Camera | None = None,
    width: int = 512,
    height: int = 384,
    samples: int = 64,
    bounces: int = 3,
    seed: int = 0,
    progress: Progress | None = None,
) -> Traced:
    """A scene path traced under light from everywhere: the truth beside `render`.

    `scene` is a file, or "built-in:still-life" or another scene of Lobe; surfaces are matte. `samples` paths for each pixel, of up to `bounces`
    reflections before the visible one. Ctrl-C and what `progress(done, total)` raises stop it.
    """
    view = _checked(light, camera)._view()
    width, height = _size(width, height)
    paths = (whole(samples, "samples", 2, 1 << 20), whole(bounces, "bounces", 0, 255), whole(seed, "seed", 0, 2**64 - 1))
    colors, source = (None, light._map) if isinstance(light, EnvMap) else (_colors(light), None)
    return Traced(*_lobe.render_traced(scene, colors, source, view, width, height, paths, progress))


@dataclass(frozen=True)
class Difference:
    """How far a picture is from a reference."""

    rmse: float
    """The root of the mean squared difference."""
    relmse: float
    """The mean squared difference relative to the reference, (a - b)²/(b² + 0.01 mean²)."""
    psnr: float
    """The peak signal-to-noise ratio in decibels; infinite for equal pictures."""
    flip: float
    """HDR-FLIP, 0 to 1: the difference that one sees when flipping between them."""


def compare(image: npt.ArrayLike, reference: npt.ArrayLike) -> Difference:
    """How far a picture of shape (height, width, 3) in linear light is from a reference of the same size."""
    a, b = (finite(np.ascontiguousarray(numbers(x, "picture"), dtype=np.float32), "picture") for x in (image, reference))
    for x in (a, b):
        if x.ndim != 3 or x.shape[-1] != 3 or x.size == 0:
            raise ValueError(f"picture: expected an array of shape (height, width, 3), found {x.shape}")
    if a.shape != b.shape:
        raise ValueError(f"pictures: expected one size, found {a.shape} and {b.shape}")
    return Difference(*_lobe.compare(a, b))
