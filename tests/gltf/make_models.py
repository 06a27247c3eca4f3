"""Writes small valid glTF 2.0 files, each with one property of the format, and some with several.

    /usr/bin/python3 tests/gltf/make_models.py FOLDER [SEED]

Points are random in a box. A program may refuse files whose names begin with "refused_", if it names the reason. Prints the
number of files.
"""
import base64
import os
import sys

import numpy as np

sys.dont_write_bytecode = True
from builder import PNG, Builder  # noqa: E402
from glb import Document, turn  # noqa: E402

MODELS = {}
ALL = "POSITION NORMAL TANGENT TEXCOORD_0 TEXCOORD_1 COLOR_0"


def model(function):
    MODELS[function.__name__] = function
    return function


# ---- indices and modes ----
@model
def plain(b):
    b.figure("POSITION")


@model
def large(b):
    b.node(mesh=b.mesh(b.primitive(b.columns(12, "POSITION NORMAL", 1e4))))


@model
def small_and_far(b):
    columns = b.columns(12, "POSITION NORMAL", 1e-3)
    columns["POSITION"] += np.float32(0.25)
    b.node(mesh=b.mesh(b.primitive(columns)))


@model
def indices_u8(b):
    b.node(mesh=b.mesh(b.primitive(b.columns(20), kind=np.uint8)))


@model
def indices_u32(b):
    b.node(mesh=b.mesh(b.primitive(b.columns(20, "POSITION NORMAL"), kind=np.uint32)))


@model
def no_indices(b):
    b.node(mesh=b.mesh(b.primitive(b.columns(18, "POSITION NORMAL"), None)))


@model
def strips_and_fans(b):
    order = b.rng.permutation(14)
    b.node(mesh=b.mesh(b.primitive(b.columns(14, "POSITION NORMAL"), order, mode=5), b.primitive(b.columns(11), None, mode=5)))
    b.node(mesh=b.mesh(b.primitive(b.columns(14, "POSITION NORMAL"), order, mode=6), b.primitive(b.columns(11), None, mode=6)))


@model
def points_and_lines(b):
    b.figure()
    b.node(mesh=b.mesh(b.primitive(b.columns(9), None, mode=0), *(b.primitive(b.columns(8), b.rng.permutation(8), mode=m) for m in (0, 1, 2, 3))))


@model
def points_alone(b):
    b.node(mesh=b.mesh(b.primitive(b.columns(30, "POSITION COLOR_0"), None, mode=0)))


@model
def vertices_without_faces(b):
    b.node(mesh=b.mesh(b.primitive(b.columns(20, "POSITION NORMAL"), b.triangles(12))))


