#!/usr/bin/env python3
"""Suns apart: the soft shadow of a sun in Lobe's pictures beside a far ball of light in Mitsuba 3.

Direct light of a sun alone, whose disc has a radius of 3 degrees: Lobe traces rays to the disc at each pixel, Mitsuba
draws points of the ball. Pixels count that the scene covers whole, and that no shadow edge of a triangle's own side makes
a matter of chance. The control has the sun mirrored for Mitsuba alone, which must differ.
"""

import argparse
import json
import math
import sys
import tempfile
from pathlib import Path

from compare import SCENES, SEEDS, SIZE, FOV, OpenEXR, lobe_map, mi, np, read_glb, run, sensor, shapes

RADIUS = math.radians(3.0)
DIRECTION = np.array([0.5, 0.4, 0.65]) / np.linalg.norm([0.5, 0.4, 0.65])
IRRADIANCE = (3.0, 2.5, 2.0)
# How far away the ball of Mitsuba is, in units of scenes of some ten units: its rays are parallel to 0.1 degrees.
FAR = 5000.0
# The relative RMS difference that is allowed beside the noise: steps of 1/64 of the sun in the penumbra, and rounding.
MOST = 0.01


def lobe_picture(lobe, folder, scene, eye, target):
    run(lobe, "bake", scene, "-o", folder / "b.glb", "--order", 3, "--samples", 4, "--mode", "shadowed", "--no-split")
    sun = {"direction": DIRECTION.tolist(), "irradiance": IRRADIANCE, "diameter": 2 * math.degrees(RADIUS)}
    (folder / "suns.json").write_text(json.dumps(sun))
    run(lobe, "render", "baked", folder / "b.glb", "--env", folder / "black.exr", "--suns", folder / "suns.json",
        "--background", "none", "-o", folder / "p.exr", "--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", 256, "--fov", FOV,
        "--eye", ",".join(map(str, eye)), "--target", ",".join(map(str, target)))
    with OpenEXR.File(str(folder / "p.exr"), separate_channels=True) as file:
        channels = file.channels()
        picture = np.stack([channels[name].pixels for name in "RGB"], -1).astype(np.float64)
        return picture, channels["A"].pixels == 1.0


def mitsuba_pictures(primitives, eye, target, direction, samples):
    radiance = [e / (math.pi * math.sin(RADIUS) ** 2) for e in IRRADIANCE]
    ball = {"type": "sphere", "center": (FAR * direction).tolist(), "radius": FAR * math.sin(RADIUS),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}}}
    scene = mi.load_dict({"type": "scene", **shapes(primitives), "sun": ball, "sensor": sensor(eye, target, samples),
                          "integrator": {"type": "path", "max_depth": 2}})
    return np.stack([np.array(mi.render(scene, spp=samples, seed=seed + 1)) for seed in range(SEEDS)])


def compared(name, ours, theirs):
    """Prints the bias and the difference beside the noise; whether both are small."""
    difference, size = ours - theirs.mean(0), math.sqrt((theirs.mean(0) ** 2).mean())
    noise = (theirs.var(0, ddof=1) / SEEDS).mean()
    rms = math.sqrt(max((difference**2).mean() - noise, 0.0)) / size
    bias = difference.mean() / theirs.mean()
    agrees = rms <= MOST and abs(bias) <= MOST
    print(f"{name:<24} {100 * bias:+8.3f} %   {100 * rms:7.3f} %   {'agrees' if agrees else 'DIFFERS'}", flush=True)
    return agrees


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("lobe", help="the command, such as target/release/lobe")
    arguments.add_argument("--samples", type=int, default=256, help="paths of a pixel for each seed of Mitsuba")
    arguments.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba; scalar_rgb needs no LLVM")
    options = arguments.parse_args()
    mi.set_variant(options.variant)
    print(f"{'':<24} bias of the mean   RMS difference less noise")
    agree = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        lobe_map(folder / "black.exr", 16, lambda d: np.zeros((*d.shape[:-1], 3)))
        for name, (eye, target) in SCENES.items():
            ours, whole = lobe_picture(options.lobe, folder, f"built-in:{name}", eye, target)
            primitives, _ = read_glb(folder / "b.glb")
            theirs = mitsuba_pictures(primitives, eye, target, DIRECTION, options.samples)
            agree.append(compared(name, ours[whole], theirs[:, whole]))
        mirrored = mitsuba_pictures(primitives, eye, target, DIRECTION * [1, -1, 1], options.samples)
        control = compared(f"{name}, sun mirrored", ours[whole], mirrored[:, whole])
    if control:
        sys.exit("the control agrees: this comparison would not notice a mirrored sun")
    if not all(agree):
        sys.exit("Lobe and Mitsuba differ")
    print("all agree, and the control does not")


if __name__ == "__main__":
    main()
