"""Options of jobs. Written by tests/option_fields.py from the options of the library: change those."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BakeFields:
    """All options of a bake, in the names of the command."""

    mode: str = "interreflected"
    """The light that is baked: unshadowed, shadowed, interreflected, glossy."""
    order: int = 4
    """The order (number of bands): n² coefficients, three times as many where light meets colors; 1 to 8."""
    samples: int | None = None
    """Paths from each vertex; powers of two are distributed best; 1 to 16777216; None: 1024, or up to 4096 where their
    noise is above 2 %."""
    bounces: int = 3
    """With mode interreflected and glossy: reflections at most; 0 to 255."""
    energy_stop: float = 0.001
    """With mode interreflected and glossy: leave out reflections that carry less than this part of the energy; 0 keeps
    all."""
    seed: int = 0
    """The same seed gives the same bytes."""
    albedo: str | None = None
    """Where the albedo of the surface itself is; not of mode glossy and grid, whose matrices never have it: vertex,
    none; None: none if a texture colors any surface, else vertex."""
    backs: bool = False
    """Keep the transfer of the backs of double-sided surfaces in the file, too, for the side from which corners run
    clockwise. Without it lobe render bakes those that it shows, and other programs have none. Only in a .glb without
    compression."""
    parts: str = "whole"
    """With mode interreflected: the parts of the transfer in the file. Pictures under suns need both, and bake the
    direct one on the way where a file holds the whole alone. Only in a .glb without compression: whole,
    direct,reflected."""
    max_edge: float | None = None
    """Split triangles first until no edge is longer than this, in the scene's unit of length."""
    adaptive: float | None = None
    """Split triangles where transfer between vertices is farthest off, until that is less than this part of it, or
    there are max_vertices; None: 0.01; none are split for a .safetensors file, nor after max_edge."""
    min_edge: float | None = None
    """Leave edges that are shorter than this; None: 1/1024 of the scene's diagonal."""
    max_vertices: int | None = None
    """The most vertices that splitting may leave the scene, spent where transfer is farthest off; None: four times
    those of the scene, at least 20000."""
    no_split: bool = False
    """Bake at the vertices that the scene has, however few."""
    texels: int | None = None
    """Bake at the W × W texels of a lightmap instead of at vertices, with the normals that normal maps have there, in
    texture coordinates of set 1 or else 0 that do not overlap, or of an unwrapping; 1 to 16384."""
    unwrap: str = "auto"
    """With texels: whether to unwrap the scene into texture coordinates of its own: auto, always, never."""
    padding: int = 2
    """With texels: empty texels around each chart of a scene that is unwrapped; 0 to 256."""
    texel_size: float | None = None
    """With texels: the side of a texel on the surfaces of a scene that is unwrapped, in its unit of length; None: the
    smallest with which all charts fit."""
    chart_angle: float = 60.0
    """With texels: the largest angle in degrees between a triangle and its chart where the scene is unwrapped: smaller
    ones distort less and cut more."""
    denoise: bool = True
    """With texels: whether to average texels that differ by their noise alone."""
    grid: tuple[int, int, int] | None = None
    """Bake the light that arrives at points in space, as matrices: NX × NY × NZ points in the scene's box."""
    grid_box: tuple[float, float, float, float, float, float] | None = None
    """With grid: two corners of the box, whose corners are points; None: the scene's box, with points in the middle of
    as many equal parts."""
    clusters: int | None = None
    """Compress to this many clusters at most; 1 gives ordinary principal components; 1 to 65536; None: 64."""
    components: int | None = None
    """Compress to this many components in each cluster; 0 gives vector quantization; 0 to 192; None: 8."""
    weights: int | None = None
    """Compress, with this many bits for each weight: 8 or 16 in steps of its range, or 32, which programs that keep
    floats alone do not spoil (Blender); None: 16."""


@dataclass(frozen=True)
class MovingFields:
    """All options of what is baked of a scene that moves, and how it is shaded, in the names of the command."""

    method: str = "fields"
    """How parts that move hide the sky: fields, exponentials."""
    spheres: int | None = None
    """Spheres fitted to each part that is deformed, and with method exponentials to each that moves; 1 to 4096; None:
    64 and 16."""
    exponential: str = "grid"
    """With method exponentials: the exponential: values on a grid of directions; the best linear function of single
    spheres; that after halving, then squared."""
    sphere_bounce: bool = False
    """Light that spheres send on, one bounce."""
    sphere_table: str | None = None
    """The table of spheres, a .safetensors file of lobe spheres table, of any clamp and tolerance; made and written if
    it is not there."""
    sphere_window: float | None = None
    """The width of a window on what single spheres leave visible, in bands; None: none."""
    interpolation: str = "linear"
    """How fields are interpolated between their spheres: linear has kinks that a moving shadow shows, cubic has none
    for twice the reads: linear, cubic."""
    group: int = 0
    """Vertices, a multiple of 16, for which spheres far away are summed once; 0: for each vertex; 0 to 4096."""
    far: float = 0.05
    """With group, spheres are far away where its radius is at most this part of their distance: the less, the nearer to
    no groups."""
    cut: float = 0.2
    """Spheres near each other count as one where what holds them all reaches at most this part of its distance; 0: each
    counts by itself."""
    no_share_overlaps: bool = False
    """Every sphere hides all that it covers, as published; without this those that overlap share it."""
    negligible: float | None = None
    """For each vertex the fields that look smallest are left out, up to this solid angle in all, in steradians; 0:
    none; None: 0.0063, a thousandth of a hemisphere."""
    max_edge: float | None = None
    """Split edges that are longer at a key of the animation, in the scene's units, for finer shadows. Not of a scene
    description."""
    still_points: int = 4096
    """Points of the grid at which it is found how much of the sky the parts that stand still leave to those that move;
    0: they hide nothing from them, and only receive shadows; 0 to 16777216."""
    bounces: int | None = None
    """Reflections at most; of what moves within each part; 0 to 255; None: 3, or those of the file."""
    bake_samples: int | None = None
    """Paths from each vertex where the scene is not baked yet; 1 to 1048576; None: 1024, or up to 4096 where their
    noise is above 2 %."""
    max_vertices: int | None = None
    """Where a scene is baked: the most vertices that splitting may leave it, spent where transfer is farthest off. Of a
    scene that moves, what moves takes half of the new ones at most, and its shadows half of the rest; None: four times
    those of the scene, at least 20000."""
    no_split: bool = False
    """Bake at the vertices that the scene has, however few."""
