"""Functions on the sphere as coefficients of spherical harmonics."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import MAX_ORDER, MAX_SIDE, Doubles, Numbers, as_asked, expect, finite, numbers, order_of, real, rotation_matrix, vectors, whole
from ._arrays import directions as unit_directions
from ._conventions import Convention, EngineForm, decoded, encoded
from ._encodings import Encoded, EncodingError, encode

# Eigenvalues below this part of the largest are raised to it, as `lobe sh log` does.
LOG_CLAMP = 0.02

# As in the command: beyond, a grid or a product matrix of one function takes gigabytes, and a search over the sphere minutes.
MOST_EXPONENTIATED = 10
MOST_SEARCHED = 64

# The closed bound of the least value is for so many bands.
MOST_BOUNDED = 3

# The power of the sigma factors that has a name of its own.
SINC4 = 4

# Short names of methods of dering, as the command has them.
METHODS = {"sinc4": f"lanczos:{SINC4}", "laplacian": "squared-laplacian"}


@dataclass(frozen=True)
class Lights:
    """Directional lights and ambient light of functions; see `Sh.lights`, also for the shapes where each channel has lights of its own."""

    directions: Doubles
    """Towards the lights, (..., count, 3)."""
    intensities: Doubles
    """The radiance that a white diffuse surface facing a light reflects, (..., count) or (..., count, 3)."""
    ambient: Doubles
    """The radiance of the ambient light, (...) or (..., 3)."""
    residual: Doubles
    """What is left of the energy: the square of the distance of the lights' function from this one, by the metric, (...) or (..., 3)."""
    irradiances: Doubles
    """The irradiance of a surface that faces each light itself, of the shape of `intensities`: what the directional light of an engine has."""


class Minimum(NamedTuple):
    """Least values of functions; see `Sh.minimum`."""

    value: Numbers
    """The values found, (...), for colors of each channel (..., 3)."""
    direction: Numbers
    """In which directions they are, (..., 3), for colors (..., 3, 3)."""
    at_least: Numbers
    """What no value is below, with proof: of the shape of `value`."""


def _function(value: object) -> Sh:
    if not isinstance(value, Sh):
        raise TypeError(f"expected functions, lobe.Sh, found {type(value).__name__}")
    return value


