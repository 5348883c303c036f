#!/usr/bin/env python3
"""A closed, bumpy ball with tilted shading normals under even light of 1: Lobe beside both rules for such normals.

Lobe must agree with Mitsuba 3 where `lobe_matte.py` is the material, and must differ from Mitsuba's own rule where
normals tilt. The means show what each rule loses: after many bounces, a white ball of flat triangles is as bright as the
light.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from compare import judge, lobe_map, lobe_pictures, math, mi, mitsuba_pictures, np, shapes, twosided
from gltf import Gltf, y_up
from lobe_matte import lobe_matte, register

# Albedos and bounces.
CASES = ((1.0, 0), (1.0, 1), (1.0, 3), (1.0, 15), (0.5, 3))
# Degrees by which smooth normals are tilted; None stands for the normals of triangles.
TILTS = (None, 0, 20, 40, 60)
# From that tilt on, Mitsuba's own rule must differ.
NOTICED = 20
ROWS, COLUMNS = 20, 32
EYE, TARGET = (3.2, -2.6, 1.8), (0.0, 0.0, 0.0)


def even(d):
    return np.ones((*d.shape[:-1], 3))


def unit(rows):
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)


def sphere():
    """Points of the unit sphere: poles, and circles between them; and triangles that face outwards."""
    rows, columns = np.arange(1, ROWS) / ROWS, np.arange(COLUMNS) / COLUMNS
    theta, phi = np.meshgrid(np.pi * rows, 2 * np.pi * columns, indexing="ij")
    circles = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).reshape(-1, 3)
    at = lambda row, column: 2 + (row - 1) * COLUMNS + column % COLUMNS
    triangles = []
    for column in range(COLUMNS):
        triangles += [(0, at(1, column), at(1, column + 1)), (1, at(ROWS - 1, column + 1), at(ROWS - 1, column))]
        for row in range(1, ROWS - 1):
            a, b, c, d = at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)
            triangles += [(a, b, c), (a, c, d)]
    return np.concatenate([[(0, 0, 1), (0, 0, -1)], circles]), np.array(triangles)


def ball(tilt):
    """Positions, normals or None, and triangles."""
    points, triangles = sphere()
    x, y, z = points.T
    points = points * (1 + 0.45 * np.sin(4 * x + 1) * np.sin(4 * y) * np.cos(3 * z))[:, None]
    if tilt is None:
        return points, None, triangles
    a, b, c = (points[triangles[:, k]] for k in range(3))
    sums = np.zeros_like(points)
    for k in range(3):
        np.add.at(sums, triangles[:, k], np.cross(b - a, c - a))
    normals = unit(sums)
    aside = unit(np.cross(normals, np.random.default_rng(3).normal(size=normals.shape)))
    return points, math.cos(math.radians(tilt)) * normals + math.sin(math.radians(tilt)) * aside, triangles


def write_glb(path, positions, normals, triangles, albedo):
    color = {"baseColorFactor": [albedo, albedo, albedo, 1.0], "metallicFactor": 0.0}
    materials = [{"doubleSided": True, "pbrMetallicRoughness": color}]
    tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]}
    gltf = Gltf({**tree, "materials": materials, "bufferViews": [], "accessors": []}, b"")
    attributes = {"POSITION": gltf.add_vectors(y_up(positions))}
    if normals is not None:
        attributes["NORMAL"] = gltf.add_vectors(y_up(normals))
    primitive = {"attributes": attributes, "indices": gltf.add_indices(triangles), "material": 0}
    gltf.tree["meshes"] = [{"primitives": [primitive]}]
    gltf.write_glb(path)


def compare(lobe, folder, samples, tilt, albedo, bounces):
    """Prints three means and two judgements; returns whether the judgements are as they must be."""
    shape = ball(tilt)
    write_glb(folder / "ball.glb", *shape, albedo)
    ours, whole = lobe_pictures(lobe, folder / "ball.glb", folder, EYE, TARGET, samples, bounces)
    by_rule = []
    for material in (lobe_matte, twosided):
        shown = shapes([(*shape, [albedo] * 3)], material)
        by_rule.append(mitsuba_pictures(shown, EYE, TARGET, even, samples, bounces)[:, whole])
    name = f"{'flat' if tilt is None else f'{tilt}°'}, albedo {albedo}, {bounces} bounces"
    means = [pictures.mean() for pictures in (ours[:, whole], *by_rule)]
    print(f"{name:<28} Lobe {means[0]:.4f}, Mitsuba by Lobe's rule {means[1]:.4f}, by its own {means[2]:.4f}")
    agrees, is_same = (judge(f"  by {rule}", ours[:, whole], pictures, lambda x: x)
                       for rule, pictures in zip(("Lobe's rule", "its own"), by_rule))
    if tilt is None:
        return agrees and is_same
    return agrees and not (is_same and tilt >= NOTICED)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("lobe", help="the command, such as target/release/lobe")
    arguments.add_argument("--samples", type=int, default=256, help="paths of a pixel for each seed")
    options = arguments.parse_args()
    mi.set_variant("llvm_ad_rgb")
    register()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        lobe_map(folder / "sky.exr", 64, even)
        right = [compare(options.lobe, folder, options.samples, tilt, albedo, bounces)
                 for tilt in TILTS for albedo, bounces in CASES]
    if not all(right):
        sys.exit(f"{right.count(False)} of {len(right)} comparisons are not as they must be")
    print("all are as they must be")


if __name__ == "__main__":
    main()
