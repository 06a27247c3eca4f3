"""Pins on a mesh: empties that move the cage through a shape key of the cage."""

import numpy as np

from . import deform, library

NAME = 'Cageform pins'  # name of the shape key of the cage

_solvers = {}  # from the stamp of a binding to (pinned vertices, Pins)
_solved = {}   # from the stamp of a binding to the positions of pins and cage at the last solve


def forget():
    _solvers.clear()
    _solved.clear()


def pins_of(binding):
    """Returns the pins of a binding whose empties are in the scene."""
    return [pin for pin in binding.pins if deform.is_in_scene(pin.empty)]


def key_of(cage):
    return deform.find_key(cage, NAME)


def problem(binding):
    """Returns why pins cannot move the cage of a binding, as a sentence; '' if they can."""
    figure = deform.figure_of(binding)
    if figure.handles != figure.vertices:
        return 'Pins do not work with Green: bind with another type.'
    shown = [modifier.name for modifier in binding.cage.modifiers if modifier.show_viewport]
    if shown:
        return 'Pins cannot move a cage with modifiers: apply "%s", or turn it off.' % shown[0]
    return ''


def solver_of(binding, vertices):
    stamp = binding.data['stamp']
    known = _solvers.get(stamp)
    if known is None or known[0] != vertices:
        solver = library.Pins(library.open_samples(binding.data['samples'], skip_checksum=True))
        solver.set(deform.figure_of(binding), vertices)
        known = _solvers[stamp] = vertices, solver
    return known[1]


def pull(binding, depsgraph):
    """Moves the cage so that pinned vertices are at their empties, if an empty or the cage has moved. Other shape keys of
    the cage keep their effect. Returns the cage's vertices in its own space, or None if they do not move, and a fault or ''."""
    pins, figure, cage = pins_of(binding), deform.figure_of(binding), binding.cage
    if not pins or figure is None or deform.problem(binding, figure) or cage.mode == 'EDIT':
        return None, ''
    key = key_of(cage)
    if key is None or key.mute or key.value == 0:
        return None, ''
    fault = problem(binding)
    if fault:
        return None, fault
    rest = figure.rest().astype(np.float64)
    shown, before = deform.shown_positions(cage, depsgraph), deform.key_positions(key)
    matrix = deform.matrix_of(binding, 'from_cage')
    linear = matrix[:3, :3]
    by_pins = (before - deform.rest_positions(cage).astype(np.float64)) @ linear.T
    by_others = deform.moved(shown.astype(np.float64), matrix) - rest - key.value * by_pins

    to_cage = cage.evaluated_get(depsgraph).matrix_world.inverted_safe()
    targets = np.array([to_cage @ pin.empty.evaluated_get(depsgraph).matrix_world.translation for pin in pins])
    targets = deform.moved(targets.astype(np.float64), matrix)
    tolerance = 1e-6 * np.ptp(rest, axis=0).max()
    state = np.concatenate([targets, by_others])
    last = _solved.get(binding.data['stamp'])
    if last is not None and last.shape == state.shape and np.abs(last - state).max() <= tolerance:
        return None, ''
    vertices = [pin.vertex for pin in pins]
    if np.abs(by_others).max() > tolerance:
        targets = targets - (figure.clone(rest + by_others) - figure.clone(rest))[vertices]
    pose = rest + by_pins
    try:
        solver = solver_of(binding, vertices)
        for _ in range(200):
            pose, report = solver.solve(targets, pose)
            if report.settled:
                break
    except library.CageformError as error:
        return None, deform.sentence(error)
    _solved[binding.data['stamp']] = state
    change = pose - rest - by_pins
    if np.abs(change).max() <= tolerance:
        return None, ''
    change = change @ np.linalg.inv(linear).T
    deform.write_key(key, before + change)
    cage.data.update()
    return (shown + key.value * change).astype(np.float32), ''
