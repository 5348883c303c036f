#!/usr/bin/env python3
"""Truth and transfer of Lobe beside Mitsuba 3, on three scenes: bias, and difference in units of the noise.

Both programs run with several seeds; the spread of the seeds is the noise. A last comparison, with the map mirrored for
Mitsuba alone, must fail: it shows that the test would notice.
"""

import argparse
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

try:
    import mitsuba as mi
    import OpenEXR
except ImportError as missing:
    sys.exit(f"{missing}; pip install mitsuba OpenEXR numpy")

from gltf import Gltf, lobe_frame

# Eye and target of each scene, in Lobe's frame.
SCENES = {
    "ball": ((4.0, -3.0, 2.5), (0.0, 0.0, 0.5)),
    "columns": ((5.0, -9.0, 5.0), (0.0, 0.0, 1.5)),
    "terrain": ((6.0, -6.0, 5.0), (0.0, 0.0, 0.0)),
}
FOV = 40.0
SIZE = (96, 72)
BOUNCES = 3
SEEDS = 4
RECEIVERS = 300
# Differences that are allowed: of the means, in standard errors or relative, whichever is more; of all numbers, the root
# mean square over that of the noise.
MOST_SIGMA, MOST_BIAS, MOST_RATIO = 4.0, 0.002, 1.15


def light(d):
    """A smooth sky with a soft sun, symmetric about no plane; radiance towards the unit vectors d."""
    def lobe(axis, sharpness):
        axis = np.array(axis) / np.linalg.norm(axis)
        return np.exp(sharpness * (d @ axis - 1.0))[..., None]
    return (0.2 + lobe((0.5, 0.7, 0.6), 20.0) * [6.0, 5.0, 3.5] + lobe((-0.9, 0.1, 0.4), 6.0) * [0.2, 0.7, 0.3]
            + (0.5 + 0.5 * d[..., 2:]) * [0.2, 0.3, 0.6])


def basis(d):
    """The nine first functions, as CONVENTIONS.md has them."""
    x, y, z = np.moveaxis(d, -1, 0)
    a, b = math.sqrt(3 / (4 * math.pi)), math.sqrt(15 / (4 * math.pi))
    return np.stack([np.full_like(x, math.sqrt(1 / (4 * math.pi))), -a * y, a * z, -a * x, b * x * y, -b * y * z,
                     math.sqrt(5 / (16 * math.pi)) * (3 * z * z - 1), -b * x * z, b / 2 * (x * x - y * y)], -1)


def lobe_map(path, height, function=light):
    """A light as a lat-long picture: centers of texels at one half, +x in the middle, +y to its left."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(2 * height) + 0.5) / (2 * height), indexing="ij")
    theta, phi = np.pi * v, np.pi * (1 - 2 * u)
    d = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    channels = {"RGB": function(d).astype(np.float32)}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels).write(str(path))


def mitsuba_map(function, height):
    """An emitter of a function of the direction. Mitsuba's rows lie on the poles, its columns between texels."""
    v, u = np.meshgrid(np.arange(height) / (height - 1), (np.arange(2 * height) + 0.5) / (2 * height), indexing="ij")
    theta, phi = np.pi * v, 2 * np.pi * u
    x, y, z = np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)
    values = function(np.stack([x, -z, y], -1)).astype(np.float32)
    turn = mi.ScalarTransform4f(np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float))
    return {"type": "envmap", "bitmap": mi.Bitmap(values), "to_world": turn}


def run(lobe, *arguments):
    command = [lobe, "--quiet", *map(str, arguments)]
    answer = subprocess.run(command, stdout=subprocess.PIPE, check=False)
    if answer.returncode:
        sys.exit(f"failed: {' '.join(command)}")


def read_glb(path):
    """Primitives of a .glb in Lobe's frame: positions, normals, triangles, base color; and transfer [vertex, color, 9]."""
    gltf = Gltf.read(path)
    found, transfer = [], []
    for node in gltf.tree["nodes"]:
        for primitive in gltf.tree["meshes"][node["mesh"]]["primitives"]:
            attributes = primitive["attributes"]
            z_up = [lobe_frame(gltf.accessor(attributes[name])) for name in ("POSITION", "NORMAL")]
            color = gltf.tree["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorFactor"][:3]
            found.append((*z_up, gltf.accessor(primitive["indices"]).reshape(-1, 3), color))
            parts = [gltf.accessor(attributes[f"_TRANSFER_{k}"]) for k in range(9)]
            colors = [np.concatenate(parts[3 * c:3 * c + 3], 1)[:, :9] for c in range(3)]
            transfer.append(np.stack(colors, 1))
    return found, np.concatenate(transfer)


