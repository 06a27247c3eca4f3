"""Checks that a glTF file is another one with its points moved by an affine map of world space, and nothing else changed.

    /usr/bin/python3 tests/gltf/compare_documents.py INPUT OUTPUT [--move all:X,Y,Z | --turn all:DEGREES,AXIS@X,Y,Z |
                                                     --scale all:X,Y,Z@X,Y,Z]...

INPUT and OUTPUT are files, or folders: then each file of OUTPUT is compared with that of the same name in INPUT/decoded, or else in
INPUT. A file in a folder decoded stands for a compressed one with the same values, whose buffers may have another order.
Operations are as in deform_mesh, one after the other. Prints a line of distances for each file, or the reason of a difference;
exits with 1 if there is one. With animations, the line has the largest distance between the moved input and the output, at five
times of each.
"""
import argparse
import copy
import hashlib
import os
import sys

import numpy as np

sys.dont_write_bytecode = True
from glb import Document, cofactors, unit  # noqa: E402

MOVED = ("POSITION", "NORMAL", "TANGENT")
COMPRESSION = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}
PLACES, DIRECTIONS = 1e-6, 1e-4  # of the size; of a unit vector
FLOAT = 2.0**-22  # of a coordinate: two units of rounding


class Difference(Exception):
    pass


def demand(right, text):
    if not right:
        raise Difference(text)


