"""Area lights: their irradiance in closed form, and how far point lights and parallel beams are from it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, directions, finite, numbers, points, real


class AreaLight:
    """A light of radiance 1 with an extent, as of `lobe env area-light`: made by `sphere`, `disc`, `rectangle` or `polygon`.

    Places are (..., 3), in any unit of length; normals (..., 3), of any length above zero; they broadcast. Irradiance never includes 1/π,
    and of a light of radiance L it is L times as much. Refuses places on the light, and in a sphere.
    """

    def __init__(self) -> None:
        raise TypeError("expected AreaLight.sphere, disc, rectangle or polygon")

    @classmethod
    def _of(cls, inner: _lobe.AreaLight, text: str, made_by: tuple[str, tuple[Any, ...]]) -> AreaLight:
        made = cls.__new__(cls)
        made._light, made._text, made._made_by = inner, text, made_by
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        name, values = self._made_by
        return getattr(AreaLight, name), values

    _light: _lobe.AreaLight
    _text: str
    _made_by: tuple[str, tuple[Any, ...]]

    @classmethod
    def sphere(cls, center: npt.ArrayLike, radius: float) -> AreaLight:
        """A luminous ball."""
        place, size = _point(center, "center"), _radius(radius)
        return cls._of(_lobe.AreaLight.sphere(place, size), f"sphere({place}, {size})", ("sphere", (place, size)))

    @classmethod
    def disc(cls, center: npt.ArrayLike, shines: npt.ArrayLike, radius: float) -> AreaLight:
        """A disc that shines to one side, in the direction `shines`, (3,)."""
        unit, shape = directions(shines)
        if shape:
            raise ValueError(f"shines: expected one direction, found an array of shape {np.shape(shines)}")
        place, size = _point(center, "center"), _radius(radius)
        values = (place, unit[0].tolist(), size)
        return cls._of(_lobe.AreaLight.disc(*values), f"disc({place}, {values[1]}, {size})", ("disc", values))

    @classmethod
    def rectangle(cls, center: npt.ArrayLike, u: npt.ArrayLike, v: npt.ArrayLike) -> AreaLight:
        """A rectangle, or a parallelogram: center ± u ± v, which shines towards u × v."""
        sides = [_point(values, what) for values, what in ((center, "center"), (u, "u"), (v, "v"))]
        text = f"rectangle({sides[0]}, {sides[1]}, {sides[2]})"
        return cls._of(_lobe.AreaLight.rectangle(*sides), text, ("rectangle", tuple(sides)))

    @classmethod
    def polygon(cls, vertices: npt.ArrayLike) -> AreaLight:
        """A plane polygon of vertices (k, 3), k of 3 or more, that shines to the side from which they run counterclockwise."""
        corners, shape = points(vertices, "vertices")
        if len(shape) != 1:
            raise ValueError(f"vertices: expected an array of shape (k, 3), found {np.shape(vertices)}")
        values = (corners.tolist(),)
        return cls._of(_lobe.AreaLight.polygon(*values), f"polygon of {len(corners)} vertices", ("polygon", values))

    def __repr__(self) -> str:
        return f"AreaLight.{self._text}"

    def irradiance(self, at: npt.ArrayLike, normal: npt.ArrayLike = (0.0, 0.0, 1.0)) -> Doubles:
        """The irradiance of surfaces at places that face normals, exactly, past their horizon: (...)."""
        places, normals, shape = _receivers(at, normal)
        return self._light.irradiance(places, normals).reshape(shape)

    def vector_irradiance(self, at: npt.ArrayLike) -> Doubles:
        """The vector irradiance e at places, (..., 3): n·e is what a surface of normal n receives on its front less what it does on its back."""
        places, shape = points(at, "at")
        return self._light.vector_irradiance(places).reshape((*shape, 3))

    def as_point(self, at: npt.ArrayLike, normal: npt.ArrayLike = (0.0, 0.0, 1.0)) -> Doubles:
        """The irradiance of the point light that the light tends to with distance: (...)."""
        places, normals, shape = _receivers(at, normal)
        return self._light.as_point(places, normals).reshape(shape)

    def as_beam(self, reference: npt.ArrayLike, normal: npt.ArrayLike = (0.0, 0.0, 1.0)) -> Doubles:
        """The irradiance, the same at all places, of the parallel beam that has the light's vector irradiance at a place of reference: (...)."""
        places, normals, shape = _receivers(reference, normal)
        return self._light.as_beam(places, normals).reshape(shape)


def _point(values: npt.ArrayLike, what: str) -> list[float]:
    array = finite(numbers(values, what).astype(np.float64, copy=False), what)
    if array.shape != (3,):
        raise ValueError(f"{what}: expected three numbers, found an array of shape {array.shape}")
    point: list[float] = array.tolist()
    return point


def _radius(value: float) -> float:
    return real(value, "radius", math.nextafter(0.0, 1.0))


def _receivers(at: npt.ArrayLike, normal: npt.ArrayLike) -> tuple[Doubles, Doubles, tuple[int, ...]]:
    """As many places as normals, (m, 3) each, and the shape that they have together."""
    (places, of_places), (normals, of_normals) = points(at, "at"), directions(normal)
    try:
        shape = np.broadcast_shapes(of_places, of_normals)
    except ValueError:
        raise ValueError(f"at and normal: expected shapes that broadcast, found {of_places} and {of_normals} vectors") from None
    both = [np.broadcast_to(a.reshape((*s, 3)), (*shape, 3)).reshape(-1, 3) for a, s in ((places, of_places), (normals, of_normals))]
    return np.ascontiguousarray(both[0]), np.ascontiguousarray(both[1]), shape
