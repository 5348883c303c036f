"""Environment maps: light from everywhere around a point."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import MAX_ORDER, MAX_SIDE, Doubles, Numbers, directions, expect, finite, numbers, real, rotation_matrix, whole
from ._sh import Sh


MAPPINGS: dict[str, str] = dict(_lobe.mappings())
"""The names of the mappings, and what the pictures of each show."""


class LoadNote(UserWarning):
    """What a reader found in a file that may not be what was meant: `warnings.simplefilter("ignore", lobe.LoadNote)` silences all of them."""


@dataclass(frozen=True)
class Sun:
    """The brightest small light of a map; see `EnvMap.sun`."""

    direction: Doubles
    """Towards the sun, (3,)."""
    irradiance: Doubles
    """What a surface receives that faces it, (3,); never includes 1/π."""
    radiance: Doubles
    """Of the disc of constant radiance, (3,): `lobe.light("cone", order, direction=..., half_angle=angular_diameter / 2, color=radiance,
    normalize="none")` is its expansion."""
    angular_diameter: float
    """In radians."""
    texels: int
    """Texels of the map that were changed."""
    rest: EnvMap
    """The map without it."""


@dataclass(frozen=True)
class Technique:
    """A picture by a technique of environment mapping; see `EnvMap.techniques`."""

    solid: str
    """ball or torus."""
    name: str
    picture: npt.NDArray[np.float32]
    """Linear light, (size, size, 3)."""
    error: float | None
    """Against the truth that it approximates, over the visible surface, Σ|a - b| / Σ|b|; None of the truth itself."""
    mirrors: bool
    """Whether the surface mirrors the map as it is; others blur it."""


class EnvMap:
    """A map of radiance from everywhere: texels of shape (height, width, 3) in linear light, row 0 on top.

    Mappings are those of `lobe.MAPPINGS`, which the command has, too. Directions are right-handed with +z up.
    """

    def __init__(self, texels: npt.ArrayLike, mapping: str = "lat-long") -> None:
        array = np.ascontiguousarray(numbers(texels, "texels"), dtype=np.float32)
        if array.ndim == 2:
            array = np.repeat(array[..., None], 3, axis=-1)
        if array.ndim != 3 or array.shape[-1] != 3:
            raise ValueError(f"texels: expected an array of shape (height, width, 3), found {array.shape}")
        expect(mapping, str, "mapping", "a name such as lat-long")
        self._map = _lobe.Map(array, mapping)

    @classmethod
    def _of(cls, inner: _lobe.Map) -> EnvMap:
        made = cls.__new__(cls)
        made._map = inner
        return made

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        *,
        mapping: str | None = None,
        left_handed: bool = False,
        faces: str | None = None,
        elevations: tuple[float, float] | None = None,
        fisheye: str | None = None,
        fisheye_fov: float | None = None,
        fisheye_axis: npt.ArrayLike | None = None,
        fisheye_circle: tuple[float, float, float] | None = None,
        padding: str = "black",
        nonfinite: str = "error",
        to_rec709: bool = False,
        max_texels: int | None = None,
        max_bytes: int | None = None,
    ) -> EnvMap:
        """A map from any file that the command reads.

        `mapping` says what it is where the file and its proportions do not. `left_handed`: the faces of a cube were made for left-handed
        directions, as by Direct3D. `faces` are those of a cube in their order, as "front,right,back,left,up,down" for photographs, or
        "px,nx,py,ny,pz,nz". `elevations` are those of the lowest and the highest row of a cropped panorama, in radians; what is above and
        below is black, or with `padding="edge"` the nearest row. `fisheye` is the projection of a lens, equidistant, equisolid, stereographic or
        orthographic: the picture shows `fisheye_fov` radians across its circle around `fisheye_axis` [default: π and +z, half of the sphere], with +x at
        the top and +y on the right. The circle, column and row of its middle and its radius in pixels, is the largest about the middle unless
        `fisheye_circle` gives it; `padding` is what lies outside. `nonfinite="zero"` reads NaN and infinity as black instead of refusing
        them. `to_rec709` converts other primaries where the file tells them; `max_texels` is the limit of the picture,
        and `max_bytes` that
        of its file and of its texels in memory, which take 12 each. Six faces share both. What the command notes, such
        as other primaries that
        stay, is a warning of the category `LoadNote`.
        """
        if elevations is not None:
            low, high = (real(angle, "elevations", -np.pi / 2, np.pi / 2) for angle in elevations)
            elevations = (low, high)
        reading: dict[str, object] = {
            "mapping": mapping,
            "left_handed": bool(left_handed),
            "faces": faces,
            "elevations": elevations,
            "fisheye": _lens(fisheye, fisheye_fov, fisheye_axis, fisheye_circle),
            "padding": padding,
            "nonfinite": nonfinite,
            "to_rec709": bool(to_rec709),
            "max_texels": None if max_texels is None else whole(max_texels, "max_texels", 1, 1 << 40),
            "max_bytes": None if max_bytes is None else whole(max_bytes, "max_bytes", 1, 2**60),
        }
        found, notes = _lobe.load(path, reading)
        for note in notes:
            warnings.warn(f"{os.fspath(path)}: {note}", LoadNote, stacklevel=2)
        return cls._of(found)

    @classmethod
    def bundled(cls, name: str) -> EnvMap:
        """A map that comes with Lobe: "sunset" or "studio"."""
        return cls._of(_lobe.bundled(name))

    @classmethod
    def sky(
        cls, sun: npt.ArrayLike, turbidity: float = 3.0, albedo: npt.ArrayLike = (0.0, 0.0, 0.0), height: int = 256
    ) -> EnvMap:
        """The clear sky of Preetham et al. 1999 in kcd/m², without the sun's disc, over a ground of an albedo."""
        unit, shape = directions(sun)
        if shape:
            raise ValueError("sun: expected one direction")
        ground = numbers(albedo, "albedo").astype(np.float64)
        if ground.shape != (3,) or not np.all((ground >= 0) & (ground <= 1)):
            raise ValueError("albedo: expected three numbers of 0 to 1")
        rows = whole(height, "height", 1, 8192)
        return cls._of(_lobe.sky(unit[0].tolist(), real(turbidity, "turbidity", 2, 10), ground.tolist(), rows))

    @classmethod
    def cie_sky(
        cls,
        kind: int,
        sun: npt.ArrayLike,
        zenith: npt.ArrayLike = (1.0, 1.0, 1.0),
        albedo: npt.ArrayLike = (0.0, 0.0, 0.0),
        height: int = 256,
    ) -> EnvMap:
        """The sky of a type of the CIE (ISO 15469), 1 overcast to 12 clear to 15, or 16, the traditional overcast one, with this radiance or luminance
        at the zenith, over a ground of an albedo."""
        unit, shape = directions(sun)
        if shape:
            raise ValueError("sun: expected one direction")
        colors = []
        for values, what in ((zenith, "zenith"), (albedo, "albedo")):
            color = finite(numbers(values, what).astype(np.float64), what)
            if color.shape != (3,):
                raise ValueError(f"{what}: expected three numbers, found an array of shape {color.shape}")
            colors.append(color.tolist())
        number, rows = whole(kind, "kind", 1, 16), whole(height, "height", 1, 8192)
        return cls._of(_lobe.cie_sky(number, unit[0].tolist(), colors[0], colors[1], rows))

    @property
    def mapping(self) -> str:
        """The name of the mapping."""
        return self._map.mapping

    @property
    def shape(self) -> tuple[int, int]:
        """Texels along the height and the width."""
        return self._map.shape

    @property
    def texels(self) -> npt.NDArray[np.float32]:
        """A copy of the texels, (height, width, 3)."""
        return self._map.texels()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Numbers:
        if copy is False:
            raise ValueError("a map has no array of its own: its texels are copied")
        return self.texels if dtype is None else self.texels.astype(dtype, copy=False)

    def __reduce__(self) -> tuple[Any, ...]:
        return EnvMap, (self.texels, self.mapping)

    def __repr__(self) -> str:
        height, width = self.shape
        return f"EnvMap({self.mapping}, {width} x {height})"

    def _repr_png_(self) -> bytes:
        """What a notebook shows: the map, tone mapped, 512 texels wide at most."""
        return self._map.png(512)

    def radiance(self, d: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """Radiance towards directions (..., 3), interpolated between texels: (..., 3)."""
        unit, shape = directions(d)
        return self._map.radiance(unit).reshape((*shape, 3))

    def project(self, order: int) -> Sh:
        """The expansion of the map, which is constant over each texel: exact, float64, colors."""
        return Sh(self._map.project(whole(order, "order", 1, MAX_ORDER)))

    def convert(self, mapping: str, width: int, height: int | None = None, rotation: npt.ArrayLike | None = None) -> EnvMap:
        """The map in another mapping and size, turned by a rotation matrix first if there is one. Every texel is an integral over its
        footprint; the mean is kept."""
        width = whole(width, "width", 1, MAX_SIDE)
        height = None if height is None else whole(height, "height", 1, 6 * MAX_SIDE)
        matrix = None if rotation is None else rotation_matrix(rotation)
        return EnvMap._of(self._map.convert(mapping, width, height, matrix))

    def rotate(self, rotation: npt.ArrayLike) -> EnvMap:
        """The map turned by a rotation matrix: the radiance from R s is what it was from s."""
        height, width = self.shape
        return self.convert(self.mapping, width, height, rotation)

    def prefilter(
        self,
        size: int = 256,
        last_size: int | None = None,
        *,
        roughness: str = "linear",
        tolerance: float = 0.02,
    ) -> list[EnvMap]:
        """A chain of cubes for glossy reflection by GGX (split sum), from the mirror to roughness 1.

        The faces of the last are not smaller than `last_size` [default: 16, or `size` if that is smaller; 1 for engines that read all levels]. Level k of 0
        to K has the roughness r = √α = k/K; with `roughness="quadratic"` k = K r (2 - r), more levels for smooth surfaces; "babylon", "unity" and "unreal"
        are those of these engines. `tolerance`, 1e-6 to 0.1, is the error
        that is allowed, relative to the peak that a single small light makes.
        """
        size = whole(size, "size", 1, 8192)
        last = None if last_size is None else whole(last_size, "last_size", 1, size)
        limit = real(tolerance, "tolerance", 1e-6, 0.1)
        return [EnvMap._of(level) for level in _lobe.prefilter(self._map, (size, last), roughness, limit)]

    def filter_lobe(
        self,
        lobe: str,
        parameter: float,
        size: int = 256,
        *,
        tolerance: float = 0.02,
    ) -> EnvMap:
        """One cube blurred by a lobe, divided by the lobe's integral: a highlight map. `lobe` is "phong" or "blinn-phong" with an exponent of 0 or more as
        parameter, or "ggx" with α, 0 to 1; `tolerance` is that of `prefilter`."""
        number = real(parameter, "parameter", 0.0, 1.0 if lobe == "ggx" else np.inf)
        limit = real(tolerance, "tolerance", 1e-6, 0.1)
        return EnvMap._of(_lobe.filter_lobe(self._map, lobe, number, whole(size, "size", 1, 8192), limit))

    def irradiance(self, order: int | None = None, width: int = 64, height: int = 32, *, method: str = "sh") -> EnvMap:
        """The irradiance for every normal, as a lat-long map, from `order` bands [default: 3]; with `method="brute-force"` a sum over all
        texels of the map for each, which has no order."""
        sides = (whole(side, "size", 1, MAX_SIDE) for side in (width, height))
        if method not in ("sh", "brute-force"):
            raise ValueError(f"method: expected sh or brute-force, found {method!r}")
        if method == "brute-force" and order is not None:
            raise ValueError("order: not of the method brute-force, which leaves nothing out")
        bands = None if method == "brute-force" else whole(3 if order is None else order, "order", 1, MAX_ORDER)
        return EnvMap._of(_lobe.irradiance(self._map, bands, *sides))

    def irradiance_at(self, normal: npt.ArrayLike) -> Doubles:
        """The irradiance of surfaces that face normals (..., 3), a sum over all texels: (..., 3). From few bands it is
        `project(order).convolve("cosine").eval(normal)`."""
        unit, shape = directions(normal)
        return _lobe.irradiance_at(self._map, unit).reshape((*shape, 3))

    def vector_irradiance(self) -> Doubles:
        """The vector irradiance (net flux) e = ∫ L(s) s ds, (3, 3), one vector for each channel: `normal @ e.T` is what surfaces receive on their
        front less what they do on their back, for each channel."""
        return _lobe.vector_irradiance(self._map)

    def sun(
        self, *, max_radius: float = float(np.radians(2.5)), min_contrast: float = 20.0, min_peak: float = 100.0
    ) -> Sun | None:
        """The sun of a photograph as a directional light, and the map without it; None if the map has none.

        A sun has a radius of `max_radius` radians at most, 0 to π/2; its brightest texel is at least `min_contrast` times as bright as
        what surrounds it, and `min_peak` times as bright as the mean of the map.
        """
        radius = real(max_radius, "max_radius", 0.0, np.pi / 2)
        found = _lobe.sun(self._map, radius, real(min_contrast, "min_contrast", 0.0), real(min_peak, "min_peak", 0.0))
        if found is None:
            return None
        direction, irradiance, radiance, diameter, texels, rest = found
        return Sun(np.array(direction), np.array(irradiance), np.array(radiance), diameter, texels, EnvMap._of(rest))

    def suns(
        self,
        count: int,
        *,
        max_radius: float = float(np.radians(2.5)),
        min_contrast: float = 20.0,
        min_peak: float = 100.0,
    ) -> list[Sun]:
        """Up to `count` suns or lamps, each by `sun` of the rest of the one before; the rest of the last one is without all of them."""
        found: list[Sun] = []
        rest = self
        for _ in range(whole(count, "count", 1, 1024)):
            sun = rest.sun(max_radius=max_radius, min_contrast=min_contrast, min_peak=min_peak)
            if sun is None:
                break
            found.append(sun)
            rest = sun.rest
        return found

    def techniques(self, size: int = 192, *, progress: Callable[[int, int], object] | None = None) -> list[Technique]:
        """A ball and a torus under the map, by each technique of environment mapping beside the truth, in pictures of (size, size, 3), 32 to 1024:
        mirrors by lat-long, sphere map, cube and paraboloids; rough mirrors by filtered maps; highlight maps; matte by irradiance map and by nine
        coefficients; bumps; blended views."""
        return [Technique(*panel) for panel in _lobe.techniques(self._map, whole(size, "size", 32, 1024), progress)]

    def show(self, output: str | os.PathLike[str], size: int = 192, *, progress: Callable[[int, int], object] | None = None) -> None:
        """Writes `techniques` as one sheet, a .png, as `lobe env show` does."""
        _lobe.show(self._map, output, whole(size, "size", 32, 1024), progress)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes an .exr, .hdr or .pfm picture, or a tone-mapped .png; until all is written nothing has the name."""
        self._map.save(path)


def _lens(
    fisheye: str | None, fov: float | None, axis: npt.ArrayLike | None, circle: tuple[float, float, float] | None
) -> tuple[object, ...] | None:
    """A fisheye lens: projection, field of view, axis and circle; refuses what it would ignore."""
    if fisheye is None:
        for name, value in (("fisheye_fov", fov), ("fisheye_axis", axis), ("fisheye_circle", circle)):
            if value is not None:
                raise ValueError(f"{name}: only with fisheye")
        return None
    unit, shape = directions((0.0, 0.0, 1.0) if axis is None else axis)
    if shape:
        raise ValueError("fisheye_axis: expected one direction")
    angle = real(np.pi if fov is None else fov, "fisheye_fov", 0, 2 * np.pi)
    return fisheye, angle, unit[0].tolist(), None if circle is None else _circle(circle)


def _circle(circle: tuple[float, float, float]) -> tuple[float, ...]:
    """Column and row of the middle of a circle, and its radius."""
    if np.shape(circle) != (3,):
        raise ValueError("fisheye_circle: expected column, row and radius")
    return tuple(real(number, "fisheye_circle", 0, 1e9) for number in circle)


def project(image: npt.ArrayLike, order: int, mapping: str = "lat-long") -> Sh:
    """The expansion of a picture of everything around a point: (height, width, 3) gives colors, (height, width) numbers.

    Float64, exact for a picture that is constant over each texel. Lat-long pictures are read as they are, others rounded to float32 first.
    """
    array = numbers(image, "image")
    if mapping != "lat-long":
        f = EnvMap(array, mapping).project(order)
        return f if array.ndim == 3 else Sh(np.ascontiguousarray(f.coefficients[:, 0]))
    order = whole(order, "order", 1, MAX_ORDER)
    if array.ndim != 2 and (array.ndim != 3 or array.shape[-1] != 3):
        raise ValueError(f"image: expected an array of shape (height, width) or (height, width, 3), found {array.shape}")
    return Sh(_lobe.project_lat_long(np.ascontiguousarray(array), order))


def reconstruct(f: Sh, width: int, height: int) -> EnvMap:
    """The lat-long map of one function: its values at the centers of texels. For values alone, of numbers or of batches, see `Sh.texels`."""
    if f.shape:
        raise ValueError(f"expected one function, found a batch of shape {f.shape}")
    c = np.ascontiguousarray(finite(f.coefficients.astype(np.float64), "coefficients"))
    sides = (whole(side, "size", 1, MAX_SIDE) for side in (width, height))
    return EnvMap._of(_lobe.reconstruct(c, *sides))


def export(
    light: EnvMap,
    engine: str | Sequence[str],
    folder: str | os.PathLike[str],
    *,
    size: int = 256,
    suns: str | int | os.PathLike[str] = "auto",
    name: str = "a map",
) -> list[Path]:
    """Writes the light of a map as the files that engines read, a folder for each in `folder`, and returns them: `lobe export --help` names the engines.

    `size` is that of the faces of cubes, a power of two from 16. `suns` become lights of their own: "auto", "none", so many at most, or the path of a .json
    file. `name` stands for the map in the texts beside the files.
    """
    expect(light, EnvMap, "light", "an EnvMap")
    engines = [engine] if isinstance(engine, str) else list(engine)
    return _lobe.export_light(light._map, engines, os.fspath(folder), name, whole(size, "size", 16, 8192), os.fspath(suns) if isinstance(suns, os.PathLike) else str(suns))