# ---- the map ----
def operation(kind, text):
    """Returns the 4 x 4 matrix of all:NUMBERS[@X,Y,Z]."""
    numbers, _, about = text.removeprefix("all:").partition("@")
    about = np.array([float(x) for x in about.split(",")]) if about else np.zeros(3)
    words, m = numbers.split(","), np.eye(4)
    if kind == "move":
        m[:3, 3] = [float(x) for x in words]
    elif kind == "scale":
        m[:3, :3] = np.diag([float(x) for x in words] * (1 if len(words) == 3 else 3))
    else:
        axis = np.eye(3)["xyz".index(words[1])] if len(words) == 2 else np.array([float(x) for x in words[1:]])
        axis, angle = axis / np.linalg.norm(axis), np.radians(float(words[0]))
        cross = np.cross(np.eye(3), axis)
        m[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    m[:3, 3] += about - m[:3, :3] @ about
    return m


def moved(rows, m):
    """Moves what Document.evaluate returns for a primitive."""
    a, result = m[:3, :3], dict(rows)
    result["POSITION"] = rows["POSITION"] @ a.T + m[:3, 3]
    if "NORMAL" in rows:
        result["NORMAL"] = unit(rows["NORMAL"] @ cofactors(a).T)
    if "TANGENT" in rows:
        result["TANGENT"] = np.c_[unit(rows["TANGENT"][:, :3] @ a.T), rows["TANGENT"][:, 3] * np.sign(np.linalg.det(a))]
    return result


# ---- what may change ----
class Changes:
    """What of a document's items may change: accessors, nodes, and keys of animations."""

    def __init__(self, document, decoded):
        self.decoded = decoded
        nodes, meshes, skins = (document.list(name) for name in ("nodes", "meshes", "skins"))
        drawn = [nodes[n] for n, _ in document.scene_nodes() if "mesh" in nodes[n]]
        self.meshes = {node["mesh"] for node in drawn}
        self.skins = {node["skin"] for node in drawn if "skin" in node}
        self.joints = {joint for skin in self.skins for joint in skins[skin]["joints"]}
        self.rounded = set()  # turns that decoders round differently
        self.accessors = {skins[skin]["inverseBindMatrices"] for skin in self.skins if "inverseBindMatrices" in skins[skin]}
        for mesh in self.meshes:
            for primitive in meshes[mesh]["primitives"]:
                for item in [primitive["attributes"], *primitive.get("targets", [])]:
                    self.accessors |= {item[name] for name in MOVED if name in item}
        for animation in document.list("animations"):
            for channel in animation["channels"]:
                output = animation["samplers"][channel["sampler"]]["output"]
                if self.keys(channel):
                    self.accessors.add(output)
                elif decoded and document.json["accessors"][output]["componentType"] == 5122:
                    self.rounded.add(output)

    def keys(self, channel):
        return channel["target"]["path"] == "translation" and channel["target"].get("node") in self.joints


def values(document, index):
    item, rows = document.json["accessors"][index], document.stored(index)
    return [str(rows.dtype), item["type"], len(rows), item.get("normalized", False), hashlib.sha256(rows.tobytes()).hexdigest()]


def shape(document, index):
    return ["moved", document.json["accessors"][index]["type"], document.json["accessors"][index]["count"]]


def mesh_item(document, index, may_move):
    """A mesh with values in place of the numbers of accessors."""
    mesh = copy.deepcopy(document.json["meshes"][index])
    for primitive in mesh["primitives"]:
        for item in [primitive["attributes"], *primitive.get("targets", [])]:
            for name in item:
                item[name] = (shape if may_move and name in MOVED else values)(document, item[name])
        if "indices" in primitive:
            primitive["indices"] = values(document, primitive["indices"])
    return mesh


def animation_item(document, animation, changes):
    """An animation whose channels have their samplers, with values; a sampler of no channel stays in the list."""
    result = copy.deepcopy(animation)
    used = {channel["sampler"] for channel in result["channels"]}
    for channel in result["channels"]:
        sampler = dict(animation["samplers"][channel["sampler"]])
        sampler["input"] = values(document, sampler["input"])
        free = changes.keys(channel) or sampler["output"] in changes.rounded
        sampler["output"] = (shape if free else values)(document, sampler["output"])
        channel["sampler"] = sampler
    result["samplers"] = [sampler for k, sampler in enumerate(result["samplers"]) if k not in used]
    return result


def canonical(document, changes):
    """The document without what may change, with values in place of references to accessors and meshes."""
    result = copy.deepcopy(document.json)
    for name in ("accessors", "bufferViews", "buffers", "meshes", "extensionsUsed", "extensionsRequired"):
        result.pop(name, None)
    drawn = {n for n, _ in document.scene_nodes()}
    for n, node in enumerate(result.get("nodes", [])):
        if "mesh" in node:
            node["mesh"] = mesh_item(document, node["mesh"], n in drawn)
        if n in changes.joints:
            node.pop("translation", None)
            if "matrix" in node:
                node["matrix"] = "moved"
    for k, skin in enumerate(result.get("skins", [])):
        if k in changes.skins:
            skin.pop("inverseBindMatrices", None)
        elif "inverseBindMatrices" in skin:
            skin["inverseBindMatrices"] = values(document, skin["inverseBindMatrices"])
    result["animations"] = [animation_item(document, animation, changes) for animation in result.get("animations", [])]
    for k, image in enumerate(result.get("images", [])):
        for name in ("uri", "bufferView", "mimeType"):
            image.pop(name, None)
        image["bytes"] = hashlib.sha256(document.image(k)).hexdigest()
    return result


def same(one, two, where):
    """Demands that two values of JSON are equal, and names the first place where they are not."""
    demand(type(one) is type(two) or {type(one), type(two)} == {int, float}, f"{where}: {one!r:.80} became {two!r:.80}")
    if isinstance(one, dict):
        for name in sorted(one.keys() | two.keys()):
            demand(name in two, f"{where}/{name} is missing")
            demand(name in one, f"{where}/{name} is new: {two.get(name)!r:.80}")
            same(one[name], two[name], f"{where}/{name}")
    elif isinstance(one, list):
        demand(len(one) == len(two), f"{where} has {len(two)} items instead of {len(one)}")
        for k, pair in enumerate(zip(one, two)):
            same(*pair, f"{where}/{k}")
    else:
        demand(one == two, f"{where}: {one!r:.80} became {two!r:.80}")


def kept(item, *names):
    return {name: value for name, value in item.items() if name not in names}


def compare_lists(one, two, changes):
    """Demands that accessors, views, buffers, meshes and extensions of the input are there, in order; others may follow."""
    packs = two.path.endswith(".glb") and len(one.list("buffers")) > 1  # into the binary chunk
    for name in ("accessors", "meshes") + (() if changes.decoded else ("bufferViews",)) + (() if changes.decoded or packs else ("buffers",)):
        demand(len(two.list(name)) >= len(one.list(name)), f"{name}: {len(two.list(name))} instead of {len(one.list(name))}")
    place = ("bufferView", "byteOffset")
    for k, pair in enumerate(zip(one.list("accessors"), two.list("accessors"))):
        free = place + ("componentType", "normalized", "sparse", "min", "max") if k in changes.accessors else place if changes.decoded else ()
        same(*(kept(item, *free) for item in pair), f"/accessors/{k}")
        if k in changes.rounded:
            most = np.abs(one.stored(k).astype(int) - two.stored(k)).max()
            demand(most <= 1, f"values of /accessors/{k} are {most} off")
        elif k not in changes.accessors:
            same(values(one, k), values(two, k), f"values of /accessors/{k}")
    for k in range(len(one.list("meshes"))):
        same(mesh_item(one, k, k in changes.meshes), mesh_item(two, k, k in changes.meshes), f"/meshes/{k}")
    for k in range(len(one.list("meshes")), len(two.list("meshes"))):
        demand(any(node.get("mesh") == k for node in two.list("nodes")), f"/meshes/{k} is new, and no node has it")
    if not changes.decoded:
        for k, pair in enumerate(zip(one.list("buffers"), two.list("buffers"))):
            same(*(kept(item, "uri", "byteLength") for item in pair), f"/buffers/{k}")
        compare_views(one, two, changes)
    for name in ("extensionsUsed", "extensionsRequired"):
        before, after = one.list(name), two.list(name)
        left = [extension for extension in before if extension in after]
        demand(left == after and set(before) - set(after) <= COMPRESSION | {"KHR_mesh_quantization"}, f"/{name}: {before} became {after}")
    integers = any(two.json["accessors"][primitive["attributes"][name]]["componentType"] != 5126
                   for mesh in two.list("meshes") for primitive in mesh["primitives"] for name in MOVED if name in primitive["attributes"])
    demand(not integers or "KHR_mesh_quantization" in two.list("extensionsRequired"), "KHR_mesh_quantization is not required")


def compare_views(one, two, changes):
    """Demands that the bytes of views are the same, except those of values that move."""
    free = [np.zeros(view["byteLength"], bool) for view in one.list("bufferViews")]
    for k in changes.accessors:
        item, width = one.json["accessors"][k], one.stored(k).itemsize * one.stored(k).shape[1]
        parts = [(item, item["count"], width)] if "bufferView" in item else []
        if "sparse" in item:
            parts.append((item["sparse"]["values"], item["sparse"]["count"], width))
        for part, count, width in parts:
            step = one.json["bufferViews"][part["bufferView"]].get("byteStride", width)
            for n in range(count):
                start = part.get("byteOffset", 0) + n * step
                free[part["bufferView"]][start : start + width] = True
    for k, pair in enumerate(zip(one.list("bufferViews"), two.list("bufferViews"))):
        same(*(kept(item, "byteOffset", "buffer") for item in pair), f"/bufferViews/{k}")
        before, after = (np.frombuffer(document.view(k), np.uint8) for document in (one, two))
        other = np.flatnonzero((before != after) & ~free[k])
        demand(len(other) == 0, f"byte {other[0] if len(other) else 0} of /bufferViews/{k} changed")


def compare_bounds(document):
    """Demands the exact min and max where an accessor has them, and that positions have them (3.6.2.5)."""
    for k, item in enumerate(document.list("accessors")):
        rows = document.stored(k).astype(float)
        demand(np.isfinite(rows).all(), f"/accessors/{k} has a number that is not finite")
        for name, right in (("min", rows.min(0)), ("max", rows.max(0))):
            if name in item:
                found = np.array(item[name], float)
                found = found.astype(np.float32) if item["componentType"] == 5126 else found
                demand(found.shape == right.shape and (found == right).all(), f"/accessors/{k}/{name} is {item[name]}, not {right.tolist()}")
    for k, mesh in enumerate(document.list("meshes")):
        for primitive in mesh["primitives"]:
            for item in [primitive["attributes"], *primitive.get("targets", [])]:
                place = document.json["accessors"][item["POSITION"]] if "POSITION" in item else {"min": 0, "max": 0}
                demand("min" in place and "max" in place, f"POSITION of /meshes/{k} has no min and max")


# ---- where vertices are ----
class Distances:
    """The largest distances of positions, normals and tangents, each with its place."""

    def __init__(self, one, m):
        places = np.concatenate([rows["POSITION"] for rows in one.evaluate().values()])
        self.m, self.size = m, float(np.linalg.norm(places.max(0) - places.min(0)))
        far = np.abs(places @ m[:3, :3].T + m[:3, 3]).max()
        self.limits = {"POSITION": PLACES + FLOAT * far / self.size, "NORMAL": DIRECTIONS, "TANGENT": DIRECTIONS}

    def of(self, one, two, strict=True, label="", **pose):
        """Returns the largest distances; demands that they are small, if `strict`."""
        before, after, largest = one.evaluate(**pose), two.evaluate(**pose), {name: 0.0 for name in MOVED}
        demand(before.keys() == after.keys(), "other nodes or primitives are drawn")
        for (n, p), rows in before.items():
            for name, right in moved(rows, self.m).items():
                difference = after[n, p][name] - right
                if name == "TANGENT":
                    demand(not strict or not difference[:, 3].any(), f"w of a tangent of node {n}, primitive {p} has the other sign")
                distance = np.linalg.norm(difference[:, :3], axis=1)
                if name != "POSITION":
                    distance = distance[np.linalg.norm(right[:, :3], axis=1) > 0.5]
                most = float(distance.max(initial=0)) / (self.size if name == "POSITION" else 1)
                demand(not strict or most <= self.limits[name], f"{label}{name} of node {n}, primitive {p} is {most:.1e} off")
                largest[name] = max(largest[name], most)
        return largest


def compare(one, two, m, decoded=False):
    """Returns a line of distances."""
    changes = Changes(one, decoded)
    same(canonical(one, changes), canonical(two, changes), "")
    if os.path.splitext(one.path)[1] == os.path.splitext(two.path)[1] and not decoded:
        same([kept(image, "bufferView") for image in one.list("images")], [kept(image, "bufferView") for image in two.list("images")], "/images")
    compare_lists(one, two, changes)
    compare_bounds(two)
    distances = Distances(one, m)
    largest = distances.of(one, two)
    text = "at rest " + ", ".join(f"{name.lower()} {value:.0e}" for name, value in largest.items())
    count = max((len(p.get("targets", [])) for mesh in one.list("meshes") for p in mesh["primitives"]), default=0)
    for k in range(count):
        largest = distances.of(one, two, label=f"target {k}: ", weights=lambda n, k=k: np.arange(n) == k)
        text += f"; target {k} {largest['POSITION']:.0e}"
    for k in range(len(one.list("animations"))):
        times = one.last_time(k) * np.array([0, 0.21, 0.5, 0.83, 1])
        text += f"; animation {k} {max(distances.of(one, two, False, animation=k, time=t)['POSITION'] for t in times):.0e}"
    return text


class Operation(argparse.Action):
    def __call__(self, parser, options, text, option):
        options.map = operation(self.dest, text) @ options.map


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.set_defaults(map=np.eye(4))
    for name in ("input", "output"):
        parser.add_argument(name)
    for name in ("--move", "--turn", "--scale"):
        parser.add_argument(name, action=Operation)
    options = parser.parse_args()
    pairs, failed = [(options.input, options.output)], False
    if os.path.isdir(options.input):
        folders = [os.path.join(options.input, "decoded"), options.input]
        names = sorted(name for name in os.listdir(options.output) if name.endswith((".glb", ".gltf")))
        found = [next(path for path in (os.path.join(folder, name) for folder in folders) if os.path.exists(path)) for name in names]
        pairs = [(path, os.path.join(options.output, name)) for path, name in zip(found, names)]
    for one, two in pairs:
        decoded = os.path.basename(os.path.dirname(one)) == "decoded"
        try:
            print(f"{two}: {compare(Document(one), Document(two), options.map, decoded)}")
        except (Difference, LookupError, OSError, TypeError, ValueError) as fault:
            failed = True
            print(f"{two}: DIFFERS: {fault!r}" if not isinstance(fault, Difference) else f"{two}: DIFFERS: {fault}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
