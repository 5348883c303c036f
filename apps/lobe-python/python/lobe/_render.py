"""Pictures of scenes, and how far two pictures are apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import expect, finite, numbers, whole
from ._bake import expect_parts, expect_shard
from ._camera import (
    Background,
    Camera,
    Picture,
    Suns,
    Traced,
    background_of,
    checked,
    expect_surfaces,
    lighting_of,
    merged,
    picture_of,
    size_of,
    tracing_of,
)
from ._env import EnvMap
from ._moving import MovingOptions, MovingScene
from ._scene import Path, Progress, Scene
from ._sh import Sh

MOST_BANDS = 8
"""Bands of transfer at most: those of the light beyond count nothing."""

IRRADIANCE_BANDS = 3
"""Bands of a map of which irradiance is made: higher ones hardly show."""


def render(
    scene: Path | Scene,
    light: EnvMap | Sh,
    *,
    mode: str | None = None,
    transfer: Path | None = None,
    lobe: str | None = None,
    order: int | None = None,
    bake_samples: int | None = None,
    bounces: int | None = None,
    time: float | None = None,
    camera: Camera | None = None,
    width: int = 512,
    height: int = 384,
    rays: int = 2,
    background: Background = "env",
    suns: Suns = "auto",
    surfaces: str = "matte",
    progress: Progress | None = None,
) -> Picture:
    """A scene under light from everywhere, as by `lobe render`: radiance of shape (height, width, 3), row 0 on top.

    Without a mode the transfer that is baked into a .glb or .gltf lights it at once, or that in a file of `transfer`, which `lobe.bake`, `compress` or
    `fit_lobes` wrote for this scene without it, a lightmap among them; a scene without any is baked, "interreflected". `mode` asks for another: "irradiance", that of the light by the shading normal; "unshadowed",
    "shadowed" or "interreflected" transfer, baked on the way where the scene is not; "glossy" with a `lobe` of reflection, "phong:E" or "ggx:ALPHA"
    [default: ggx:0.3], by the matrices in `transfer` or baked on the way; "fields" or "exponentials", a scene that moves at a `time` in seconds
    [default: 0], of which `MovingScene` has the options. What is baked has an `order` of 1 to 8 [default: 4], `bake_samples` paths from each vertex
    [default: 1024, or up to 4096 where their noise is above 2 %] and `bounces` [default: 3]; of what was baked before they are expected to be these.

    `suns` cast shadows by themselves, beside the expansion: "auto" finds in a map up to four, each of half a percent of its light at least; "none" leaves all
    in the expansion; a number takes so many at most; a .json file of `lobe env sun --json` or a list of `Sun` adds its own.

    `surfaces` of transfer are "matte"; "gltf", metallic-roughness with textures and emission; or "gltf-separable", as `trace` has them.

    Behind the scene is a `background`: "env", the map, or the expansion itself; "light", the bands that light the scene; "none", with which the picture
    has shape (height, width, 4), premultiplied by its alpha; or a color, three numbers of linear radiance or "#rrggbb" of sRGB. `rays` squared rays are
    averaged for each pixel, four times as many where surfaces end. Backs of double-sided surfaces, which files do
    not hold, are baked as far as the view shows them. Ctrl-C and what `progress(done, total)` raises, for one step after the other, stop it.
    """
    if mode in ("fields", "exponentials"):
        if (transfer, lobe) != (None, None):
            raise ValueError(f"transfer and lobe: not of the mode {mode}")
        if expect_surfaces(surfaces) != "matte":
            raise ValueError(f"surfaces: matte in the mode {mode}; the command lobe render moving has others")
        options = MovingOptions(method=mode, order=order, bake_samples=bake_samples, bounces=bounces)
        moving = MovingScene(scene, options)
        seconds = 0.0 if time is None else time
        return moving.render(light, seconds, camera=camera, width=width, height=height, rays=rays, background=background, suns=suns, progress=progress)
    if time is not None:
        raise ValueError("time: only of the modes fields and exponentials")
    asked: dict[str, object] = {"mode": mode, "transfer": transfer, "lobe": lobe, "bake_samples": bake_samples, "bounces": bounces}
    if mode == "irradiance":
        if any(asked[name] is not None for name in asked if name != "mode") or order is not None:
            raise ValueError("transfer, lobe, order, bake_samples and bounces: only of a mode with transfer")
        if expect_surfaces(surfaces) != "matte":
            raise ValueError("surfaces: matte in the mode irradiance")
    elif order is not None:
        whole(order, "order", 1, MOST_BANDS)
    view, size = checked(light, camera)._view(), size_of(width, height)
    behind = background_of(background)
    bands = IRRADIANCE_BANDS if mode == "irradiance" else MOST_BANDS
    lighting = lighting_of(light, bands, suns)
    method = None if mode == "irradiance" else asked
    count, model = whole(rays, "rays", 1, 64), expect_surfaces(surfaces)
    if model != "matte" and (mode == "glossy" or lobe is not None):
        raise ValueError("surfaces: glossy transfer reflects by its lobe; leave surfaces out")
    return _lobe.render_still(Scene.of(scene), method, order, lighting, behind, view, size, count, model, progress)


def trace(
    scene: Path | Scene,
    light: EnvMap | Sh,
    *,
    time: float | None = None,
    camera: Camera | None = None,
    width: int = 512,
    height: int = 384,
    samples: int = 64,
    bounces: int = 3,
    seed: int = 0,
    surfaces: str = "matte",
    background: Background = "env",
    merge: Sequence[Path] = (),
    progress: Progress | None = None,
) -> Traced:
    """A scene path traced under light from everywhere: the truth beside `render`.

    `scene` is a file, or "built-in:still-life" or another scene of Lobe. With a `time`, in seconds, it is one that moves, with its lamps.
    `samples` paths for each pixel, of up to `bounces` reflections before the visible one. `surfaces` are "matte", as in a bake; "gltf", by the
    metallic-roughness model of glTF with height-correlated masking; or "gltf-separable", as its specification prints that. `background` is that of
    `render`; the light that was given is the light that lights. `merge` takes the paths from all files that
    `trace_shard` wrote with the same options, on any machines. Ctrl-C and what `progress(done, total)` raises stop it.
    """
    if time is not None:
        return MovingScene(scene).trace(
            light,
            time,
            camera=camera,
            width=width,
            height=height,
            samples=samples,
            bounces=bounces,
            seed=seed,
            surfaces=surfaces,
            background=background,
            merge=merge,
            progress=progress,
        )
    asked = tracing_of(light, camera, width, height, samples, bounces, seed, surfaces, background)
    with merged(expect_parts(merge)) as share:
        return picture_of(_lobe.render_traced(Scene.of(scene), *asked, share, progress))


def trace_shard(
    scene: Path | Scene,
    light: EnvMap | Sh,
    output: Path,
    shard: tuple[int, int],
    *,
    time: float | None = None,
    camera: Camera | None = None,
    width: int = 512,
    height: int = 384,
    samples: int = 64,
    bounces: int = 3,
    seed: int = 0,
    surfaces: str = "matte",
    background: Background = "env",
    progress: Progress | None = None,
) -> None:
    """Traces part i of n of the pixels of `trace`, `shard=(i, n)` from 1 on, and writes them as a .safetensors file, as by `lobe render --shard`.

    What was stopped, by Ctrl-C or by what `progress(done, total)` raises, goes on from its file. `trace(.., merge=files)` makes the picture of all.
    """
    if time is not None:
        MovingScene(scene).trace_shard(
            light,
            output,
            shard,
            time,
            camera=camera,
            width=width,
            height=height,
            samples=samples,
            bounces=bounces,
            seed=seed,
            surfaces=surfaces,
            background=background,
            progress=progress,
        )
        return
    asked = tracing_of(light, camera, width, height, samples, bounces, seed, surfaces, background)
    _lobe.render_traced(Scene.of(scene), *asked, (output, expect_shard(shard)), progress)


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
    """HDR-FLIP, of pictures for a display FLIP, 0 to 1: the difference that one sees when flipping between them."""


def tone_mapped(
    picture: npt.ArrayLike, *, tone: Literal["reinhard", "aces", "agx", "neutral", "clip"] = "reinhard", exposure: float | None = None
) -> npt.NDArray[np.uint8]:
    """A picture of shape (height, width, 3) in linear light as a display shows it: bytes of sRGB of that shape.

    Light is multiplied by 2^exposure, and the tone curve brings it into 0 to 1. Without an `exposure` the log-average luminance becomes 0.18.
    """
    return _lobe.tone_mapped(_picture(picture), str(tone), None if exposure is None else float(exposure))


PIXELS_PER_DEGREE = 67.0
"""Of a 4K display that is as far away as it is wide."""


def compare(
    image: npt.ArrayLike, reference: npt.ArrayLike, *, pixels_per_degree: float = PIXELS_PER_DEGREE, for_display: bool = False
) -> Difference:
    """How far a picture of shape (height, width, 3) in linear light is from a reference of the same size.

    `pixels_per_degree` of visual angle are for FLIP. With `for_display` the pictures are what a display shows, 0 to 1 in linear light, and FLIP is
    that of such pictures, as the command takes it of .png and .jpg files.
    """
    a, b = (_picture(x) for x in (image, reference))
    if a.shape != b.shape:
        raise ValueError(f"pictures: expected one size, found {a.shape} and {b.shape}")
    if not (np.isfinite(pixels_per_degree) and pixels_per_degree > 0):
        raise ValueError(f"pixels_per_degree: expected a number above 0, found {pixels_per_degree}")
    return Difference(*_lobe.compare(a, b, float(pixels_per_degree), bool(for_display)))


def _picture(image: npt.ArrayLike) -> Picture:
    picture = finite(np.ascontiguousarray(numbers(image, "picture"), dtype=np.float32), "picture")
    if picture.ndim != 3 or picture.shape[-1] != 3 or picture.size == 0:
        raise ValueError(f"picture: expected an array of shape (height, width, 3), found {picture.shape}")
    return picture


@dataclass(frozen=True)
class SurfaceError:
    """How far a picture is from a reference of which there are two independent halves, whose noise is subtracted."""

    pixels: int
    """The pixels that count: those that show surfaces in both halves, and nothing beside them."""
    relative_rms: float
    """The root of the mean squared error as a part of that of the reference."""
    uncertainty: float
    """How far `relative_rms` may be raised by chance: one standard error."""
    mean_ratio: float
    """The mean of the picture divided by that of the reference."""
    psnr: float
    """The peak signal-to-noise ratio in decibels, of a peak that a thousandth of the reference's values exceed."""
    noise: float
    """The noise of the mean of both halves as a part of the reference."""
    dark: float
    """The part of the pixels that are below a tenth of a reference that is above a quarter of its mean."""