class Sh:
    """Functions on the sphere, f(s) = Σ_lm c_lm y_lm(s), with real orthonormal spherical harmonics y_lm.

    `c` has shape (..., n²), or (..., n², 3) for colors, where n is the order, the number of bands, and coefficient l² + l + m
    belongs to y_lm, with the phase (-1)^m: y_1,-1 = -√(3/4π) y, y_10 = √(3/4π) z, y_11 = -√(3/4π) x. Leading dimensions are a batch. Numbers are float32
    or float64, and functions and values that are computed of them have the same, but for searches and encodings, which are float64; they are not copied if they are contiguous and aligned. Of coefficients that are not
    finite the values are not finite, unless a method says that it refuses them.
    """

    # numpy asks these objects first when one of its own stands on the left.
    __array_priority__ = 1.0

    def __init__(self, c: npt.ArrayLike | Sh) -> None:
        array = c.coefficients if isinstance(c, Sh) else numbers(c, "coefficients")
        # No order has three coefficients, so that an axis of three holds colors.
        self._is_color = array.ndim > 1 and array.shape[-1] == 3
        if array.ndim == 0:
            raise ValueError("coefficients: expected an array of shape (..., n²) or (..., n², 3), found a number")
        self._order = order_of(array.shape[-2 if self._is_color else -1], "coefficients")
        self._c: Numbers = array

    @classmethod
    def load(cls, path: str | os.PathLike[str], quantity: str | None = None) -> Sh:
        """The function of a .sh.json file of the command, float64. With `quantity`, such as "radiance" or "irradiance", a file of another one is
        refused."""
        c, found = _lobe.load_sh(path)
        if quantity is not None and found != quantity:
            raise ValueError(f"{os.fspath(path)}: expected {quantity}, found {found}")
        return cls(c)

    def save(self, path: str | os.PathLike[str], quantity: str = "radiance") -> None:
        """Writes one function as a .sh.json file of a quantity: radiance, irradiance, transfer, visibility, log-visibility or function. Until all is
        written nothing has the name."""
        if self.shape:
            raise ValueError(f"expected one function, found a batch of shape {self.shape}")
        _lobe.save_sh(np.ascontiguousarray(self._c, dtype=np.float64), quantity, path)

    @classmethod
    def from_convention(cls, array: npt.ArrayLike, name: Convention, *, color: bool | None = None) -> Sh:
        """The functions of coefficients that another library keeps, float64: the inverse of `to_convention`.

        `array` has the library's own shape, with axes of a batch before it. An axis of three right before it holds
        colors; `color=False` takes
        it for a batch. Complex numbers that are not those of a real function are refused, with the l and m.

            >>> import numpy as np
            >>> alm = np.zeros(6, complex)  # healpy, lmax = 2
            >>> alm[0] = np.sqrt(4 * np.pi)
            >>> float(lobe.Sh.from_convention(alm, "healpy").mean().round(12))
            1.0
        """
        return cls(decoded(array, name, color))

    # What it is

    @property
    def coefficients(self) -> Numbers:
        """The coefficients, (..., n²) or (..., n², 3)."""
        return self._c

    @property
    def order(self) -> int:
        """The number of bands n."""
        return self._order

    @property
    def is_color(self) -> bool:
        """Whether coefficients are colors."""
        return self._is_color

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading dimensions, those of the batch."""
        return self._c.shape[: -2 if self._is_color else -1]

    @property
    def dtype(self) -> np.dtype[Any]:
        """float32 or float64."""
        return self._c.dtype

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Numbers:
        return as_asked(self._c, dtype, copy)

    def __repr__(self) -> str:
        batch = f", shape {self.shape}" if self.shape else ""
        return f"Sh(order {self._order}, {'rgb ' if self._is_color else ''}{self.dtype}{batch})"

    def __getitem__(self, key: Any) -> Sh:
        """Functions of the batch: `f[3]`, `f[..., :2]`. Axes of coefficients are kept."""
        keys = key if isinstance(key, tuple) else (key,)
        kept = 2 if self._is_color else 1
        if not any(k is Ellipsis for k in keys):
            keys = (*keys, Ellipsis)
        return Sh(self._c[(*keys, *(slice(None),) * kept)])

    def __iter__(self) -> Iterator[Sh]:
        if not self.shape:
            raise TypeError("one function is no sequence; its coefficients are")
        return (self[k] for k in range(len(self)))

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("one function has no length")
        return self.shape[0]

    def __add__(self, other: Sh) -> Sh:
        return Sh(self._c + self._alike(_function(other))._c)

    def __radd__(self, other: object) -> Sh:
        # What `sum` begins with.
        if isinstance(other, int) and other == 0:
            return self
        return Sh(self._alike(_function(other))._c + self._c)

    def __sub__(self, other: Sh) -> Sh:
        return Sh(self._c - self._alike(_function(other))._c)

    def __rsub__(self, other: object) -> Sh:
        return Sh(self._alike(_function(other))._c - self._c)

    def __mul__(self, factor: float) -> Sh:
        """The function times a number; for products of functions see `product`."""
        if isinstance(factor, Sh):
            raise TypeError("expected a number, found functions: their product is a.product(b)")
        if np.ndim(factor) != 0:
            raise TypeError("expected a number; for factors of a batch, multiply the coefficients")
        if np.iscomplexobj(factor):
            raise TypeError(f"expected a real number, found {factor}")
        return Sh((self._c * factor).astype(self.dtype, copy=False))

    __rmul__ = __mul__

    def __neg__(self) -> Sh:
        return Sh(-self._c)

    # What is done to it

    def eval(self, d: npt.ArrayLike) -> Numbers:
        """Values towards directions of shape (..., 3), of any length above zero: (batch, ...), for colors (batch, ..., 3)."""
        towards = vectors(d)
        values = _lobe.eval(self._rows(), self._order, np.ascontiguousarray(towards.reshape(-1, 3)))
        return values.reshape(self.shape + towards.shape[:-1] + ((3,) if self._is_color else ()))

    def texels(self, width: int, height: int) -> Numbers:
        """Values towards the centers of the texels of a lat-long map, row 0 on top: (batch, height, width), for colors (batch, height, width, 3)."""
        sides = [whole(side, "size", 1, MAX_SIDE) for side in (width, height)]
        values = _lobe.texels(self._rows(), *sides)
        return values.reshape(self.shape + values.shape[1:])

    def rotate(self, r: npt.ArrayLike) -> Sh:
        """The functions turned by a rotation matrix R of shape (3, 3): the value at R s is what it was at s."""
        return self._like(_lobe.rotate(self._rows(), self._order, rotation_matrix(r)), self._order)

    def product(self, other: Sh, order: int | None = None) -> Sh:
        """The product with other functions, projected onto `order` bands, as many as the larger order unless given.

        Batches broadcast as in numpy, and a function of numbers multiplies each channel of one of colors. Both have one dtype. In float32
        more than eight functions are multiplied side by side, which rounds otherwise than one after the other.
        """
        if not isinstance(other, Sh):
            raise TypeError(f"expected functions, found {type(other).__name__}")
        if self.dtype != other.dtype:
            raise TypeError(f"expected functions of one dtype, found {self.dtype} and {other.dtype}")
        out = whole(max(self._order, other._order) if order is None else order, "order", 1, MAX_ORDER)
        is_color = self._is_color or other._is_color
        a, b = (f._c if f._is_color or not is_color else np.repeat(f._c[..., None], 3, axis=-1) for f in (self, other))
        tail = 2 if is_color else 1
        batch = np.broadcast_shapes(a.shape[:-tail], b.shape[:-tail])
        # Copies only where something is repeated.
        rows = [np.ascontiguousarray(np.broadcast_to(f, batch + f.shape[-tail:]).reshape((-1,) + f.shape[-tail:])) for f in (a, b)]
        values = _lobe.product(rows[0], rows[1], out)
        return Sh(values.reshape(batch + values.shape[1:]))

    def convolve(self, kernel: str | npt.ArrayLike, parameter: float = 0.0) -> Sh:
        """The convolution with a kernel that is symmetric about its axis.

        `kernel` is "cosine" (clamped; radiance becomes irradiance), "phong" with its exponent as parameter, "ggx" with α in [0, 1] as
        parameter, the last two of integral 1; or n numbers, the factors √(4π/(2l+1)) h_l of the bands.
        """
        if isinstance(kernel, str):
            parameter = float(parameter)
            if kernel == "phong" and not (0.0 <= parameter < np.inf):
                raise ValueError(f"parameter: expected an exponent of 0 or more, found {parameter}")
            if kernel == "ggx" and not 0.0 <= parameter <= 1.0:
                raise ValueError(f"parameter: expected α in [0, 1], found {parameter}")
            factors = _lobe.kernel_factors(kernel, parameter, self._order)
        else:
            factors = self._factors(kernel)
        return self._scaled(factors)

    def window(
        self,
        window: str | npt.ArrayLike,
        *,
        keep: float | None = None,
        content: bool = False,
        order: int | None = None,
        peak: float | None = None,
        power: float | None = None,
    ) -> Sh:
        """Bands scaled by a window, or by n factors.

        "hanning", "lanczos" and "sinc4" reach zero at the band n, or at another such as "hanning:6"; "lanczos:6:4", or "lanczos" with `power`, has a
        power, "gauss:0.2" a standard deviation in radians, "squared-laplacian:0.01" a weight; "punctual-light" has three factors. The first three with
        `peak` have the width that leaves a unit impulse of order n this value at its peak, above 1/4π and below n²/4π. "horizon" scales what is
        symmetric about +z alone, m = 0, which holds the step of a sky at its horizon, by the factors of "lanczos". "squared-laplacian" with `keep`,
        above 0 to 1, finds the weight of each function that leaves this part of its squared Laplacian. With `content` a
        function stays as it is towards its light, the direction of band 1, and the window comes in away from it; the blend needs more
        bands than the function, of which `order` are computed [default: n].
        """
        if power is not None:
            real(power, "power", 0.0)
            if not isinstance(window, str) or window != "lanczos" or power == 0.0:
                raise ValueError("power: only of the window lanczos without a width, and above 0")
        if peak is not None:
            window = self._of_peak(window, peak, power)
        elif power is not None:
            window = f"lanczos:{self._order}:{power}"
        if keep is not None:
            return self._kept(window, keep, content)
        if order is not None and not content:
            raise ValueError("order: only with content")
        if not isinstance(window, str):
            if content:
                raise TypeError(f"window: expected the name of a window with content, found {type(window).__name__}")
            return self._scaled(self._factors(window))
        if window == "horizon":
            if content:
                raise ValueError("content: horizon knows no light, it damps the same everywhere; choose another window")
            return self._like(_lobe.damp_zonal(self._rows(), self._order), self._order)
        name = self._window_name(window)
        if not content:
            return self._scaled(_lobe.window_factors(name, self._order))
        self._expect_order(MOST_SEARCHED)
        out = whole(self._order if order is None else order, "order", 1, MAX_ORDER)
        return self._like(_lobe.content_window(self._rows(), name, out), out)

    def _kept(self, window: str | npt.ArrayLike, keep: float, content: bool) -> Sh:
        if content or not isinstance(window, str) or window != "squared-laplacian":
            raise ValueError("keep: only of the window squared-laplacian, without content")
        part = real(keep, "keep", 0.0, 1.0)
        if part == 0.0:
            raise ValueError("keep: expected a number above 0, found 0.0")
        return self._like(_lobe.window_keep(self._rows(), self._order, part), self._order)

    def _of_peak(self, window: str | npt.ArrayLike, peak: float, power: float | None) -> str:
        """The window of the width that lowers an impulse to the peak, a Lanczos window of this power."""
        powers: dict[str, float | None] = {"hanning": None, "lanczos": 1.0 if power is None else float(power), "sinc4": float(SINC4)}
        if not isinstance(window, str) or window not in powers:
            raise ValueError("peak: only of the windows hanning, lanczos and sinc4, without a width")
        power = powers[window]
        width = _lobe.width_of_peak(power, self._order, real(peak, "peak", 0.0))
        if width is None:
            least, most = 1 / (4 * np.pi), self._order**2 / (4 * np.pi)
            if least < peak < most:
                raise ValueError(f"peak: no width of this window has the peak {peak}; take a larger power")
            raise ValueError(f"peak: expected a value between {least:.6f} and {most:.6f} at order {self._order}, found {peak}")
        return f"hanning:{width}" if power is None else f"lanczos:{width}:{power}"

    def _window_name(self, window: str) -> str:
        """The window with all its numbers."""
        name, _, width = window.partition(":")
        if name == "sinc4":
            return f"lanczos:{width or self._order}:{SINC4}"
        return f"{name}:{self._order}" if window in ("hanning", "lanczos") else window

    def dering(self, method: str = "least-change", of_irradiance: bool = False) -> Sh:
        """The functions made non-negative by factors of their bands; or such that their irradiance is not negative.

        Methods are named as in the command, "sinc4" and "laplacian" too. The mean stays; a function whose mean is negative, or not finite, is refused. To order 64.
        """
        self._expect_order(MOST_SEARCHED)
        expect(method, str, "method", "a name such as least-change")
        return self._like(_lobe.dering(self._rows(), self._order, METHODS.get(method, method), bool(of_irradiance)), self._order)

    def mirror(self, axis: str) -> Sh:
        """The functions reflected along an axis, "x", "y" or "z", which changes its sign: the value at (-x, y, z) is what it was at (x, y, z)."""
        expect(axis, str, "axis", "x, y or z")
        signs = np.asarray(_lobe.mirror_signs(self._order, axis), dtype=self.dtype)
        return Sh(self._c * (signs[:, None] if self._is_color else signs))

    def exp(self, method: str = "grid") -> Sh:
        """e to the functions, projected onto their bands, to order 10. Refuses coefficients that are not finite.

        Methods are those of the command (Ren et al. 2006): "grid", on a grid of directions; "optimal-linear", the best linear function;
        "hybrid" or "hybrid:NORM", that after halving to a norm [default: 1], then squared; "series:P", by P truncated products;
        "eigen", by eigenvectors of the product matrix: the reference, a second for one function of order 10."""
        self._expect_order(MOST_EXPONENTIATED)
        expect(method, str, "method", "a name such as grid")
        return self._like(_lobe.exp(self._rows(), self._order, method), self._order)

    def log(self, clamp: float = LOG_CLAMP) -> Sh:
        """The logarithm of functions such as visibilities, so that sums of them stand for products; what is below `clamp` times the
        largest eigenvalue of the product matrix is raised to it. To order 10. Refuses coefficients that are not finite."""
        self._expect_order(MOST_EXPONENTIATED)
        if not 0.0 < clamp <= 1.0:
            raise ValueError(f"clamp: expected a number above 0, up to 1, found {clamp}")
        return self._like(_lobe.log(self._rows(), self._order, float(clamp)), self._order)

    def resized(self, order: int) -> Sh:
        """The functions with as many bands, cut off or filled up with zeros."""
        order = whole(order, "order", 1, MAX_ORDER)
        axis = -2 if self._is_color else -1
        count = min(order, self._order) ** 2
        shape = list(self._c.shape)
        shape[axis] = order * order
        c = np.zeros(shape, self.dtype)
        kept = (slice(None), slice(count), slice(None)) if self._is_color else (slice(None), slice(count))
        c[(Ellipsis, *kept[1:])] = self._c[(Ellipsis, *kept[1:])]
        return Sh(c)

    # What is found in it

    def minimum(self, tolerance: float = 1e-6) -> Minimum:
        """The least value of each function, a direction in which it is, and what no value is below: (...), (..., 3) and (...); for colors of
        each channel, (..., 3), (..., 3, 3) and (..., 3). The two values differ by `tolerance` at most, as a part of the root mean square. To
        order 64. Refuses coefficients that are not finite."""
        self._expect_order(MOST_SEARCHED)
        if not (np.isfinite(tolerance) and tolerance > 0):
            raise ValueError(f"tolerance: expected a number above 0, found {tolerance}")
        c = np.moveaxis(self._c, -1, -2) if self._is_color else self._c
        rows = np.ascontiguousarray(c, dtype=np.float64).reshape(-1, self._order**2)
        values, bounds, where = _lobe.minimum(rows, self._order, float(tolerance))
        shape = c.shape[:-1]
        return Minimum(values.reshape(shape), where.reshape((*shape, 3)), bounds.reshape(shape))

    def minimum_bound(self) -> Doubles:
        """What no value of a function of up to three bands is below, in closed form, as the dering of Sloan 2017 has it: (...), for colors of each
        channel (..., 3). `minimum` is nearer. Refuses coefficients that are not finite."""
        self._expect_order(MOST_BOUNDED)
        c = np.moveaxis(self._c, -1, -2) if self._is_color else self._c
        rows = np.ascontiguousarray(c, dtype=np.float64).reshape(-1, self._order**2)
        return _lobe.minimum_bound(rows, self._order).reshape(c.shape[:-1])

    def peaks(self, search: str = "grid") -> tuple[Doubles, Doubles]:
        """All local maxima of one function, of the luminance of colors: directions (k, 3) and values (k,), the highest first; none of a function
        that is the same everywhere. `search` begins at the high points of a fine "grid", or, to order 6, at the few of the "paper", Sloan 2008, which
        is faster and misses fewer than 1 %. Orders to 64; refuses coefficients that are not finite."""
        if self.shape:
            raise ValueError(f"expected one function, found a batch of shape {self.shape}")
        whole(self._order, "order", 1, 64)
        c = finite(self._c.astype(np.float64), "coefficients")
        # The luminance of Rec. 709.
        row = c @ np.array([0.2126, 0.7152, 0.0722]) if self._is_color else c
        expect(search, str, "search", "grid or paper")
        return _lobe.peaks(np.ascontiguousarray(row)[None], self._order, search)

    def lights(
        self,
        count: int = 1,
        refine: bool = False,
        *,
        metric: str = "irradiance",
        choose: str = "residual",
        closed: bool = False,
        per_channel: bool = False,
        directions: npt.ArrayLike | None = None,
    ) -> Lights:
        """Directional lights and ambient light that approximate radiance (Sloan 2008): `count` of them at most; where fewer are found, the rest have
        no intensity. From order 2 on, to order 64; refuses coefficients that are not finite.

        `metric` is the function that they reproduce, "irradiance" or "radiance"; `choose` says which maxima become lights: by the "residual", one
        after the other, or by their "height". `closed` is one light in closed form, from where the linear band points, without these options;
        it and the ambient light may come out negative. With `per_channel` each channel of colors has lights of its own, not the directions of the
        luminance: directions (..., 3, count, 3), intensities (..., 3, count), ambient light and residual (..., 3).

        `directions`, (count, 3) of any length above zero, are those of lights that are known, the same for all functions: their intensities by
        `metric`, in this order."""
        self._expect_order(MOST_SEARCHED)
        count = whole(count, "count", 1, 64)
        if closed and (count, bool(refine), metric, choose) != (1, False, "irradiance", "residual"):
            raise ValueError("closed: expected no other option, as it has one light by its irradiance")
        known: Doubles | None = None
        if directions is not None:
            if closed or per_channel or (count, bool(refine), choose) != (1, False, "residual"):
                raise ValueError("directions: expected no other option but metric, as these lights are known")
            known, shape = unit_directions(directions)
            if len(shape) != 1:
                raise ValueError(f"directions: expected an array of shape (count, 3), found {np.shape(directions)}")
            count = whole(len(known), "directions", 1, 64)
        if per_channel and self._is_color:
            channels = Sh(np.ascontiguousarray(np.moveaxis(self._c, -1, -2)))
            return channels.lights(count, refine, metric=metric, choose=choose, closed=closed)
        rows = self._rows().astype(np.float64, copy=False)
        settings = {
            "count": count,
            "refine": bool(refine),
            "metric": metric,
            "choose": choose,
            "closed": bool(closed),
            "directions": None if known is None else known.tolist(),
        }
        found, intensities, ambient, residual = _lobe.lights(rows, self._order, settings)
        tail = (3,) if self._is_color else ()
        return Lights(
            found.reshape((*self.shape, count, 3)),
            intensities.reshape((*self.shape, count, *tail)),
            ambient.reshape(self.shape + tail),
            residual.reshape(self.shape + tail),
            (_lobe.irradiance_of_light(self._order) * intensities).reshape((*self.shape, count, *tail)),
        )

    def to_convention(self, name: Convention) -> Numbers:
        """The coefficients as another library keeps them, float64 or complex128, in its own shape.

        `lobe sh convert --to` writes the same numbers, and `lobe.CONVENTIONS` says what each name is. The batch comes
        first, and colors are an axis of three before the library's.

            >>> sky = lobe.Sh([1.0, 0.2, 0.5, -0.1])
            >>> sky.to_convention("pyshtools").shape  # for pyshtools.SHCoeffs.from_array
            (2, 2, 2)
            >>> sky.to_convention("healpy").dtype  # for healpy.alm2map
            dtype('complex128')
        """
        return encoded(self._rows().astype(np.float64, copy=False), name, self.shape)

    def encode(
        self, name: str | EngineForm, normal: npt.ArrayLike = (0.0, 0.0, 1.0), *, over_pi: bool = False, up: str = "z"
    ) -> Encoded:
        """Irradiance in fewer numbers, in an encoding named as in the command, such as "zh3", "ahd" or "h-6".

        `encodings` lists them with their errors. "packed" are the seven vectors cAr .. cC of Sloan's shader, "matrix"
        the 4x4 matrices of Ramamoorthi and Hanrahan, row after row. "r-h" are their nine coefficients of radiance,
        which have no Condon-Shortley phase. "packed-5" are fourteen vectors cAr .. cG, of five bands; the others take
        three. A function of numbers has three channels alike.

        "three", "babylon", "playcanvas", "filament", "godot", "unity", "unreal" and "cesium" are nine colors as that
        engine keeps them, in its order and its frame; `lobe.import_coefficients` reads them back.

            >>> irradiance = lobe.light("ambient", 3).convolve("cosine")
            >>> irradiance.encode("godot").numbers["L00"].round(3)
            array([1.128, 1.128, 1.128])

        `normal` is the geometric one of those that serve one side of a surface only. `over_pi` divides by π, as the shaders of Sloan's paper,
        Direct3D and Unity expect: what a white matte surface leaves of the irradiance. `up="y"` is for where y points up: directions, that of
        `normal` and those of `Encoded.eval` too, are then (x, z, -y) of Lobe's. The functions are irradiance, `convolve("cosine")` of
        radiance; bands that they lack count as zero."""
        rows = self._rows().astype(np.float64, copy=False)
        return encode(rows, self._order, name, normal, over_pi, up, self.shape)

    def encodings(self, normals: int = 1024) -> list[EncodingError]:
        """How far each encoding of this irradiance is from it, for that many normals over the sphere. One function."""
        if self.shape:
            raise ValueError(f"expected one function, found a batch of shape {self.shape}")
        normals = whole(normals, "normals", 1, 1 << 20)
        return [EncodingError(*row) for row in _lobe.encoding_errors(self._rows().astype(np.float64, copy=False), normals)]

    def band_energies(self) -> Numbers:
        """Σ_m c_lm² of each band: (..., n), for colors (..., n, 3)."""
        axis = -2 if self._is_color else -1
        ends = [l * l for l in range(self._order)]
        return np.add.reduceat(self._c * self._c, ends, axis=axis)

    def mean(self) -> Numbers:
        """The mean over the sphere, c_00/√4π."""
        first: Numbers = self._c[..., 0, :] if self._is_color else self._c[..., 0]
        mean: Numbers = first / self.dtype.type(np.sqrt(4.0 * np.pi))
        return mean

    # How it looks

    def plot(self, ax: Any = None, *, samples: int = 64) -> Any:
        """A balloon by matplotlib: the distance from the origin is |f|, of colors their mean; red where f is positive, blue where it is
        negative. `ax` is a 3d axes, which is made if there is none; it is returned. One function."""
        import matplotlib

        if self.shape:
            raise ValueError(f"expected one function, found a batch of shape {self.shape}")
        samples = whole(samples, "samples", 4, 1024)
        theta, phi = np.meshgrid(np.linspace(0, np.pi, samples), np.linspace(-np.pi, np.pi, 2 * samples), indexing="ij")
        d = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
        values = self.eval(d)
        values = values.mean(axis=-1) if self._is_color else values
        if ax is None:
            import matplotlib.pyplot as plt

            ax = plt.figure().add_subplot(projection="3d")
        points = np.abs(values)[..., None] * d
        colors = matplotlib.colormaps["coolwarm"](np.where(values >= 0, 1.0, 0.0))
        ax.plot_surface(*np.moveaxis(points, -1, 0), facecolors=colors, rstride=1, cstride=1, linewidth=0)
        reach = float(np.abs(values).max()) or 1.0
        ax.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach), xlabel="x", ylabel="y", zlabel="z")
        ax.set_box_aspect((1, 1, 1))
        return ax

    def _repr_png_(self) -> bytes | None:
        """The balloon of one function as a notebook shows it; a batch, or where matplotlib is not installed, shows itself in words."""
        if self.shape:
            return None
        try:
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure
        except ModuleNotFoundError:
            return None
        figure = Figure(figsize=(3.2, 3.2))
        FigureCanvasAgg(figure)
        self.plot(figure.add_subplot(projection="3d"))
        picture = io.BytesIO()
        figure.savefig(picture, format="png", dpi=100)
        return picture.getvalue()

    # Within

    def _expect_order(self, most: int) -> None:
        if self._order > most:
            raise ValueError(f"expected functions of order {most} at most, found order {self._order}; .resized({most}) cuts them off")

    def _rows(self) -> Numbers:
        batch = self.shape
        return np.ascontiguousarray(self._c).reshape((math.prod(batch), *self._c.shape[len(batch) :]))

    def _like(self, rows: Numbers, order: int) -> Sh:
        like = object.__new__(Sh)
        like._is_color, like._order = self._is_color, order
        like._c = rows.reshape(self.shape + ((order * order, 3) if self._is_color else (order * order,)))
        return like

    def _scaled(self, factors: list[float]) -> Sh:
        return self._like(_lobe.scale_bands(self._rows(), factors), self._order)

    def _factors(self, values: npt.ArrayLike) -> list[float]:
        array = numbers(values, "factors")
        if array.shape != (self._order,):
            raise ValueError(f"factors: expected one for each of {self._order} bands, found an array of shape {array.shape}")
        factors: list[float] = array.astype(np.float64).tolist()
        return factors

    def _alike(self, other: Sh) -> Sh:
        if (self._order, self._is_color) != (other._order, other._is_color):
            raise ValueError(f"expected functions of one order and kind, found {self!r} and {other!r}")
        return other
