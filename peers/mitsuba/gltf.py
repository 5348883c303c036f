"""Files of glTF 2.0: their tree, and the numbers of their accessors."""

import base64
import copy
import json
import struct
from pathlib import Path

import numpy as np

KINDS = {5120: "|i1", 5121: "|u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
COMPONENTS = {kind: component for component, kind in KINDS.items()}
PARTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942


def lobe_frame(vectors):
    """Rows of y-up vectors, as glTF has them, in Lobe's frame."""
    return vectors[:, [0, 2, 1]] * [1, -1, 1]


def y_up(vectors):
    """Rows of vectors in Lobe's frame, as glTF has them."""
    return vectors[:, [0, 2, 1]] * [1, 1, -1]


class Gltf:
    """A tree and the bytes of all its buffers, as one buffer."""

    def __init__(self, tree, binary):
        self.tree, self.binary = tree, binary

    @classmethod
    def read(cls, path):
        """Reads a .gltf or .glb file."""
        data = Path(path).read_bytes()
        chunk = b""
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            data, chunk = data[20:20 + length], data[28 + length:]
        tree = json.loads(data)
        starts, binary = [], b""
        for buffer in tree.get("buffers", []):
            starts.append(len(binary))
            uri = buffer.get("uri")
            if uri is None:
                part = chunk
            elif uri.startswith("data:"):
                part = base64.b64decode(uri.split(",", 1)[1])
            else:
                part = (Path(path).parent / uri).read_bytes()
            binary += part[:buffer["byteLength"]] + bytes(-buffer["byteLength"] % 4)
        for view in tree.get("bufferViews", []):
            view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
            view["buffer"] = 0
        return cls(tree, binary)

    def copied(self):
        return Gltf(copy.deepcopy(self.tree), self.binary)

    def accessor(self, index):
        """Rows of an accessor: float64 where it holds reals or normalized integers, else uint32."""
        accessor = self.tree["accessors"][index]
        kind, count = np.dtype(KINDS[accessor["componentType"]]), accessor["count"]
        rows = np.zeros((count, PARTS[accessor["type"]]), kind)
        if "bufferView" in accessor:
            rows = self._rows(accessor, kind, *rows.shape)
        if "sparse" in accessor:
            changed, sparse = rows.copy(), accessor["sparse"]
            places = np.dtype(KINDS[sparse["indices"]["componentType"]])
            numbers = self._rows(sparse["indices"], places, sparse["count"], 1)[:, 0]
            changed[numbers] = self._rows(sparse["values"], kind, sparse["count"], rows.shape[1])
            rows = changed
        if accessor.get("normalized"):
            return np.maximum(rows / np.iinfo(kind).max, -1.0)
        return rows.astype(np.float64 if kind.kind == "f" else np.uint32)

    def _rows(self, place, kind, count, parts):
        view = self.tree["bufferViews"][place["bufferView"]]
        start = view["byteOffset"] + place.get("byteOffset", 0)
        stride = view.get("byteStride", parts * kind.itemsize)
        return np.ndarray((count, parts), kind, self.binary, start, (stride, kind.itemsize))

    def add_vectors(self, rows):
        """Adds an accessor of vectors; returns its number."""
        rows = rows.astype("<f4")
        return self._add(rows, {"type": "VEC3", "min": rows.min(0).tolist(), "max": rows.max(0).tolist()})

    def add_indices(self, rows):
        """Adds an accessor of whole numbers; returns its number."""
        return self._add(rows.astype("<u4").ravel(), {"type": "SCALAR"})

    def _add(self, rows, more):
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": rows.nbytes}
        accessor = {"bufferView": len(self.tree["bufferViews"]), "componentType": COMPONENTS[rows.dtype.str]}
        self.tree["bufferViews"].append(view)
        self.tree["accessors"].append({**accessor, "count": len(rows), **more})
        self.binary += rows.tobytes()
        return len(self.tree["accessors"]) - 1

    def write_glb(self, path):
        self.tree["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.tree).encode()
        text += b" " * (-len(text) % 4)
        chunks = b"".join(struct.pack("<II", len(data), name) + data
                          for name, data in ((JSON_CHUNK, text), (BINARY_CHUNK, self.binary)))
        Path(path).write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
