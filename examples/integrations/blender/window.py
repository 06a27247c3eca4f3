"""Tests of the add-on in a window; also takes the pictures:

    blender --enable-event-simulate -p 0 0 1280 800 --python window.py -- cageform_blender.zip FOLDER

Commands run as a user starts them, with progress, Escape and undo. Writes screenshots to FOLDER.
"""

import os
import sys
import threading
import time
import traceback

import bpy
import numpy as np

archive, pictures = (os.path.abspath(path) for path in sys.argv[sys.argv.index('--') + 1:])
bpy.ops.preferences.addon_install(filepath=archive, overwrite=True)
bpy.ops.preferences.addon_enable(module='cageform')
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
bpy.context.preferences.view.show_splash = False
from support import *  # needs the add-on

SECONDS = 60  # maximum time of a command


def view():
    window = bpy.context.window_manager.windows[0]
    return window, max((area for area in window.screen.areas if area.type == 'VIEW_3D'), key=lambda area: area.width)


def context():
    """The context of the 3D Viewport, which a timer does not have."""
    window, area = view()
    region = next(region for region in area.regions if region.type == 'WINDOW')
    return bpy.context.temp_override(window=window, area=area, region=region)


def press(kind, x=400, y=400, **modifiers):
    """Presses a key or a mouse button; y points up."""
    window = view()[0]
    window.event_simulate(type='MOUSEMOVE', value='NOTHING', x=x, y=y)
    for value in ('PRESS', 'RELEASE'):
        window.event_simulate(type=kind, value=value, x=x, y=y, **modifiers)


def screenshot(name):
    with context():
        bpy.ops.screen.screenshot(filepath=os.path.join(pictures, name + '.png'))


def crop(name, left, right, bottom, top):
    """The pixels of a part of a screenshot: (#rows, #columns, 4), bottom row first."""
    image = bpy.data.images.load(os.path.join(pictures, name + '.png'))
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(image.size[1], image.size[0], 4)[bottom:top, left:right]
    bpy.data.images.remove(image)
    return pixels


def save(name, pixels, size=1):
    image = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0])
    image.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
    image.scale(round(size * pixels.shape[1]), round(size * pixels.shape[0]))
    image.filepath_raw, image.file_format = os.path.join(pictures, name + '.png'), 'PNG'
    image.save()


def look(turn=0.5):
    """Looks at the scene from the front, a little from above."""
    area = view()[1]
    space = area.spaces[0]
    space.region_3d.view_perspective = 'PERSP'
    space.region_3d.view_rotation = (np.cos(turn / 2) * 0.78, 0.62 * np.cos(turn / 2), 0.62 * np.sin(turn / 2),
                                     0.78 * np.sin(turn / 2))
    space.region_3d.view_location, space.region_3d.view_distance = (0.25, 0, 0.1), 7
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = space.overlay.show_cursor = False
    space.shading.light, space.shading.studio_light = 'MATCAP', 'clay_brown.exr'
    space.shading.background_type, space.shading.background_color = 'VIEWPORT', (0.05, 0.05, 0.05)


def until(ready):
    end = time.monotonic() + SECONDS
    while not ready():
        if time.monotonic() > end:
            raise AssertionError('a command does not end')
        yield 0.05
    yield 0.3


