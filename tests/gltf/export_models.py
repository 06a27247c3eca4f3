"""Adds skins, morph targets and skeletons to the files of make_models.py, and plays the results with glb.py.

    /usr/bin/python3 tests/gltf/export_models.py PROGRAMS FOLDER [SEED]

Each result has the input's vertices at rest and the poses of deform_mesh, and keeps the other objects of the document. The
files remain in FOLDER. Prints the number of checks.
"""
import os
import re
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
from glb import Document  # noqa: E402

FACES = [(4, 3, 2, 1), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8)]
POSE = ["--scale", "all:1.4,0.7,1.1@0,0,0", "--move", "0-3:0.3,-0.2,0.1"]
TURN = ["--turn", "all:70,1,-1,0.5@0.2,0,0"]
PLAYED = ["nodes_played", "skin_played", "skin_with_one_sampler", "skin_i16_turns", "targets_played", "skin_and_targets"]
WITHOUT_FACES = ["points_alone", "vertices_without_faces"]
WITH_WEIGHTS = ["everything", "targets"]  # normals at rest have parts of morph targets, which poses do not turn
checks = failed = 0


def check(what, ok):
    global checks, failed
    checks += 1
    if not ok:
        failed += 1
        print(f"FAILED: {what}")


def run(what, *command):
    done = subprocess.run(command, capture_output=True, text=True)
    check(f"{what}: exit code {done.returncode}: {done.stderr.strip()}", done.returncode == 0)
    return done.returncode == 0


def write_box(path, rows):
    """Writes a box around vertices as an OBJ file."""
    points = np.concatenate([part["POSITION"] for part in rows.values()])
    low, high = points.min(0), points.max(0)
    margin = 0.1 * np.linalg.norm(high - low)
    corners = [[(high[k] + margin if c[k] else low[k] - margin) for k in range(3)]
               for c in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))]
    with open(path, "w") as file:
        file.writelines("v %.17g %.17g %.17g\n" % tuple(corner) for corner in corners)
        file.writelines("f %d %d %d %d\n" % face for face in FACES)


def meshes_of(document):
    """Returns the mesh that each node of the scene has after meshes of several nodes are copied."""
    nodes, inside = document.list("nodes"), {n for n, _ in document.scene_nodes()}
    used = {node["mesh"] for n, node in enumerate(nodes) if "mesh" in node and n not in inside}
    result, count = {}, len(document.list("meshes"))
    for n, node in enumerate(nodes):
        if "mesh" not in node or n not in inside:
            continue
        result[n] = node["mesh"]
        if node["mesh"] in used:
            result[n], count = count, count + 1
        used.add(node["mesh"])
    return result


class Result:
    """An output, whose rows are found by the input's nodes."""

    def __init__(self, path, before):
        self.document, of_mesh = Document(path), {mesh: n for n, mesh in meshes_of(before).items()}
        self.node = {n: of_mesh[node["mesh"]] for n, node in enumerate(self.document.list("nodes"))
                     if "mesh" in node and n in {n for n, _ in self.document.scene_nodes()}}

    def evaluate(self, *given):
        return {(self.node[n], p): rows for (n, p), rows in self.document.evaluate(*given).items()}


def apart(a, b, name="POSITION"):
    """Returns the largest distance of rows, as a share of the size of `b`; normals have no size.

    Roundings of positions to single precision do not count.
    """
    if a.keys() != b.keys():
        return np.inf
    most = max([np.linalg.norm(a[key][name] - rows[name], axis=1).max() for key, rows in b.items() if name in rows], default=0)
    if name != "POSITION":
        return most
    points = np.concatenate([rows["POSITION"] for rows in b.values()])
    return max(most - 2e-7 * np.abs(points).max(), 0) / np.linalg.norm(np.ptp(points, axis=0))


