"""The page in a browser, and the native programs for comparison."""

import csv
import json
import math
import os
import re
import subprocess
import tempfile
import time

from browser import Browser

PROGRAMS, DATA, BUILT = 'build/examples/', 'examples/data/', 'build/page/'


class Page(Browser):
    def __init__(self, path, still=True, mode='cage'):
        super().__init__()
        self.mode = mode
        self.downloads = tempfile.mkdtemp()
        self.call('Browser.setDownloadBehavior', {'behavior': 'allow', 'downloadPath': self.downloads, 'eventsEnabled': True}, session=None)
        if still:  # otherwise the first scene moves
            self.still()
        start = time.time()
        self.open(path)
        self.opened_after = time.time() - start

    def open(self, path):
        super().open(path)
        if self.mode == 'cage':  # not the default mode
            self.run("setMode(page, 'cage')")

    def computed(self):
        """Returns the CPU time of all threads of the page, in seconds."""
        self.call('Performance.enable')
        return next(m['value'] for m in self.call('Performance.getMetrics')['metrics'] if m['name'] == 'ProcessTime')

    def pose(self):
        return self.run('Array.from(page.pose)')

    def vertex(self, i, view=0):
        """Returns the position of a vertex on the screen."""
        return self.run('(() => { const v = page.views[%d], f = v.frame(), r = v.div.getBoundingClientRect(), p = page.shownPose;'
                        'return [r.left + v.div.clientLeft + f.x + f.scale * p[2 * %d], r.top + v.div.clientTop + f.y + f.scale * p[2 * %d + 1]]; })()'
                        % (view, i, i))

    def drag_vertex(self, i, dx, dy, **more):
        x, y = (round(v) for v in self.vertex(i))  # mouse positions are whole pixels
        self.drag((x, y), (x + dx, y + dy), **more)

    def places(self, coordinates):
        """Returns the bound points and their posed positions."""
        self.run("page.ensureBound('%s')" % coordinates)
        flat = self.run("[Array.from(page.figure.points), Array.from(page.cloneFigure('%s', page.pose))]" % coordinates)
        return [list(zip(points[::2], points[1::2])) for points in flat]

    def saved(self, selector, name):
        path = os.path.join(self.downloads, name)
        if os.path.exists(path):
            os.remove(path)
        self.click(selector)
        limit = time.time() + 20
        while not os.path.exists(path) or os.path.exists(path + '.crdownload'):
            if time.time() > limit:
                raise TimeoutError('no file saved as ' + name)
            time.sleep(0.05)
        return path


def check(condition, text):
    print(('ok    ' if condition else 'FAULT ') + text, flush=True)
    check.faults += not condition


check.faults = 0


def pairs(flat):
    return list(zip(flat[::2], flat[1::2]))


def write_points(path, points):
    with open(path, 'w') as file:
        file.writelines('%r,%r\n' % tuple(p) for p in points)


def native_places(coordinates, cage, pose, points, folder):
    """Returns points moved with the weights of cage_weights."""
    cage_path, points_path, out = (os.path.join(folder, n) for n in ('cage.csv', 'points.csv', 'weights.csv'))
    write_points(cage_path, cage)
    write_points(points_path, points)
    subprocess.run([PROGRAMS + 'cage_weights', '--cage', cage_path, '--points', points_path, '--coordinates', coordinates, '-o', out],
                   check=True, stdout=subprocess.DEVNULL)
    handles, moved_handles = list(cage), list(pose)
    if coordinates == 'green':  # normals of the edges, with the lengths of the edges
        area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(cage, cage[1:] + cage[:1]))

        def normals(loop):
            edges = zip(loop, loop[1:] + loop[:1])
            return [(math.copysign(1, area) * (b[1] - a[1]), math.copysign(1, area) * (a[0] - b[0])) for a, b in edges]
        handles, moved_handles = handles + normals(handles), moved_handles + normals(moved_handles)
    moved = []
    with open(out) as file:
        for point, row in zip(points, list(csv.reader(file))[1:]):
            weights = [float(w) for w in row[1:]]
            assert len(weights) == len(handles)
            moved.append(tuple(point[k] + sum(w * (m[k] - h[k]) for w, m, h in zip(weights, moved_handles, handles)) for k in (0, 1)))
    return moved


def farthest(a, b):
    assert len(a) == len(b)
    return max(math.dist(p, q) for p, q in zip(a, b))


def read_csv(path):
    with open(path) as file:
        return [tuple(map(float, line.split(','))) for line in file if line.strip() and not line.startswith('#')]


def compare_pictures(page, one, other, same_view=False):
    """Returns the mean difference of the colours of two SVG documents, in the viewBox of the second."""
    if same_view:
        view = re.search(r'viewBox="[^"]*"', other).group(0)
        one = re.sub(r'viewBox="[^"]*"', view, one, count=1)

    def sized(text):
        head, tag, rest = re.match(r'(.*?)(<svg\b[^>]*>)(.*)', text, re.S).groups()
        return head + re.sub(r'\s(width|height)="[^"]*"', '', tag).replace('<svg', '<svg width="600" height="480"') + rest
    return page.run('''(async texts => {
      const pixels = [];
      for (const text of texts) {
        const image = new Image();
        image.src = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(text);
        await image.decode();
        const canvas = new OffscreenCanvas(600, 480), context = canvas.getContext('2d');
        context.fillStyle = '#fff';
        context.fillRect(0, 0, 600, 480);
        context.drawImage(image, 0, 0);
        pixels.push(context.getImageData(0, 0, 600, 480).data);
      }
      return pixels[0].reduce((sum, x, k) => sum + Math.abs(x - pixels[1][k]), 0) / pixels[0].length / 255;
    })(%s)''' % json.dumps([sized(one), sized(other)]))