def steps():
    yield 1
    area = view()[1]
    area.spaces[0].show_region_ui = True
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    with context():
        figure = monkey(8000)
        bpy.ops.object.shade_smooth()
    look()
    yield 1
    sidebar = next(region for region in area.regions if region.type == 'UI')
    press('LEFTMOUSE', sidebar.x + sidebar.width - 14, sidebar.y + sidebar.height - 175)  # the tab of the add-on
    yield 0.5
    screenshot('panel_first')

    # The dialog is confirmed; make_cage runs beside the window.
    with context():
        bpy.ops.cageform.make_cage('INVOKE_DEFAULT', vertices=60)
    yield 0.5
    screenshot('dialog')
    press('RET')
    yield from until(lambda: len(figure.cageform.bindings))
    cage = figure.cageform.bindings[0].cage
    assert cage is not None and len(cage.data.vertices) > 30

    # Escape stops a long bind, without a message in the panel.
    binding = figure.cageform.bindings[0]
    binding.accuracy = 1e-3
    with context():
        bpy.ops.ed.undo_push(message='cage')
        threads = threading.active_count()
        result = bpy.ops.cageform.bind('INVOKE_DEFAULT')
    assert result == {'RUNNING_MODAL'}, result
    press('ESC')
    yield from until(lambda: threading.active_count() == threads)
    yield 1
    assert binding.data is None and binding.refused == '', 'Escape stops a bind'
    print('  Escape: nothing is bound')

    binding.accuracy = 1e-2
    with context():
        bpy.ops.cageform.bind('INVOKE_DEFAULT')
    yield 0.1
    screenshot('progress')
    yield from until(lambda: binding.data is not None)
    screenshot('bound')

    # Ctrl Z undoes the bind; Shift Ctrl Z redoes it, and the mesh follows.
    press('Z', ctrl=True)
    yield 1
    figure = bpy.data.objects['Suzanne']
    assert figure.cageform.bindings[0].data is None, 'Ctrl Z undoes a bind'
    press('Z', ctrl=True, shift=True)
    yield 1
    figure = bpy.data.objects['Suzanne']
    binding = figure.cageform.bindings[0]
    assert binding.data is not None, 'Shift Ctrl Z redoes a bind'
    print('  undo and redo: ' + binding.report)

    cage, rest = binding.cage, deform.rest_positions(binding.cage)
    for name, pose in (('tall', rest * (0.8, 0.8, 1.5)), ('bent', bent(rest, 0.35)), ('twisted', twisted(rest, 0.8))):
        before = key_of(figure)
        cage.data.vertices.foreach_set('co', np.float32(pose).ravel())
        cage.data.update()
        yield 0.7
        assert off(key_of(figure), before) > 0.05, 'the mesh follows in the window'
        screenshot('pose_' + name)
    cage.data.vertices.foreach_set('co', rest.ravel())
    cage.data.update()
    yield 0.5

    # Pins: one ear is pulled up; pins hold the nose and the other ear.
    points = deform.rest_positions(figure)
    chosen = [int(points[:, 0].argmax()), int(points[:, 0].argmin()), int(points[:, 1].argmin()), int(points[:, 2].argmin())]
    with context():
        select_only(figure)
        for vertex in figure.data.vertices:
            vertex.select = vertex.index in chosen
        bpy.ops.cageform.add_pins('INVOKE_DEFAULT')
    yield from until(lambda: len(binding.pins))
    empty = next(pin.empty for pin in binding.pins if pin.vertex == chosen[0])
    empty.location.z += 0.9
    yield 1
    place = key_of(figure)[chosen[0]]
    assert np.linalg.norm(place - np.array(empty.location)) < 0.01, 'the pinned vertex is at its empty'
    screenshot('pins')

    # A fault: the panel shows it as text and has a button that selects the faulty elements.
    with context():
        bpy.ops.cageform.remove_pins()
        mesh = cage.data
        faces = [list(face.vertices) for face in mesh.polygons][::2]
        vertices = [tuple(vertex.co) for vertex in mesh.vertices]
        cage.shape_key_clear()
        mesh.clear_geometry()
        mesh.from_pydata(vertices, [], faces)
        try:
            bpy.ops.cageform.bind('INVOKE_DEFAULT')
        except RuntimeError as error:
            print('  ' + str(error).strip())
    yield from until(lambda: binding.refused)
    screenshot('fault')
    with context():
        bpy.ops.cageform.select_faults('INVOKE_DEFAULT')
    yield 0.7
    assert bpy.context.view_layer.objects.active == cage and cage.mode == 'EDIT', 'the faults are shown in edit mode'
    screenshot('fault_selected')

    # Escape stops a wrap, which changes nothing. A wrap that ends writes a shape key.
    with context():
        bpy.ops.object.mode_set(mode='OBJECT')
        for x, scale in ((3, (0.3, 0.2, 1)), (0, (0.2, 0.2, 1))):
            bpy.ops.mesh.primitive_uv_sphere_add(location=(x, 0, 0))
            wrapped = bpy.context.object
            wrapped.scale = scale
        select_only(bpy.data.objects['Sphere'], wrapped)
    for is_stopped in (True, False):
        threads = threading.active_count()
        with context():
            bpy.ops.cageform.wrap_onto('INVOKE_DEFAULT')
        yield 0.5
        press('RET')
        yield from until(lambda: threading.active_count() > threads)
        if is_stopped:
            press('ESC')
        yield from until(lambda: threading.active_count() == threads)
        yield 1
        assert (wrapped.data.shape_keys is None) == is_stopped, 'Escape stops a wrap'
    assert abs(shown(wrapped)[:, 0].mean() - 3) < 0.1, 'the mesh lies on its target'
    print('  wrapped, after an Escape')
    save('blender_panel', crop('pins', 370, 1057, 265, 720))
    poses = [crop('pose_' + name, 368, 680, 215, 575) for name in ('tall', 'bent', 'twisted')]
    save('blender_poses', np.concatenate(poses, axis=1), 0.75)


def twisted(points, angle):
    points = np.array(points, dtype=np.float64)
    turned = points.copy()
    turn = angle * points[:, 2]
    turned[:, 0] = np.cos(turn) * points[:, 0] - np.sin(turn) * points[:, 1]
    turned[:, 1] = np.sin(turn) * points[:, 0] + np.cos(turn) * points[:, 1]
    return turned


running = steps()


def step():
    try:
        return next(running)
    except StopIteration:
        print('window: passed', flush=True)
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        screenshot('failed')
        sys.stderr.flush()
        os._exit(1)


bpy.app.timers.register(step, first_interval=1)