# ---- views ----
@model
def interleaved(b):
    c = b.columns(12, ALL)
    names = ["POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "COLOR_0"]
    rows = np.concatenate([c[name].view(np.uint8) for name in names], axis=1)
    view, at, attributes = b.view(rows.tobytes(), byteStride=rows.shape[1], target=34962), 0, {}
    for name in names:
        attributes[name] = b.accessor(c[name], name == "POSITION", name == "COLOR_0", view, at)
        at += c[name].itemsize * c[name].shape[1]
    b.node(mesh=b.mesh({"attributes": attributes, "indices": b.indices(b.triangles(12))}))


@model
def padded_stride(b):
    c, attributes = b.columns(12, "POSITION NORMAL"), {}
    for name, rows in c.items():
        padded = b.rng.integers(0, 256, (12, 24)).astype(np.uint8)
        padded[:, 8:20] = rows.view(np.uint8)
        attributes[name] = b.accessor(rows, name == "POSITION", view=b.view(padded.tobytes(), byteStride=24, target=34962), offset=8)
    b.node(mesh=b.mesh({"attributes": attributes, "indices": b.indices(b.triangles(12))}))


@model
def one_view(b):
    """Several accessors one after the other in one view, after bytes that no accessor has."""
    first, second = b.points(9), b.points(6)
    view = b.view(b"\1\2\3\4" * 3 + first.tobytes() + second.tobytes(), byteStride=12, target=34962)
    places = [b.accessor(rows, True, view=view, offset=at) for rows, at in ((first, 12), (second, 12 + first.nbytes))]
    b.node(mesh=b.mesh(*({"attributes": {"POSITION": place}} for place in places)))


@model
def shared_positions(b):
    """Primitives of one mesh with one POSITION accessor: other indices, other normals, no normals."""
    first = b.primitive(b.columns(12, "POSITION NORMAL TEXCOORD_0"))
    other = b.accessor(b.directions(12), target=34962)
    place = first["attributes"]["POSITION"]
    b.node(mesh=b.mesh(first, {**first, "indices": b.indices(b.triangles(12))}, {**first, "attributes": {"POSITION": place, "NORMAL": other}},
                       {**first, "attributes": {"POSITION": place}}))


@model
def positions_of_two_meshes(b):
    first = b.primitive(b.columns(12, "POSITION NORMAL"))
    b.node(mesh=b.mesh(first))
    b.node(mesh=b.mesh(dict(first)), **b.placed())


@model
def position_as_normal(b):
    """One accessor is POSITION and NORMAL of a sphere."""
    place = b.accessor(b.directions(24), True, target=34962)
    b.node(mesh=b.mesh({"attributes": {"POSITION": place, "NORMAL": place}, "indices": b.indices(b.triangles(24))}))


def set_bounds(item, rows):
    item["min"], item["max"] = rows.min(0).tolist(), rows.max(0).tolist()


@model
def sparse(b):
    n, where, base = 12, [1, 4, 9], b.points(12)
    first = b.primitive({"POSITION": base, "NORMAL": b.directions(n)})
    base[where] = b.points(3)
    set_bounds(b.put(first["attributes"]["POSITION"], where, base[where], np.uint8), base)
    b.put(first["attributes"]["NORMAL"], where, b.directions(3))
    of_zeros, rows = b.accessor(np.zeros((n, 3), np.float32)), b.points(n)
    rows[-1] = 0
    set_bounds(b.put(of_zeros, np.arange(n - 1), rows[:-1], np.uint32, keep=False), rows)
    b.node(mesh=b.mesh(first, {"attributes": {"POSITION": of_zeros}}))


# ---- nodes and scenes ----
def used_twice(b, first, second, names="POSITION NORMAL TANGENT"):
    mesh = b.mesh(b.primitive(b.columns(12, names)), name="twice")
    b.node(mesh=mesh, name="one", **first)
    b.node(mesh=mesh, name="two", **second)


@model
def twice_same_turn(b):
    q = b.rotation()
    used_twice(b, {"translation": b.numbers(-1, 1), "rotation": q}, {"translation": b.numbers(-1, 1), "rotation": q})


@model
def twice_other_turn(b):
    used_twice(b, b.placed(), b.placed())


@model
def twice_same_place(b):
    place = b.placed()
    used_twice(b, place, place)


@model
def twice_mirrored(b):
    used_twice(b, b.placed(), {"translation": b.numbers(-1, 1), "scale": [-1, 1, 1]})


@model
def mirrored(b):
    b.figure("POSITION NORMAL TANGENT", scale=[1.5, -0.5, 1], rotation=b.rotation(), translation=b.numbers(-1, 1))


@model
def hierarchy(b):
    parent = None
    for k in range(12):
        place = {"matrix": b.matrix()} if k % 3 == 2 else b.placed()
        if "scale" in place:
            place["scale"] = b.numbers(0.9, 1.1)
        if k % 4 == 3:
            parent = b.figure("POSITION NORMAL TANGENT", 9, parent=parent, name=f"figure {k}", **place)
        else:
            parent = b.node(parent, name=f"node {k}", **place)


@model
def in_other_scenes(b):
    """Meshes in another scene, and in no scene; the default scene is the second."""
    b.json["scenes"] = [{"nodes": [], "name": "first"}, {"nodes": [], "name": "second"}]
    b.json["scene"] = 1
    b.figure(scene=0)
    b.figure(scene=1, **b.placed())
    b.figure(scene=None)


@model
def one_mesh_in_two_scenes(b):
    """A node of the default scene and one of another have the same mesh."""
    b.json["scenes"] = [{"nodes": []}, {"nodes": []}]
    mesh = b.mesh(b.primitive(b.columns(12)))
    b.node(mesh=mesh)
    b.node(scene=1, mesh=mesh)


@model
def no_default_scene(b):
    del b.json["scene"]
    b.figure(**b.placed())


# ---- attributes ----
@model
def attributes(b):
    columns = b.columns(12, ALL)
    columns["TEXCOORD_1"] = b.rng.integers(0, 65536, (12, 2)).astype(np.uint16)
    first = b.primitive(columns)
    first["attributes"]["_TEMPERATURE"] = b.accessor(b.rng.normal(size=12).astype(np.float32), target=34962)
    b.node(mesh=b.mesh(first), **b.placed())


@model
def bounds_of_all(b):
    """min and max of normals and tangents too."""
    columns = b.columns(12, "POSITION NORMAL TANGENT")
    b.node(mesh=b.mesh({"attributes": {name: b.accessor(rows, True, target=34962) for name, rows in columns.items()}}), **b.placed())


def whole(rows, kind):
    return np.round(rows * np.iinfo(kind).max).astype(kind)


def quantized(b, kind, normalized, small, **more):
    b.use("KHR_mesh_quantization", True)
    n, columns = 12, b.columns(12, "POSITION NORMAL TANGENT")
    place = whole(columns["POSITION"], kind)
    attributes = {"POSITION": b.accessor(place, True, normalized, target=34962)}
    for name in ("NORMAL", "TANGENT"):
        attributes[name] = b.accessor(whole(columns[name], small), False, True, target=34962)
    size = 1.5 if normalized else 1.5 / np.iinfo(kind).max
    primitive = {"attributes": attributes, "indices": b.indices(b.triangles(n)), **more}
    return b.node(mesh=b.mesh(primitive), translation=b.numbers(-1, 1), rotation=b.rotation(), scale=[size] * 3), primitive


@model
def quantized_i8(b):
    quantized(b, np.int8, False, np.int8)


@model
def quantized_i8_normalized(b):
    quantized(b, np.int8, True, np.int16)


@model
def quantized_i16(b):
    quantized(b, np.int16, False, np.int16)


@model
def quantized_i16_normalized(b):
    quantized(b, np.int16, True, np.int8)


@model
def quantized_u16(b):
    quantized(b, np.uint16, False, np.int8)


@model
def quantized_targets(b):
    _, primitive = quantized(b, np.int16, True, np.int8)
    rows = lambda: whole(b.rng.uniform(-0.5, 0.5, (12, 3)), np.int16)  # noqa: E731
    primitive["targets"] = [{"POSITION": b.accessor(rows(), True, True, target=34962), "NORMAL": b.accessor(rows(), False, True, target=34962)}]
    b.json["meshes"][0]["weights"] = [0.25]


# ---- files ----
@model
def beside(b):
    b.figure()
    b.beside("points ü of beside.bin", "points%20%C3%BC%20of%20beside.bin")


@model
def data_uri(b):
    b.figure()
    b.data_uri()


@model
def several_buffers(b):
    b.data.append(bytearray())
    b.uris.append(None)
    c = b.columns(12, "POSITION NORMAL")
    attributes = {"POSITION": b.accessor(c["POSITION"], True, target=34962, buffer=1), "NORMAL": b.accessor(c["NORMAL"], target=34962)}
    b.node(mesh=b.mesh({"attributes": attributes, "indices": b.indices(b.triangles(12))}))
    b.beside("several_buffers.bin")
    b.data_uri(1)


@model
def buffers_of_glb(b):
    """A GLB whose second buffer is a file beside it."""
    several_buffers_of_glb = b.columns(12, "POSITION NORMAL")
    b.data.append(bytearray())
    b.uris.append("buffers_of_glb.bin")
    b.files["buffers_of_glb.bin"] = b.data[1]
    b.node(mesh=b.mesh({"attributes": b.attributes(several_buffers_of_glb, 1), "indices": b.indices(b.triangles(12))}))


def textured(b, image):
    texture = b.add("textures", {"source": b.add("images", image)})
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": texture, "texCoord": 0}}, "name": "paint"}
    b.node(mesh=b.mesh(b.primitive(b.columns(12, "POSITION NORMAL TEXCOORD_0"), material=b.add("materials", material))))


@model
def texture_inside(b):
    textured(b, {"bufferView": b.view(PNG), "mimeType": "image/png", "name": "pixel"})


@model
def texture_beside(b):
    textured(b, {"uri": "a%20pixel.png"})
    b.files["a pixel.png"] = PNG
    b.beside("texture_beside.bin")


@model
def texture_data_uri(b):
    textured(b, {"uri": "data:image/png;base64," + base64.b64encode(PNG).decode(), "name": "pixel"})
    b.data_uri()


# ---- what has to stay ----
@model
def extras_and_extensions(b):
    """Extras and an unknown extension at every level, with numbers that have to keep all their digits."""
    extension = "EXT_of_these_tests"
    textured(b, {"bufferView": b.view(PNG), "mimeType": "image/png"})
    b.add("samplers", {})
    b.json["textures"][0]["sampler"] = 0
    camera = b.add("cameras", {"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}})
    mesh_node = b.json["nodes"][0]
    mesh_node["mesh"], other = 0, b.node(camera=camera, **b.placed(False))
    b.animate((other, "translation", b.points(3), "LINEAR"))
    b.accessor(b.points(4))
    k = 0

    def fill(item):
        nonlocal k
        if isinstance(item, dict):
            for value in list(item.values()):
                fill(value)
            k += 1
            item["extras"] = [k, 0.1 * k, 9007199254740993 + k, 1e-300, -0.0, True, None, {"größe": "0\u0000\t\"\\", "empty": {}, "list": []}]
            item["extensions"] = {extension: {"number": k, "bufferView": 0}}
        elif isinstance(item, list):
            for value in item:
                fill(value)

    attributes = b.json["meshes"][0]["primitives"][0].pop("attributes")
    fill(b.json)
    b.json["meshes"][0]["primitives"][0]["attributes"] = attributes
    b.use(extension)


@model
def lights_cameras_variants(b):
    for name in ("KHR_lights_punctual", "KHR_materials_variants", "KHR_texture_transform", "KHR_materials_unlit"):
        b.use(name)
    textured(b, {"bufferView": b.view(PNG), "mimeType": "image/png"})
    b.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {"KHR_texture_transform": {"scale": [2, 3]}}
    b.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 0.5}, "intensity": 3}]},
                            "KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}}
    night = b.add("materials", {"extensions": {"KHR_materials_unlit": {}}})
    b.json["meshes"][0]["primitives"][0]["extensions"] = {"KHR_materials_variants": {"mappings": [{"material": night, "variants": [1]}]}}
    b.node(extensions={"KHR_lights_punctual": {"light": 0}}, **b.placed(False))
    b.node(0, camera=b.add("cameras", {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 0}}))


