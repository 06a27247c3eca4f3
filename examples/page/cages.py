"""Tests of lattices and curved cages on the page."""

import cmath
import csv
import json
import math
import os
import re
import subprocess

from support import DATA, PROGRAMS, check, compare_pictures, farthest, pairs, write_points

STATUS = "document.getElementById('status').textContent"


def rest_of(page):
    return page.run('Array.from(page.cage.rest)')


def places(page):
    """Returns the bound points and their posed positions."""
    page.frames()
    flat = page.run('[Array.from(page.figure.points), Array.from(page.cloneFigure(page.types[0], page.pose))]')
    return [pairs(points) for points in flat]


def pose_by(page, f):
    """Poses all points by a map of the plane, and returns the deviation of the figure from the map."""
    pose = [x for p in pairs(rest_of(page)) for x in f(*p)]
    page.run('page.pose = Float64Array.from(%s); page.redraw()' % pose)
    rest, moved = places(page)
    return farthest(moved, [f(*p) for p in rest])


def set_value(page, name, value):
    """Sets the value of a field or slider with the events of a user."""
    page.run('(() => { const field = document.getElementById(%r); field.value = %r;'
             "for (const kind of ['input', 'change']) field.dispatchEvent(new Event(kind)); })()" % (name, str(value)))
    page.frames()


def open_cage(page, path):
    page.run("clearTimeout(page.notice); page.notice = 0; document.getElementById('status').classList.remove('fault')")
    document = page.call('DOM.getDocument')['root']['nodeId']
    node = page.call('DOM.querySelector', {'nodeId': document, 'selector': '#open-cage'})['nodeId']
    page.call('DOM.setFileInputFiles', {'nodeId': node, 'files': [os.path.abspath(path)]})
    page.frames(4)


def refusal(page, folder, name, text):
    path = os.path.join(folder, name)
    with open(path, 'w') as file:
        file.write(text)
    before = rest_of(page)
    open_cage(page, path)
    page.wait("document.getElementById('status').classList.contains('fault')")
    return page.run(STATUS) if rest_of(page) == before else 'but the cage has changed'


