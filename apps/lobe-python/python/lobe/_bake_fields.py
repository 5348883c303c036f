"""x"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BakeFields:
    mode: str = "interreflected"
    order: int = 4
    samples: int|None = None
    bounces: int = 3
    energy_stop: float = 0.001
    seed: int = 0
    albedo: str|None = None
    backs: bool = False
    max_edge: float|None = None
    adaptive: float|None = None
    min_edge: float|None = None
    max_vertices: int|None = None
    no_split: bool = False
    texels: int|None = None
    unwrap: str = "auto"
    padding: int = 2
    texel_size: float|None = None
    chart_angle: float = 60.0
    denoise: bool = True
    grid: tuple[int,int,int]|None = None
    grid_box: tuple[float,float,float,float,float,float]|None = None
    clusters: int|None = None
    components: int|None = None
    weights: int|None = None