@model
def names(b):
    node = b.figure(name="Фигура 図 🙂")
    b.json["meshes"][0]["name"] = "maille \"é\" \\ /"
    b.json["scenes"][0]["name"] = ""
    b.node(node, name="Фигура 図 🙂")


@model
def refused_instancing(b):
    b.use("EXT_mesh_gpu_instancing", True)
    node = b.figure()
    b.json["nodes"][node]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": b.accessor(b.points(4, 5))}}}


# ---- skins ----
def local(place):
    if "matrix" in place:
        return np.array(place["matrix"]).reshape(4, 4).T
    m = np.eye(4)
    m[:3, :3] = turn(*place.get("rotation", [0, 0, 0, 1])) * np.array(place.get("scale", [1, 1, 1]))
    m[:3, 3] = place.get("translation", [0, 0, 0])
    return m


def skeleton(b, count=5, parent=None, above=np.eye(4), of_matrices=False):
    """A chain of joints, each but the first a child of one of the two before it. Returns nodes and global transforms."""
    nodes, worlds = [], []
    for k in range(count):
        of = max(0, k - 1 - int(b.rng.integers(0, 2)))
        place = {"translation": b.numbers(-0.5, 0.5), "rotation": b.rotation(0.8)}
        if of_matrices:
            place = {"matrix": local(place).T.ravel().tolist()}
        nodes.append(b.node(nodes[of] if k else parent, name=f"joint {k}", **place))
        worlds.append((worlds[of] if k else above) @ local(place))
    return nodes, worlds


