"""Writes broken glTF files, each with one fault, and checks how a program refuses them.

    /usr/bin/python3 tests/gltf/broken_models.py FOLDER [COMMAND WORD...]

Without COMMAND, the files are written. With it, COMMAND is run on each, with the file in place of {in} and a name in FOLDER/out
in place of {out}. It has to exit with 1, to print one line with the name of the file and the element at fault, and to leave no file
behind. COMMAND must accept the documents without a fault. Prints each failure; exits with 1 if there is one.
"""
import base64
import json
import os
import re
import resource
import shutil
import struct
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
from builder import Builder  # noqa: E402
from make_models import add_skin, influences, skeleton  # noqa: E402

ABSENT = object()
COPIED = {"skin_joint_scale_zero"}  # a program may accept these
SECONDS, BYTES = 20, 4 << 30  # for each file


# ---- sound documents ----
def figure(b):
    b.figure("POSITION NORMAL TANGENT")  # accessors and views 0 to 3, the last of indices


def plain_u8(b):
    b.node(mesh=b.mesh(b.primitive(b.columns(12), kind=np.uint8)))


def skin(b):
    """Accessors: 0 POSITION, 1 NORMAL, 2 JOINTS_0, 3 WEIGHTS_0, 4 indices, 5 inverse bind matrices, 6 times, 7 keys.

    Nodes 0 to 4 are joints.
    """
    nodes, worlds = skeleton(b)
    primitive = b.primitive({**b.columns(12, "POSITION NORMAL"), **influences(b, 12, 5)})
    b.node(mesh=b.mesh(primitive), skin=add_skin(b, nodes, worlds))
    turns = [b.rotation() for _ in range(3)]
    b.animate((nodes[1], "translation", b.points(3), "LINEAR"), (nodes[2], "rotation", turns, "LINEAR"))


def targets(b):
    """Accessors: 0 POSITION, 1 NORMAL, 2 indices, 3 to 6 of two targets."""
    primitive = b.targets(b.primitive(b.columns(12, "POSITION NORMAL")), "POSITION NORMAL", 12)
    b.node(mesh=b.mesh(primitive, weights=[0.5, 0.5]))


def sparse(b):
    b.figure("POSITION")
    where, rows = [2, 5, 7], np.frombuffer(bytes(b.data[0]), np.float32, 36).reshape(12, 3)
    b.put(0, where, rows[where])


def meshopt(b):
    figure(b)
    b.use("EXT_meshopt_compression", True)
    b.json["bufferViews"][0]["extensions"] = {
        "EXT_meshopt_compression": {"buffer": 0, "byteLength": 100, "byteStride": 12, "count": 12, "mode": "ATTRIBUTES"}}


