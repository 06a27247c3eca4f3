#!/usr/bin/env python3
"""Usage: affine.py PROGRAMS SEED COUNT

Laws of programs that move meshes: an affine pose x -> A x + b of the cage takes every vertex to A x + b and every
normal n to A^-T n, also normals that lean against their faces, at the origin and far from it. A pose that mirrors
is named, and --flip-faces reverses the faces. Weights in single precision lose nothing far from the origin.
Rotations of up to 720 degrees have keys that every player shows alike. The poses are random; their seeds are printed.

Vertices that are no numbers or far away and that no face has change nothing of what a program writes, in any figure or
frame. Copies of a vertex that a file has rounded apart stay together where weights are limited by number.
"""
import json
import math
import os
import random
import struct
import subprocess
import sys
import tempfile

PROGRAMS, SEED, COUNT = os.path.abspath(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
PLACE_TOLERANCE, NORMAL_TOLERANCE = 1e-6, 1e-5  # of the figure's size; radians
BOX = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
FACES = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
faults = 0


def check(is_right, what):
    global faults
    faults += not is_right
    if not is_right:
        print("FAILED:", what)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(v):
    return [x / math.sqrt(dot(v, v)) for x in v]


def moved(a, v):
    return [dot(row, v) for row in a]


def inverse_transposed(a):
    """The rows' cofactors over the determinant."""
    cofactors = [cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])]
    return [[x / dot(a[0], cofactors[0]) for x in row] for row in cofactors]


def write_obj(path, vertices, normals, faces):
    with open(path, "w") as file:
        for v in vertices:
            file.write("v %.17g %.17g %.17g\n" % tuple(v))
        for n in normals:
            file.write("vn %.17g %.17g %.17g\n" % tuple(n))
        for face in faces:
            file.write("f %s\n" % face)


def read_obj(path, key):
    return [[float(x) for x in line.split()[1:4]] for line in open(path) if line.split()[:1] == [key]]


def read_glb(path):
    """The JSON of a GLB file, and a reader of its accessors: `step` elements at a time."""
    data = open(path, "rb").read()
    size = struct.unpack_from("<I", data, 12)[0]
    scene, data = json.loads(data[20:20 + size]), data[28 + size:]

    def vectors(accessor, words="<3f", step=1):
        a = scene["accessors"][accessor]
        view = scene["bufferViews"][a["bufferView"]]
        begin, size = view.get("byteOffset", 0) + a.get("byteOffset", 0), struct.calcsize(words) // step
        return [struct.unpack_from(words, data, begin + i * view.get("byteStride", size)) for i in range(0, a["count"], step)]

    return scene, vectors


def read_targets(path):
    """Places, normals and faces of the only mesh of a GLB file with its first target added, and its node's place."""
    scene, vectors = read_glb(path)
    primitive = scene["meshes"][0]["primitives"][0]
    node = next(n for n in scene["nodes"] if "mesh" in n)
    place = node.get("translation", [0, 0, 0])
    parts = []
    for key in ("POSITION", "NORMAL"):
        rest = vectors(primitive["attributes"][key])
        change = vectors(primitive["targets"][0][key]) if "targets" in primitive else [[0, 0, 0]] * len(rest)
        parts.append([[x + y for x, y in zip(a, b)] for a, b in zip(rest, change)])
    return [[x + y for x, y in zip(p, place)] for p in parts[0]], parts[1], vectors(primitive["indices"], "<3H", 3)


def run(*command, code=0):
    """Runs a program; what it says."""
    done = subprocess.run([os.path.join(PROGRAMS, command[0]), *command[1:]], capture_output=True, text=True)
    check(done.returncode == code, "%s: exit code %d: %s" % (" ".join(command), done.returncode, done.stderr))
    return done.stderr


def faces_of(path):
    return [[int(w.split("/")[0]) - 1 for w in line.split()[1:]] for line in open(path) if line.startswith("f ")]


