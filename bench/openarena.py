#!/usr/bin/env python3
"""Usage: python3 bench/openarena.py FOLDER [NAME…]

Extracts figures and motions of a game for the benchmarks. Downloads the Debian packages openarena-data and
openarena-081-players (119 MB). Their models are under the GPL, so this project does not contain them. Writes for each
player, or for each NAME:

    FOLDER/NAME.obj       first frames of legs, trunk and head, assembled by their tags
    FOLDER/NAME_legs.md3  the vertex animation of the legs, input of bench_skeleton
"""
import pathlib
import struct
import subprocess
import sys
import tempfile
import zipfile


def read_md3(data):
    """Returns vertices, triangles and tags (position and three axes, by name) of the first frame."""
    frames, tags, surfaces = struct.unpack_from("<3i", data, 76)
    at_tags, at_surface = struct.unpack_from("<2i", data, 96)
    found = {}
    for n in range(tags):
        at = at_tags + 112 * n
        name = data[at : at + 64].split(b"\0")[0].decode("ascii", "replace")
        numbers = struct.unpack_from("<12f", data, at + 64)
        found[name] = (numbers[:3], numbers[3:])
    vertices, faces = [], []
    for _ in range(surfaces):
        count, triangles, at_triangles = struct.unpack_from("<3i", data, at_surface + 80)
        at_vertices, size = struct.unpack_from("<2i", data, at_surface + 100)
        for n in range(triangles):
            faces.append([len(vertices) + i for i in struct.unpack_from("<3i", data, at_surface + at_triangles + 12 * n)])
        for n in range(count):
            place = struct.unpack_from("<3h", data, at_surface + at_vertices + 8 * n)
            vertices.append([x / 64 for x in place])
        at_surface += size
    return vertices, faces, found


def placed(tag, place):
    """Transforms a position from the frame of a tag."""
    origin, axes = tag
    return [origin[k] + sum(place[j] * axes[3 * j + k] for j in range(3)) for k in range(3)]


def whole_figure(parts):
    """Attaches the trunk to the legs and the head to the trunk."""
    vertices, faces, tags = parts["lower"]
    vertices, faces = list(vertices), list(faces)
    chain = [tags["tag_torso"]]
    for part in ("upper", "head"):
        own, own_faces, own_tags = parts[part]
        faces += [[len(vertices) + i for i in face] for face in own_faces]
        for place in own:
            for tag in reversed(chain):
                place = placed(tag, place)
            vertices.append(place)
        if part == "upper":
            chain.append(own_tags["tag_head"])
    return vertices, faces


def archives(folder):
    """Unpacks the Debian packages into a folder; returns the game's archives."""
    packages = ["openarena-data", "openarena-081-players"]
    subprocess.run(["apt-get", "-o", "APT::Sandbox::User=root", "download", "-q", *packages], cwd=folder, check=True)
    for package in pathlib.Path(folder).glob("*.deb"):
        subprocess.run(["dpkg-deb", "-x", str(package), folder], check=True)
    return sorted(pathlib.Path(folder).rglob("*.pk3"))


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__.strip())
        return 0 if sys.argv[1:] == ["--help"] else 2
    out = pathlib.Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    wanted = set(sys.argv[2:])
    with tempfile.TemporaryDirectory() as folder:
        for archive in archives(folder):
            with zipfile.ZipFile(archive) as pack:
                names = set(pack.namelist())
                players = sorted({name.split("/")[2] for name in names if name.startswith("models/players/")})
                for player in players:
                    files = {part: f"models/players/{player}/{part}.md3" for part in ("lower", "upper", "head")}
                    if (wanted and player not in wanted) or not set(files.values()) <= names:
                        continue
                    parts = {part: read_md3(pack.read(file)) for part, file in files.items()}
                    if "tag_torso" not in parts["lower"][2] or "tag_head" not in parts["upper"][2]:
                        continue
                    vertices, faces = whole_figure(parts)
                    with open(out / f"{player}.obj", "w", encoding="ascii") as file:
                        file.writelines(f"v {x:.6g} {y:.6g} {z:.6g}\n" for x, y, z in vertices)
                        file.writelines("f " + " ".join(str(i + 1) for i in face) + "\n" for face in faces)
                    (out / f"{player}_legs.md3").write_bytes(pack.read(files["lower"]))
                    print(f"{player}: {len(vertices)} vertices, {len(faces)} triangles")
                    wanted.discard(player)
    for player in sorted(wanted):
        print(f"openarena.py: unknown player {player}", file=sys.stderr)
    return 1 if wanted else 0


if __name__ == "__main__":
    sys.exit(main())