def off_animation(page, folder, cage, shown, *options):
    """Returns the distance of a point of the body from that of animate_svg, half-way through the saved key frames."""
    clip, prefix = page.saved('#save-clip', 'cat_clip.csv'), os.path.join(folder, 'stills_')
    subprocess.run([PROGRAMS + 'animate_svg', DATA + 'cat.svg', '--cage', cage, '--clip', clip, '-o', prefix + '.svg', '--stills', prefix, '--still-count', '2',
                    *options], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    body = re.search(r'id="body"[^>]*?\sd="([^"]*)"', open(prefix + '02.svg').read()).group(1)
    native = tuple(map(float, re.match(r'M([-\d.]+) ([-\d.]+)', body).groups()))
    return math.dist(shown[page.run("page.figure.shapes.find(s => s.element.id === 'body').begin")], native)


def test_kinds(page):
    """Each kind of cage keeps its pose; undo switches between kinds."""
    page.click('[data-figure=cat]')
    page.click('[data-cage=polygon]')
    page.click('#rest')
    page.drag_vertex(9, 50, 20)
    polygon = page.pose()
    page.run("page.ensureBound('green')")
    green = pairs(page.run('Array.from(page.cloneFigure(\'green\', page.pose))'))
    page.click('[data-cage=curved]')
    check(len(page.pose()) == 3 * len(polygon) and page.pose()[0::6] == polygon[0::2], 'curves start with the pose of the polygon')
    error = farthest(places(page)[1], green)
    check(error < 1e-9, 'and deform as Green coordinates: error %.1e' % error)
    page.click('[data-cage=lattice]')
    check(page.pose() == rest_of(page) and places(page)[0] == places(page)[1], 'a lattice starts at rest, bitwise')
    page.drag_vertex(5, 30, 40)
    lattice = page.pose()
    page.click('[data-cage=polygon]')
    check(page.pose() == polygon, 'the polygon keeps its pose')
    page.click('[data-cage=lattice]')
    check(page.pose() == lattice, 'so is the lattice')
    for _ in range(2):
        page.key('z', 'KeyZ', modifiers=2)
    check(page.pose() == lattice and page.run('page.types[0]') == 'splines', 'undo switches the kind of cage')
    page.key('z', 'KeyZ', modifiers=2)
    page.key('z', 'KeyZ', modifiers=2)
    check(page.run("page.cage.kind === 'curved' && document.body.dataset.cage === 'curved'"), 'to the curves')
    page.key('z', 'KeyZ', modifiers=2)
    check(page.pose() == polygon and page.run("page.types[0] === document.querySelector('#types .chosen').dataset.type"), 'and to the polygon')
    for _ in range(2):
        page.key('y', 'KeyY', modifiers=2)
    check(page.run('page.cage.kind') == 'lattice', 'redo switches it again')
    page.click('[data-figure=biped]')
    check(page.run('page.cage.kind') is None, 'another figure keeps its polygon')
    page.click('[data-figure=cat]')
    check(page.run("page.cage.kind === 'lattice' && page.views[0].type === 'splines'"), 'and the cat its lattice again')


ANY_ORDER = '''(seed => {
  const random = () => { // mulberry32
    let t = seed = seed + 0x6D2B79F5 | 0;
    t = Math.imul(t ^ t >>> 15, t | 1);
    t ^= t + Math.imul(t ^ t >>> 7, t | 61);
    return ((t ^ t >>> 14) >>> 0) / 4294967296;
  };
  const any = n => Math.floor(n * random()), points = () => page.pose.length / 2, isLattice = () => page.cage.kind === 'lattice';
  const set = (id, value) => { byId(id).value = value; for (const kind of ['input', 'change']) byId(id).dispatchEvent(new Event(kind)); };
  const move = (f, isBroken = false) => { page.history.remember(); page.moveSelected(f, page.shownPose, isBroken); page.finishEdit(); };
  const pinDrags = f => { setMode(page, 'figure'); page.pinDrag.prepare(); try { f(); } finally { page.pinDrag.stop(); setMode(page, 'cage'); } };
  const steps = {
    kind: () => chooseKind(page, ['polygon', 'lattice', 'curved'][any(3)]),
    drag: () => { page.select([any(points())]); const [dx, dy] = [any(60) - 30, any(60) - 30]; move((x, y) => [x + dx, y + dy], any(3) === 0); },
    turn: () => { page.select(allOf(points()).filter(() => any(3) === 0)); move(turned([500, 400], random() - 0.5)); },
    add: () => isLattice() || page.addVertex(any(points()), 0.1 + 0.8 * random()),
    remove: () => { page.select([3 * any(points() / 3), any(points())]); if (!isLattice()) page.removeSelected(); },
    undo: () => page.history.undo(), redo: () => page.history.redo(), edit: () => byId('edit').click(),
    key: () => { page.timeline.setTime(2.4 * random()); page.timeline.setKey(); }, time: () => page.timeline.setTime(2.4 * random()),
    count: () => isLattice() && set(['columns', 'rows'][any(2)], 2 + any(6)), degree: () => isLattice() && set('degree', ['1', '2', '3', 'bernstein'][any(4)]),
    frozen: () => isLattice() && set('frozen', any(3)), slide: () => set(isLattice() ? 'falloff' : 'disk', page.cage.kind ? random() : 0),
    line: () => isLattice() && selectLine(page), step: () => page.stepVertex(any(2) ? 1 : -1, any(2) === 0), weights: () => byId('weights').click(),
    pin: () => pinDrags(() => { page.history.remember(); const { targets } = page.pins, i = any(targets.length); if (i < targets.length) page.pinDrag.moveTo(i, targets[i].map(x => x + any(60) - 30)); for (let n = 0; n < 3; ++n) page.pinDrag.frame(); }),
    pins: () => pinDrags(() => any(3) ? addFarPin(page) : page.pins.points.length > 1 && (page.history.remember(), page.pinDrag.remove(0))),
    turnPin: () => pinDrags(() => { if (page.pins.points.length === 0) return; page.history.remember(); page.pinDrag.turnTo(0, random() - 0.5); page.pinDrag.frame(); }),
  };
  const names = Object.keys(steps), log = [], first = Array.from(page.pose);
  for (let k = 0; k < 150; ++k) {
    log.push(names[any(names.length)]);
    try {
      steps[log[k]]();
    } catch (error) {
      if (error instanceof TypeError || error instanceof RangeError) return log.slice(-5) + ': ' + error.stack;
    }
    page.draw();
    const count = points(), fault = page.views.find(view => view.fault)?.fault;
    if (fault || 2 * count !== page.cage.rest.length || !page.pose.every(Number.isFinite) || page.views[0].parts.dots.length !== count ||
        [...page.selection].some(i => i >= count) || page.clip.poseTracks.some(({ vertex }) => vertex >= count)) return log.slice(-5) + ': ' + fault;
  }
  if (page.isEditing) byId('edit').click();
  if (page.showsWeights) byId('weights').click();
  while (page.history.earlier.length > 0) page.history.undo();
  page.draw();
  return page.cage.kind || page.pose.join() !== first.join() ? 'undo does not lead back' : '';
})(%d)'''


def test_any_order(page, first):
    """Random changes of cages; undo restores the initial state."""
    page.click('[data-figure=cat]')
    page.click('[data-cage=polygon]')
    faults = []
    for seed in range(first, first + 6):
        page.run("page.show({ figure: page.figure, cage: cageOfSvg(DATA.cat.cage) }); page.onCage()")
        fault = page.run(ANY_ORDER % seed)
        faults += ['seed %d: %s' % (seed, fault)] if fault else []
    check(not faults, '900 steps in any order from seed %d' % first if not faults else '; '.join(faults))
    page.run("page.show({ figure: page.figure, cage: cageOfSvg(DATA.cat.cage) }); page.onCage()")


def take_cage_pictures(page, out):
    page.click('[data-figure=cat]')
    page.click('[data-cage=polygon]')
    page.click('#rest')
    page.run('page.kinds = {}')
    page.click('[data-cage=lattice]')
    page.drag_vertex(5, -20, -110, modifiers=8)
    page.key('Escape')
    page.click('#fit-view')
    page.frames(4)
    page.picture(os.path.join(out, 'page_lattice.png'))
    page.click('[data-cage=curved]')
    page.run('page.addVertex(36, 0.5)')
    page.drag_vertex(39, 0, -50)
    page.drag_vertex(40, -45, -25)
    page.frames(4)
    page.picture(os.path.join(out, 'page_curved.png'))
    page.click('[data-cage=polygon]')


# ---- lattices ----

def native_lattice(page, folder):
    """Returns the figure moved with the weights of cage_weights for the saved lattice."""
    cage, pose, (points, _) = page.saved('#save-cage', 'cat.lattice.json'), pairs(page.pose()), places(page)
    table, out = os.path.join(folder, 'points.csv'), os.path.join(folder, 'weights.csv')
    write_points(table, points)
    subprocess.run([PROGRAMS + 'cage_weights', '--cage', cage, '--points', table, '-o', out], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    rest = pairs(rest_of(page))
    with open(out) as file:
        rows = [[float(w) for w in row[1:]] for row in list(csv.reader(file))[1:]]
    still = len(rows[0]) - len(rest)  # number of additional weights with a falloff, at the end
    assert still in (0, 3)
    return [tuple(p[k] + sum(w * (m[k] - h[k]) for w, m, h in zip(row, pose, rest)) for k in (0, 1)) for p, row in zip(points, rows)]


def test_lattice(page, folder):
    page.click('[data-figure=cat]')
    page.click('[data-cage=polygon]')
    page.click('[data-cage=lattice]')
    page.click('#rest')
    rest = page.pose()
    made = os.path.join(folder, 'made.lattice.json')
    subprocess.run([PROGRAMS + 'make_cage', DATA + 'cat.svg', '--lattice', '4x4', '-o', made], check=True, stdout=subprocess.DEVNULL)
    with open(made) as file:
        box = json.load(file)
    error = max(abs(a - b) for a, b in zip(page.run('Array.from(page.cage.frame)'), box['origin'] + sum(box['frame_columns'], [])))
    check(error < 2e-3 * page.run('page.figure.size'), "the lattice's box differs from that of make_cage by %.3f units" % error)
    check(page.run("[...document.querySelectorAll('#types button')].every(b => b.disabled)"), 'polygon types are disabled')

    page.drag_vertex(5, 20, 10)
    changed = {k // 2 for k, (a, b) in enumerate(zip(rest, page.pose())) if a != b}
    check(changed == {5}, 'a point of a lattice follows the pointer')
    page.drag_vertex(6, 5, -60, modifiers=8)
    scale, pose = page.run('page.views[0].frame().scale'), page.pose()
    moves = [(x - a) * scale for x, a in zip(pose, rest)]
    check(all(math.dist(moves[2 * i:2 * i + 2], (5, -60)) < 1e-6 for i in (4, 6, 7)) and
          math.dist(moves[10:12], (25, -50)) < 1e-6 and all(m == 0 for k, m in enumerate(moves) if k // 2 not in (4, 5, 6, 7)),
          'with Shift its row follows, if the pointer crosses the row')
    page.drag_vertex(9, 30, 4, modifiers=8)
    changed = {k // 2 for k, (a, b) in enumerate(zip(pose, page.pose())) if a != b}
    check(changed == {1, 5, 9, 13}, 'or its column')
    page.key('z', 'KeyZ', modifiers=2)
    check(page.pose() == pose, 'as one undo step')
    middle = [round((a + b) / 2) for a, b in zip(page.vertex(13), page.vertex(14))]
    page.drag(middle, (middle[0], middle[1] + 20), modifiers=8)
    changed = {k // 2 for k, (a, b) in enumerate(zip(pose, page.pose())) if a != b}
    check(changed == {12, 13, 14, 15}, 'and the line, if dragged between its points')
    page.key('Escape')
    page.key('n', 'KeyN')
    page.key('l', 'KeyL')
    row = page.run('[...page.selection].sort((a, b) => a - b)')
    page.key('l', 'KeyL')
    check((row, page.run('[...page.selection].sort((a, b) => a - b)')) == ([0, 1, 2, 3], [0, 4, 8, 12]), 'L selects the row, a second L the column')
    page.key('n', 'KeyN')
    page.key('Insert')
    check(page.run('page.pose.length') == 32 and 'columns and rows' in page.run(STATUS), 'a single point cannot be added: ' + page.run(STATUS))
    page.key('Escape')

    error = farthest(places(page)[1], native_lattice(page, folder))
    check(error < 1e-9, 'the figure agrees with cage_weights: error %.1e' % error)
    mine = open(page.saved('#save-svg', 'cat_posed.svg')).read()
    saved = {name: page.saved(button, name) for button, name in (('#save-cage', 'cat.lattice.json'), ('#save-pose', 'cat_pose.svg'))}
    native = os.path.join(folder, 'native.svg')
    subprocess.run([PROGRAMS + 'deform_svg', DATA + 'cat.svg', '--cage', saved['cat.lattice.json'], '--pose', saved['cat_pose.svg'], '-o', native],
                   check=True, stderr=subprocess.DEVNULL)
    difference = compare_pictures(page, mine, open(native).read(), same_view=True)
    check(difference < 0.002, 'deform_svg with the lattice and pose saved draws the same: colour difference %.5f' % difference)
    error = pose_by(page, lambda x, y: (1.1 * x - 0.4 * y + 30, 0.3 * x + 0.8 * y - 50))
    check(error < 1e-11 * page.run('page.figure.size'), 'an affine pose is exact: error %.1e' % error)

    affine = places(page)[1]
    page.click('#key')
    set_value(page, 'columns', 6)
    set_value(page, 'degree', 'bernstein')
    check(page.run("[page.cage.axes.map(a => [a.points, a.degree]), page.pose.length, page.clip.poseTracks.length].join()") == '6,5,4,3,48,48',
          'a lattice of more columns, of Bernstein polynomials: ' + page.run(STATUS))
    error = max(farthest(places(page)[1], affine), farthest(pairs(page.run('Array.from(page.clip.poseAt(0, page.cage.rest, page.engine))')), pairs(page.pose())))
    check(error < 1e-9, 'keeps an affine pose and its key frame: error %.1e' % error)
    page.key('z', 'KeyZ', modifiers=2)
    page.key('z', 'KeyZ', modifiers=2)
    check(len(page.pose()) == 32 and places(page)[1] == affine, 'undo reverts this')

    set_value(page, 'frozen', 1)
    outer = [i for i in range(16) if i % 4 in (0, 3) or i // 4 in (0, 3)]
    still = page.run("page.views[0].parts.dots.flatMap((dot, i) => dot.classList.contains('still') ? [i] : [])")
    fill = page.run('getComputedStyle(page.views[0].parts.dots[0]).fill')
    check(still == outer and fill == 'rgb(207, 213, 221)', 'points of the frozen layer are grey')
    held, rest = page.pose(), rest_of(page)
    check(all(held[2 * i:2 * i + 2] == rest[2 * i:2 * i + 2] for i in outer), 'and at rest')
    page.drag_vertex(0, 30, 30)
    check(page.pose() == held, 'drags do not move them')
    page.drag_vertex(5, 0, 25, modifiers=8)
    check({k // 2 for k, (a, b) in enumerate(zip(held, page.pose())) if a != b} == {5, 6}, 'dragging a row does not move its frozen ends')
    page.run('page.timeline.setTime(0)')
    check(page.pose() == held, 'and key frames do not move them')
    page.click('#no-clip')
    set_value(page, 'frozen', 0)

    page.drag_vertex(15, 40, 30)
    page.click('#edit')
    page.drag_vertex(6, -120, 60)  # the box as a whole
    page.click('#edit')
    outside = page.run('page.bound.splines.outside')
    set_value(page, 'falloff', 0.1)
    check(outside > 50 and 0 < page.run('page.cage.falloff') < page.run('page.figure.size'), 'after moving the box, %d points are outside, and a falloff is set' % outside)
    rest, moved = places(page)
    error = farthest(moved, native_lattice(page, folder))
    check(error < 1e-9 and farthest(rest, moved) > 5, 'as with cage_weights: error %.1e' % error)
    cage = page.saved('#save-cage', 'cat.lattice.json')
    values = page.run("JSON.stringify([Array.from(page.cage.rest), page.cage.frame, page.cage.falloff])")
    page.key('z', 'KeyZ', modifiers=2)
    check(page.run('page.cage.falloff') == 0, 'undo removes the falloff')
    open_cage(page, cage)
    check(page.run("JSON.stringify([Array.from(page.cage.rest), page.cage.frame, page.cage.falloff])") == values, 'the saved lattice opens with bitwise equal values')

    page.click('#rest')
    page.click('#key')
    page.run('page.timeline.setTime(1.2)')
    page.drag_vertex(5, 40, -30)
    page.key('k', 'KeyK')
    page.run('page.timeline.setTime(1.2)')
    shown = places(page)[1]
    error = off_animation(page, folder, cage, shown)
    check(error < 0.08, 'animate_svg plays key frames of the lattice: difference %.3f (it writes one decimal)' % error)
    said = [refusal(page, folder, *file) for file in (('a.lattice.json', '{"format": "lattice/1"}'), ('b.lattice.json', '{'),
            ('c.lattice.json', json.dumps({**box, 'axes': [{'points': 1, 'degree': 1}, {'points': 4, 'degree': 3}]})),
            ('d.lattice.json', json.dumps({**box, 'frame_columns': [[1, 2], [2, 4]]})))]
    check('is not a lattice' in said[0] and 'is not JSON' in said[1] and 'degree' in said[2] and said[3], 'invalid lattice files are errors: ' + ' | '.join(said))
    page.click('#no-clip')
    page.click('#weights')
    page.drag_vertex(9, 1, 1)
    check(page.run('page.views[0].field.width > 100'), 'weights of a point are shown')
    page.click('#weights')


# ---- curves ----

def curves(points):
    """Returns the edges of one loop, four points each, as complex numbers."""
    z = [complex(*p) for p in points]
    return [[z[k], z[k + 1], z[k + 2], z[(k + 3) % len(z)]] for k in range(0, len(z), 3)]


def bezier(points, t):
    while len(points) > 1:
        points = [(1 - t) * a + t * b for a, b in zip(points, points[1:])]
    return points[0]


# Gauss and Legendre's eight nodes on [0, 1].
NODES = [(0.5 + s * x / 2, w / 2) for x, w in ((0.1834346424956498, 0.3626837833783620), (0.5255324099163290, 0.3137066458778873),
         (0.7966664774136267, 0.2223810344533745), (0.9602898564975363, 0.1012285362903763)) for s in (-1, 1)]


def integral(rest, pose, z, pieces=40):
    """Returns Cauchy's integral of the posed curves over the rest curves, by quadrature."""
    total = 0
    for e, f in zip(rest, pose):
        slope = [3 * (b - a) for a, b in zip(e, e[1:])]
        for k in range(pieces):
            for node, weight in NODES:
                t = (k + node) / pieces
                total += weight / pieces * bezier(f, t) * bezier(slope, t) / (bezier(e, t) - z)
    return total / (2j * math.pi)


def off_integral(page, count=12):
    """Returns the deviation of interior figure points from the integral, with the disk of the cage if it has one."""
    rest, pose = curves(pairs(rest_of(page))), curves(pairs(page.pose()))
    if sum((e[0].conjugate() * e[3]).imag for e in rest) < 0:  # the inside is on the right
        rest, pose = ([edge[::-1] for edge in loop[::-1]] for loop in (rest, pose))
    samples = [bezier(e, k / 40) for e in rest for k in range(40)]
    both = [(complex(*p), complex(*q)) for p, q in zip(*places(page))]
    inside = [(p, q) for p, q in both if min(abs(p - s) for s in samples) > 20][::7][:count]
    x, y, radius = page.run('diskOf(page.cage)')

    def value(z):
        if radius == 0:
            return integral(rest, pose, z)
        mirrored = complex(x, y) + radius ** 2 / (z - complex(x, y)).conjugate()
        return integral(rest, pose, z) - integral(rest, pose, mirrored)
    assert len(inside) == count
    return max(abs(value(p) - q) for p, q in inside)


def native_curves(page, folder, *options):
    """Returns the figure moved with the weights of cage_weights for the saved curves: of points, then of legs."""
    cage, pose, (points, _), rest = page.saved('#save-cage', 'cat_cage.svg'), pairs(page.pose()), places(page), pairs(rest_of(page))
    table, out = os.path.join(folder, 'points.csv'), os.path.join(folder, 'weights.csv')
    write_points(table, points)
    subprocess.run([PROGRAMS + 'cage_weights', '--cage', cage, '--points', table, '-o', out, '--coordinates', 'curved-green', *options],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(out) as file:
        rows = [[float(w) for w in row[1:]] for row in list(csv.reader(file))[1:]]
    area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(rest, rest[1:] + rest[:1]))

    def handles(loop):
        legs = [(math.copysign(1, area) * (b[1] - a[1]), math.copysign(1, area) * (a[0] - b[0])) for a, b in zip(loop, loop[1:] + loop[:1])]
        return loop + legs
    moves = [(q[0] - p[0], q[1] - p[1]) for p, q in zip(handles(rest), handles(pose))]
    return [tuple(p[k] + sum(w * m[k] for w, m in zip(row, moves)) for k in (0, 1)) for p, row in zip(points, rows)]


def knows_curves():
    return 'curved' in subprocess.run([PROGRAMS + 'deform_svg', '--help-all'], capture_output=True, text=True).stdout


def test_curved(page, folder):
    page.click('[data-figure=cat]')
    page.click('[data-cage=polygon]')
    page.click('#rest')
    page.run('page.kinds = {}')
    page.click('[data-cage=curved]')
    check(page.pose() == rest_of(page) and places(page)[0] == places(page)[1], 'curves start at rest, bitwise')
    shown = "page.views[0].parts.dots.flatMap((dot, i) => dot.classList.contains('unseen') ? [] : [i])"
    count = len(page.pose()) // 2
    check(page.run(shown) == list(range(0, count, 3)) and page.run("page.views[0].parts.dots.every((dot, i) => dot.localName === (i % 3 ? 'circle' : 'rect'))"),
          'ends of lines are shown as squares, their tangents are hidden')
    error = pose_by(page, lambda x, y: (1.2 * x + 0.5 * y - 20, -0.5 * x + 1.2 * y + 60))
    check(error < 1e-10 * page.run('page.figure.size'), 'a similarity is exact: error %.1e' % error)
    page.click('#rest')

    rest = page.pose()
    page.drag_vertex(27, 10, -20)
    pose = page.pose()
    check({k // 2 for k, (a, b) in enumerate(zip(rest, pose)) if a != b} == {25, 26, 27, 28, 29} and page.run('isLine([27, 28, 29, 30].map(i => pointAt(page.pose, i)), 1e-6)'),
          'an end is dragged; lines stay lines')
    check(page.run(shown)[9:14] == [25, 26, 27, 28, 29], 'and show their tangents because the end is selected')
    page.drag_vertex(28, 30, -40)
    bent = page.pose()
    check({k // 2 for k, (a, b) in enumerate(zip(pose, bent)) if a != b} == {28}, 'at a corner, only the dragged tangent moves')
    error = off_integral(page)
    check(error < 1e-7, "the figure agrees with Cauchy's integral: error %.1e" % error)
    page.key('Escape')
    check({28, 29} <= set(page.run(shown)) and 25 not in page.run(shown), 'tangents of a bent edge are shown, others only where selected')
    page.drag_vertex(27, -15, 5)
    scale, now = page.run('page.views[0].frame().scale'), page.pose()
    move = [(now[k] - bent[k]) * scale for k in range(54, 60)]
    check(max(math.dist(move[0:2], (-15, 5)), math.dist(move[2:4], (-15, 5)), math.dist(move[4:6], (0, 0))) < 1e-6, 'an end moves its tangent')
    page.key('z', 'KeyZ', modifiers=2)
    page.key('z', 'KeyZ', modifiers=2)
    page.key('z', 'KeyZ', modifiers=2)
    check(page.pose() == rest, 'undo reverts all changes')

    page.key('y', 'KeyY', modifiers=2)
    page.key('y', 'KeyY', modifiers=2)
    before, middle = places(page)[1], page.run('page.pose.length')
    at = [round(v) for v in page.run("""(() => { const v = page.views[0], f = v.frame(), r = v.div.getBoundingClientRect(),
        p = pointOfCurve([27, 28, 29, 30].map(i => pointAt(page.pose, i)), 0.5); return [r.left + 1 + f.x + f.scale * p[0], r.top + 1 + f.y + f.scale * p[1]]; })()""")]
    for clicks in (1, 2):
        page.mouse('mousePressed', *at, clickCount=clicks)
        page.mouse('mouseReleased', *at, clickCount=clicks)
    page.frames()
    error = farthest(places(page)[1], before)
    check(page.run('page.pose.length') == middle + 6 and error < 1e-10, 'a double click divides a curve without moving anything: %.1e' % error)

    def tangents():
        p = [complex(*q) for q in pairs(page.pose())[29:32]]
        return p[0] - p[1], p[2] - p[1]
    lengths = [abs(t) for t in tangents()]
    page.drag_vertex(31, 12, 25)
    one, other = tangents()
    check(abs(abs(cmath.phase(-other / one))) < 1e-9 and abs(abs(one) - lengths[0]) < 1e-9 and abs(abs(other) - lengths[1]) > 0.1,
          'the new node is smooth: a dragged tangent rotates the other one')
    page.key('z', 'KeyZ', modifiers=2)
    kept = tangents()[0]
    page.drag_vertex(31, 12, 25, modifiers=1)
    one, other = tangents()
    check(one == kept and abs(cmath.phase(-other / one)) > 0.01, 'Alt breaks the smoothness')
    error = off_integral(page)
    check(error < 1e-7, "the figure still agrees with the integral: error %.1e" % error)
    page.key('z', 'KeyZ', modifiers=2)
    page.run('page.select([30])')
    page.key('Delete')
    check(page.run('page.pose.length') == middle and page.run('page.cage.curves[0][9].length') == 2, 'Delete joins the two edges again')
    for _ in range(2):
        page.key('z', 'KeyZ', modifiers=2)
    check(page.pose() == bent, 'undo restores the previous curves')

    cage, saved = page.saved('#save-cage', 'cat_cage.svg'), page.saved('#save-pose', 'cat_pose.svg')
    data = [re.search(r' d="([^"]*)"', open(path).read()).group(1) for path in (cage, saved)]
    number = r'-?\d[\d.]*(?:e[-+]?\d+)?'
    read = [float(x) for x in re.findall(number, data[1])]
    check(re.sub('[^A-Z]', '', data[0]) == 'M' + 'L' * (count // 3) + 'Z' and re.sub('[^A-Z]', '', data[1]) == 'M' + 'C' * (count // 3) + 'Z',
          'the cage is saved as a path of lines, the pose as a path of cubics')
    check(read[:-2] == bent and read[-2:] == bent[:2], 'with bitwise equal points')
    if knows_curves():
        error = farthest(places(page)[1], native_curves(page, folder))
        check(error < 1e-9, 'the figure agrees with cage_weights: error %.1e' % error)
        mine, native = page.saved('#save-svg', 'cat_posed.svg'), os.path.join(folder, 'native.svg')
        subprocess.run([PROGRAMS + 'deform_svg', DATA + 'cat.svg', '--cage', cage, '--pose', saved, '--coordinates', 'curved-green', '-o', native],
                       check=True, stderr=subprocess.DEVNULL)
        page.run('page.timeline.setTime(1.2)')
        page.click('#key')
        error = off_animation(page, folder, cage, places(page)[1], '--coordinates', 'curved-green')
        check(error < 0.08, 'animate_svg plays key frames of the curves: difference %.3f (it writes one decimal)' % error)
        page.key('z', 'KeyZ', modifiers=2)
        difference = compare_pictures(page, open(mine).read(), open(native).read(), same_view=True)
        check(difference < 0.002, 'deform_svg with the path and pose saved draws the same: colour difference %.5f' % difference)
    pose_path = os.path.join(folder, 'bent.svg')
    with open(pose_path, 'w') as file:
        file.write(open(saved).read())
    open_cage(page, pose_path)
    error = farthest(pairs(rest_of(page)), pairs(bent))
    check(page.run('page.cage.kind') == 'curved' and error < 1e-10 and page.run('page.cage.curves[0].map(e => e.length).join("")') ==
          '4' * (count // 3), 'the pose is opened as a cage of cubics')
    page.drag_vertex(30, 25, 25)
    error = off_integral(page)
    check(error < 1e-7, "curves at rest also agree with the integral: error %.1e" % error)
    page.click('#rest')

    page.click('#edit')
    page.drag_vertex(27, 3, -6)
    page.key('n', 'KeyN')
    page.drag_vertex(28, 20, -10)
    page.click('#edit')
    lengths = page.run('page.cage.curves[0].map(e => e.length).join("")')
    error = max(abs(a - b) for a, b in zip(page.pose(), rest_of(page)))
    check(lengths[8:11] == '242' and error < 1e-9, 'rest curves can be edited and are bound again; the pose is kept')
    page.click('#edit')
    held = rest_of(page)
    page.drag_vertex(27, -300, 100)
    page.click('#edit')
    check(rest_of(page) == held and 'cannot be used' in page.run(STATUS), 'crossing curves are an error: ' + page.run(STATUS))

    ring = os.path.join(folder, 'ring.svg')
    with open(ring, 'w') as file:
        file.write('<svg xmlns="http://www.w3.org/2000/svg"><path d="M-120 400Q-120 -200 500 -200A620 600 0 0 1 1120 400S1100 1000 500 1000Q-120 1000 -120 400Z"/></svg>')
    open_cage(page, ring)
    control = page.run("parsePath('M0 0C0 9 9 9 9 0T18 0')[0].segments[1].control")
    check(control == [9, 0], 'T after a cubic has no reflected control point, as in SVG')
    lengths = page.run('page.cage.curves[0].map(e => e.length).join("")')
    check(re.match('34+43$', lengths) and page.run('page.bound[page.types[0]].outside') == 0, 'a path with Q, A and S is a cage with edges of different degrees: ' + lengths)
    page.click('#fit-view')
    page.drag_vertex(3 * (len(lengths) - 1), 30, -40)
    error = off_integral(page)
    check(page.pose() != rest_of(page) and error < 1e-7, "they agree with the integral: error %.1e" % error)
    bent = page.pose()
    free = places(page)[1]
    set_value(page, 'disk', 0.8)
    error = off_integral(page)
    check(page.pose() == bent and farthest(places(page)[1], free) > 1e-3 and error < 1e-7, "with the function of a disk the figure agrees with the integral: error %.1e" % error)
    if knows_curves():
        error = farthest(places(page)[1], native_curves(page, folder, '--disk-radius', repr(page.run('diskOf(page.cage)[2]'))))
        check(error < 1e-9, 'and with cage_weights: error %.1e' % error)
    check(pose_by(page, lambda x, y: (0.9 * x + 0.2 * y, -0.2 * x + 0.9 * y)) < 1e-9, 'and keeps similarities')
    page.click('#weights')
    page.run('page.select([3]); page.redraw()')
    page.frames(4)
    check(page.run('page.views[0].field.width > 100 && !page.views[0].fault'), 'weights of an end are shown')
    page.click('#weights')
    path = '<svg xmlns="http://www.w3.org/2000/svg">%s</svg>'
    said = [refusal(page, folder, *file) for file in (('open.svg', path % '<path d="M0 0L100 0Q100 90 0 90"/>'), ('none.svg', path % '<rect width="9" height="9"/>'),
            ('moved.svg', path % '<g transform="scale(2)"><path d="M0 0L9 0L9 9Z"/></g>'), ('cross.svg', path % '<path d="M0 0C900 600 -500 600 400 0Z"/>'),
            ('text.svg', 'no document'), ('words.csv', 'a,b'), ('huge.svg', path % ('<path d="M0 0%sZ"/>' % ('l1 1' * 9000))))]
    check('not closed' in said[0] and 'no path' in said[1] and 'transform' in said[2] and said[3] and 'no path' in said[4] and 'x,y' in said[5] and 'more than' in said[6],
          'other files are errors: ' + ' | '.join(said))
    page.click('[data-cage=polygon]')
    page.click('#rest')
    page.click('#fit-view')
