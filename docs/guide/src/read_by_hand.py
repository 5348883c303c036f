#!/usr/bin/env python3
"""Reads Lobe's files with the standard library alone, as docs/guide/src/formats.md describes them.

read_by_hand.py FILE ... prints what each holds; with --light LIGHT.sh.json what its receivers send back of the light, and with
--at X,Y,Z what is seen of the sky, or shines, at a point around an entity or a lamp.
"""
import base64
import json
import math
import pathlib
import struct
import sys

CODES = {"F32": "f", "F16": "e", "U16": "H", "U8": "B", 5126: "f", 5123: "H", 5121: "B"}
LARGEST = {"H": 65535, "B": 255}
WIDTHS = {"SCALAR": 1, "VEC4": 4}
VERSIONS = {"lobe-occlusion-field": 2, "lobe-lamp": 2}


def read_sh_json(path):
    """The order and the rows of coefficients, colors."""
    with open(path, encoding="utf-8-sig") as file:
        sh = json.load(file)
    assert (sh["format"], sh["version"]) == ("lobe-sh", 1), sh["format"]
    rows = sh["coefficients"]
    assert len(rows) == sh["order"] ** 2, (sh["order"], len(rows))
    return sh["order"], [row * 3 if len(row) == 1 else row for row in rows]


def read_safetensors(path):
    """The metadata, and the tensors as flat lists beside their shapes."""
    data = pathlib.Path(path).read_bytes()
    (length,) = struct.unpack_from("<Q", data)
    head = json.loads(data[8 : 8 + length])
    about = json.loads(head.pop("__metadata__")["lobe"])
    assert about["version"] == VERSIONS.get(about["format"], 1), about
    tensors = {}
    for name, tensor in head.items():
        code, count = CODES[tensor["dtype"]], math.prod(tensor["shape"])
        tensors[name] = struct.unpack_from(f"<{count}{code}", data, 8 + length + tensor["data_offsets"][0])
        if name == "weights" and code in LARGEST:
            tensors[name] = [q / LARGEST[code] for q in tensors[name]]
    return about, tensors


