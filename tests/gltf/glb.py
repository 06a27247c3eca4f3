"""A reader of glTF 2.0 and a player of skins, apart from the library's writer: what in_blender.py and in_three.py compare with."""
import json
import math
import struct

import numpy as np

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
FRAMES = 25
ALLOWED = 1e-5


class Glb:
    """As much of glTF 2.0 as a skin with one animation takes.

    Between straight keys, turns go at one speed along the shortest arc, as glTF says. With `by_components` the numbers of
    the quaternion go straight, as Blender has them.
    """

    def __init__(self, path, by_components=False):
        self.by_components = by_components
        data = open(path, "rb").read()
        size = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + size])
        self.bytes = data[20 + size + 8 :]
        self.animation = self.json["animations"][0]
        places = self.places(0)
        self.size = float(np.linalg.norm(places.max(0) - places.min(0)))

    def array(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        step = view.get("byteStride", kind.itemsize * width)
        rows = np.ndarray((accessor["count"], width), kind, self.bytes, start, (step, kind.itemsize))
        return rows / np.iinfo(kind).max if accessor.get("normalized") else rows

    def times(self):
        """Returns the times that are compared: from the first to the last, in whole milliseconds."""
        last = max(float(self.array(sampler["input"])[-1, 0]) for sampler in self.animation["samplers"])
        return [round(1000 * last * n / (FRAMES - 1)) for n in range(FRAMES)]

    def pictured(self):
        """Returns the three times of the pictures, in milliseconds."""
        return self.times()[: FRAMES - 1 : 9]

    def sampled(self, channel, time):
        sampler = self.animation["samplers"][channel["sampler"]]
        times = self.array(sampler["input"])[:, 0].astype(float)
        values = self.array(sampler["output"]).astype(float)
        k = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, len(times) - 1))
        turns = channel["target"]["path"] == "rotation"
        cubic = sampler.get("interpolation") == "CUBICSPLINE"
        places = values[1::3] if cubic else values
        if time <= times[0] or k + 1 >= len(times):
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

    def locals_at(self, time):
        nodes = self.json["nodes"]
        parts = [
            {"translation": n.get("translation", [0, 0, 0]), "rotation": n.get("rotation", [0, 0, 0, 1]),
             "scale": n.get("scale", [1, 1, 1])} for n in nodes
        ]
        for channel in self.animation["channels"]:
            parts[channel["target"]["node"]][channel["target"]["path"]] = self.sampled(channel, time)
        result = []
        for part in parts:
            x, y, z, w = part["rotation"]
            m = np.eye(4)
            m[:3, :3] = [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
            m[:3, :3] *= np.array(part["scale"], float)
            m[:3, 3] = part["translation"]
            result.append(m)
        return result

    def places(self, time):
        """Returns where all vertices of the first mesh are, in glTF's axes."""
        local, nodes = self.locals_at(time), self.json["nodes"]
        world = [None] * len(nodes)

        def descend(n, above):
            world[n] = above @ local[n]
            for child in nodes[n].get("children", []):
                descend(child, world[n])

        for root in self.json["scenes"][self.json.get("scene", 0)]["nodes"]:
            descend(root, np.eye(4))
        skin = self.json["skins"][0]
        inverse = self.array(skin["inverseBindMatrices"]).astype(float).reshape(-1, 4, 4).transpose(0, 2, 1)
        matrices = np.array([world[j] @ inverse[k] for k, j in enumerate(skin["joints"])])
        result = []
        for primitive in self.json["meshes"][0]["primitives"]:
            of = primitive["attributes"]
            rest = self.array(of["POSITION"]).astype(float)
            rest = np.c_[rest, np.ones(len(rest))]
            place = np.zeros((len(rest), 3))
            sets = 0
            while f"JOINTS_{sets}" in of:
                joints, weights = self.array(of[f"JOINTS_{sets}"]), self.array(of[f"WEIGHTS_{sets}"]).astype(float)
                for k in range(4):
                    place += weights[:, k, None] * np.einsum("nij,nj->ni", matrices[joints[:, k]], rest)[:, :3]
                sets += 1
            result.append(place)
        return np.concatenate(result)

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
