#!/usr/bin/env python3
"""Animated characters that others made: Lobe poses and traces them, beside `poser.py` and Mitsuba 3.

Each is traced at three times of its first animation, with the normals of its triangles and with smooth ones. A last
comparison at each time must fail: Mitsuba's pose is later by a twentieth of a second. All is matte, of one color.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from compare import (FOV, SIZE, judge, light, lobe_map, lobe_pictures, math, mi, mitsuba_pictures, np, sensor, shapes,
                     twosided)
from gltf import Gltf
from lobe_matte import lobe_matte, register
from poser import duration, pose

# The characters of peers/motion that are traced where no file is named; and what no character has: step and cubic
# samplers, morph targets that move, a mirror.
NAMES = ("Fox", "dolphin", "dancer", "made")
COLOR = (0.8, 0.6, 0.4)
# Times as parts of the animation, at which all characters move. The control is later, in seconds. There is none where
# the pose moves by less than a part of its size, a seventh of a pixel.
TIMES, LATE, LEAST_MOVE = (0.2, 0.37, 0.55), 0.05, 0.002
# From where the eye looks at the middle of the pose.
VIEW = np.array((0.6, -0.7, 0.39)) / np.linalg.norm((0.6, -0.7, 0.39))
BOUNCES = 1
MASK_SAMPLES = 256


def characters(files):
    """Names and files: those given, or those that peers/motion gets from public registries."""
    if files:
        return [(Path(file).stem, file) for file in files]
    lister = Path(__file__).parent.parent / "motion" / "list.mjs"
    answer = subprocess.run(["node", lister], stdout=subprocess.PIPE, check=False)
    if answer.returncode:
        sys.exit("peers/motion/list.mjs could not get the characters; name .gltf or .glb files in place of them")
    models = {model["name"]: model["file"] for model in json.loads(answer.stdout)}
    return [(name, models[name]) for name in NAMES]


def bare(gltf, is_smooth):
    """The same file in one matte color; without normals, or with smooth ones where it has none."""
    gltf = gltf.copied()
    tree = gltf.tree
    color = {"baseColorFactor": [*COLOR, 1.0], "metallicFactor": 0.0}
    tree["materials"] = [{"doubleSided": True, "pbrMetallicRoughness": color}]
    for left_out in ("textures", "images", "samplers", "extensionsUsed", "extensions", "cameras"):
        tree.pop(left_out, None)
    for primitive in (primitive for mesh in tree["meshes"] for primitive in mesh["primitives"]):
        attributes, targets = primitive["attributes"], primitive.get("targets", [])
        primitive["material"] = 0
        primitive.pop("extensions", None)
        if not is_smooth:
            for vectors in (attributes, *targets):
                vectors.pop("NORMAL", None)
        elif "NORMAL" not in attributes:
            attributes["NORMAL"] = gltf.add_vectors(smooth_normals(gltf, primitive))
        for vectors in (attributes, *targets):
            vectors.pop("TANGENT", None)
    return gltf


def smooth_normals(gltf, primitive):
    """At each place the mean of the normals of all triangles that meet there, by their areas."""
    positions = gltf.accessor(primitive["attributes"]["POSITION"])
    triangles = gltf.accessor(primitive["indices"]) if "indices" in primitive else np.arange(len(positions))
    triangles = triangles.reshape(-1, 3)
    places, place_of = np.unique(positions, axis=0, return_inverse=True)
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    sums = np.zeros_like(places)
    for k in range(3):
        np.add.at(sums, place_of.ravel()[triangles[:, k]], np.cross(b - a, c - a))
    normals = sums[place_of.ravel()]
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def camera(primitives):
    """Eye and target that show all of a pose, as large as it can be."""
    points = np.concatenate([primitive.positions for primitive in primitives])
    target = (points.min(0) + points.max(0)) / 2
    right = np.cross((0, 0, 1), VIEW) / np.linalg.norm(np.cross((0, 0, 1), VIEW))
    x, y, near = ((points - target) @ np.stack([right, np.cross(VIEW, right), VIEW], 1)).T
    slope = math.tan(math.radians(FOV / 2))
    return target + VIEW * (near + np.maximum(abs(x) * SIZE[1] / SIZE[0], abs(y)) / slope).max(), target


def shown_at(shape, time, material):
    """A pose as meshes of Mitsuba."""
    return shapes([(*primitive, COLOR) for primitive in pose(shape, time)], material)


def moved(before, after):
    """How far the vertices of a pose have moved, over its size."""
    before, after = (np.concatenate([primitive.positions for primitive in pose]) for pose in (before, after))
    return math.sqrt(((after - before)**2).sum(1).mean()) / np.ptp(before, 0).max()


def whole_pixels(shown, eye, target):
    """Pixels that the shapes cover, by samples that no judged picture has."""
    scene = mi.load_dict({"type": "scene", **shown, "light": {"type": "constant"},
                          "integrator": {"type": "path", "max_depth": 1, "hide_emitters": True},
                          "sensor": sensor(eye, target, MASK_SAMPLES, "rgba")})
    return np.array(mi.render(scene, spp=MASK_SAMPLES, seed=0))[..., 3] == 1.0


def compare(lobe, name, gltf, folder, samples, smooth_material):
    """Compares a character at all times; returns whether all agree, and whether all controls differ."""
    agree, differ = [], []
    for is_smooth in (False, True):
        shape = bare(gltf, is_smooth)
        shape.write_glb(folder / "character.glb")
        for time in (part * duration(shape) for part in TIMES):
            eye, target = camera(pose(shape, time))
            whole = whole_pixels(shown_at(shape, time, twosided), eye, target)
            more = ("--time", time)
            ours, _ = lobe_pictures(lobe, folder / "character.glb", folder, eye, target, samples, BOUNCES, more)

            def agrees(title, time, material):
                shown = shown_at(shape, time, material)
                theirs = mitsuba_pictures(shown, eye, target, light, samples, BOUNCES)
                return judge(title, ours[:, whole], theirs[:, whole], lambda x: x)

            title = f"{name} {time:.2f} s"
            if is_smooth:
                agree.append(agrees(f"{title}, smooth", time, smooth_material))
            else:
                agree.append(agrees(f"{title}, flat", time, twosided))
                if moved(pose(shape, time), pose(shape, time + LATE)) > LEAST_MOVE:
                    differ.append(not agrees(f"{title}, flat, late", time + LATE, twosided))
    return all(agree), bool(differ) and all(differ)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("lobe", help="the command, such as target/release/lobe")
    arguments.add_argument("files", nargs="*", help="animated .gltf or .glb files in place of those of peers/motion")
    arguments.add_argument("--samples", type=int, default=128, help="paths of a pixel for each seed")
    arguments.add_argument("--own-rule", action="store_true", help="smooth normals by Mitsuba's rule, which differs")
    options = arguments.parse_args()
    mi.set_variant("llvm_ad_rgb")
    register()
    print(f"{'':<28} {'bias of the mean':<20} difference/noise")
    answers = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        lobe_map(folder / "sky.exr", 512)
        for name, file in characters(options.files):
            answers.append(compare(options.lobe, name, Gltf.read(file), folder, options.samples,
                                   twosided if options.own_rule else lobe_matte))
    if not all(differs for _, differs in answers):
        sys.exit("a control agrees or nothing moves: this comparison would not notice a pose that is late")
    if not all(agrees for agrees, _ in answers):
        sys.exit("Lobe and Mitsuba differ")
    print("all agree, and the controls do not")


if __name__ == "__main__":
    main()
