"""Poses of animated glTF files, from the specification alone: nodes, samplers, morph targets, skins."""

from collections import namedtuple

import numpy as np

from gltf import lobe_frame

# In Lobe's frame. Normals are None where the file has none.
Posed = namedtuple("Posed", "positions normals triangles")


def duration(gltf, animation=0):
    """The last key of an animation."""
    samplers = gltf.tree["animations"][animation]["samplers"]
    return max(gltf.accessor(sampler["input"])[-1, 0] for sampler in samplers)


def pose(gltf, time, animation=0):
    """The primitives of the default scene at a time of an animation."""
    nodes = [dict(node) for node in gltf.tree["nodes"]]
    for channel in gltf.tree["animations"][animation]["channels"]:
        target = channel["target"]
        if "node" in target:
            sampler = gltf.tree["animations"][animation]["samplers"][channel["sampler"]]
            nodes[target["node"]][target["path"]] = value_at(gltf, sampler, target["path"], time)
    worlds = {}
    for root in gltf.tree["scenes"][gltf.tree.get("scene", 0)]["nodes"]:
        place(nodes, root, np.eye(4), worlds)
    return [posed(gltf, nodes[node], primitive, worlds, node)
            for node in worlds if "mesh" in nodes[node]
            for primitive in gltf.tree["meshes"][nodes[node]["mesh"]]["primitives"]]


def value_at(gltf, sampler, path, time):
    """What a sampler says at a time; before its first key and after its last one, what they say."""
    times = gltf.accessor(sampler["input"])[:, 0]
    kind = sampler.get("interpolation", "LINEAR")
    # For each key its value, or the tangent before it, its value and the tangent after it.
    keys = gltf.accessor(sampler["output"]).reshape(len(times), 3 if kind == "CUBICSPLINE" else 1, -1)
    values = keys[:, keys.shape[1] // 2]
    k = np.searchsorted(times, time, side="right") - 1
    if k < 0 or k == len(times) - 1 or kind == "STEP":
        return values[max(k, 0)]
    span = times[k + 1] - times[k]
    u = (time - times[k]) / span
    if kind == "CUBICSPLINE":
        value = hermite(u, values[k], span * keys[k, 2], values[k + 1], span * keys[k + 1, 0])
        return unit(value) if path == "rotation" else value
    if path == "rotation":
        return slerp(values[k], values[k + 1], u)
    return (1 - u) * values[k] + u * values[k + 1]


def hermite(u, p, p_tangent, q, q_tangent):
    return ((2 * u**3 - 3 * u**2 + 1) * p + (u**3 - 2 * u**2 + u) * p_tangent
            + (3 * u**2 - 2 * u**3) * q + (u**3 - u**2) * q_tangent)


def slerp(a, b, u):
    """From one unit quaternion to another along the shorter arc of a great circle."""
    a, b = unit(a), unit(b)
    if a @ b < 0:
        b = -b
    # Twice the half angle, which is exact for small ones too.
    angle = 2 * np.arctan2(np.linalg.norm(b - a), np.linalg.norm(b + a))
    if angle == 0:
        return a
    return (np.sin((1 - u) * angle) * a + np.sin(u * angle) * b) / np.sin(angle)


def unit(rows):
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)


def place(nodes, number, parent, worlds):
    """Notes the matrices from a node and all below it to the world."""
    worlds[number] = parent @ local(nodes[number])
    for child in nodes[number].get("children", []):
        place(nodes, child, worlds[number], worlds)


def local(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = unit(np.array(node.get("rotation", (0, 0, 0, 1)), float))
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get("scale", (1, 1, 1)), float)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def posed(gltf, node, primitive, worlds, number):
    """A primitive: morphed, then taken along by the joints of a skin, or else by its node."""
    if primitive.get("mode", 4) != 4:
        raise SystemExit("the poser knows triangles alone")
    attributes = primitive["attributes"]
    positions = morphed(gltf, node, primitive, "POSITION")
    normals = morphed(gltf, node, primitive, "NORMAL") if "NORMAL" in attributes else None
    count = len(positions)
    triangles = gltf.accessor(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(count)
    triangles = triangles.reshape(-1, 3)
    if "skin" in node:
        matrices = skinned(gltf, gltf.tree["skins"][node["skin"]], attributes, worlds)
    else:
        matrices = np.tile(worlds[number], (count, 1, 1))
        if np.linalg.det(worlds[number][:3, :3]) < 0:
            triangles = triangles[:, ::-1]
    places = np.einsum("vij,vj->vi", matrices, np.pad(positions, ((0, 0), (0, 1)), constant_values=1))[:, :3]
    if normals is not None:
        normals = lobe_frame(unit(np.einsum("vij,vj->vi", inverse_transposes(matrices[:, :3, :3]), normals)))
    return Posed(lobe_frame(places), normals, triangles)


def morphed(gltf, node, primitive, name):
    """An attribute with the morph targets added by their weights."""
    mesh = gltf.tree["meshes"][node["mesh"]]
    rows = gltf.accessor(primitive["attributes"][name])
    targets = primitive.get("targets", [])
    weights = node.get("weights", mesh.get("weights", np.zeros(len(targets))))
    for weight, target in zip(weights, targets):
        if weight != 0 and name in target:
            rows = rows + weight * gltf.accessor(target[name])
    return rows


def skinned(gltf, skin, attributes, worlds):
    """For each vertex the mean of the matrices of its joints, by its weights, which sum to 1."""
    joints = np.stack([worlds[joint] for joint in skin["joints"]])
    if "inverseBindMatrices" in skin:
        joints = joints @ gltf.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    sets = range(sum(name.startswith("JOINTS_") for name in attributes))
    numbers = np.concatenate([gltf.accessor(attributes[f"JOINTS_{k}"]) for k in sets], 1)
    weights = np.concatenate([gltf.accessor(attributes[f"WEIGHTS_{k}"]) for k in sets], 1)
    weights /= weights.sum(1, keepdims=True)
    return np.einsum("vk,vkij->vij", weights, joints[numbers])


def inverse_transposes(matrices):
    """What takes normals along with a surface, up to a positive factor: cofactors, with the sign of the determinant."""
    x, y, z = np.moveaxis(matrices, 2, 0)
    cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], 2)
    return cofactors * np.sign(np.linalg.det(matrices))[:, None, None]
