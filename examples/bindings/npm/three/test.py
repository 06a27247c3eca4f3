"""Opens the example with three.js in a headless Chromium: python3 test.py FOLDER PICTURES [--serve]"""

import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / 'test'))
from chromium import Browser, serve  # noqa: E402

WALK = 0.3  # seconds
# The names of a model's materials, their textures and its animations.
CONTENTS = '''models.map(({ scene, animations }) => {
  const names = animations.map(({ name }) => name);
  scene.traverse(({ material }) => material && names.push(material.name, material.map?.name, material.normalMap?.name));
  return names;
})'''


def main(folder, pictures, *options):
    address = serve(folder)
    if '--serve' in options:
        print(address)
        while True:
            time.sleep(1000)
    expected = json.loads((pathlib.Path(folder) / 'character.json').read_text())
    browser = Browser((900, 700))
    try:
        browser.call('Page.navigate', {'url': address + '/index.html'})
        browser.wait('window.drawn && window.drawn.frames > 60', seconds=120)
        each = browser.run('window.drawn.milliseconds')
        for stop in (0, expected['time'], 1.5):
            browser.run("location.hash = '#%g'" % stop)
            browser.wait('window.drawn.time === %g' % stop)
            browser.frames(3)
            browser.picture('%s/npm_three_%g.png' % (pictures, stop))
            if stop == expected['time']:
                points = browser.run('Array.from(window.points)')
        browser.resize(1200, 400)
        browser.call('Page.navigate', {'url': address + '/index.html?beside#%g' % WALK})
        browser.wait('window.models && window.drawn && window.drawn.frames > 3', seconds=120)
        browser.picture(pictures + '/npm_three_model.png')
        contents = browser.run(CONTENTS)
        faults = browser.faults()
    finally:
        browser.close()
    assert points == expected['points'], 'the points of the page differ from those of node'
    assert not faults, faults
    places = {}
    for k in range(0, len(points), 3):
        places.setdefault(tuple(expected['rest'][k:k + 3]), []).append(points[k:k + 3])
    gap = max(abs(x - y) for first, *others in places.values() for other in others for x, y in zip(first, other))
    assert gap < 2e-4, 'a seam of %g opens' % gap
    assert len(set(map(tuple, contents))) == 1 and 'walk' in contents[0] and 'cloth' in contents[0], contents
    shots = {(pathlib.Path(pictures) / ('npm_three_%g.png' % stop)).read_bytes() for stop in (0, expected['time'], 1.5)}
    assert len(shots) == 3, 'the pictures are equal'
    print('three.js: %d points bitwise as in node; %.2f ms per frame for clip, clone and normals' % (len(points) // 3, each))


main(*sys.argv[1:])