def draco(b):
    figure(b)
    b.use("KHR_draco_mesh_compression", True)
    b.json["meshes"][0]["primitives"][0]["extensions"] = {
        "KHR_draco_mesh_compression": {"bufferView": 1, "attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2}}}


# ---- one value of the JSON is another: (name, document, path, value, words of the message) ----
P, A = "meshes/0/primitives/0", "accessor 0"  # a path; words of a message
OF_JSON = [
    # accessors and views
    ("count_large", figure, "accessors/0/count", 1000, A),
    ("count_2_31", figure, "accessors/0/count", 2**31, A),
    ("count_2_63", figure, "accessors/0/count", 2**63, A),
    ("count_of_many_digits", figure, "accessors/0/count", 10**30, A),
    ("count_negative", figure, "accessors/0/count", -1, A),
    ("count_fraction", figure, "accessors/0/count", 11.5, A),
    ("count_text", figure, "accessors/0/count", "12", A),
    ("count_absent", figure, "accessors/0/count", ABSENT, A),
    ("count_zero", figure, "accessors/0/count", 0, "accessor 0|POSITION has 0"),
    ("count_without_view", figure, "accessors/0", {"componentType": 5126, "type": "VEC3", "count": 2**40}, A),
    ("offset", figure, "accessors/0/byteOffset", 4, A),
    ("offset_2_64", figure, "accessors/0/byteOffset", 2**64 - 4, A),
    ("offset_unaligned", figure, "accessors/0/byteOffset", -4, A),
    ("component_unknown", figure, "accessors/0/componentType", 5130, A),
    ("component_text", figure, "accessors/0/componentType", "FLOAT", A),
    ("component_of_position", figure, "accessors/0/componentType", 5125, A),
    ("component_of_indices", plain_u8, "accessors/1/componentType", 5120, "accessor 1"),
    ("type_unknown", figure, "accessors/0/type", "VEC7", A),
    ("type_absent", figure, "accessors/0/type", ABSENT, A),
    ("type_of_position", figure, "accessors/0/type", "VEC2", A),
    ("type_of_tangent", figure, "accessors/2/type", "VEC3", "accessor 2"),
    ("type_of_indices", figure, "accessors/3/type", "VEC2", "accessor 3"),
    ("view_absent", figure, "accessors/0/bufferView", 99, "bufferView 99"),
    ("view_negative", figure, "accessors/0/bufferView", -1, A),
    ("view_text", figure, "accessors/0/bufferView", "0", A),
    ("view_no_object", figure, "bufferViews/0", 7, "bufferView 0"),
    ("views_no_list", figure, "bufferViews", {"0": {}}, "bufferViews"),
    ("view_buffer", figure, "bufferViews/0/buffer", 7, "buffer 7"),
    ("view_long", figure, "bufferViews/0/byteLength", 10**6, "bufferView 0"),
    ("view_2_40", figure, "bufferViews/0/byteLength", 2**40, "bufferView 0"),
    ("view_offset_2_64", figure, "bufferViews/0/byteOffset", 2**64 - 100, "bufferView 0"),
    ("view_stride", figure, "bufferViews/0/byteStride", 8, "bufferView 0"),
    ("view_stride_large", figure, "bufferViews/0/byteStride", 252, A),
    ("buffer_long", figure, "buffers/0/byteLength", 2**31, "buffer 0"),
    ("buffer_length_absent", figure, "buffers/0/byteLength", ABSENT, "buffer 0"),
    ("buffers_absent", figure, "buffers", ABSENT, "buffer 0"),
    ("sparse_count", sparse, "accessors/0/sparse/count", 2**31, A),
    ("sparse_no_values", sparse, "accessors/0/sparse/values", ABSENT, A),
    ("sparse_component", sparse, "accessors/0/sparse/indices/componentType", 5126, A),
    ("sparse_view", sparse, "accessors/0/sparse/values/bufferView", 99, A),
    # meshes
    ("position_absent", figure, P + "/attributes/POSITION", 99, "accessor 99"),
    ("position_text", figure, P + "/attributes/POSITION", "0", "mesh 0"),
    ("normal_count", figure, "accessors/1/count", 11, "NORMAL"),
    ("indices_absent", figure, P + "/indices", 99, "accessor 99"),
    ("indices_fraction", figure, P + "/indices", 0.5, "mesh 0"),
    ("indices_of_floats", figure, P + "/indices", 1, "accessor 1"),
    ("mode_9", figure, P + "/mode", 9, "mesh 0"),
    ("mode_text", figure, P + "/mode", "TRIANGLES", "mesh 0"),
    ("attributes_list", figure, P + "/attributes", [0], "mesh 0"),
    ("attributes_without", figure, P + "/attributes", ABSENT, "mesh 0"),
    ("primitives_without", figure, "meshes/0/primitives", ABSENT, "mesh 0"),
    ("primitives_text", figure, "meshes/0/primitives", "none", "mesh 0"),
    ("primitive_no_object", figure, P, 3, "mesh 0"),
    ("target_count", targets, "accessors/3/count", 5, "mesh 0"),
    ("target_absent", targets, P + "/targets/0/POSITION", 99, "accessor 99"),
    ("target_no_object", targets, P + "/targets/0", 3, "mesh 0"),
    ("target_type", targets, "accessors/3/type", "SCALAR", "accessor 3"),
    ("targets_no_list", targets, P + "/targets", {"POSITION": 3}, "mesh 0"),
    ("target_weights", targets, "meshes/0/weights", [1], "mesh 0"),
    ("target_weights_text", targets, "meshes/0/weights", ["1", "0"], "mesh 0"),
    ("target_weights_of_node", targets, "nodes/0/weights", [1, 2, 3], "node 0|mesh 0"),
    # nodes and scenes
    ("node_own_child", figure, "nodes/0/children", [0], "node 0"),
    ("nodes_in_a_ring", figure, "nodes", [{"mesh": 0}, {"children": [2]}, {"children": [1]}], "node [12]"),
    ("node_two_parents", figure, "nodes", [{"children": [1, 2]}, {"children": [2]}, {"mesh": 0}], "node 2"),
    ("node_child_twice", figure, "nodes", [{"children": [1, 1]}, {"mesh": 0}], "node 1"),
    ("node_child_absent", figure, "nodes/0/children", [99], "node 99"),
    ("node_children_text", figure, "nodes/0/children", "1", "node 0"),
    ("node_mesh_absent", figure, "nodes/0/mesh", 99, "mesh 99"),
    ("node_matrix_of_15", figure, "nodes/0/matrix", [1.0] * 15, "node 0"),
    ("node_matrix_of_texts", figure, "nodes/0/matrix", ["1"] * 16, "node 0"),
    ("node_matrix_projects", figure, "nodes/0/matrix", [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "node 0"),
    ("node_matrix_singular", figure, "nodes/0/matrix", [1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "node 0"),
    ("node_translation", figure, "nodes/0/translation", [1, 2], "node 0"),
    ("node_scale_large", figure, "nodes/0/scale", [1e308, 1e308, 1e308], "node 0|v [0-9]"),
    ("node_rotation_zero", figure, "nodes/0/rotation", [0, 0, 0, 0], "node 0"),
    ("node_scale_zero", figure, "nodes/0/scale", [1, 0, 1], "node 0"),
    ("scene_absent", figure, "scene", 5, "scene 5"),
    ("scene_text", figure, "scene", "main", "scene"),
    ("scene_node_absent", figure, "scenes/0/nodes", [99], "node 99"),
    ("scene_node_twice", figure, "scenes/0/nodes", [0, 0], "node 0"),
    ("scene_empty", figure, "scenes/0/nodes", ABSENT, "scene|vert"),
    # skins and animations
    ("skin_absent", skin, "nodes/5/skin", 9, "skin 9"),
    ("skin_joint_absent", skin, "skins/0/joints", [0, 1, 2, 3, 99], "node 99"),
    ("skin_joint_text", skin, "skins/0/joints", [0, 1, 2, 3, "4"], "skin 0"),
    ("skin_few_joints", skin, "skins/0/joints", [0, 1], "skin 0|joint"),
    ("skin_no_joints", skin, "skins/0/joints", ABSENT, "skin 0"),
    ("skin_matrices_count", skin, "accessors/5/count", 4, "skin 0"),
    ("skin_matrices_type", skin, "accessors/5/type", "VEC4", "accessor 5"),
    ("skin_matrices_absent", skin, "skins/0/inverseBindMatrices", 99, "accessor 99"),
    ("skin_joint_scale_zero", skin, "nodes/2/scale", [0, 0, 0], "node 2|skin 0|joint 2|node 5"),
    ("skin_joints_of_floats", skin, P + "/attributes/JOINTS_0", 3, "JOINTS_0"),
    ("skin_no_weights", skin, P + "/attributes/WEIGHTS_0", ABSENT, "WEIGHTS_0"),
    ("skin_weights_count", skin, "accessors/3/count", 11, "WEIGHTS_0"),
    ("animation_sampler", skin, "animations/0/channels/0/sampler", 9, "animation 0"),
    ("animation_no_samplers", skin, "animations/0/samplers", ABSENT, "animation 0"),
    ("animation_input", skin, "animations/0/samplers/0/input", 99, "accessor 99"),
    ("animation_output_count", skin, "accessors/7/count", 2, "animation 0"),
    ("animation_cubic_count", skin, "animations/0/samplers/0/interpolation", "CUBICSPLINE", "animation 0"),
    ("animation_output_type", skin, "accessors/7/type", "SCALAR", "accessor 7"),
    ("animation_node", skin, "animations/0/channels/0/target/node", 99, "node 99"),
    ("animation_no_list", skin, "animations/0/channels", 5, "animation 0"),
    # documents
    ("asset_absent", figure, "asset", ABSENT, "asset"),
    ("asset_version_1", figure, "asset/version", "1.0", "version"),
    ("asset_version_number", figure, "asset/version", 2.0, "version"),
    ("extension_required", figure, "extensionsRequired", ["EXT_nobody_knows"], "EXT_nobody_knows"),
    ("extension_no_list", figure, "extensionsRequired", "EXT_nobody_knows", "extensionsRequired"),
    ("nodes_no_list", figure, "nodes", 3, "nodes"),
    ("meshopt_garbage", meshopt, "bufferViews/0/name", "x", "bufferView 0"),
    ("meshopt_mode", meshopt, "bufferViews/0/extensions/EXT_meshopt_compression/mode", "ANY", "bufferView 0"),
    ("meshopt_filter", meshopt, "bufferViews/0/extensions/EXT_meshopt_compression/filter", "ANY", "bufferView 0"),
    ("meshopt_filter_number", meshopt, "bufferViews/0/extensions/EXT_meshopt_compression/filter", 4, "bufferView 0"),
    ("meshopt_count", meshopt, "bufferViews/0/extensions/EXT_meshopt_compression/count", 2**40, "bufferView 0"),
    ("meshopt_stride", meshopt, "bufferViews/0/extensions/EXT_meshopt_compression/byteStride", 7, "bufferView 0"),
    ("meshopt_length", meshopt, "bufferViews/0/extensions/EXT_meshopt_compression/byteLength", 2**40, "bufferView 0"),
    ("meshopt_buffer", meshopt, "bufferViews/0/extensions/EXT_meshopt_compression/buffer", 9, "bufferView 0"),
    ("draco_garbage", draco, P + "/extensions/KHR_draco_mesh_compression/bufferView", 1, "mesh 0"),
    ("draco_view", draco, P + "/extensions/KHR_draco_mesh_compression/bufferView", 99, "bufferView 99"),
    ("draco_attributes", draco, P + "/extensions/KHR_draco_mesh_compression/attributes", ABSENT, "mesh 0"),
]

# ---- one number of a buffer is another: (name, document, accessor, its component, text of struct, value, words) ----
NAN, INF = float("nan"), float("inf")
OF_NUMBERS = [
    ("position_nan", figure, 0, 4, "<f", NAN, "POSITION|accessor 0"),
    ("position_infinite", figure, 0, 4, "<f", -INF, "POSITION|accessor 0"),
    ("position_signals", figure, 0, 4, "<I", 0x7F800001, "POSITION|accessor 0"),
    ("normal_nan", figure, 1, 4, "<f", NAN, "NORMAL|accessor 1"),
    ("tangent_infinite", figure, 2, 4, "<f", INF, "TANGENT|accessor 2"),
    ("target_nan", targets, 3, 4, "<f", NAN, "target|accessor 3"),
    ("index_large", figure, 3, 5, "<H", 12, "vertex 12"),
    ("index_65535", figure, 3, 5, "<H", 65535, "65535"),
    ("index_u8", plain_u8, 1, 5, "<B", 200, "vertex 200"),
    ("sparse_index_large", sparse, "sparse", 2, "<H", 12, A),
    ("sparse_index_descends", sparse, "sparse", 1, "<H", 1, A),
    ("sparse_index_twice", sparse, "sparse", 1, "<H", 2, A),
    ("skin_joint_large", skin, 2, 5, "<B", 5, "joint 5"),
    ("skin_weight_nan", skin, 3, 4, "<f", NAN, "weight|accessor 3"),
    ("skin_weight_negative", skin, 3, 4, "<f", -2.0, "weight|accessor 3"),
    ("skin_weight_infinite", skin, 3, 4, "<f", INF, "weight|accessor 3"),
    ("skin_matrix_nan", skin, 5, 4, "<f", NAN, "skin 0|accessor 5|node 5"),
    ("skin_matrix_row", skin, 5, 3, "<f", 1.0, "skin 0|accessor 5"),
    ("animation_time_nan", skin, 6, 1, "<f", NAN, "animation 0|accessor 6"),
    ("animation_time_descends", skin, 6, 1, "<f", 9.0, "animation 0|accessor 6"),
    ("animation_key_nan", skin, 7, 4, "<f", NAN, "animation 0|accessor 7"),
]


def document(make, seed=1):
    """Returns the JSON and the bytes of a sound document."""
    builder = Builder(np.random.default_rng(seed))
    make(builder)
    builder.json["buffers"] = [{"byteLength": len(builder.data[0])}]
    return builder.json, bytearray(builder.data[0])


def packed(tree, data):
    """Returns a GLB of a tree, or of a text of JSON, and its binary chunk."""
    text = tree if isinstance(tree, bytes) else json.dumps(tree).encode()
    text, data = text + b" " * (-len(text) % 4), bytes(data) + bytes(-len(data) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(data), len(text), 0x4E4F534A)
    return head + text + struct.pack("<II", len(data), 0x004E4942) + data


def with_value(make, path, value):
    tree, data = document(make)
    *way, last = [int(word) if word.isdigit() else word for word in path.split("/")]
    item = tree
    for word in way:
        item = item[word]
    if value is ABSENT:
        del item[last]
    else:
        item[last] = value
    return packed(tree, data)


def with_number(make, accessor, component, text, value):
    tree, data = document(make)
    view = tree["accessors"][0]["sparse"]["indices"]["bufferView"] if accessor == "sparse" else tree["accessors"][accessor]["bufferView"]
    struct.pack_into(text, data, tree["bufferViews"][view]["byteOffset"] + component * struct.calcsize(text), value)
    return packed(tree, data)


def containers():
    """Yields names, bytes and words of files whose container or text is broken."""
    tree, data = document(figure)
    glb = packed(tree, data)
    size = struct.unpack_from("<I", glb, 12)[0]
    text = glb[20 : 20 + size].rstrip()
    places = {"empty": 0, "magic": 4, "version": 8, "header": 12, "chunk_header": 16, "chunk": 20, "json": 20 + size // 2,
              "json_end": 20 + size, "binary_header": 24 + size, "binary_empty": 28 + size, "binary": 28 + size + len(data) // 2,
              "last_byte": len(glb) - 1}
    for name, place in places.items():
        yield f"cut_{name}.glb", glb[:place], ""
    for name, place, value in (("version_1", 4, 1), ("version_3", 4, 3), ("length_long", 8, 2**32 - 1), ("length_short", 8, 100),
                               ("length_0", 8, 0), ("json_long", 12, 2**32 - 1), ("json_0", 12, 0), ("json_short", 12, size - 8),
                               ("json_type", 16, 0x004E4942), ("binary_long", 20 + size, 2**32 - 4)):
        changed = bytearray(glb)
        struct.pack_into("<I", changed, place, value)
        yield f"header_{name}.glb", bytes(changed), "version" if place == 4 else ""
    yield "header_magic.glb", b"glTG" + glb[4:], ""
    extras = {"nan": b"NaN", "not_utf8": b'"\xff\xfe"', "surrogate": b'"\\ud800"', "number_1e999": b"1e999", "deep": b"[" * 10**6 + b"]" * 10**6}
    texts = {name: text.replace(b'"2.0"', b'"2.0", "extras": ' + value) for name, value in extras.items()}
    for name, words in {"cut": text[:-1], "list": b"[]", "null": b"null", "empty_object": b"{}", **texts}.items():
        yield f"text_{name}.glb", packed(words, data), ""
    yield "text_cut.gltf", text[: len(text) // 2], ""


def outside():
    """Yields .gltf files whose buffer is not where it should be, and files beside them."""
    right, data = base64.b64encode(document(figure)[1]).decode(), "data:application/octet-stream;base64,"
    uris = {"missing": "no%20file.bin", "parent": "../../../../../../../etc/passwd", "absolute": "/etc/passwd", "scheme_file": "file:///etc/passwd",
            "scheme_http": "http://127.0.0.1/a.bin", "encoded": "%2e%2e%2fsecret.bin", "parent_inside": "folder/../../secret.bin",
            "backslash": "..\\secret.bin", "folder": "folder", "empty": "", "zero": "short.bin%00.bin", "short": "short.bin", "number": 7,
            "base64_letters": data + right[:80] + "!*" + right[82:], "base64_length": data + right[:-3], "base64_short": data + "AAAA",
            "no_base64": "data:application/octet-stream,AAAA", "data": "data:", "absent": ABSENT}
    for name, uri in uris.items():
        tree, _ = document(figure)
        if uri is not ABSENT:
            tree["buffers"][0]["uri"] = uri
        yield f"uri_{name}.gltf", json.dumps(tree).encode(), "buffer 0"


def all_files():
    for name, make, path, value, words in OF_JSON:
        yield name + ".glb", with_value(make, path, value), words
    for name, make, accessor, component, text, value, words in OF_NUMBERS:
        yield name + ".glb", with_number(make, accessor, component, text, value), words
    yield from containers()
    yield from outside()


def sound():
    """Yields the documents without a fault, which a program must accept."""
    for make in (figure, plain_u8, skin, targets, sparse):
        yield f"sound_{make.__name__}.glb", packed(*document(make))


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))


def run(command, path, folder):
    """Runs a command on a file; returns its exit code, what it printed, and the files it leaves."""
    out = os.path.join(folder, "out")
    shutil.rmtree(out, ignore_errors=True)
    os.mkdir(out)
    given = {"{in}": path, "{out}": os.path.join(out, "moved" + os.path.splitext(path)[1])}
    try:
        done = subprocess.run([given.get(word, word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=SECONDS, preexec_fn=limited)
    except subprocess.TimeoutExpired:
        return f"none after {SECONDS} s", "", []
    return done.returncode, done.stdout.decode(errors="replace"), os.listdir(out)


def refusal(path, words, code, said, left):
    """Returns what is wrong with how a file was refused."""
    lines, faults = [line for line in said.splitlines() if line.strip()], []
    if code != 1:
        faults.append(f"exit code {code}")
    if len(lines) != 1:
        faults.append(f"{len(lines)} lines")
    if os.path.basename(path) not in said:
        faults.append("does not name the file")
    if not re.search(words, said, re.IGNORECASE):
        faults.append(f'does not say "{words}"')
    if re.search(r"exception\.(type_error|out_of_range\.40[13])", said):
        faults.append("says what only a programmer understands")
    if left:
        faults.append("leaves " + ", ".join(left))
    return "; ".join(faults)


def main():
    if len(sys.argv) < 2:
        print(__doc__)
        return 2
    folder, command = os.path.join(sys.argv[1], "files"), sys.argv[2:]
    os.makedirs(os.path.join(folder, "folder"), exist_ok=True)
    size = len(document(figure)[1])
    for name, count in ((os.path.join(folder, "short.bin"), size - 1), (os.path.join(sys.argv[1], "secret.bin"), size)):
        with open(name, "wb") as file:
            file.write(bytes(count))
    files, failed = [*all_files(), *((name, data, None) for name, data in sound())], 0
    for name, data, words in files:
        path = os.path.join(folder, name)
        with open(path, "wb") as file:
            file.write(data)
        if command:
            result = run(command, path, sys.argv[1])
            fault = refusal(path, words, *result) if words is not None else "is sound" if result[0] != 0 else ""
            fault = "" if result[0] == 0 and name.removesuffix(".glb") in COPIED else fault
            failed += fault != ""
            if fault:
                print(f"FAILED: {name}: {fault}\n  " + result[1].strip()[:400].replace("\n", "\n  "))
    print(f"{len(files)} files" + (f", {failed} failed" if command else " written"))
    return 1 if failed else 0


sys.exit(main())