def volume(v, faces):
    return sum(dot(v[f[0]], cross(v[f[k]], v[f[k + 1]])) / 6 for f in faces for k in range(1, len(f) - 1))


def compare(what, places, normals, right_places, right_normals, size):
    off = max(math.dist(p, q) for p, q in zip(places, right_places)) / size
    turn = max(math.asin(min(1, math.sqrt(dot(c, c)))) if dot(n, m) > 0 else 3
               for n, m in zip(normals, right_normals) for c in [cross(unit(n), unit(m))])
    check(off <= PLACE_TOLERANCE and turn <= NORMAL_TOLERANCE, "%s: places are off by %g sizes, normals by %g" % (what, off, turn))


def test(seed):
    draw = random.Random(seed)
    # Leaves: squares in all directions, with normals that do not stand across them.
    vertices, normals, faces = [], [], []
    for leaf in range(6):
        middle, u = ([draw.uniform(-0.5, 0.5) for _ in range(3)] for _ in range(2))
        u = unit(u)
        v = unit(cross(u, [draw.gauss(0, 1) for _ in range(3)]))
        for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            vertices.append([m + 0.2 * (i * a + j * b) for m, a, b in zip(middle, u, v)])
            normals.append(unit([c + draw.gauss(0, 0.4) for c in cross(u, v)]))
        faces.append(" ".join("%d//%d" % (n, n) for n in range(4 * leaf + 1, 4 * leaf + 5)))
    a = [[draw.gauss(0, 0.5) + (i == j) for j in range(3)] for i in range(3)]
    while abs(dot(a[0], cross(a[1], a[2]))) < 0.2:
        a = [[draw.gauss(0, 0.5) + (i == j) for j in range(3)] for i in range(3)]
    is_mirror = dot(a[0], cross(a[1], a[2])) < 0
    shift = [draw.gauss(0, 1) for _ in range(3)]
    right_normals = [moved(inverse_transposed(a), n) for n in normals]
    size = math.dist(*[[pick(v[k] for v in vertices) for k in range(3)] for pick in (min, max)])
    for offset in ([0, 0, 0], [draw.choice([-1, 1]) * 10 ** draw.uniform(2, 7) * size for _ in range(3)]):
        def away(points):
            return [[x + o for x, o in zip(p, offset)] for p in points]

        def pose(points):
            return away([[x + s for x, s in zip(moved(a, p), shift)] for p in points])
        box = [[x * draw.uniform(1, 1.2) for x in corner] for corner in BOX]
        write_obj("figure.obj", away(vertices), normals, faces)
        write_obj("cage.obj", away(box), [], FACES)
        write_obj("pose.obj", pose(box), [], FACES)
        right = pose(vertices)
        for kind in ("mean-value", "harmonic", "green"):
            said = run("deform_mesh", "figure.obj", "--cage", "cage.obj", "--pose", "pose.obj", "--coordinates", kind, "-o", "moved.obj",
                       "--faces", "triangles")
            if kind != "green":  # which is not affine where the cage is stretched or mirrored
                check(("mirrors" in said) == is_mirror, "the message says whether the pose mirrors: " + said)
                compare("deform_mesh, " + kind, read_obj("moved.obj", "v"), read_obj("moved.obj", "vn"), right, right_normals, size)
        said = run("export_gltf", "figure.obj", "--cage", "cage.obj", "--pose", "pose.obj", "--morph", "-o", "moved.glb")
        check(("mirrors" in said) == is_mirror, "the message says whether the pose mirrors: " + said)
        compare("export_gltf --morph", *read_targets("moved.glb")[:2], right, right_normals, size)
        said = run("bind_mesh", "figure.obj", "--cage", "cage.obj", "--pose", "pose.obj", "-o", "moved.figure")
        check(("mirrors" in said) == is_mirror, "the message says whether the pose mirrors: " + said)
        with open("poses.csv", "w") as file:
            for points in (away(box), pose(box)):
                file.write(",".join("%.17g" % x for p in points for x in p) + "\n")
        run("clone_figure", "moved.figure", "--poses", "poses.csv", "--mesh", "figure.obj", "-o", "clone_%d.obj")
        for row, places, directions in ((0, away(vertices), normals), (1, right, right_normals)):
            compare("clone_figure, row %d" % row, read_obj("clone_%d.obj" % row, "v"), read_obj("clone_%d.obj" % row, "vn"), places, directions, size)
        with open("points.csv", "w") as file:
            for p in away(vertices):
                file.write("%.17g,%.17g,%.17g\n" % tuple(p))
        run("cage_weights", "--cage", "cage.obj", "--points", "points.csv", "--scalar", "float", "-o", "weights.csv")
        rows = [[float(x) for x in line.split(",")[1:]] for line in open("weights.csv").readlines()[1:]]
        off = max(math.dist(p, [dot(w, column) for column in zip(*box)]) for p, w in zip(vertices, rows)) / size
        check(off <= PLACE_TOLERANCE, "cage_weights, float: sums of weights are off by %g sizes" % off)
        # A closed figure keeps its volume's sign only if the faces of a mirror image are turned over.
        inner, flips = [[0.5 * x for x in p] for p in box], ["--flip-faces"] if is_mirror else []
        write_obj("inner.obj", away(inner), [], FACES)
        write_obj("frame.obj", pose(inner), [], FACES)
        run("deform_mesh", "inner.obj", "--cage", "cage.obj", "--pose", "pose.obj", "-o", "moved.obj", *flips)
        run("bind_mesh", "inner.obj", "--cage", "cage.obj", "-o", "inner.figure")
        for mesh in [], ["--mesh", "inner.obj"]:
            name = "mesh_%d.obj" if mesh else "inner_%d.obj"
            said = run("clone_figure", "inner.figure", "--poses", "poses.csv", "--rows", "1:2", "-o", name, *mesh)
            check(("--flip-faces reverses" in said) == is_mirror, "the message offers --flip-faces: " + said)
            run("clone_figure", "inner.figure", "--poses", "poses.csv", "--rows", "1:2", "-o", name, *mesh, *flips)
        run("export_gltf", "inner.obj", "--cage", "cage.obj", "--pose", "pose.obj", "--morph", "-o", "moved.glb", *flips)
        stretched = ["fit_skeleton", "inner.obj", "inner.obj", "frame.obj", "--bones", "1", "--kind", "stretched", "-o", "fitted.glb"]
        said = run(*stretched)
        check(("frame.obj: the pose mirrors" in said and "--flip-faces reverses" in said) == is_mirror, "the mirrored frame is named: " + said)
        check(("frame.obj: the pose mirrors" in run(*stretched[:-4], "-o", "fitted.glb")) == is_mirror, "rigid bones, too")
        check("mirror" not in run(*stretched, *flips), "with --flip-faces nothing is left to say")
        # In the files of export_gltf and fit_skeleton the winding is that of the pose, not of rest.
        side = -1 if is_mirror else 1
        rest, _, turned = read_targets("fitted.glb")
        for what, v, written, sign in (("deform_mesh", read_obj("moved.obj", "v"), faces_of("moved.obj"), 1),
                                     ("clone_figure", read_obj("inner_1.obj", "v"), faces_of("inner_1.obj"), 1),
                                     ("clone_figure --mesh", read_obj("mesh_1.obj", "v"), faces_of("mesh_1.obj"), 1),
                                     ("export_gltf", *read_targets("moved.glb")[::2], 1),
                                     ("fit_skeleton", rest, turned, side)):
            near = [[x - y for x, y in zip(p, v[0])] for p in v]
            check(sign * volume(near, written) > 0, what + ": the faces look outwards in the pose")