def influences(b, n, joints, sets=1, joint_kind=np.uint8, kind=np.float32):
    """Different joints and weights of sum 1 for each of n vertices; integers have the exact sum."""
    order = np.argsort(b.rng.uniform(size=(n, joints)), axis=1)[:, : 4 * sets]
    weights = b.rng.uniform(0.1, 1, (n, 4 * sets))
    weights /= weights.sum(1, keepdims=True)
    if kind != np.float32:
        weights = np.floor(weights * np.iinfo(kind).max)
        weights[:, 0] += np.iinfo(kind).max - weights.sum(1)
    result = {}
    for k in range(sets):
        result[f"JOINTS_{k}"] = order[:, 4 * k : 4 * k + 4].astype(joint_kind)
        result[f"WEIGHTS_{k}"] = weights[:, 4 * k : 4 * k + 4].astype(kind)
    return result


def add_skin(b, nodes, worlds, inverse=True, of_mesh=np.eye(4)):
    matrices = np.array([(np.linalg.inv(m) @ of_mesh).T.ravel() for m in worlds])
    matrices[:, 3::4] = [0, 0, 0, 1]
    more = {"inverseBindMatrices": b.accessor(matrices.astype(np.float32))} if inverse else {}
    return b.add("skins", {"joints": nodes, **more})


