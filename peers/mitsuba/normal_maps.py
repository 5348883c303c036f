#!/usr/bin/env python3
"""A bumpy square, its normals from a texture, by Lobe's paths and by Mitsuba 3's `normalmap`: bias, and difference in units of the noise.

Both turn the stored normal from a frame of the texture's u and the normal; both let no light through the face itself. A last comparison,
green turned around for Mitsuba alone, must fail.
"""

import argparse
import base64
import json
import math
import struct
import sys
import tempfile
import zlib
from pathlib import Path

from compare import judge, light, lobe_map, lobe_pictures, mi, mitsuba_pictures, np

# From so high that no stored normal faces away: Mitsuba turns those about, Lobe leaves them.
EYE, TARGET = (0.6, -1.2, 2.6), (0.0, 0.0, 0.0)
# Texels along a side, and waves along u and v: different ones, so that no exchange of axes goes unseen.
TEXELS, WAVES = 128, (3, 5)
TURN = 0.5


def bumps():
    """The stored normals of waves that are steeper along u, rows from the top, as bytes."""
    v, u = np.meshgrid((np.arange(TEXELS) + 0.5) / TEXELS, (np.arange(TEXELS) + 0.5) / TEXELS, indexing="ij")
    slope_u = 0.5 * np.cos(2 * np.pi * WAVES[0] * u) + 0.2
    slope_up = 0.35 * np.sin(2 * np.pi * WAVES[1] * v) - 0.1
    n = np.stack([-slope_u, -slope_up, np.ones_like(u)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.round(255 * (0.5 + 0.5 * n)).astype(np.uint8)


def png(picture):
    """An 8-bit RGB picture without a filter."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    rows = b"".join(b"\0" + row.tobytes() for row in picture)
    head = struct.pack(">IIBBBBB", picture.shape[1], picture.shape[0], 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def square():
    """Corners in Lobe's frame, turned about +z, and their places in the texture: v runs downwards, towards -y before the turn."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    c, s = math.cos(TURN), math.sin(TURN)
    uv = np.stack([0.5 + 0.5 * corners[:, 0], 0.5 - 0.5 * corners[:, 1]], -1)
    return corners @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), uv


def write_gltf(path):
    corners, uv = square()
    y_up = np.stack([corners[:, 0], corners[:, 2], -corners[:, 1]], -1)
    parts = [y_up.astype("<f4"), np.tile([0, 1, 0], (4, 1)).astype("<f4"), uv.astype("<f4"), np.array([0, 1, 2, 0, 2, 3], "<u2")]
    data, views = b"", []
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": part.nbytes})
        data += part.tobytes()
    box = {"min": y_up.min(0).tolist(), "max": y_up.max(0).tolist()}
    inline = lambda kind, bytes_: f"data:{kind};base64," + base64.b64encode(bytes_).decode()
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}],
        "materials": [{"normalTexture": {"index": 0}, "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.6, 0.4, 1], "metallicFactor": 0}}],
        "textures": [{"source": 0}], "images": [{"uri": inline("image/png", png(bumps()))}],
        "buffers": [{"byteLength": len(data), "uri": inline("application/octet-stream", data)}], "bufferViews": views,
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", **box},
                      {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
                      {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"}],
    }))


def mitsuba_square(stored):
    corners, uv = square()
    texture = {"type": "bitmap", "bitmap": mi.Bitmap(stored.astype(np.float32) / 255), "raw": True}
    diffuse = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.6, 0.4]}}
    properties = mi.Properties()
    # Without what softens the end of the light on bumps, which glTF has not.
    properties["bsdf"] = mi.load_dict({"type": "normalmap", "normalmap": texture, "bsdf": diffuse, "use_shadowing_function": False})
    mesh = mi.Mesh("square", 4, 2, properties, has_vertex_normals=True, has_vertex_texcoords=True)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = corners.astype(np.float32).ravel()
    parameters["vertex_normals"] = np.tile([0, 0, 1], (4, 1)).astype(np.float32).ravel()
    parameters["vertex_texcoords"] = uv.astype(np.float32).ravel()
    parameters["faces"] = np.array([0, 1, 2, 0, 2, 3], np.uint32)
    parameters.update()
    return {"square": mesh}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("lobe", help="the command, such as target/release/lobe")
    arguments.add_argument("--samples", type=int, default=1024, help="paths of a pixel for each seed")
    options = arguments.parse_args()
    mi.set_variant("llvm_ad_rgb")
    print(f"{'':<28} {'bias of the mean':<20} difference/noise")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        lobe_map(folder / "sky.exr", 512)
        write_gltf(folder / "s.gltf")
        pictures, whole = lobe_pictures(options.lobe, folder / "s.gltf", folder, EYE, TARGET, options.samples, bounces=0)
        ours = pictures[:, whole]

        def theirs(stored):
            return mitsuba_pictures(mitsuba_square(stored), EYE, TARGET, light, options.samples, bounces=0)[:, whole]

        stored = bumps()
        agrees = judge("bumps: truth", ours, theirs(stored), lambda x: x)
        turned = stored.copy()
        turned[..., 1] = 255 - turned[..., 1]
        control = judge("bumps: truth, green turned", ours, theirs(turned), lambda x: x)
    if control:
        sys.exit("the control agrees: this comparison would not notice a green turned around")
    if not agrees:
        sys.exit("Lobe and Mitsuba differ")
    print("they agree, and the control does not")


if __name__ == "__main__":
    main()
