"""Compares the animations of a skin that deform_mesh kept with the cage's deformation at rest, carried by the input's skin.

    /usr/bin/python3 tests/gltf/kept_skin.py INPUT OUTPUT BAKED

BAKED is the output with --drop-skin. A vertex x of the input has the skin's matrix M(t) at time t and is moved by d at rest, in
world space. The expected place at t is M(t) x + M(t) M(rest)^-1 d, without the translations of M in the second term. Prints the
largest distance from the expected place at three times of each animation, as a share of the figure's size.
"""
import sys

import numpy as np

sys.dont_write_bytecode = True
from glb import Document  # noqa: E402


def linear(document, animation, time):
    """Returns the matrices of the vertices of skinned primitives, without translations: {(node, primitive): rows}."""
    world, result = document.worlds(document.parts_at(animation, time)), {}
    for n, _ in document.scene_nodes():
        node = document.json["nodes"][n]
        if "skin" in node and "mesh" in node:
            for p, primitive in enumerate(document.json["meshes"][node["mesh"]]["primitives"]):
                result[n, p] = document.blended(primitive, document.json["skins"][node["skin"]], world)[:, :3, :3]
    return result


def main():
    if len(sys.argv) != 4:
        print(__doc__)
        return 2
    before, after, baked = map(Document, sys.argv[1:])
    rest, moved, matrices = before.evaluate(), baked.evaluate(), linear(before, None, 0)
    places = np.concatenate([rows["POSITION"] for rows in rest.values()])
    size = np.linalg.norm(places.max(0) - places.min(0))
    steps = {key: moved[key]["POSITION"] - rest[key]["POSITION"] for key in matrices}
    print(f"at rest, the cage moves vertices by at most {max(np.linalg.norm(d, axis=1).max() for d in steps.values()) / size:.2e} of the size")
    for k, animation in enumerate(before.list("animations")):
        for share in (0.25, 0.5, 0.75):
            time = share * before.last_time(k)
            played, found, now = before.evaluate(k, time), after.evaluate(k, time), linear(before, k, time)
            most = 0.0
            for key, d in steps.items():
                expected = played[key]["POSITION"] + np.einsum("nij,njk,nk->ni", now[key], np.linalg.inv(matrices[key]), d)
                most = max(most, float(np.linalg.norm(found[key]["POSITION"] - expected, axis=1).max()))
            print(f"{animation.get('name', k)}, {time:.3f} s: {most / size:.2e} of the size")
    return 0


sys.exit(main())
