"""Compares times of the add-on and of Blender's Mesh Deform, for Suzanne with about 50,000 vertices in a cage of 60: seconds to
bind, and milliseconds per frame of playback in background mode (median of 60).

    sh examples/integrations/blender/run.sh --benchmark [PRECISION]    of Mesh Deform, 5 by default; 7 takes minutes
"""

import os
import statistics
import sys
import time

import bpy

ARCHIVE, PRECISION = sys.argv[sys.argv.index('--') + 1:][:2]
bpy.ops.preferences.addon_install(filepath=ARCHIVE)
bpy.ops.preferences.addon_enable(module='cageform')
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import empty_scene, monkey, select_only  # noqa: E402


def seconds_of(work):
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def frame_ms():
    scene = bpy.context.scene
    return 1000 * statistics.median(seconds_of(lambda: scene.frame_set(frame)) for frame in range(1, 61))


def swing(cage):
    """Animates the value of a shape key of the cage."""
    cage.shape_key_add(name='Basis', from_mix=False)
    key = cage.shape_key_add(name='Up', from_mix=False)
    for point in key.data:
        point.co.z *= 1.3
    for frame, value in ((1, 0), (60, 1)):
        key.value = value
        key.keyframe_insert('value', frame=frame)
    bpy.context.scene.frame_set(1)


def main():
    empty_scene()
    figure = monkey(50000)
    select_only(figure)
    bpy.ops.cageform.make_cage(vertices=60)
    select_only(figure)
    binding = figure.cageform.bindings[0]
    cage = binding.cage
    swing(cage)
    print('%d vertices in a cage of %d' % (len(figure.data.vertices), len(cage.data.vertices)))
    for kind in ('harmonic', 'mean-value', 'green'):
        binding.kind = kind
        seconds = seconds_of(bpy.ops.cageform.bind)
        print('Cageform, %s: bind %.2f s, frame %.1f ms' % (kind, seconds, frame_ms()), flush=True)
    bpy.ops.cageform.remove_cage()
    bpy.context.scene.frame_set(1)
    deform = figure.modifiers.new('Mesh Deform', 'MESH_DEFORM')
    deform.object, deform.precision = cage, int(PRECISION)
    seconds = seconds_of(lambda: bpy.ops.object.meshdeform_bind(modifier=deform.name))
    print('Mesh Deform, precision %s: bind %.2f s, frame %.1f ms' % (PRECISION, seconds, frame_ms()), flush=True)


main()