def twosided(color):
    """Mitsuba's own matte material."""
    return {"type": "twosided", "material": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(color)}}}


def shapes(primitives, material=twosided):
    """Matte, double-sided meshes. Where normals are None, they are those of the triangles."""
    scene = {}
    for k, (positions, normals, triangles, color) in enumerate(primitives):
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(material(color))
        mesh = mi.Mesh(f"m{k}", len(positions), len(triangles), properties, has_vertex_normals=normals is not None)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = positions.astype(np.float32).ravel()
        parameters["faces"] = triangles.astype(np.uint32).ravel()
        parameters.update()
        if normals is not None:
            # After the positions: Mitsuba 3.6 computes normals anew where both are updated at once.
            parameters["vertex_normals"] = normals.astype(np.float32).ravel()
            parameters.update()
        scene[f"m{k}"] = mesh
    return scene


def sensor(eye, target, samples, channels="rgb"):
    return {
        "type": "perspective", "fov": FOV, "fov_axis": "y",
        "to_world": mi.ScalarTransform4f().look_at(origin=list(eye), target=list(target), up=[0, 0, 1]),
        "film": {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"},
                 "pixel_format": channels, "component_format": "float32"},
        "sampler": {"type": "independent", "sample_count": samples},
    }


def mitsuba_pictures(shown, eye, target, function, samples, bounces=BOUNCES):
    """Pictures [seed, row, column, color] of shapes under a light."""
    scene = mi.load_dict({
        "type": "scene", **shown, "light": mitsuba_map(function, 512), "sensor": sensor(eye, target, samples),
        "integrator": {"type": "path", "max_depth": bounces + 2, "rr_depth": 1000},
    })
    return np.stack([np.array(mi.render(scene, spp=samples, seed=seed + 1)) for seed in range(SEEDS)])


def lobe_pictures(lobe, scene, folder, eye, target, samples, bounces=BOUNCES, more=()):
    """The same by Lobe under sky.exr of the folder, with more options, and the pixels that the scene covers whole."""
    pictures = []
    for seed in range(SEEDS):
        run(lobe, "render", "trace", scene, "--env", folder / "sky.exr", "-o", folder / "t.exr",
            "--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", samples, "--bounces", bounces, "--seed", seed,
            "--fov", FOV, "--eye", ",".join(map(str, eye)), "--target", ",".join(map(str, target)), *more)
        with OpenEXR.File(str(folder / "t.exr")) as file:
            channels = file.channels()
            pictures.append(channels["RGB"].pixels.astype(np.float64))
            whole = channels["coverage.A"].pixels == 1.0
    return np.stack(pictures), whole


def in_the_open(primitives):
    """Numbers of the vertices that lie on no other surface: where two touch, what a ray meets there is for chance to say."""
    scene = mi.load_dict({"type": "scene", **shapes(primitives)})
    places, normals = (np.concatenate([primitive[k] for primitive in primitives]) for k in (0, 1))
    free = np.ones(len(places), bool)
    for direction in np.random.default_rng(2).normal(size=(32, 3)):
        direction /= np.linalg.norm(direction)
        start = places + 2e-3 * normals - 1e-3 * direction
        ray = mi.Ray3f(mi.Point3f(start.T.astype(np.float32)), mi.Vector3f(np.tile(direction, (len(start), 1)).T.astype(np.float32)))
        ray.maxt = 2e-3
        free &= ~np.array(scene.ray_test(ray)).astype(bool)
    return np.flatnonzero(free)


