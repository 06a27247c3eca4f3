"""Plays a skin in Blender and by a reader of its own, and compares the places of all vertices in many frames.

    blender -b --factory-startup --python tests/gltf/in_blender.py -- SKIN.glb PICTURES [BONE]

Prints the largest distance as a share of the figure's size, and exits with 1 if it is above 1e-5. Writes three frames
with the skeleton in front of the figure to PICTURES_0.png, PICTURES_1.png and PICTURES_2.png; with BONE another one,
PICTURES_turned.png, in which that bone of the rest pose is turned by hand, by 60 degrees.
"""
import json
import math
import struct
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

np.bool = bool  # Debian 12 has an importer that is older than its numpy
TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
FRAMES = 25


class Glb:
    """As much of glTF 2.0 as a skin with one animation takes."""

    def __init__(self, path):
        data = open(path, "rb").read()
        size = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + size])
        self.bytes = data[20 + size + 8 :]

    def array(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        step = view.get("byteStride", kind.itemsize * width)
        rows = np.ndarray((accessor["count"], width), kind, self.bytes, start, (step, kind.itemsize))
        return rows / np.iinfo(kind).max if accessor.get("normalized") else rows

    def sampled(self, channel, time):
        sampler = self.json["animations"][0]["samplers"][channel["sampler"]]
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
        if angle < 1e-6:
            return a + s * (b - a)
        return (math.sin((1 - s) * angle) * a + math.sin(s * angle) * b) / math.sin(angle)

    def locals_at(self, time):
        nodes = self.json["nodes"]
        parts = [
            {"translation": n.get("translation", [0, 0, 0]), "rotation": n.get("rotation", [0, 0, 0, 1]),
             "scale": n.get("scale", [1, 1, 1])} for n in nodes
        ]
        for channel in self.json["animations"][0]["channels"]:
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


def of_blender(mesh):
    evaluated = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    count = len(evaluated.data.vertices)
    places = np.empty(3 * count, np.float32)
    evaluated.data.vertices.foreach_get("co", places)
    world = np.array(evaluated.matrix_world)
    return places.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]


def render(path):
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def main():
    path, pictures = sys.argv[sys.argv.index("--") + 1 :][:2]
    bone_name = (sys.argv[sys.argv.index("--") + 3 :] or [None])[0]
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    scene = bpy.context.scene
    scene.render.fps = 1000  # glTF counts in seconds: a frame is a millisecond
    bpy.ops.import_scene.gltf(filepath=path, merge_vertices=False)
    mesh = next(o for o in scene.objects if o.type == "MESH" and o.find_armature())
    armature = mesh.find_armature()
    glb = Glb(path)
    inputs = {s["input"] for s in glb.json["animations"][0]["samplers"]}
    last = max(float(glb.array(i)[-1, 0]) for i in inputs)
    size, largest = 0.0, 0.0
    for n in range(FRAMES):
        time = round(1000 * last * n / (FRAMES - 1))
        scene.frame_set(time)
        x, y, z = glb.places(time / 1000).T
        expected = np.c_[x, -z, y]  # Blender's z is up
        if n == 0:
            size = float(np.linalg.norm(expected.max(0) - expected.min(0)))
        found = of_blender(mesh)
        if found.shape != expected.shape:
            print(f"{path}: {len(found)} vertices in Blender, {len(expected)} in the file")
            return 1
        largest = max(largest, float(np.linalg.norm(found - expected, axis=1).max()))
    print(f"{path}: {len(expected)} vertices, {len(armature.data.bones)} bones, {FRAMES} frames: "
          f"at most {largest / size:.1e} of the size apart")

    # The skeleton in front of the figure: an octahedron for each bone.
    lower, upper = expected.min(0), expected.max(0)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 1.25 * float((upper - lower).max())
    camera.location = Vector((lower + upper) / 2) + Vector((0.6, -3, 0.4)) * size
    camera.rotation_euler = (Vector((lower + upper) / 2) - camera.location).to_track_quat("-Z", "Y").to_euler()
    camera.data.clip_end = 10 * size
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x = scene.render.resolution_y = 700
    mesh.data.materials.clear()
    scene.display.shading.show_xray = True
    scene.display.shading.xray_alpha = 0.5
    scene.display.shading.color_type = "OBJECT"
    sticks = []

    def show_bones():
        for stick in sticks:
            bpy.data.objects.remove(stick)
        sticks.clear()
        for bone in armature.pose.bones:
            head, tail = armature.matrix_world @ bone.head, armature.matrix_world @ bone.tail
            bpy.ops.mesh.primitive_cone_add(vertices=4, radius1=0.012 * size, radius2=0, depth=1)
            stick = bpy.context.object
            along = tail - head
            stick.matrix_world = (Matrix.Translation((head + tail) / 2) @ along.to_track_quat("Z", "Y").to_matrix().to_4x4()
                                  @ Matrix.Diagonal((1, 1, max(along.length, 1e-3 * size), 1)))
            stick.color = (0.9, 0.2, 0.1, 1)
            sticks.append(stick)

    for k in range(3):
        scene.frame_set(round(1000 * last * k / 2.6))
        show_bones()
        render(f"{pictures}_{k}.png")
    if bone_name:
        armature.animation_data_clear()
        for bone in armature.pose.bones:
            bone.matrix_basis = Matrix.Identity(4)
        turned = armature.pose.bones[bone_name]
        turned.rotation_mode = "XYZ"
        turned.rotation_euler = (math.radians(60), 0, 0)
        bpy.context.view_layer.update()
        show_bones()
        render(f"{pictures}_turned.png")
    return 0 if largest <= 1e-5 * size else 1


sys.exit(main())