def skinned(b, n=24, names="POSITION NORMAL TANGENT", joints=5, inverse=True, bones=None, **more):
    """Returns the joints, after adding a skinned mesh."""
    nodes, worlds = bones or skeleton(b, joints)
    primitive = b.primitive({**b.columns(n, names), **influences(b, n, len(nodes), **more)})
    b.node(mesh=b.mesh(primitive), skin=add_skin(b, nodes, worlds, inverse), name="skinned")
    return nodes


@model
def skin(b):
    skinned(b)


def bent(b, nodes):
    for n in nodes:
        b.json["nodes"][n]["rotation"] = b.rotation(0.8)


@model
def skin_rest_is_not_bind(b):
    bent(b, skinned(b)[1:])


@model
def skin_scaled_rest(b):
    nodes = skinned(b)
    b.json["nodes"][nodes[2]]["scale"] = [1.2, 0.8, 1.1]


@model
def skin_without_matrices(b):
    skinned(b, inverse=False)


@model
def skin_matrix_joints(b):
    skinned(b, bones=skeleton(b, of_matrices=True))


@model
def skin_u8_weights(b):
    skinned(b, kind=np.uint8)


@model
def skin_u16_weights_u16_joints(b):
    skinned(b, joint_kind=np.uint16, kind=np.uint16)


@model
def skin_8_influences(b):
    bent(b, skinned(b, joints=9, sets=2)[1:])


