"""An independent reader of glTF 2.0: documents, the values of accessors, and the positions of a scene's vertices.

Numbers in comments are sections of the specification of glTF 2.0. Compressed meshes are not read.
"""
import base64
import json
import math
import os
import struct
import urllib.parse

import numpy as np

TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
FRAMES = 25
ALLOWED = 1e-5


def turn(x, y, z, w):
    """Returns the rotation matrix of a unit quaternion."""
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def unit(rows):
    """Divides each row by its length; rows of zeros stay."""
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return rows / np.where(length > 0, length, 1)


def cofactors(m):
    """Returns the inverse transposes of 3 x 3 matrices times the absolute values of their determinants."""
    a, b, c = m[..., 0], m[..., 1], m[..., 2]
    result = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    return result * np.sign(np.linalg.det(m))[..., None, None]


class Document:
    """A file .glb or .gltf with its buffers.

    Between keys with LINEAR interpolation, rotations have a constant speed along the shortest arc (appendix C). With
    `by_components` each component of the quaternion is interpolated linearly, as in Blender.
    """

    def __init__(self, path, by_components=False):
        self.path, self.by_components = path, by_components
        self.folder = os.path.dirname(path)
        data, binary = open(path, "rb").read(), None
        if data[:4] == b"glTF":  # 4.4.2
            size = struct.unpack_from("<I", data, 12)[0]
            binary, data = data[20 + size + 8 :], data[20 : 20 + size]
        self.json = json.loads(data)
        self.buffers = [self.resource(b["uri"]) if "uri" in b else binary[: b["byteLength"]] for b in self.list("buffers")]

    def list(self, name):
        return self.json.get(name, [])

    def resource(self, uri):
        """Returns the bytes of a data URI or of a file beside the document."""
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return open(os.path.join(self.folder, urllib.parse.unquote(uri)), "rb").read()

    def view(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.buffers[view["buffer"]][start : start + view["byteLength"]]

    def image(self, index):
        image = self.json["images"][index]
        return self.resource(image["uri"]) if "uri" in image else self.view(image["bufferView"])

    def stored(self, index):
        """Returns an accessor's values as they are stored, one row an element, with its sparse ones in place (3.6.2)."""
        accessor = self.json["accessors"][index]
        kind, width, count = np.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]], accessor["count"]

        def rows(view, offset, kind, width, count):
            step = self.json["bufferViews"][view].get("byteStride", kind.itemsize * width)
            return np.ndarray((count, width), kind, self.view(view), offset, (step, kind.itemsize)).copy()

        if "bufferView" in accessor:
            result = rows(accessor["bufferView"], accessor.get("byteOffset", 0), kind, width, count)
        else:
            result = np.zeros((count, width), kind)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            indices, values = sparse["indices"], sparse["values"]
            where = rows(indices["bufferView"], indices.get("byteOffset", 0), np.dtype(TYPES[indices["componentType"]]), 1, sparse["count"])
            result[where[:, 0]] = rows(values["bufferView"], values.get("byteOffset", 0), kind, width, sparse["count"])
        return result

    def array(self, index):
        """Returns an accessor's values; normalised integers become numbers from -1 or 0 to 1 (3.6.2.2)."""
        rows = self.stored(index)
        if not self.json["accessors"][index].get("normalized"):
            return rows
        return np.maximum(rows / np.iinfo(rows.dtype).max, -1)

    def sampled(self, animation, channel, time):
        """Returns a channel's value at a time, in seconds (appendix C); for weights a value for each target."""
        sampler = animation["samplers"][channel["sampler"]]
        times = self.array(sampler["input"])[:, 0].astype(float)
        values = self.array(sampler["output"]).astype(float)
        way, path = sampler.get("interpolation", "LINEAR"), channel["target"]["path"]
        if path == "weights":
            values = values.reshape(len(times) * (3 if way == "CUBICSPLINE" else 1), -1)
        k = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, len(times) - 1))
        turns, cubic = path == "rotation", way == "CUBICSPLINE"
        places = values[1::3] if cubic else values
        if time <= times[0] or k + 1 >= len(times) or way == "STEP":
            return places[0] if time <= times[0] else places[k]
        length = times[k + 1] - times[k]
        s = (time - times[k]) / length
        a, b = places[k], places[k + 1]
        if cubic:
            out, into = values[3 * k + 2], values[3 * k + 3]
            v = (1 - s) ** 2 * (1 + 2 * s) * a + s * s * (3 - 2 * s) * b + length * s * (1 - s) * ((1 - s) * out - s * into)
            return v / np.linalg.norm(v) if turns else v
        if not turns:
            return (1 - s) * a + s * b
        if np.dot(a, b) < 0:
            b = -b
        angle = math.acos(min(1.0, float(np.dot(a, b))))
        if angle < 1e-6 or self.by_components:
            v = a + s * (b - a)
            return v / np.linalg.norm(v)
        return (math.sin((1 - s) * angle) * a + math.sin(s * angle) * b) / math.sin(angle)

    def parts_at(self, animation, time):
        """Returns the properties of all nodes, at rest or at a time of an animation, which is given by its number."""
        parts = [
            {"translation": n.get("translation", [0, 0, 0]), "rotation": n.get("rotation", [0, 0, 0, 1]), "scale": n.get("scale", [1, 1, 1]),
             "matrix": n.get("matrix"), "weights": n.get("weights", self.json["meshes"][n["mesh"]].get("weights") if "mesh" in n else None)}
            for n in self.list("nodes")
        ]
        if animation is not None:
            animation = self.json["animations"][animation]
            for channel in animation["channels"]:
                if "node" in channel["target"] and channel["target"]["path"] in parts[0]:
                    parts[channel["target"]["node"]][channel["target"]["path"]] = self.sampled(animation, channel, time)
        return parts

    def scene_nodes(self):
        """Returns the nodes of the default scene, or of the first one, from the roots down, each with its parent or -1."""
        scenes, nodes = self.list("scenes"), self.list("nodes")
        above = {child for node in nodes for child in node.get("children", [])}
        todo = scenes[self.json.get("scene", 0)].get("nodes", []) if scenes else [n for n in range(len(nodes)) if n not in above]
        result = [(n, -1) for n in todo]
        for n, _ in result:
            result.extend((child, n) for child in nodes[n].get("children", []))
        return result

    def worlds(self, parts):
        """Returns the global transforms of the nodes (3.5.3), also of those in no scene."""
        nodes, result = self.list("nodes"), {}
        above = {child: n for n, node in enumerate(nodes) for child in node.get("children", [])}

        def world(n):
            chain = []
            while n not in result and n is not None:
                chain.append(n)
                n = above.get(n)
            for n in reversed(chain):
                part, m = parts[n], np.eye(4)
                if part["matrix"] is not None:
                    m = np.array(part["matrix"], float).reshape(4, 4).T
                else:
                    m[:3, :3] = turn(*part["rotation"]) * np.array(part["scale"], float)
                    m[:3, 3] = part["translation"]
                result[n] = result[above[n]] @ m if n in above else m

        for n in range(len(nodes)):
            world(n)
        return result

    def blended(self, primitive, skin, world):
        """Returns the matrix of each vertex: its joints' matrices by weights (3.7.3.3)."""
        joints, inverse = skin["joints"], [np.eye(4)] * len(skin["joints"])
        if "inverseBindMatrices" in skin:
            inverse = self.array(skin["inverseBindMatrices"]).astype(float).reshape(-1, 4, 4).transpose(0, 2, 1)
        matrices = np.array([world[j] @ inverse[k] for k, j in enumerate(joints)])
        attributes, result, k = primitive["attributes"], 0, 0
        while f"JOINTS_{k}" in attributes:
            weights = self.array(attributes[f"WEIGHTS_{k}"]).astype(float)
            result = result + np.einsum("nk,nkij->nij", weights, matrices[self.stored(attributes[f"JOINTS_{k}"])])
            k += 1
        return result

    def evaluate(self, animation=None, time=0.0, weights=None):
        """Returns POSITION, NORMAL and TANGENT in world space: {(node, primitive): {name: rows}}, of the default scene.

        `weights` replaces the weights of morph targets: a function of their number. The last number of a tangent has
        the sign of its matrix too, so that it times normal x tangent is the bitangent in world space.
        """
        parts = self.parts_at(animation, time)
        world, result = self.worlds(parts), {}
        for n, _ in self.scene_nodes():
            node = self.json["nodes"][n]
            for p, primitive in enumerate(self.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []):
                targets, found = primitive.get("targets", []), {}
                by = weights(len(targets)) if weights else parts[n]["weights"]
                for name in ("POSITION", "NORMAL", "TANGENT"):
                    if name in primitive["attributes"]:
                        found[name] = self.array(primitive["attributes"][name]).astype(float)
                        for target, weight in zip(targets, [] if by is None else by):
                            if name in target:
                                found[name][:, :3] += weight * self.array(target[name]).astype(float)
                if "POSITION" not in found:
                    continue
                skinned = "skin" in node and "JOINTS_0" in primitive["attributes"]
                m = self.blended(primitive, self.json["skins"][node["skin"]], world) if skinned else world[n][None]
                linear = np.broadcast_to(m[:, :3, :3], (len(found["POSITION"]), 3, 3))
                found["POSITION"] = np.einsum("nij,nj->ni", linear, found["POSITION"]) + m[:, :3, 3]
                if "NORMAL" in found:
                    found["NORMAL"] = unit(np.einsum("nij,nj->ni", cofactors(linear), found["NORMAL"]))
                if "TANGENT" in found:
                    found["TANGENT"][:, :3] = unit(np.einsum("nij,nj->ni", linear, found["TANGENT"][:, :3]))
                    found["TANGENT"][:, 3] *= np.sign(np.linalg.det(linear))
                result[n, p] = found
        return result

    def last_time(self, animation):
        samplers = self.json["animations"][animation]["samplers"]
        return max(float(self.array(sampler["input"])[-1, 0]) for sampler in samplers)


