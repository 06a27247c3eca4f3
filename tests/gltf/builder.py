"""Makes documents of glTF 2.0 from rows of numbers, for make_models.py and broken_models.py."""
import base64
import json
import os
import struct

import numpy as np

from glb import TYPES, turn, unit

CODES = {np.dtype(kind): code for code, kind in TYPES.items()}
SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
PNG = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==")


class Builder:
    """A document under construction: its JSON, the bytes of its buffers, and random numbers."""

    def __init__(self, rng):
        self.rng, self.data, self.suffix, self.uris, self.files = rng, [bytearray()], ".glb", [None], {}
        self.json = {"asset": {"version": "2.0", "generator": "tests of cageform"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
                     "meshes": [], "accessors": [], "bufferViews": []}

    def add(self, name, item):
        self.json.setdefault(name, []).append(item)
        return len(self.json[name]) - 1

    def use(self, extension, required=False):
        for name in ["extensionsUsed"] + ["extensionsRequired"] * required:
            if extension not in self.json.setdefault(name, []):
                self.json[name].append(extension)

    def view(self, data, buffer=0, **more):
        target = self.data[buffer]
        target.extend(bytes(-len(target) % 4))
        item = {"buffer": buffer, "byteOffset": len(target), "byteLength": len(data), **more}
        target.extend(data)
        return self.add("bufferViews", item)

    def accessor(self, rows, bounds=False, normalized=False, view=None, offset=0, target=None, buffer=0):
        """Adds an accessor to rows of numbers; each row begins at a multiple of 4 bytes if it is an attribute (3.6.2.4)."""
        rows = np.ascontiguousarray(rows if rows.ndim == 2 else rows[:, None])
        item = {"componentType": CODES[rows.dtype], "type": SHAPES[rows.shape[1]], "count": len(rows)}
        if view is None:
            size, more = rows.itemsize * rows.shape[1], {"target": target} if target else {}
            if target == 34962 and size % 4:
                more["byteStride"] = size + -size % 4
                padded = np.full((len(rows), more["byteStride"]), 0xA5, np.uint8)
                padded[:, :size] = rows.view(np.uint8)
                view = self.view(padded.tobytes(), buffer, **more)
            else:
                view = self.view(rows.tobytes(), buffer, **more)
        if offset:
            item["byteOffset"] = offset
        if normalized:
            item["normalized"] = True
        if bounds:
            item["min"], item["max"] = rows.min(0).tolist(), rows.max(0).tolist()
        return self.add("accessors", {"bufferView": view, **item})

    def put(self, accessor, where, values, kind=np.uint16, keep=True):
        """Gives an accessor sparse values, of which the rows `where` change; without `keep`, the others become 0."""
        item, where = self.json["accessors"][accessor], np.asarray(where, kind)
        item["sparse"] = {"count": len(where), "indices": {"bufferView": self.view(where.tobytes()), "componentType": CODES[where.dtype]},
                          "values": {"bufferView": self.view(values.tobytes())}}
        if not keep:
            del item["bufferView"]
        return item

    def attributes(self, columns, buffer=0):
        return {name: self.accessor(rows, name == "POSITION", rows.dtype.kind in "iu" and not name.startswith("JOINTS"), target=34962, buffer=buffer)
                for name, rows in columns.items()}

    def indices(self, values, kind=np.uint16):
        return self.accessor(np.asarray(values, kind).reshape(-1), target=34963)

    def points(self, n, scale=1.0):
        return (self.rng.uniform(-1, 1, (n, 3)) * scale).astype(np.float32)

    def directions(self, n, across=None):
        rows = unit(self.rng.normal(size=(n, 3)))
        return (rows if across is None else unit(np.cross(across, rows))).astype(np.float32)

    def columns(self, n, names="POSITION", scale=1.0):
        """Random attributes of n vertices; `names` are divided by spaces."""
        rng, result = self.rng, {}
        for name in names.split():
            if name == "POSITION":
                result[name] = self.points(n, scale)
            elif name == "NORMAL":
                result[name] = self.directions(n)
            elif name == "TANGENT":
                result[name] = np.c_[self.directions(n, result["NORMAL"]), rng.choice([-1, 1], n)].astype(np.float32)
            elif name.startswith("COLOR"):
                result[name] = rng.integers(0, 256, (n, 4)).astype(np.uint8)
            else:
                result[name] = rng.uniform(0, 1, (n, 2)).astype(np.float32)
        return result

    def triangles(self, n):
        """Triangles that use all of n vertices, 3 k of them in any order."""
        order = self.rng.permutation(n)
        return np.concatenate([order, order[: -n % 3]])

    def primitive(self, columns, indices="triangles", kind=np.uint16, **more):
        n = len(columns["POSITION"])
        result = {"attributes": self.attributes(columns), **more}
        if indices is not None:
            result["indices"] = self.indices(self.triangles(n) if isinstance(indices, str) else indices, kind)
        return result

    def mesh(self, *primitives, **more):
        return self.add("meshes", {"primitives": list(primitives), **more})

    def node(self, parent=None, scene=0, **more):
        n = self.add("nodes", more)
        if parent is not None:
            self.json["nodes"][parent].setdefault("children", []).append(n)
        elif scene is not None:
            self.json["scenes"][scene]["nodes"].append(n)
        return n

    def figure(self, names="POSITION NORMAL", n=12, **more):
        """A node with a mesh of one primitive."""
        return self.node(mesh=self.mesh(self.primitive(self.columns(n, names))), **more)

    def rotation(self, largest=np.pi):
        axis, angle = self.directions(1)[0], self.rng.uniform(-largest, largest)
        q = np.append(axis * np.sin(angle / 2), np.cos(angle / 2))
        return (q / np.linalg.norm(q)).tolist()

    def numbers(self, low, high, n=3):
        return self.rng.uniform(low, high, n).tolist()

    def placed(self, scale=True):
        """A random translation and rotation, and a scale that differs by axis."""
        result = {"translation": self.numbers(-1, 1), "rotation": self.rotation()}
        return {**result, "scale": self.numbers(0.5, 2)} if scale else result

    def matrix(self):
        m = np.eye(4)
        m[:3, :3] = turn(*self.rotation()) * self.numbers(0.5, 2)
        m[:3, 3] = self.numbers(-1, 1)
        return m.T.ravel().tolist()

    def targets(self, primitive, names, n, count=2):
        """Adds morph targets with differences for the attributes named."""
        rows = lambda: (self.rng.normal(size=(n, 3)) * 0.3).astype(np.float32)  # noqa: E731
        primitive["targets"] = [{name: self.accessor(rows(), name == "POSITION", target=34962) for name in names.split()} for _ in range(count)]
        return primitive

    def animate(self, *channels, keys=(0.0, 0.4, 1.0)):
        """Adds an animation: channels are (node, path, rows, interpolation); rows of int16 are normalised."""
        times, animation = self.accessor(np.array(keys, np.float32), True), {"channels": [], "samplers": []}
        for node, path, rows, way in channels:
            animation["channels"].append({"sampler": len(animation["samplers"]), "target": {"node": node, "path": path}})
            rows = np.asarray(rows) if getattr(rows, "dtype", None) == np.int16 else np.asarray(rows, np.float32)
            animation["samplers"].append({"input": times, "output": self.accessor(rows, normalized=rows.dtype == np.int16), "interpolation": way})
        return self.add("animations", animation)

    def write(self, path):
        """Writes the document; of a .gltf, also buffers with a URI and the files beside it. Lists without items are left out."""
        used = [k for k, data in enumerate(self.data) if data]
        for k in used:
            self.add("buffers", {**({"uri": self.uris[k]} if self.uris[k] else {}), "byteLength": len(self.data[k])})
        document = {name: item for name, item in self.json.items() if item != []}
        text = json.dumps(document, ensure_ascii=False).encode()
        for name, data in self.files.items():
            with open(os.path.join(os.path.dirname(path), name), "wb") as file:
                file.write(data)
        binary = bytes(self.data[0]) + bytes(-len(self.data[0]) % 4)
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if self.data[0] and not self.uris[0]:
            chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
        with open(path + self.suffix, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks if self.suffix == ".glb" else text)
        return path + self.suffix

    def beside(self, name, uri=None):
        """Makes a .gltf with its buffer in a file of its own."""
        self.suffix, self.uris[0], self.files[name] = ".gltf", uri or name, self.data[0]

    def data_uri(self, buffer=0):
        self.suffix = ".gltf"
        self.data[buffer].extend(bytes(-len(self.data[buffer]) % 4))
        self.uris[buffer] = "data:application/octet-stream;base64," + base64.b64encode(self.data[buffer]).decode()
