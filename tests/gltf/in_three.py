"""Plays a skin in three.js and by a reader of its own, and compares the places of all vertices in many frames.

    /usr/bin/python3 tests/gltf/in_three.py SKIN.glb PICTURES

Installs three.js from npm's registry into build/gltf_three, once, which needs a network, and opens a page in a headless Chromium. Prints
the largest distance as a share of the figure's size, and exits with 1 if it is above 1e-5. Writes three frames with the skeleton
in front of the figure to PICTURES_0.png, PICTURES_1.png and PICTURES_2.png. three.js plays four weights a vertex.
"""
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.dont_write_bytecode = True
sys.path[:0] = [HERE, os.path.join(ROOT, "examples/bindings/npm/test")]
from chromium import Browser, serve  # noqa: E402
from glb import Glb  # noqa: E402


def installed():
    """Returns the folder of three.js, of the version that the project's example takes."""
    folder = os.path.join(ROOT, "build/gltf_three")
    wanted = os.path.join(ROOT, "examples/bindings/npm/three/package.json")
    os.makedirs(folder, exist_ok=True)
    shutil.copy(wanted, folder)
    subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--silent", "--prefer-offline"], cwd=folder, check=True)
    return os.path.join(folder, "node_modules/three")


def main():
    if len(sys.argv) != 3:
        print(__doc__)
        return 2
    path, pictures = sys.argv[1:]
    glb, three = Glb(path), installed()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(path, os.path.join(folder, "skin.glb"))
        shutil.copy(os.path.join(HERE, "in_three.html"), folder)
        os.symlink(three, os.path.join(folder, "three"))
        browser = Browser((700, 700))
        try:
            browser.call("Page.navigate", {"url": serve(folder) + "/in_three.html"})
            browser.wait("window.player !== undefined", seconds=60)
            name = "three.js %s, %d bones" % (browser.run("player.revision"), browser.run("player.bones"))

            def play(time):
                return np.array(browser.run(f"player.places({time})")).reshape(-1, 3)

            good = glb.compare(path, name, play)
            places = np.concatenate([glb.places(time / 1000) for time in glb.pictured()])
            browser.run(f"player.look({places.min(0).tolist()}, {places.max(0).tolist()}, {glb.size})")
            for k, time in enumerate(glb.pictured()):
                browser.run(f"player.draw({time}, {glb.size})")
                browser.frames(3)
                browser.picture(f"{pictures}_{k}.png")
            faults = browser.faults()
        finally:
            browser.close()
    for fault in faults:
        print("the browser says: " + fault)
    return 0 if good and not faults else 1


if __name__ == "__main__":
    sys.exit(main())
