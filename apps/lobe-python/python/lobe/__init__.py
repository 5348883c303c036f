"""Spherical-harmonic lighting over numpy arrays.

    >>> import lobe
    >>> sky = lobe.EnvMap.bundled("sunset").project(3)
    >>> sky
    Sh(order 3, rgb float64)
    >>> irradiance = sky.convolve("cosine")
    >>> bool(irradiance.eval([0, 0, 1])[1] > irradiance.eval([0, 0, -1])[1])
    True

Directions are right-handed with +z up; order n means n bands, n² coefficients. Radiance L is what arrives along one direction;
irradiance E is what a surface receives in all and never includes 1/π.
"""

import os as _os

from . import _lobe
from ._area_light import AreaLight
from ._bake import AdaptiveReport, BakeOptions, BakeReport, CompressReport, Matrices, Transfer, bake, merge
from ._camera import Camera, Traced
from ._compression import CompressedReport, CurvePoint, HalvesReport, LobesReport, compress, compress_f16, error_curve, fit_lobes
from ._conventions import CONVENTIONS
from ._encodings import Encoded, EncodingError
from ._env import MAPPINGS, EnvMap, LoadNote, Sun, Technique, export, project, reconstruct
from ._light import import_coefficients, light
from ._lobe import __version__
from ._moving import MovingOptions, MovingScene
from ._reflection import dfg, dfg_table, directional_albedo
from ._render import (
    Difference,
    SurfaceError,
    ZTest,
    compare,
    compare_surfaces,
    render,
    tone_mapped,
    trace,
    trace_shard,
    z_test,
)
from ._scene import Scene
from ._sh import Lights, Minimum, Sh
from ._shadow import (
    FieldReport,
    Spheres,
    VisibilityReport,
    field,
    field_shard,
    lamp,
    self_visibility,
    sphere_table,
    spheres,
)

# A child of fork has none of the threads that its parent works with.
if hasattr(_os, "register_at_fork"):
    _os.register_at_fork(after_in_child=_lobe.after_fork)

__all__ = [
    "CONVENTIONS",
    "MAPPINGS",
    "AdaptiveReport",
    "AreaLight",
    "BakeOptions",
    "BakeReport",
    "Camera",
    "CompressReport",
    "CompressedReport",
    "CurvePoint",
    "Difference",
    "Encoded",
    "EncodingError",
    "EnvMap",
    "FieldReport",
    "HalvesReport",
    "Lights",
    "LoadNote",
    "LobesReport",
    "Matrices",
    "Minimum",
    "MovingOptions",
    "MovingScene",
    "Scene",
    "Sh",
    "Spheres",
    "Sun",
    "SurfaceError",
    "Technique",
    "Traced",
    "Transfer",
    "VisibilityReport",
    "ZTest",
    "__version__",
    "bake",
    "compare",
    "compare_surfaces",
    "compress",
    "compress_f16",
    "dfg",
    "dfg_table",
    "directional_albedo",
    "error_curve",
    "export",
    "field",
    "field_shard",
    "fit_lobes",
    "import_coefficients",
    "lamp",
    "light",
    "merge",
    "project",
    "reconstruct",
    "render",
    "self_visibility",
    "sphere_table",
    "spheres",
    "tone_mapped",
    "trace",
    "trace_shard",
    "z_test",
]
