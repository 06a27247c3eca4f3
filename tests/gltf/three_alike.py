"""Compares glTF files in three.js: renderings of pairs have to be the same, and places those of Document.evaluate.

    /usr/bin/python3 tests/gltf/three_alike.py INPUT OUTPUT [INPUT OUTPUT]...

For each pair, prints how many pixels differ at rest, and for the input the largest distance between places in three.js and in
glb.py, at rest and at a time of each animation, as a share of the size. Exits with 1 if a pixel differs or a distance is above 1e-5.
Takes three.js from npm's registry as in_three.py does. three.js plays four weights a vertex, so places of files with more are not
compared.
"""
import os
import shutil
import sys
import tempfile

import numpy as np

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
from glb import Document  # noqa: E402
from in_three import Browser, installed, serve  # noqa: E402

ALLOWED = 1e-5


def distance(browser, document, size, animation=None, time=0.0):
    """Returns the largest distance between places in three.js and in glb.py, as a share of the size."""
    browser.run(f"player.load('one/{os.path.basename(document.path)}')")
    found = browser.run("player.places()" if animation is None else f"player.places({animation}, {time})")
    expected = document.evaluate(animation, time)
    if sorted((n, p) for n, p, _ in found) != sorted(expected):
        return np.inf
    return max(float(np.linalg.norm(np.array(rows).reshape(-1, 3) - expected[n, p]["POSITION"], axis=1).max()) for n, p, rows in found) / size


def compare(browser, one, two):
    """Compares a pair of files, whose names are in the server's folder one/ and two/."""
    document = Document(one)
    places = np.concatenate([rows["POSITION"] for rows in document.evaluate().values()])
    lower, upper = places.min(0), places.max(0)
    size = float(np.linalg.norm(upper - lower))
    browser.run(f"player.load('two/{os.path.basename(two)}')")
    browser.run(f"player.draw('two', {lower.tolist()}, {upper.tolist()})")
    browser.run(f"player.load('one/{os.path.basename(one)}')")
    browser.run(f"player.draw('one', {lower.tolist()}, {upper.tolist()})")
    differing, drawn = browser.run("player.differing('one', 'two')")
    if any("JOINTS_1" in primitive["attributes"] for mesh in document.list("meshes") for primitive in mesh["primitives"]):
        print(f"{one}: {differing} of {drawn} pixels differ from {two}; it has more than four weights a vertex")
        return differing == 0 and drawn > 0
    most = distance(browser, document, size)
    for k in range(len(document.list("animations"))):
        most = max(most, distance(browser, document, size, k, 0.37 * document.last_time(k)))
    print(f"{one}: {differing} of {drawn} pixels differ from {two}; places in three.js are at most {most:.0e} off")
    return differing == 0 and drawn > 0 and most <= ALLOWED


def main():
    if len(sys.argv) < 3 or len(sys.argv) % 2 == 0:
        print(__doc__)
        return 2
    three, good = installed(), True
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(os.path.join(HERE, "three_alike.html"), folder)
        os.symlink(three, os.path.join(folder, "three"))
        browser = Browser((500, 500))
        try:
            browser.call("Page.navigate", {"url": serve(folder) + "/three_alike.html"})
            browser.wait("window.player !== undefined", seconds=60)
            for one, two in zip(sys.argv[1::2], sys.argv[2::2]):
                for name, path in (("one", one), ("two", two)):
                    link = os.path.join(folder, name)
                    if os.path.lexists(link):
                        os.unlink(link)
                    os.symlink(os.path.dirname(os.path.abspath(path)), link)
                good = compare(browser, one, two) and good
            faults = browser.faults()
        finally:
            browser.close()
    for fault in faults:
        print("the browser says: " + fault)
    return 0 if good and not faults else 1


sys.exit(main())