def read_glb(path):
    """`asset.extras.lobe`, and by vertex the numbers of its attributes in the order of their names' numbers."""
    data = pathlib.Path(path).read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    gltf, start = json.loads(data[20 : 20 + length]), 20 + length + 8
    about = gltf["asset"]["extras"]["lobe"]
    assert about["version"] == 1, about

    def column(attribute):
        accessor = gltf["accessors"][attribute]
        view = gltf["bufferViews"][accessor["bufferView"]]
        code, width = CODES[accessor["componentType"]], WIDTHS[accessor["type"]]
        scale = LARGEST[code] if accessor.get("normalized") else 1
        first = start + view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        step = view.get("byteStride", width * struct.calcsize(code))
        places = range(first, first + accessor["count"] * step, step)
        return [[x / scale for x in struct.unpack_from(f"<{width}{code}", data, place)] for place in places]

    def vertices(prefix):
        rows, todo = [], list(reversed(gltf["scenes"][gltf.get("scene", 0)]["nodes"]))
        while todo:
            node = gltf["nodes"][todo.pop()]
            todo += reversed(node.get("children", []))
            for primitive in gltf["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
                ours = [a for a in primitive["attributes"] if a.startswith(prefix)]
                ours.sort(key=lambda a: int(a.removeprefix(prefix) or 0))
                columns = [column(primitive["attributes"][a]) for a in ours]
                rows += [sum(parts, []) for parts in zip(*columns)]
        return rows

    tensors = {}
    if "compression" not in about:
        n2, q4 = about["order"] ** 2, 4 * math.ceil(about["order"] ** 2 / 4)
        padded = vertices("_TRANSFER_")
        tensors["transfer"] = [x for row in padded for c in range(about["channels"]) for x in row[c * q4 : c * q4 + n2]]
        return about, tensors
    about |= about["compression"]
    bases = base64.b64decode(gltf["scenes"][gltf.get("scene", 0)]["extras"]["lobe"]["bases"])
    tensors["bases"] = struct.unpack(f"<{len(bases) // 4}f", bases)
    tensors["clusters"] = [int(row[0]) for row in vertices("_CLUSTER")]
    weights = vertices("_WEIGHTS_") or [[]] * len(tensors["clusters"])
    tensors["weights"] = [w for row in weights for w in row[: about["components"]]]
    return about, tensors


def basis(order, s):
    """The n² functions y_i towards s, by the recurrences of the associated Legendre functions."""
    x, y, z = s
    values = [0.0] * order**2
    re, im, diagonal = 1.0, 0.0, math.sqrt(1 / (4 * math.pi))
    for m in range(order):
        before, current = 0.0, diagonal
        for l in range(m, order):
            root = math.sqrt(2) if m else 1.0
            values[l * (l + 1) + m] = current * re * root
            if m:
                values[l * (l + 1) - m] = current * im * root
            a = math.sqrt((4 * (l + 1) ** 2 - 1) / ((l + 1) ** 2 - m * m))
            b = math.sqrt((l * l - m * m) / (4 * l * l - 1)) if l else 0.0
            before, current = current, a * (z * current - b * before)
        diagonal *= -math.sqrt((2 * m + 3) / (2 * m + 2))
        re, im = x * re - y * im, x * im + y * re
    return values


def transfer_of(about, tensors):
    """The transfer vectors of all receivers, one flat list each: channel by channel, in the order of the index."""
    order, channels = about["order"], about["channels"]
    width = about.get("width", channels * order**2)
    if "transfer" in tensors:
        flat = tensors["transfer"]
        return [flat[k : k + width] for k in range(0, len(flat), width)]
    if "bases" in tensors:
        count, weights, bases = about["components"], tensors["weights"], tensors["bases"]

        def row(receiver, cluster):
            at = cluster * (1 + count) * width
            total = list(bases[at : at + width])
            for j in range(count):
                w, b = weights[receiver * count + j], at + (1 + j) * width
                total = [t + w * x for t, x in zip(total, bases[b : b + width])]
            return total

        return [row(r, k) for r, k in enumerate(tensors["clusters"])]
    axes, z, rows = tensors["axes"], tensors["coefficients"], []
    for r in range(len(axes) // (3 * about["lobes"])):
        total = [0.0] * width
        for k in range(r * about["lobes"], (r + 1) * about["lobes"]):
            y = basis(order, axes[3 * k : 3 * k + 3])
            for c in range(channels):
                for l in range(order):
                    scale = math.sqrt(4 * math.pi / (2 * l + 1)) * z[(k * channels + c) * order + l]
                    for i in range(l * l, (l + 1) ** 2):
                        total[c * order**2 + i] += scale * y[i]
        rows.append(total)
    return rows


def exit_radiance(about, row, light):
    """What a receiver with this transfer sends back of light of the same order."""
    n2 = about["order"] ** 2
    start = [0, n2, 2 * n2] if about["channels"] == 3 else [0, 0, 0]
    return [sum(light[i][c] * row[start[c] + i] for i in range(n2)) for c in range(3)]


def points_of(about):
    """The center and the radius of the sample points, and how they are weighed: pairs of row and weight by offset."""
    if "center" in about:
        center, radius = about["center"], about["radius"]
    else:
        corner, u, v = about["corner"], about["u"], about["v"]
        center = [c + (a + b) / 2 for c, a, b in zip(corner, u, v)]
        radius = max(math.dist(u, [sign * x for x in v]) for sign in (1, -1)) / 2
    last, cells = about["spheres"] - 1, about["cells"]
    side = cells + 1

    def m(ratio):
        return math.copysign(math.sqrt(abs(math.log(ratio))), math.log(ratio))

    def place(r):
        a, b, at = m(about["inner"]), m(about["outer"]), m(r / radius)
        if last < 2 or not a < 0 < b:
            return last / (b - a) * (at - a)
        e = min(max(math.floor(-a * last / (b - a) + 0.5), 1), last - 1)
        return e + at * (-e / a if at < 0 else (last - e) / b)

    def weights(offset):
        r, size = math.hypot(*offset), sum(map(abs, offset))
        u, v, w = [c / size for c in offset]
        if w < 0:
            u, v = math.copysign(1 - abs(v), u), math.copysign(1 - abs(u), v)
        (i, a), (j, b) = [(k, c - k) for c in ((u + 1) * cells / 2, (v + 1) * cells / 2) for k in [min(int(c), cells - 1)]]
        corner = j * side + i
        corners = [(corner, (1 - a) * (1 - b)), (corner + 1, a * (1 - b))]
        corners += [(corner + side, (1 - a) * b), (corner + side + 1, a * b)]
        k = place(r)
        part = r / (radius * about["inner"])
        if k <= 0:
            spheres = [(0, part)]
        else:
            first = min(int(k), last)
            spheres = [(first, 1 + first - k), (first + 1, k - first)] if first < last else [(last, 1)]
        found = [(sphere * side**2 + p, x * w) for sphere, x in spheres for p, w in corners]
        return found + ([((last + 1) * side**2, 1 - part)] if k <= 0 else [])

    def place_of(p):
        sphere, vertex = divmod(p, side**2)
        if sphere > last:
            return center
        u, v = [2 * i / cells - 1 for i in (vertex % side, vertex // side)]
        w = 1 - abs(u) - abs(v)
        if w < 0:
            u, v = math.copysign(1 - abs(v), u), math.copysign(1 - abs(u), v)
        low, high = 1e-9 * radius, 1e9 * radius
        for _ in range(200):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if place(middle) < sphere else (low, middle)
        return [c + low * x / math.hypot(u, v, w) for c, x in zip(center, (u, v, w))]

    def weights_in_front(offset):
        found = weights(offset)
        kept = [(p, x) for p, x in found if height(about, place_of(p)) >= -1e-6 * radius]
        grown = sum(x for _, x in found) / (sum(x for _, x in kept) or 1)
        return [(p, x * grown) for p, x in kept]

    return center, radius, weights_in_front if shines_to_one_side(about) else weights


def shines_to_one_side(about):
    """Whether it is a rectangle whose back is dark."""
    return about.get("two_sided") is False


def height(about, point):
    """The height of a point above the plane of a rectangle."""
    u, v = about["u"], about["v"]
    normal = [u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3] for k in range(3)]
    return sum(n * (a - b) for n, a, b in zip(normal, point, about["corner"])) / math.hypot(*normal)


def around(about, table, start, point):
    """`(z_l y_lm(d) + g_lm) / (1 + (r/R)²)` at a point, where row p begins at number start(p) of the table."""
    n = about["order"]
    if shines_to_one_side(about) and height(about, point) <= 0:
        return [0.0] * (n * n)
    center, radius, weights = points_of(about)
    offset = [a - b for a, b in zip(point, center)]
    row = [0.0] * (n + n * n)
    for p, weight in weights(offset):
        row = [a + weight * b for a, b in zip(row, table[start(p) : start(p) + len(row)])]
    r = math.hypot(*offset)
    y, scale = basis(n, [-c / r for c in offset]), 1 + (r / radius) ** 2
    return [(row[math.isqrt(i)] * y[i] + row[n + i]) / scale for i in range(n * n)]


def stored(about, tensors, name, width):
    """The numbers of rows of this width, which tensor `name` has unless they are in clusters."""
    storage = about.get("storage", "f32")
    if storage == "u8":
        least, step = tensors["ranges"][:width], tensors["ranges"][width:]
        return [least[i % width] + step[i % width] * q for i, q in enumerate(tensors[name])]
    if storage == "clustered":
        components = len(tensors["weights"]) // len(tensors["clusters"])
        table = {"order": about["order"], "channels": 1, "components": components, "width": width}
        return sum(transfer_of(table, tensors), [])
    return tensors[name]


def visibility(about, tensors, point):
    """What an entity leaves of the sky at a point."""
    width = about["order"] * (about["order"] + 1)
    rows = stored(about, tensors, "rows", width)
    occlusion = around(about, rows, lambda p: p * width, point)
    return [(math.sqrt(4 * math.pi) if i == 0 else 0) - o for i, o in enumerate(occlusion)]


def own_visibility(about, tensors):
    """What each vertex of a scene sees of the sky past that scene."""
    width = about["order"] ** 2
    rows = stored(about, tensors, "rows", width)
    return [rows[k : k + width] for k in range(0, len(rows), width)]


def shining(about, tensors, point, time=0.0):
    """The light of a lamp at a point: red, green and blue."""
    n = about["order"]
    width = n * (n + 1)
    if about["shape"] == "ball":
        to_center = [a - b for a, b in zip(about["center"], point)]
        r = math.hypot(*to_center)
        c = math.sqrt(1 - (about["radius"] / r) ** 2) if r > about["radius"] else -1.0
        p = [1.0, c]
        for l in range(1, n):
            p.append(((2 * l + 1) * c * p[l] - l * p[l - 1]) / (l + 1))
        integrals = [1 - c] + [(p[l - 1] - p[l + 1]) / (2 * l + 1) for l in range(1, n)]
        y = basis(n, [x / r for x in to_center])
        cone = [2 * math.pi * integrals[math.isqrt(i)] * y[i] for i in range(n * n)]
        return [[color * x for x in cone] for color in about["radiance"]]
    if about["shape"] == "rectangle":
        rows = stored(about, tensors, "rows", 3 * width)
        return [around(about, rows, lambda p, c=c: (3 * p + c) * width, point) for c in range(3)]
    of_patches = stored(about, tensors, "patches", width)
    patches = about["patches"][0] * about["patches"][1]
    points = about["spheres"] * (about["cells"] + 1) ** 2 + 1
    picture = math.floor(time * about["per_second"]) % about["pictures"]
    light = [[0.0] * n * n for _ in range(3)]
    for k in range(patches):
        of_patch = around(about, of_patches, lambda p, k=k: (k * points + p) * width, point)
        for c in range(3):
            radiance = tensors["radiance"][(picture * patches + k) * 3 + c]
            light[c] = [a + radiance * b for a, b in zip(light[c], of_patch)]
    return light


def spheres(about, tensors):
    """Centers and radii."""
    centers, origin = tensors["centers"], about.get("origin", [0.0] * 3)
    return [([o + x for o, x in zip(origin, centers[3 * k :])], r) for k, r in enumerate(tensors["radii"])]


def posed_spheres(about, tensors, matrices):
    """Centers and radii where joints are: for each 12 numbers, the rows of M, and last for the node of the entity."""

    def det(m):
        return sum(m[i] * (m[4 + (i + 1) % 3] * m[8 + (i + 2) % 3] - m[4 + (i + 2) % 3] * m[8 + (i + 1) % 3]) for i in range(3))

    found = []
    for k, (c, radius) in enumerate(spheres(about, tensors)):
        joints, weights = [len(matrices) - 1], [1.0]
        if "joints" in tensors:
            joints, weights = tensors["joints"][4 * k :][:4], tensors["weights"][4 * k :][:4]
        four = [(w, matrices[j]) for j, w in zip(joints, weights) if w > 0]
        center = [sum(w * (sum(m[4 * i + x] * c[x] for x in range(3)) + m[4 * i + 3]) for w, m in four) for i in range(3)]
        found.append((center, radius * sum(w * abs(det(m)) ** (1 / 3) for w, m in four)))
    return found


def option(arguments, name):
    """The value of an option, which is taken out of the arguments."""
    if name not in arguments:
        return None
    at = arguments.index(name)
    value = arguments[at + 1]
    del arguments[at : at + 2]
    return value


def main(arguments):
    light, at = option(arguments, "--light"), option(arguments, "--at")
    light = light and read_sh_json(light)
    at = at and [float(x) for x in at.split(",")]
    for path in arguments:
        if path.endswith(".json"):
            order, rows = read_sh_json(path)
            print(f"{path}: order {order}, mean {[c * math.sqrt(1 / (4 * math.pi)) for c in rows[0]]}")
            continue
        about, tensors = read_glb(path) if path.endswith(".glb") else read_safetensors(path)
        kind = about.get("format", "baked scene")
        if kind in ("lobe-occlusion-field", "lobe-lamp"):
            print(f"{path}: {kind}, order {about['order']}")
            if at is not None:
                one = kind == "lobe-occlusion-field"
                found = [visibility(about, tensors, at)] if one else shining(about, tensors, at)
                print("  mean over the sphere", [f[0] * math.sqrt(1 / (4 * math.pi)) for f in found])
            continue
        if kind == "lobe-visibility":
            rows = own_visibility(about, tensors)
            mean = sum(row[0] for row in rows) / max(len(rows), 1) * math.sqrt(1 / (4 * math.pi))
            print(f"{path}: {kind}, order {about['order']}, vertices {len(rows)}, mean {mean}")
            continue
        if kind in ("lobe-spheres", "lobe-morphed-spheres", "lobe-sphere-logarithms"):
            print(f"{path}: {kind},", f"{len(tensors['radii'])} spheres" if "radii" in tensors else about["options"])
            if "skeleton" in about:
                still = [[float(i % 5 == 0) for i in range(12)]] * (len(about["skeleton"]["joints"]) + 1)
                print("  of", about["skeleton"]["entity"], "bound at", posed_spheres(about, tensors, still)[0])
            continue
        if "matrices" in tensors:
            print(f"{path}: {about['format']}, order {about['order']}, {len(tensors['matrices'])} numbers")
            continue
        rows = transfer_of(about, tensors)
        print(f"{path}: order {about['order']}, channels {about['channels']}, receivers {len(rows)}")
        if light is not None:
            assert light[0] == about["order"], "light of the same order"
            lit = [exit_radiance(about, row, light[1]) for row in rows]
            print("  mean exit radiance", [sum(b[c] for b in lit) / len(lit) for c in range(3)])


if __name__ == "__main__":
    main(sys.argv[1:])
