#!/usr/bin/env python3
"""Fisheye photographs that FFmpeg makes of a known sky, projected by Lobe: the nine coefficients beside those of the sky itself.

FFmpeg's filter `v360` looks up into a lat-long picture through lenses of the four projections. A last comparison, the photograph mirrored, must
fail. Needs ffmpeg and numpy.
"""

import argparse
import json
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np

# Lobe's name of a projection, and FFmpeg's.
LENSES = {"equidistant": "fisheye", "equisolid": "equisolid", "stereographic": "sg", "orthographic": "og"}
# Of the sky, and the side of a photograph.
HEIGHT, SIDE = 3072, 1200
# The largest difference that is allowed, relative to the norm: FFmpeg takes the middles of the outermost texels for the edges of the sky, which is
# a texel of 0.06 degrees in all.
MOST = 1e-3


def sky():
    """A sky in 16 bits, alike in no two directions: centers of texels at one half, +x in the middle, +y to its left; black below the horizon."""
    v, u = np.meshgrid((np.arange(HEIGHT) + 0.5) / HEIGHT, (np.arange(2 * HEIGHT) + 0.5) / (2 * HEIGHT), indexing="ij")
    theta, phi = np.pi * v, np.pi * (1 - 2 * u)
    x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    light = np.stack([0.4 + 0.3 * x + 0.2 * y, 0.3 + 0.3 * y * y + 0.2 * x, 0.5 + 0.2 * z - 0.2 * x * y], -1)
    # Dark at the horizon, whose row is not seen alike by any two programs.
    return np.round(65535 * light * np.clip(z, 0, None)[..., None]).astype(">u2")


def write_png(path, picture):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    rows = b"".join(b"\0" + row.tobytes() for row in picture)
    head = struct.pack(">IIBBBBB", picture.shape[1], picture.shape[0], 16, 2, 0, 0, 0)
    # Linear numbers: a gamma of 1.
    linear = chunk(b"gAMA", struct.pack(">I", 100000))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + linear + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def photograph(path, lens, mirrored):
    """What FFmpeg sees through a lens that looks up, in 16 bits. Pitched up, +x is below: turned about it is above, as Lobe has it."""
    turn = "vflip" if mirrored else "hflip,vflip"
    filters = f"v360=e:{lens}:h_fov=180:v_fov=180:pitch=90:w={SIDE}:h={SIDE}:interp=cubic,{turn}"
    command = ["ffmpeg", "-loglevel", "error", "-i", path, "-vf", f"format=gbrp16,{filters}", "-f", "rawvideo", "-pix_fmt", "rgb48be", "-"]
    data = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
    seen = np.frombuffer(data, ">u2").reshape(SIDE, SIDE, 3)
    # Outside of the circle, where its orthographic lens shows the zenith, there is nothing.
    middles = (2 * np.arange(SIDE) + 1) / SIDE - 1
    return np.where(np.hypot(*np.meshgrid(middles, middles))[..., None] <= 1, seen, 0).astype(">u2")


def coefficients(lobe, *arguments):
    answer = subprocess.run([lobe, "--quiet", "project", *map(str, arguments), "--order", "3", "-o", "-"], stdout=subprocess.PIPE, check=False)
    if answer.returncode:
        sys.exit(f"failed: {' '.join(map(str, arguments))}")
    return np.array(json.loads(answer.stdout)["coefficients"], float)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("lobe", help="the command, such as target/release/lobe")
    lobe = arguments.parse_args().lobe
    agree = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        write_png(folder / "sky.png", sky())
        expected = coefficients(lobe, folder / "sky.png")

        def difference(lens, mirrored):
            write_png(folder / "photo.png", photograph(folder / "sky.png", LENSES[lens], mirrored))
            found = coefficients(lobe, folder / "photo.png", "--fisheye", lens)
            return np.linalg.norm(found - expected) / np.linalg.norm(expected)

        for lens in LENSES:
            off = difference(lens, False)
            agree.append(off <= MOST)
            print(f"{lens:<26} {off:.2e}   {'agrees' if agree[-1] else 'DIFFERS'}", flush=True)
        control = difference("equidistant", True)
        print(f"{'equidistant, mirrored':<26} {control:.2e}   {'agrees' if control <= MOST else 'DIFFERS'}")
    if control <= MOST:
        sys.exit("the control agrees: this comparison would not notice a mirrored photograph")
    if not all(agree):
        sys.exit("Lobe and FFmpeg differ")
    print("all agree, and the control does not")


if __name__ == "__main__":
    main()
