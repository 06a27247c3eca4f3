#!/usr/bin/env python3
"""Compares deform_mesh on one torus as OBJ, GLB, PLY and STL: seconds of processor time (user + system) and peak memory.

    python3 bench/files.py PROGRAMS [VERTICES [RUNS]]

PROGRAMS is build/examples, built with -O3 (cmake --preset bench). VERTICES: 1,000,000. RUNS: 3, alternating; the medians are printed.
"""
import json
import os
import statistics
import struct
import subprocess
import sys
import tempfile

import numpy as np


def torus(vertices):
    """Returns the positions, unit normals and triangles of a torus with about as many vertices."""
    n = int(vertices**0.5)
    u, v = (2 * np.pi * grid.ravel() / n for grid in np.mgrid[0:n, 0:n])
    normals = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], 1)
    places = 0.4 * normals + np.stack([np.cos(u), np.sin(u), 0 * u], 1)
    i, j = (grid.ravel() for grid in np.mgrid[0:n, 0:n])
    a, b, c, d = (i * n + j, (i + 1) % n * n + j, (i + 1) % n * n + (j + 1) % n, i * n + (j + 1) % n)
    return places.astype("<f4"), normals.astype("<f4"), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype("<u4")


def write(folder, places, normals, faces):
    """Writes the torus in four formats; returns the paths. STL has no vertex normals."""
    paths = [os.path.join(folder, "torus." + extension) for extension in ("obj", "glb", "ply", "stl")]
    with open(paths[0], "w") as file:
        np.savetxt(file, places, "v %.9g %.9g %.9g")
        np.savetxt(file, normals, "vn %.9g %.9g %.9g")
        np.savetxt(file, np.repeat(faces + 1, 2, 1), "f %d//%d %d//%d %d//%d")
    parts = [places.tobytes(), normals.tobytes(), faces.tobytes()]
    views = [{"buffer": 0, "byteOffset": sum(map(len, parts[:k])), "byteLength": len(part)} for k, part in enumerate(parts)]
    accessors = [{"bufferView": k, "componentType": 5126, "count": len(places), "type": "VEC3"} for k in (0, 1)]
    accessors[0].update(min=places.min(0).tolist(), max=places.max(0).tolist())
    accessors.append({"bufferView": 2, "componentType": 5125, "count": faces.size, "type": "SCALAR"})
    primitive = {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}
    document = json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}],
                           "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": sum(map(len, parts))}]}).encode()
    document += b" " * (-len(document) % 4)
    with open(paths[1], "wb") as file:
        total = 28 + len(document) + sum(map(len, parts))
        file.write(struct.pack("<4sIIII", b"glTF", 2, total, len(document), 0x4E4F534A) + document)
        file.write(struct.pack("<II", sum(map(len, parts)), 0x004E4942) + b"".join(parts))
    with open(paths[2], "wb") as file:
        properties = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
        file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\n{properties}element face {len(faces)}\n"
                   "property list uchar uint vertex_indices\nend_header\n".encode())
        file.write(np.hstack([places, normals]).tobytes())
        records = np.zeros(len(faces), [("count", "u1"), ("corners", "<u4", 3)])
        records["count"], records["corners"] = 3, faces
        file.write(records.tobytes())
    with open(paths[3], "wb") as file:
        records = np.zeros(len(faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        records["corners"] = places[faces]
        records["normal"] = np.cross(places[faces[:, 1]] - places[faces[:, 0]], places[faces[:, 2]] - places[faces[:, 0]])
        file.write(b"torus".ljust(80) + struct.pack("<I", len(faces)) + records.tobytes())
    return paths


def cost(program, path):
    """Returns seconds of processor time and the peak memory in MB of one run."""
    out = path.replace("torus.", "moved.")
    process = subprocess.Popen([program, path, "--cage", "box", "--scale", "all:1.1,0.9,1.2", "-o", out])
    _, status, used = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{path}: deform_mesh failed")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    if not 2 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    vertices, runs = (int(text) for text in (sys.argv[2:] + ["1000000", "3"][len(sys.argv) - 2 :]))
    with tempfile.TemporaryDirectory() as folder:
        paths = write(folder, *torus(vertices))
        costs = {path: [] for path in paths}
        for _ in range(runs):
            for path in paths:
                costs[path].append(cost(os.path.join(sys.argv[1], "deform_mesh"), path))
        reference = statistics.median(seconds for seconds, _ in costs[paths[0]])
        for path in paths:
            seconds, memory = (statistics.median(values) for values in zip(*costs[path]))
            size = os.path.getsize(path) / 1e6
            print(f"{path[-3:]}: {size:.0f} MB, {seconds:.2f} s, {seconds / reference:.2f} of OBJ, {memory:.0f} MB of memory")


main()