@model
def skin_skeleton_and_node(b):
    """A skinned node below a moved node, whose own transforms have no effect; joints below a node that is no joint."""
    place = {"translation": [3, 4, 5], "rotation": b.rotation(), "scale": [0.01] * 3}
    armature = b.node(name="armature", **place)
    nodes, worlds = [], []
    for k in range(5):
        item = {"translation": b.numbers(-50, 50), "rotation": b.rotation(0.8)}
        nodes.append(b.node(nodes[-1] if nodes else armature, name=f"joint {k}", **item))
        worlds.append((worlds[-1] if worlds else local(place)) @ local(item))
    skinned(b, bones=(nodes, worlds))
    last = b.json["scenes"][0]["nodes"].pop()
    b.json["nodes"][armature]["children"].append(last)
    b.json["skins"][0]["skeleton"] = armature


@model
def skins_of_shared_joints(b):
    bones = skeleton(b)
    skinned(b, bones=bones)
    skinned(b, n=18, bones=(bones[0][::-1], bones[1][::-1]))
    bent(b, bones[0][2:4])


@model
def mesh_below_joint(b):
    """A static mesh, a camera and nodes between joints."""
    nodes = skinned(b)
    b.figure("POSITION NORMAL TANGENT", parent=nodes[2], **b.placed())
    b.node(nodes[3], camera=b.add("cameras", {"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}), translation=[1, 0, 0])
    between = b.node(nodes[4], translation=[0.2, 0, 0], rotation=b.rotation())
    b.figure("POSITION", 9, parent=between)


@model
def skin_played(b):
    nodes = skinned(b)
    turns = lambda: [b.rotation(0.7) for _ in range(3)]  # noqa: E731
    b.animate((nodes[0], "translation", b.points(3, 0.5), "LINEAR"), (nodes[1], "rotation", turns(), "LINEAR"),
              (nodes[2], "rotation", turns(), "STEP"), (nodes[3], "translation", b.points(9, 0.3), "CUBICSPLINE"), (nodes[3], "scale", b.rng.uniform(0.8, 1.2, (3, 3)), "STEP"))
    cubic = np.array([q for turn_ in turns() for q in (b.numbers(-0.1, 0.1, 4), turn_, b.numbers(-0.1, 0.1, 4))])
    b.animate((nodes[1], "rotation", cubic, "CUBICSPLINE"), (nodes[2], "scale", b.rng.uniform(0.8, 1.2, (3, 3)), "LINEAR"), keys=(0.2, 0.5, 2))


@model
def skin_with_one_sampler(b):
    """Two joints and a node that is no joint play the same keys."""
    nodes = skinned(b)
    other = b.node(**b.placed())
    k = b.animate((nodes[1], "translation", b.points(3), "LINEAR"))
    b.json["animations"][k]["channels"] += [{"sampler": 0, "target": {"node": n, "path": "translation"}} for n in (nodes[2], other)]


@model
def skin_with_one_accessor(b):
    """A joint and a node that is no joint play the same keys in two animations."""
    nodes = skinned(b)
    first = b.animate((nodes[1], "translation", b.points(3), "LINEAR"))
    second = b.animate((b.node(**b.placed()), "translation", b.points(3), "LINEAR"))
    output = b.json["animations"][first]["samplers"][0]["output"]
    b.json["animations"][second]["samplers"][0]["output"] = output


@model
def skin_i16_turns(b):
    nodes = skinned(b)
    b.animate((nodes[1], "rotation", whole(np.array([b.rotation(0.7) for _ in range(3)]), np.int16), "LINEAR"))


@model
def quantized_skin(b):
    b.use("KHR_mesh_quantization", True)
    nodes, worlds = skeleton(b)
    size, n = 1.5, 24
    of_mesh = np.diag([size, size, size, 1.0])
    of_mesh[:3, 3] = 0.25
    columns = b.columns(n, "POSITION NORMAL")
    rows = {"POSITION": whole(columns["POSITION"], np.int16), "NORMAL": whole(columns["NORMAL"], np.int8), **influences(b, n, 5, kind=np.uint8)}
    b.node(mesh=b.mesh({"attributes": b.attributes(rows), "indices": b.indices(b.triangles(n))}), skin=add_skin(b, nodes, worlds, of_mesh=of_mesh))


# ---- morph targets and animations ----
def morphed(b, names="POSITION NORMAL TANGENT", mesh=None, **more):
    primitive = b.targets(b.primitive(b.columns(12, "POSITION NORMAL TANGENT")), names, 12)
    return b.node(mesh=b.mesh(primitive, **(mesh or {})), **more)


@model
def targets(b):
    morphed(b, mesh={"extras": {"targetNames": ["smile", "Ärger"]}}, **b.placed())


@model
def targets_weights_of_mesh(b):
    morphed(b, mesh={"weights": [0.5, -0.25]}, **b.placed())


@model
def targets_weights_of_node(b):
    morphed(b, "POSITION", mesh={"weights": [0.5, -0.25]}, weights=[1, 0.5])


@model
def targets_of_two_nodes(b):
    """Two nodes of one mesh with other weights at rest."""
    node = morphed(b)
    b.node(mesh=b.json["nodes"][node]["mesh"], weights=[0.5, 0.5])


@model
def targets_sparse(b):
    morphed(b, mesh={"weights": [0.5, 0.5]})
    for target in b.json["meshes"][0]["primitives"][0]["targets"]:
        rows, where = np.zeros((12, 3), np.float32), [2, 3, 7]
        rows[where] = b.points(3)
        set_bounds(b.put(target["POSITION"], where, rows[where], np.uint8, keep=False), rows)


@model
def targets_played(b):
    node = morphed(b)
    b.animate((node, "weights", b.rng.uniform(0, 1, 6), "LINEAR"))
    b.animate((node, "weights", b.rng.uniform(0, 1, 18), "CUBICSPLINE"))
    b.animate((node, "weights", b.rng.uniform(0, 1, 6), "STEP"), (node, "rotation", [b.rotation() for _ in range(3)], "LINEAR"))


@model
def nodes_played(b):
    parent = b.node(**b.placed())
    child = b.figure("POSITION NORMAL TANGENT", parent=parent, **b.placed())
    b.animate((parent, "translation", b.points(3), "LINEAR"), (child, "rotation", [b.rotation() for _ in range(3)], "STEP"),
              (child, "scale", b.rng.uniform(0.5, 2, (9, 3)), "CUBICSPLINE"))


@model
def skin_and_targets(b):
    nodes, worlds = skeleton(b)
    columns = {**b.columns(24, "POSITION NORMAL TANGENT TEXCOORD_0"), **influences(b, 24, 5)}
    primitive = b.targets(b.primitive(columns), "POSITION NORMAL TANGENT", 24)
    node = b.node(mesh=b.mesh(primitive, weights=[0.3, 0.6]), skin=add_skin(b, nodes, worlds))
    bent(b, nodes[1:])
    b.animate((nodes[1], "rotation", [b.rotation(0.7) for _ in range(3)], "LINEAR"), (node, "weights", b.rng.uniform(0, 1, 6), "LINEAR"))


@model
def everything(b):
    skin_and_targets(b)
    for make in (twice_mirrored, hierarchy, texture_inside, lights_cameras_variants, strips_and_fans, sparse, attributes, targets_weights_of_mesh,
                 interleaved):
        make(b)


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__)
        return 2
    folder, seed = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1
    os.makedirs(folder, exist_ok=True)
    for k, (name, make) in enumerate(MODELS.items()):
        builder = Builder(np.random.default_rng([seed, k]))
        make(builder)
        Document(builder.write(os.path.join(folder, name))).evaluate()
    print(f"{len(MODELS)} models, seed {seed}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
