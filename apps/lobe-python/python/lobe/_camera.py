"""What pictures of scenes have in common: a camera, a light, a size."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, expect, finite, numbers, whole
from ._env import EnvMap, Sun
from ._scene import Path
from ._sh import Sh

Picture = npt.NDArray[np.float32]

MAX_SIDE = 16384
"""Pixels at most along a side."""


@dataclass(frozen=True)
class Camera:
    """An eye and where it looks, in the world of the scene, z up."""

    eye: tuple[float, float, float] | None = None
    """None: around the scene, so far away that all of it is in view."""
    target: tuple[float, float, float] | None = None
    """None: the middle of the scene."""
    fov: float = 40.0
    """The angle from the bottom to the top of the picture, in degrees."""
    orbit: tuple[float, float] | None = None
    """Without an eye: its azimuth from +x towards +y and its height above the horizon, in degrees; None: (-63, 20)."""

    def _view(self) -> View:
        if self.eye is None and self.target is not None:
            raise ValueError("target: only with an eye")
        if self.eye is not None and self.orbit is not None:
            raise ValueError("orbit: not with an eye")
        return _point(self.eye, "eye"), _point(self.target, "target"), _point(self.orbit, "orbit", 2), float(self.fov)


View = tuple[list[float] | None, list[float] | None, list[float] | None, float]
"""An eye and its target, or an orbit, and the angle of view, in degrees."""


def _point(values: npt.ArrayLike | None, what: str, length: int = 3) -> list[float] | None:
    if values is None:
        return None
    array = numbers(values, what).astype(np.float64)
    if array.shape != (length,) or not np.all(np.isfinite(array)):
        raise ValueError(f"{what}: expected {'three' if length == 3 else 'two'} finite numbers")
    point: list[float] = array.tolist()
    return point


@dataclass(frozen=True)
class Traced:
    """A path traced picture."""

    mean: Picture
    """Radiance, (height, width, 3); before the background "none" (height, width, 4), premultiplied by its alpha."""
    variance: Picture
    """The variance of the means, (height, width, 3): the square of their standard error."""
    degrees_of_freedom: float
    """Of each variance: how many differences it is estimated from."""
    coverage: Picture
    """The part of each pixel that shows a surface, (height, width), 0 to 1."""


Background = str | Sequence[float]
"""What is behind a scene: "env", "light", "none", "#rrggbb" of sRGB, or three numbers of linear radiance."""


def background_of(background: Background) -> str:
    """The text of a background, as the command has it."""
    if isinstance(background, str):
        return background
    color = _point(background, "background")
    assert color is not None
    return ",".join(repr(c) for c in color)


def checked(light: EnvMap | Sh, camera: Camera | None) -> Camera:
    """The camera, where the light is one."""
    expect(light, (EnvMap, Sh), "light", "an EnvMap or an Sh")
    expect(camera, (Camera, type(None)), "camera", "a Camera")
    return camera or Camera()


Suns = str | os.PathLike[str] | int | Sequence[Sun]
"""Suns beside an expansion: "auto", "none", so many at most, the path of a .json file, or suns themselves."""

Lighting = tuple[Doubles | None, _lobe.Map | None, int, str, list[tuple[list[float], list[float], float]]]
"""An expansion, or a map and its bands; which suns, and given ones."""


def lighting_of(light: EnvMap | Sh, order: int, suns: Suns) -> Lighting:
    """The light of pictures by expansions."""
    given: list[tuple[list[float], list[float], float]] = []
    if isinstance(suns, (str, os.PathLike)):
        choice = os.fspath(suns)
    elif isinstance(suns, (int, np.integer)):
        choice = str(whole(suns, "suns", 0, 1024))
    else:
        choice = "none"
        for sun in suns:
            expect(sun, Sun, "suns", "auto, none, a number, the path of a .json file, or a list of Sun")
            irradiance: list[float] = np.asarray(sun.irradiance, dtype=np.float64).tolist()
            given.append((np.asarray(sun.direction, dtype=np.float64).tolist(), irradiance, float(sun.angular_diameter)))
    if isinstance(light, EnvMap):
        return None, light._map, order, choice, given
    return colors_of(light), None, order, choice, given


def picture_of(traced: tuple[Picture, Picture, int, Picture] | None) -> Traced:
    """A picture that is no shard."""
    assert traced is not None
    return Traced(*traced)


SURFACES = ("matte", "gltf", "gltf-separable")



def expect_surfaces(surfaces: str) -> str:
    """The name of a model of reflection."""
    if surfaces not in SURFACES:
        raise ValueError(f"surfaces: expected {', '.join(SURFACES[:-1])} or {SURFACES[-1]}, found {surfaces!r}")
    return surfaces


Paths = tuple[int, int, int, str]
"""Samples of each pixel, bounces before the visible surface, a seed, and the model of surfaces."""


Tracing = tuple[Doubles | None, _lobe.Map | None, str, View, tuple[int, int], Paths]
"""Light, an expansion or a map, and what is behind the scene; eye, size and paths of a picture."""


def tracing_of(
    light: EnvMap | Sh,
    camera: Camera | None,
    width: int,
    height: int,
    samples: int,
    bounces: int,
    seed: int,
    surfaces: str,
    background: Background,
) -> Tracing:
    """What a picture is traced by."""
    view, size = checked(light, camera)._view(), size_of(width, height)
    counts = whole(samples, "samples", 2, 1 << 20), whole(bounces, "bounces", 0, 255), whole(seed, "seed", 0, 2**64 - 1)
    paths = *counts, expect_surfaces(surfaces)
    colors, source = (None, light._map) if isinstance(light, EnvMap) else (colors_of(light), None)
    return colors, source, background_of(background), view, size, paths


@contextmanager
def merged(parts: list[Path]) -> Iterator[tuple[str, list[Path]] | None]:
    """The shards of a picture, and a file to put them together in; none if there are no shards."""
    if not parts:
        yield None
        return
    with tempfile.TemporaryDirectory(prefix="lobe-") as folder:
        yield os.path.join(folder, "merged.checkpoint"), parts


def colors_of(light: Sh) -> Doubles:
    """The colors of one function, (n², 3)."""
    if light.shape:
        raise ValueError(f"light: expected one function, found a batch of shape {light.shape}")
    c = finite(light.coefficients.astype(np.float64), "light")
    return np.ascontiguousarray(c if light.is_color else np.repeat(c[:, None], 3, axis=1))


def size_of(width: int, height: int) -> tuple[int, int]:
    """Columns and rows of a picture."""
    return whole(width, "width", 1, MAX_SIDE), whole(height, "height", 1, MAX_SIDE)
