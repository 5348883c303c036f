"""Writes the pictures brighter than white that tests of lobe-image read, by the encoders of others, and prints what those decode.

    pip install imagecodecs==2026.3.6 tifffile && python delivery.py
"""

import os
import subprocess

import imagecodecs
import numpy as np
import tifffile

WIDTH, HEIGHT = 32, 16
y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
# Red rises to the right, green downwards; a lamp of six times white.
dim = np.stack([0.0625 + x / 64, 0.0625 + y / 32, 0.25 + 0 * x], -1)
lamp = np.exp(-((x - 10) ** 2 + (y - 5) ** 2) / 8)[..., None]
light = (dim + lamp * [6, 5, 3]).astype("f4")
opaque = np.concatenate([light, np.ones_like(light[..., :1])], -1).astype("f2")

ultra = imagecodecs.ultrahdr_encode(opaque, 95, gamut=0, transfer=0)
open("ultra-hdr.jpg", "wb").write(ultra)
decoded = imagecodecs.ultrahdr_decode(ultra).astype("f4")
for column, row in [(0, 0), (10, 5), (13, 5), (20, 12), (31, 15)]:
    print(f"({column}, {row}, {decoded[row, column, :3].tolist()}),")

open("float.jxl", "wb").write(imagecodecs.jpegxl_encode(light, lossless=True))
tifffile.imwrite("lzw.tif", light, photometric="rgb", compression="lzw", predictor=True)
tifffile.imwrite("tiled.tif", opaque, photometric="rgb", extrasamples=["unassalpha"], tile=(16, 16), compression="deflate")
tifffile.imwrite("planes.tif", light.transpose(2, 0, 1), photometric="rgb", planarconfig="separate", bigtiff=True, byteorder=">")
tifffile.imwrite("gray.tif", light[..., 0].astype("f8"), photometric="minisblack")
tifffile.imwrite("display.tif", np.round(255 * np.clip(dim, 0, 1)).astype("u1"), photometric="rgb")

# Colors of another gamut, and gray: six times white, in every form that tells of it.
bright = (light[:4, :8] + 5).astype("f4")
open("gray.jxl", "wb").write(imagecodecs.jpegxl_encode(bright[..., 0], lossless=True))
with open("wide.pfm", "wb") as file:
    file.write(b"PF\n8 4\n-1\n" + bright[::-1].tobytes())
subprocess.run(["cjxl", "wide.pfm", "wide.jxl", "-d", "0", "-x", "color_space=RGB_D65_202_Rel_Lin"], check=True)
os.remove("wide.pfm")
RATIONAL, REC_2020, D65 = 5, [0.708, 0.292, 0.170, 0.797, 0.131, 0.046], [0.3127, 0.3290]
fractions = lambda numbers: [n for number in numbers for n in (round(number * 10000), 10000)]
tags = [(319, RATIONAL, 6, fractions(REC_2020), True), (318, RATIONAL, 2, fractions(D65), True)]
tifffile.imwrite("wide.tif", bright, photometric="rgb", extratags=tags)
profile = imagecodecs.cms_profile("adobergb")
tifffile.imwrite("adobe.tif", np.full((4, 8, 3), 128, "u1"), photometric="rgb", iccprofile=profile)
with tifffile.TiffWriter("raw.tif") as file:
    file.write(np.zeros((4, 8, 3), "u1"), photometric="rgb", subfiletype=1, subifds=1)
    file.write(np.zeros((8, 16), "u2"), photometric="minisblack")
