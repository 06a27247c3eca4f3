"""Plays a skin in Blender and by a reader of its own, and compares the places of all vertices in many frames.

    blender -b --factory-startup --python tests/gltf/in_blender.py -- SKIN.glb PICTURES [BONE]

Prints the largest distance as a share of the figure's size, and exits with 1 if it is above 1e-5. Between keys Blender
moves the numbers of a quaternion straight. The reader does so too, and prints how far that is from glTF's rule. Writes
three frames with the skeleton in front of the figure to PICTURES_0.png, PICTURES_1.png and PICTURES_2.png. With BONE it
writes PICTURES_turned.png too, in which that bone of the rest pose is turned by hand, by 60 degrees.
"""
import math
import os
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from glb import Glb  # noqa: E402

np.bool = bool  # Debian 12 has an importer that is older than its numpy

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
    glb, as_gltf_says = Glb(path, by_components=True), Glb(path)

    def play(time):
        scene.frame_set(time)
        x, y, z = of_blender(mesh).T
        return np.c_[x, z, -y]  # Blender's z is up

    good = glb.compare(path, f"Blender, {len(armature.data.bones)} bones", play)
    off = max(np.linalg.norm(glb.places(t / 1000) - as_gltf_says.places(t / 1000), axis=1).max() for t in glb.times())
    print(f"Blender's turns between keys move the figure by {off / glb.size:.1e} of the size from glTF's")
    size, places = glb.size, of_blender(mesh)

    # The skeleton in front of the figure: an octahedron for each bone.
    lower, upper = places.min(0), places.max(0)
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

    for k, time in enumerate(glb.pictured()):
        scene.frame_set(time)
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
    return 0 if good else 1


sys.exit(main())