def rotated(v, axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    return [c * x + s * y + (1 - c) * dot(axis, v) * z for x, y, z in zip(v, cross(axis, v), axis)]


def keys_of_turns(path):
    """The rotation keys of a GLB file's only bone that turns."""
    scene, vectors = read_glb(path)
    animation = scene["animations"][0]
    channel = next(c for c in animation["channels"] if c["target"]["path"] == "rotation")
    return vectors(animation["samplers"][channel["sampler"]]["output"], "<4f")


def test_turns(seed):
    draw = random.Random(seed)
    axis = unit([draw.gauss(0, 1) for _ in range(3)])
    degrees = draw.choice([180, 360, 540, 720, draw.uniform(90, 720)])
    write_obj("solid.obj", BOX, [], FACES)
    for k in range(4):
        write_obj("turned_%d.obj" % k, [rotated(p, axis, math.radians(k * degrees)) for p in BOX], [], FACES)
    run("fit_skeleton", "solid.obj", *["turned_%d.obj" % k for k in range(4)], "--bones", "1", "-o", "turned.glb")
    with open("bones.csv", "w") as file:
        file.write("arm,,0,0,-1,0,0,1,%.17g,%.17g,%.17g\n" % tuple(degrees * x for x in axis))
    run("skin_mesh", "solid.obj", "--bones", "bones.csv", "--see-through", "-o", "skinned.glb")
    for path in ("turned.glb", "skinned.glb"):
        if path == "turned.glb" and degrees % 360 == 0:
            continue  # nothing moves
        keys = keys_of_turns(path)
        halves = [math.acos(min(1, dot(unit(a), unit(b)))) for a, b in zip(keys, keys[1:])]
        # slerp and the chord differ the most near a fifth of the way.
        ways = max(abs(math.atan2(0.21 * math.sin(h), 0.79 + 0.21 * math.cos(h)) - 0.21 * h) for h in halves)
        check(max(halves) <= math.radians(45.001) and 2 * ways <= 2e-3, "%s, %g degrees: keys are up to %g degrees apart, the ways %g" %
              (path, degrees, math.degrees(2 * max(halves)), 2 * ways))
    turned = math.degrees(sum(halves))  # there and back: half of twice the angle, in halves
    check(abs(turned - degrees) <= 0.05, "skin_mesh turns by %g degrees, not %g" % (turned, degrees))


def drawn(path):
    """All that a GLB file draws: its nodes, the attributes at all corners of its triangles, and its animations."""
    scene, vectors = read_glb(path)

    def elements(accessor):
        a = scene["accessors"][accessor]
        return vectors(accessor, "<%d%s" % ({"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[a["type"]],
                                            {5121: "B", 5123: "H", 5125: "I", 5126: "f"}[a["componentType"]]))

    parts = [scene["nodes"]]
    for mesh in scene["meshes"]:
        for primitive in mesh["primitives"]:
            corners = [c for c, in elements(primitive["indices"])]
            for attributes in (primitive["attributes"], *primitive.get("targets", [])):
                for name in sorted(attributes):
                    of_vertex = elements(attributes[name])
                    parts.append([of_vertex[c] for c in corners])
    for animation in scene.get("animations", []):
        parts += [elements(sampler[key]) for sampler in animation["samplers"] for key in ("input", "output")]
    return parts


def without_strays(path):
    """The lines of an OBJ file but for faces and for vertices that are no numbers or far away; and these."""
    lines = [line for line in open(path) if not line.startswith("f")]
    strays = [line for line in lines if any(word in line for word in ("n", "#", "e3", "e4"))]
    return [line for line in lines if line not in strays], strays


def test_strays(seed):
    draw = random.Random(seed)
    rings, around = draw.randint(3, 5), draw.randint(5, 8)
    vertices = [[0, -1, 0]] + [
        [r * math.cos(t) * math.sin(h), -math.cos(h), r * math.sin(t) * math.sin(h)]
        for h in (math.pi * n / (rings + 1) for n in range(1, rings + 1))
        for t, r in ((2 * math.pi * n / around, draw.uniform(0.6, 1)) for n in range(around))] + [[0, 1, 0]]
    faces = [[0, 1 + n, 1 + (n + 1) % around] for n in range(around)]
    faces += [[1 + k * around + n, 1 + (k + 1) * around + n, 1 + (k + 1) * around + (n + 1) % around, 1 + k * around + (n + 1) % around]
              for k in range(rings - 1) for n in range(around)]
    last = len(vertices) - 1
    faces += [[last, last - around + (n + 1) % around, last - around + n] for n in range(around)]
    order = sorted([(n, n) for n in range(len(vertices))] + [(draw.uniform(-1, len(vertices)), None) for _ in range(draw.randint(1, 5))],
                   key=lambda entry: entry[0])
    number = {n: k for k, (_, n) in enumerate(order) if n is not None}

    def write(name, points):
        """The figure, and beside it a figure with strays; they are others in each file, at the same numbers."""
        for folder in ("clean", "dirty"):
            far = []  # after the first stray, which is no number
            with open(os.path.join(folder, name), "w") as file:
                for _, n in order:
                    if n is not None:
                        file.write("v %.17g %.17g %.17g\n" % tuple(points[n]))
                    elif folder == "dirty":
                        words = [draw.choice(["nan", "-nan(ind)", "1.#QNAN", "inf", "-inf", *far]), "1", draw.choice(["nan", "2"])]
                        far = ["1e30", "-7e300", "1e400", "-2e31"]
                        file.write("v %s %s %s\n" % tuple(draw.sample(words, 3)))
                for face in faces:
                    file.write("f %s\n" % " ".join(str((n if folder == "clean" else number[n]) + 1) for n in face))

    def bent(angle):
        return [[x, y * math.cos(a) - z * math.sin(a), y * math.sin(a) + z * math.cos(a)] for x, y, z in vertices for a in [angle * (y > 0)]]

    for folder in ("clean", "dirty"):
        os.makedirs(folder, exist_ok=True)
    write("figure.obj", vertices)
    for k in range(4):
        write("frame_%d.obj" % k, bent(0.2 * k))
    write_obj("cage.obj", [[1.2 * x for x in corner] for corner in BOX], [], FACES)
    with open("bones.csv", "w") as file:
        file.write("lower,,0,-1,0,0,0,0,0,0,0\nupper,lower,0,0,0,0,1,0,0,0,60\n")
    with open("poses.csv", "w") as file:
        file.write(",".join("%.17g" % (1.5 * x) for corner in BOX for x in corner) + "\n")
    run("make_splats", "clean/figure.obj", "-o", "scene.ply", "--count", "50")
    frames = ["@/frame_%d.obj" % k for k in range(4)]
    twist = ["--cage", "cage.obj", "--twist", "all:y,-1,1,60"]
    for words in (["deform_mesh", "@/figure.obj", *twist, "-o", "@/out.obj"],
                  ["export_gltf", "@/figure.obj", *twist, "--skin", "4", "-o", "@/out.glb"],
                  ["export_gltf", "@/figure.obj", *twist, "--morph", "-o", "@/out.glb"],
                  ["export_gltf", "@/figure.obj", *twist, "--bones", "2", "-o", "@/out.glb"],
                  ["skin_mesh", "@/figure.obj", "--bones", "bones.csv", "-o", "@/out.glb"],
                  ["fit_skeleton", "@/figure.obj", *frames, "--bones", "2", "-o", "@/out.glb"],
                  ["make_cage", "@/figure.obj", "--vertices", "16", "-o", "@/out.obj"],
                  ["make_cage", "@/figure.obj", "--lattice", "3x3x3", "-o", "@/out.lattice.json"],
                  ["lattice_fit", "@/figure.obj", "@/frame_3.obj", "--cage", "lattice:3x3x3", "-o", "@/out.obj"],
                  ["make_tiles", "@/figure.obj", "--points", "50", "-o", "@/out.ply"],
                  ["make_splats", "@/figure.obj", "--count", "50", "-o", "@/out.ply"],
                  ["draw_splats", "scene.ply", "--beside", "@/figure.obj", "--width", "64", "--height", "64", "-o", "@/out.png"],
                  ["adaptive_grid", "--cage", "cage.obj", "--figure", "@/figure.obj", "-o", "@/out.svg"],
                  ["bind_mesh", "@/figure.obj", "--cage", "cage.obj", "-o", "@/out.figure"],
                  ["clone_figure", "@/out.figure", "--poses", "poses.csv", "--mesh", "@/figure.obj", "-o", "@/out_%d.obj"]):
        what = " ".join(words)
        for folder in ("clean", "dirty"):
            said = run(*(word.replace("@", folder) for word in words))
            is_named = "vertices are left out, first v" in said and "--strict" in said
            check(is_named == (folder == "dirty" and words[0] != "clone_figure"), what + ": strays are named: " + said)
        out = words[-1].replace("%d", "0")
        if words[0] == "bind_mesh":
            continue
        results = [out.replace("@", folder) for folder in ("clean", "dirty")]
        if words[0] in ("deform_mesh", "clone_figure"):
            (clean, _), (dirty, strays) = (without_strays(path) for path in results)
            check(clean == dirty and strays == without_strays("dirty/figure.obj")[1], what + ": places, and the text of strays")
        elif out.endswith(".glb"):
            check(drawn(results[0]) == drawn(results[1]), what + ": what is drawn")
        else:
            check(open(results[0], "rb").read() == open(results[1], "rb").read(), what + ": bytes")
        if words[0] != "clone_figure":
            os.remove(results[1])
            said = run(*(word.replace("@", "dirty") for word in words), "--strict", code=1)
            check("not finite" in said and not os.path.exists(results[1]), what + " --strict: " + said)


def test_copies(seed):
    """A tube whose quads have corners of their own, by up to 1e-7 of its length from those of their neighbours."""
    draw = random.Random(seed)
    rings, around, corners, faces, groups = draw.randint(6, 12), draw.randint(6, 10), [], [], {}
    for r in range(rings):
        for a in range(around):
            for ring, spoke in ((r, a), (r, a + 1), (r + 1, a + 1), (r + 1, a)):
                angle = 2 * math.pi * (spoke % around) / around
                place = (0.6 * math.cos(angle), 0.6 * math.sin(angle), 1.8 * ring / rings - 0.9)
                groups.setdefault((ring, spoke % around), []).append(len(corners))
                corners.append([x + draw.uniform(-1, 1) * 1e-7 for x in place])
            faces.append(" ".join(str(n) for n in range(len(corners) - 3, len(corners) + 1)))
    write_obj("tube.obj", corners, [], faces)
    cage = [[1.1 * x, 1.1 * y, z] for z in (-1, -0.4, 0.1, 0.5, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    sides = [[4 * k + a, 4 * k + (a + 1) % 4, 4 * k + 4 + (a + 1) % 4, 4 * k + 4 + a] for k in range(4) for a in range(4)]
    sides = [" ".join(str(n + 1) for n in side) for side in [[3, 2, 1, 0], [16, 17, 18, 19], *sides]]
    write_obj("cage.obj", cage, [], sides)
    with open("poses.csv", "w") as file:
        file.write(",".join("%.17g" % (x + draw.gauss(0, 0.3)) for p in cage for x in p) + "\n")
    run("bind_mesh", "tube.obj", "--cage", "cage.obj", "--largest", "4", "-o", "tube.figure")
    run("clone_figure", "tube.figure", "--poses", "poses.csv", "--mesh", "tube.obj", "-o", "tube_%d.obj")
    moved = read_obj("tube_0.obj", "v")
    gap = max(math.dist(moved[n], moved[group[0]]) for group in groups.values() for n in group)
    check(gap <= 2e-6, "bind_mesh --largest 4 opens the tube by %g" % gap)


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    for seed in range(SEED, SEED + COUNT):
        before = faults
        test(seed)
        if seed % 4 == 0:
            test_strays(seed)
            test_copies(seed)
            test_turns(seed)
        if faults > before:
            print("seed", seed)
print("%d poses from seed %d on, %d faults" % (COUNT, SEED, faults))
sys.exit(faults > 0)