class Glb(Document):
    """A figure with a skin and one animation, which in_blender.py and in_three.py compare with other players."""

    def __init__(self, path, by_components=False):
        super().__init__(path, by_components)
        places = self.places(0)
        self.size = float(np.linalg.norm(places.max(0) - places.min(0)))

    def times(self):
        """Returns the times that are compared: from the first to the last, in whole milliseconds."""
        return [round(1000 * self.last_time(0) * n / (FRAMES - 1)) for n in range(FRAMES)]

    def pictured(self):
        """Returns the three times of the pictures, in milliseconds."""
        return self.times()[: FRAMES - 1 : 9]

    def places(self, time):
        """Returns where all vertices of the first mesh are, in glTF's axes."""
        nodes = self.json["nodes"]
        return np.concatenate([rows["POSITION"] for (n, _), rows in self.evaluate(0, time).items() if nodes[n]["mesh"] == 0])

    def compare(self, path, player, play):
        """Compares with the places that play(milliseconds) returns, in glTF's axes and in the file's order.

        Prints the largest distance as a share of the figure's size, and returns whether it is allowed.
        """
        largest = 0.0
        for time in self.times():
            expected, found = self.places(time / 1000), play(time)
            if found.shape != expected.shape:
                print(f"{path}: {len(found)} vertices in {player}, {len(expected)} in the file")
                return False
            largest = max(largest, float(np.linalg.norm(found - expected, axis=1).max()))
        share = largest / self.size
        print(f"{path}: {player}, {len(expected)} vertices, {FRAMES} frames: at most {share:.1e} of the size apart")
        return share <= ALLOWED