def compare_surfaces(image: npt.ArrayLike, reference: Traced, half: Traced) -> SurfaceError:
    """How far a picture of shape (height, width, 3) is from the truth, which two traced pictures of other seeds estimate, as `lobe compare --half` does.

    The mean of the product of both differences, (P - A)(P - B), has no noise of the truth in it: halves may be noisier than the error that they measure.
    Pixels count that show a surface in both and nothing beside it.
    """
    for traced in (reference, half):
        expect(traced, Traced, "picture", "what lobe.trace returns")
    picture, *halves = (_picture(x) for x in (image, _colors(reference), _colors(half)))
    if any(x.shape != picture.shape for x in halves):
        raise ValueError(f"pictures: expected one size, found {[x.shape for x in (picture, *halves)]}")
    if np.array_equal(halves[0], halves[1]):
        raise ValueError("half: expected another seed than that of the reference, found the same picture")
    counts = (reference.coverage >= 1) & (half.coverage >= 1)
    return SurfaceError(*_lobe.compare_halves(picture, halves, np.ascontiguousarray(counts)))


def _colors(traced: Traced) -> Picture:
    """The radiance of a traced picture, without an alpha."""
    return traced.mean[..., :3]


@dataclass(frozen=True)
class ZTest:
    """Whether chance explains the differences of two traced pictures; three numbers each, for red, green and blue."""

    mean_z: tuple[float, ...]
    """The mean of the differences in units of their standard deviation; 0 without a bias."""
    p_bias: tuple[float, ...]
    """The probability of a mean that far from 0 by chance."""
    spread: tuple[float, ...]
    """The mean of their squares as a multiple of what is expected; 1 if the variances are right."""
    p_spread: tuple[float, ...]
    """The probability of one that large by chance."""
    passes: bool
    """Whether chance explains them at the level of significance, for all six numbers together (Šidák)."""


def z_test(picture: Traced, reference: Traced, *, level: float = 0.01) -> ZTest:
    """Tests by their variance whether two path-traced pictures of one size, of other paths, show the same light, as `lobe compare --z-test`
    does: `level` is the probability that two such are told apart by mistake. Needs variances of five degrees of freedom or more."""
    if not 0.0 < level < 1.0:
        raise ValueError(f"level: expected a probability above 0 and below 1, found {level}")
    for traced in (picture, reference):
        expect(traced, Traced, "picture", "what lobe.trace returns")
    a, b = ((_picture(_colors(x)), _picture(x.variance), float(x.degrees_of_freedom)) for x in (picture, reference))
    if not a[0].shape == a[1].shape == b[0].shape == b[1].shape:
        raise ValueError(f"pictures: expected one size, found {[x.shape for x in (*a[:2], *b[:2])]}")
    *numbers_of, passes = _lobe.z_test(a, b, float(level))
    mean_z, p_bias, spread, p_spread = (tuple(x) for x in numbers_of)
    return ZTest(mean_z, p_bias, spread, p_spread, passes)
