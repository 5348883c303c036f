"""A ball in Mitsuba 3, seen from each direction, lit by what the exported program does.

mitsuba_balls.py FOLDER OUT.json
"""
import importlib.util
import json
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
from mitsuba import ScalarTransform4f as T  # noqa: E402

AXES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
DIAGONALS = [np.array((x, y, z)) / np.sqrt(3) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
# Paths in each of 16 pixels. Those of the matte ball go where the sky is bright.
PATHS = {"matte": 4096, "mirror": 16}
SURFACES = {
    "matte": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}},
    "mirror": {"type": "conductor", "material": "none"},
}


def picture(program, d, surface):
    up = [0, 0, 1] if abs(d[1]) > 0.9 else [0, 1, 0]
    place = T().look_at(origin=[3 * float(c) for c in d], target=[0, 0, 0], up=up) @ T().scale([0.005, 0.005, 1])
    film = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    sampler = {"type": "independent", "sample_count": PATHS[surface]}
    sensor = {"type": "orthographic", "to_world": place, "film": film, "sampler": sampler}
    ball = {"type": "sphere", "bsdf": SURFACES[surface]}
    integrator = {"type": "path", "max_depth": 2}
    shown = {"integrator": integrator, "sensor": sensor, "ball": ball}
    scene = mi.load_dict({"type": "scene", **shown, **program.emitters()})
    return np.array(mi.render(scene)).mean((0, 1))[:3].tolist()


def main():
    folder, out = map(Path, sys.argv[1:])
    spec = importlib.util.spec_from_file_location("sky", folder / "sky.py")
    program = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(program)
    values = {name: [picture(program, d, name) for d in [*AXES, *DIAGONALS]] for name in SURFACES}
    out.write_text(json.dumps({"version": mi.__version__, "values": values}))


if __name__ == "__main__":
    main()
