"""Tests compare_documents.py: a reference moves files of make_models.py by an affine map; each of many faults in a result is found.

    /usr/bin/python3 tests/gltf/compare_test.py FOLDER

The reference gives each node a mesh of its own and keeps joints: vertices move before the skin, each by its own matrix. Its
results are written to FOLDER/reference.
"""
import copy
import glob
import os
import shutil
import sys

import numpy as np

sys.dont_write_bytecode = True
from builder import Builder  # noqa: E402
from compare_documents import MOVED, Difference, compare, operation  # noqa: E402
from glb import Document, cofactors, unit  # noqa: E402

MAP = operation("move", "all:1,-2,0.5") @ operation("turn", "all:40,1,2,3") @ operation("scale", "all:1.3,0.8,1.1@1,1,1")
FAULTS = {}


def reopened(document):
    """Returns a Builder that adds to a document."""
    builder = Builder(None)
    builder.json, builder.data = copy.deepcopy(document.json), [bytearray(data) for data in document.buffers]
    builder.uris, builder.buffers = [None] * len(builder.data), builder.json.pop("buffers")
    return builder


def written(builder, path):
    """Writes a .glb whose buffers but the first are data URIs, and reads it."""
    for k in range(1, len(builder.data)):
        builder.data_uri(k)
    builder.suffix = ".glb"
    builder.write(path)
    return Document(path + ".glb")


def move(document, m):
    builder, worlds, a = reopened(document), document.worlds(document.parts_at(None, 0)), m[:3, :3]
    for n, _ in document.scene_nodes():
        node = document.json["nodes"][n]
        if "mesh" not in node:
            continue
        mesh = copy.deepcopy(document.json["meshes"][node["mesh"]])
        for primitive in mesh["primitives"]:
            place = document.blended(primitive, document.json["skins"][node["skin"]], worlds) if "skin" in node else worlds[n][None]
            local = np.linalg.inv(place) @ m @ place
            for name in set(MOVED) & primitive["attributes"].keys():
                rows = document.array(primitive["attributes"][name]).astype(float)
                linear = cofactors(local[:, :3, :3]) if name == "NORMAL" else local[:, :3, :3]
                linear = np.broadcast_to(linear, (len(rows), 3, 3))
                new, length = np.einsum("nij,nj->ni", linear, rows[:, :3]), 1.0
                if name == "POSITION":
                    new += local[:, :3, 3]
                else:
                    length = np.maximum(np.linalg.norm(new, axis=1, keepdims=True), 1e-9)
                    new = np.c_[unit(new), rows[:, 3:] * np.sign(np.linalg.det(a))]
                primitive["attributes"][name] = builder.accessor(new.astype(np.float32), name == "POSITION")
                for target in primitive.get("targets", []):
                    if name in target:
                        new = np.einsum("nij,nj->ni", linear, document.array(target[name]).astype(float)) / length
                        target[name] = builder.accessor(new.astype(np.float32), name == "POSITION")
        builder.json["nodes"][n]["mesh"] = builder.add("meshes", mesh)
    return builder


# ---- faults: each changes a Builder of the moved file `everything` ----
def fault(words):
    """Adds a fault, and the words that have to be in the message."""
    return lambda function: FAULTS.__setitem__(function.__name__, (function, words))


def last_of(b, name, which="attributes"):
    """The last accessor of that name that is not interleaved, and its numbers, to be changed in place."""
    found = [p[which] if which == "attributes" else p[which][0] for mesh in b.json["meshes"] for p in mesh["primitives"] if which in p]
    items = [b.json["accessors"][attributes[name]] for attributes in found if name in attributes]
    item = [i for i in items if "bufferView" in i and "byteStride" not in b.json["bufferViews"][i["bufferView"]]][-1]
    view, kind = b.json["bufferViews"][item["bufferView"]], np.float32 if item["componentType"] == 5126 else np.uint8
    width = {"VEC2": 2, "VEC3": 3, "VEC4": 4}[item["type"]]
    return item, np.frombuffer(b.data[view["buffer"]], kind, item["count"] * width, view.get("byteOffset", 0)).reshape(-1, width)


