"""Options of a bake. Written by tests/bake_fields.py from the options of the library: change those."""

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
    """Compress to this many clusters at most; 1 gives ordinary principal components; 1 to 65536; None: 64 where there
    is compression."""
    components: int | None = None
    """Compress to this many components in each cluster; 0 gives vector quantization; 0 to 192; None: 8 where there is
    compression."""
    weights: int | None = None
    """Compress, with this many bits for each weight: 8 or 16 in steps of its range, or 32; None: 16 where there is
    compression."""