def mitsuba_transfer(primitives, chosen, samples):
    """Transfer [seed, receiver, color, 9] at chosen vertices: the light is each function, raised so that it is positive."""
    raised = 1.2
    places, normals, colors = (np.concatenate(parts)[chosen] for parts in (
        [p for p, *_ in primitives], [n for _, n, *_ in primitives], [np.tile(c, (len(p), 1)) for p, _, _, c in primitives]))
    integrator = mi.load_dict({"type": "path", "max_depth": BOUNCES + 1, "rr_depth": 1000})
    answers = np.zeros((SEEDS, len(chosen), 3, 9))
    for i in range(9):
        emitter = mitsuba_map(lambda d, i=i: np.repeat(basis(d)[..., i:i + 1] + raised, 3, -1), 256)
        scene = mi.load_dict({"type": "scene", **shapes(primitives), "light": emitter})
        for seed in range(SEEDS):
            count = len(chosen) * samples
            sampler = mi.load_dict({"type": "independent"})
            sampler.seed(1000 + seed, count)
            local = np.array(mi.warp.square_to_cosine_hemisphere(sampler.next_2d())).reshape(3, -1)
            frame = mi.Frame3f(mi.Normal3f(np.repeat(normals, samples, 0).T.astype(np.float32)))
            towards = frame.to_world(mi.Vector3f(local.astype(np.float32)))
            start = mi.Point3f(np.repeat(places + 1e-4 * normals, samples, 0).T.astype(np.float32))
            seen = integrator.sample(scene, sampler, mi.RayDifferential3f(start, towards))[0]
            answers[seed, :, :, i] = np.array(seen).reshape(3, -1).T.reshape(len(chosen), samples, 3).mean(1) * colors
    # The response to 1 follows from that to the first, constant function, along the same paths.
    even = answers[..., :1] / (raised + math.sqrt(1 / (4 * math.pi)))
    return answers - raised * even


def judge(name, ours, theirs, mean_of):
    """Compares [seed, ...] with [seed, ...], prints a line, and returns whether they agree."""
    difference = ours.mean(0) - theirs.mean(0)
    variance = ours.var(0, ddof=1) / SEEDS + theirs.var(0, ddof=1) / SEEDS
    ratio = math.sqrt((difference**2).mean() / variance.mean())
    d, v, m = mean_of(difference), mean_of(variance), mean_of(theirs.mean(0))
    bias, error = d.mean() / m.mean(), math.sqrt(v.sum()) / v.size / m.mean()
    agrees = abs(bias) <= max(MOST_SIGMA * error, MOST_BIAS) and ratio <= MOST_RATIO
    print(f"{name:<28} {100 * bias:+8.3f} % ± {100 * error:.3f}   {ratio:7.3f}   {'agrees' if agrees else 'DIFFERS'}", flush=True)
    return agrees


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("lobe", help="the command, such as target/release/lobe")
    arguments.add_argument("--samples", type=int, default=64, help="paths of a pixel for each seed; transfer takes 4 times as many")
    options = arguments.parse_args()
    mi.set_variant("llvm_ad_rgb")
    version = subprocess.run([options.lobe, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    print(f"{version}, Mitsuba {mi.__version__}; {SEEDS} seeds, {options.samples} paths a pixel, {4 * options.samples} a receiver")
    print(f"{'':<28} {'bias of the mean':<20} difference/noise")
    mirrored = lambda d: light(d * [1, -1, 1])
    agree = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        lobe_map(folder / "sky.exr", 512)
        for name, (eye, target) in SCENES.items():
            scene = f"built-in:{name}"
            baked = []
            for seed in range(SEEDS):
                run(options.lobe, "bake", scene, "-o", folder / "b.glb", "--order", 3, "--samples", 4 * options.samples,
                    "--bounces", BOUNCES, "--energy-stop", 0, "--seed", seed)
                primitives, transfer = read_glb(folder / "b.glb")
                baked.append(transfer)
            pictures, whole = lobe_pictures(options.lobe, scene, folder, eye, target, options.samples)
            covered = pictures[:, whole]
            theirs = mitsuba_pictures(shapes(primitives), eye, target, light, options.samples)[:, whole]
            agree.append(judge(f"{name}: truth", covered, theirs, lambda x: x))
            chosen = np.sort(np.random.default_rng(1).choice(in_the_open(primitives), RECEIVERS, replace=False))
            theirs = mitsuba_transfer(primitives, chosen, 4 * options.samples)
            agree.append(judge(f"{name}: transfer", np.stack(baked)[:, chosen], theirs, lambda x: x[..., 0]))
        theirs = mitsuba_pictures(shapes(primitives), eye, target, mirrored, options.samples)[:, whole]
        control = judge(f"{name}: truth, map mirrored", covered, theirs, lambda x: x)
    if control:
        sys.exit("the control agrees: this comparison would not notice a mirrored map")
    if not all(agree):
        sys.exit("Lobe and Mitsuba differ")
    print("all agree, and the control does not")


if __name__ == "__main__":
    main()