@fault("POSITION of node")
def position(b):
    rows = last_of(b, "POSITION")[1]
    rows[np.argsort(rows[:, 0])[len(rows) // 2], 0] += 1e-4


@fault("POSITION of node")
def vertex_order(b):
    rows = last_of(b, "POSITION")[1]
    rows[:] = rows[::-1].copy()


@fault("NORMAL of node")
def normal(b):
    last_of(b, "NORMAL")[1][0] *= -1


@fault("TANGENT of node")
def tangent(b):
    last_of(b, "TANGENT")[1][0, :3] *= -1


@fault("has the other sign")
def handedness(b):
    last_of(b, "TANGENT")[1][0, 3] *= -1


@fault("POSITION of node")
def target(b):
    rows = last_of(b, "POSITION", "targets")[1]
    rows[np.argsort(rows[:, 0])[len(rows) // 2], 0] += 1e-3


@fault("/min is")
def bounds(b):
    last_of(b, "POSITION")[0]["min"][1] -= 1e-3


@fault("has no min and max")
def no_bounds(b):
    del last_of(b, "POSITION")[0]["max"]


@fault("/TEXCOORD_0/")
def texture_coordinates(b):
    last_of(b, "TEXCOORD_0")[1][1, 1] += 1e-6


@fault("/mesh/primitives")
def influences(b):
    primitive = next(p for mesh in b.json["meshes"][::-1] for p in mesh["primitives"] if "WEIGHTS_0" in p["attributes"])
    primitive["attributes"]["WEIGHTS_0"] = primitive["attributes"]["POSITION"]


@fault("/indices")
def indices(b):
    first, second = [p for mesh in b.json["meshes"] for p in mesh["primitives"] if "indices" in p][-2:]
    first["indices"] = second["indices"]


@fault("bytes")
def picture(b):
    b.data[0][b.json["bufferViews"][b.json["images"][0]["bufferView"]]["byteOffset"] + 20] ^= 1


@fault("/cameras is missing")
def cameras(b):
    del b.json["cameras"]


@fault("/nodes/8/name")
def name(b):
    b.json["nodes"][8]["name"] = "other"


@fault("/rotation")
def joint_rotation(b):
    b.json["nodes"][1]["rotation"] = [0, 0, 0, 1]


@fault("/translation")
def node(b):
    next(node for node in b.json["nodes"] if node.get("name") == "node 1")["translation"][0] += 1e-9


@fault("/scenes/0/nodes/0")
def order_of_nodes(b):
    b.json["scenes"][0]["nodes"].reverse()


@fault("/scene is missing")
def scene(b):
    del b.json["scene"]


@fault("/extensionsUsed")
def extension(b):
    b.json["extensionsUsed"].pop()


@fault("/animations/0/channels/0")
def interpolation(b):
    b.json["animations"][0]["samplers"][0]["interpolation"] = "STEP"


@fault("/accessors/2")
def accessor(b):
    b.json["accessors"][2]["name"] = "new"


@fault("is new, and no node has it")
def mesh(b):
    b.json["meshes"].append(b.json["meshes"][0])


@fault("/extras")
def extras(b):
    b.json["asset"]["extras"] = {}


def main():
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    folder, failed = sys.argv[1], 0
    os.makedirs(os.path.join(folder, "reference"), exist_ok=True)
    for path in glob.glob(os.path.join(folder, "*.png")):
        shutil.copy(path, os.path.join(folder, "reference"))
    for path in sorted(glob.glob(os.path.join(folder, "*.gl*"))):
        name = os.path.splitext(os.path.basename(path))[0]
        if name.startswith(("meshopt", "draco", "refused")):
            continue
        one = Document(path)
        try:
            compare(one, written(move(one, MAP), os.path.join(folder, "reference", name)), MAP)
        except Difference as difference:
            failed += 1
            print(f"FAILED: {name}: {difference}")
    one = Document(os.path.join(folder, "everything.glb"))
    for name, (function, words) in FAULTS.items():
        builder, message = move(one, MAP), "no difference"
        function(builder)
        try:
            compare(one, written(builder, os.path.join(folder, "reference", "fault")), MAP)
        except Difference as difference:
            message = str(difference)
        if words not in message:
            failed += 1
            print(f"FAILED: fault {name}: {message}")
    print(f"{len(FAULTS)} faults, {failed} failed")
    return 1 if failed else 0


sys.exit(main())