def sides(document, rows):
    """Returns a sign of each primitive that depends on the side from which its faces are drawn (3.7.4)."""
    worlds, result = document.worlds(document.parts_at(None, 0)), {}
    for (n, p), values in rows.items():
        primitive = document.json["meshes"][document.json["nodes"][n]["mesh"]]["primitives"][p]
        count, mode = len(values["POSITION"]), primitive.get("mode", 4)
        corners = document.stored(primitive["indices"])[:, 0].astype(int) if "indices" in primitive else np.arange(count)
        if mode == 4:
            faces = corners[: len(corners) // 3 * 3].reshape(-1, 3)
        elif mode == 5:
            faces = np.array([corners[[k, k + 1 + k % 2, k + 2 - k % 2]] for k in range(len(corners) - 2)])
        elif mode == 6:
            faces = np.array([corners[[0, k + 1, k + 2]] for k in range(len(corners) - 2)])
        else:
            continue
        a, b, c = (values["POSITION"][faces[:, k]] for k in range(3))
        total = (np.cross(b - a, c - a) @ np.array([1.0, 2.0, 4.0])).sum()
        result[n, p] = np.sign(total * np.linalg.det(worlds[n][:3, :3]))
    return result


def keeps(what, before, after, skin):
    """Whether the objects of the input are in the output."""
    for name in ("nodes", "materials", "textures", "images", "cameras", "extensionsUsed"):
        a, b = before.list(name), after.list(name)
        if name == "nodes":
            own = {"mesh", "skin", "weights"} | ({"translation", "rotation", "scale", "matrix"} if skin else set())
            a = [{key: value for key, value in node.items() if key not in own} for node in a]
            b = [{key: value for key, value in node.items() if key not in own} for node in b[: len(a)]]
        check(f"{what}: keeps {name}", a == b[: len(a)])


def morph(programs, model, cage):
    stem, ending = os.path.splitext(model)
    before, out, moved = Document(model), f"{stem}.morph{ending}", f"{stem}.moved{ending}"
    what, options = out, ["--cage", cage, *POSE, "--coordinates", "mean-value"]
    if not run(what, f"{programs}/export_gltf", model, *options, "--morph", "-o", out):
        return
    if not run(what, f"{programs}/deform_mesh", model, *options, "--drop-skin", "-o", moved):
        return
    result, pose = Result(out, before), Document(moved).evaluate()
    keeps(what, before, result.document, False)
    check(f"{what}: at rest", apart(result.evaluate(), before.evaluate()) < 1e-6)
    last = len(result.document.list("animations")) - 1
    played = result.evaluate(last, 1.0)
    check(f"{what}: in the pose", apart(played, pose) < 1e-6)
    if not any(name in stem for name in WITH_WEIGHTS):
        for attribute, allowed in (("NORMAL", 2e-3), ("TANGENT", 3)):
            off = apart(played, pose, attribute)
            check(f"{what}: {attribute} in the pose, off by {off}", off < allowed)
    for animation in range(last):
        for time in np.linspace(0, before.last_time(animation), 5):
            off = apart(result.evaluate(animation, time), before.evaluate(animation, time))
            check(f"{what}: animation {animation} at {time}, off by {off}", off < 1e-6)


def skin(programs, model, cage):
    stem, ending = os.path.splitext(model)
    before, wanted = Document(model), f"{stem}.wanted{ending}"
    rest = before.evaluate()
    for kind, pose, options, allowed in (("skin", POSE, ["--skin", "8"], 1e-5), ("bones", TURN, ["--bones", "1"], 1e-3)):
        out = f"{stem}.{kind}{ending}"
        command = ["--cage", cage, *pose, "--coordinates", "mean-value"]
        if not run(out, f"{programs}/export_gltf", model, *command, *options, "-o", out):
            continue
        result = Result(out, before)
        keeps(out, before, result.document, True)
        places = result.evaluate()
        check(f"{out}: at rest", apart(places, rest) < 1e-6)
        if "quantized" not in stem and not any(name in stem for name in WITH_WEIGHTS):
            check(f"{out}: normals at rest", apart(places, rest, "NORMAL") < 1e-4)
        drawn = {(result.node[n], p): side for (n, p), side in sides(result.document, result.document.evaluate()).items()}
        check(f"{out}: sides of faces", drawn == sides(before, rest))
        if not run(out, f"{programs}/deform_mesh", model, *command, "--drop-skin", "-o", wanted):
            continue
        off = apart(result.evaluate(len(result.document.list("animations")) - 1, 1.0), Document(wanted).evaluate())
        check(f"{out}: in the pose, off by {off}", off < allowed)


def fit(programs, model):
    """The vertices at the times of the frames are as far from those of the input's animation as the program says."""
    stem, ending = os.path.splitext(model)
    before, out = Document(model), f"{stem}.fitted{ending}"
    done = subprocess.run([f"{programs}/fit_skeleton", model, "-o", out, "--bones", "3", "--rate", "24", "--report"],
                          capture_output=True, text=True)
    said = re.search(r"off by at most ([^ ]+) \(", done.stdout)
    check(f"{out}: {done.stderr}", done.returncode == 0 and said)
    if not said:
        return
    result = Result(out, before)
    moves = len(result.document.list("animations"))  # none if all frames are alike
    check(f"{out}: a skin and at most one animation", moves <= 1 and result.document.list("skins"))
    check(f"{out}: no morph targets", not any("targets" in p for m in result.document.list("meshes") for p in m["primitives"]))
    keeps(out, before, result.document, True)
    largest = 0
    for frame in range(int(24 * before.last_time(0)) + 1):
        a, b = result.evaluate(0 if moves else None, frame / 24), before.evaluate(0, frame / 24)
        check(f"{out}: the same vertices", a.keys() == b.keys())
        largest = max([largest] + [np.linalg.norm(a[key]["POSITION"] - rows["POSITION"], axis=1).max() for key, rows in b.items()])
    check(f"{out}: off by {largest}, said {said[1]}", 0.99 * float(said[1]) - 1e-5 < largest < 1.01 * float(said[1]) + 1e-5)


def main():
    programs, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
    here = os.path.dirname(os.path.abspath(__file__))
    subprocess.run([sys.executable, f"{here}/make_models.py", folder, *sys.argv[3:]], check=True)
    for file in sorted(os.listdir(folder)):
        name, ending = os.path.splitext(file)
        if ending not in (".glb", ".gltf") or name.startswith("refused") or name in WITHOUT_FACES:
            continue
        model, cage = f"{folder}/{file}", f"{folder}/{name}.obj"
        write_box(cage, Document(model).evaluate())
        morph(programs, model, cage)
        skin(programs, model, cage)
        if name in PLAYED:
            fit(programs, model)
    print(f"{checks} checks, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
