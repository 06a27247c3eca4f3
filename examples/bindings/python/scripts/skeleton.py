"""Fits a skeleton for an engine to a sequence of meshes: an arm that bends its elbow and twists its wrist."""

import numpy as np

import cageform

rings, corners = 31, 12
along, around = np.repeat(np.linspace(0, 6, rings), corners), np.tile(np.arange(corners) * 2 * np.pi / corners, rings)
rest = np.stack([along, 0.5 * np.cos(around), 0.5 * np.sin(around)], axis=1)
quads = [[r * corners + c, (r + 1) * corners + c, (r + 1) * corners + (c + 1) % corners, r * corners + (c + 1) % corners]
         for r in range(rings - 1) for c in range(corners)]
faces = np.array([(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads])


def posed(phase):
    """Returns the vertices in a frame: (#vertices, 3)."""
    x, y, z = rest.T
    twist = np.clip(x - 4, 0, 1) * np.sin(phase)                      # of the wrist
    y, z = np.cos(twist) * y - np.sin(twist) * z, np.sin(twist) * y + np.cos(twist) * z
    bend = np.clip(x - 2.5, 0, 1) * 0.7 * (1 - np.cos(phase))         # of the elbow, smooth over a length of 1
    spine = np.cumsum(np.stack([np.cos(bend), np.sin(bend)])[:, ::corners] * 6 / (rings - 1), axis=1).repeat(corners, axis=1)
    return np.stack([spine[0] - np.sin(bend) * y, spine[1] + np.cos(bend) * y, z], axis=1)


frames = np.array([posed(phase) for phase in np.linspace(0, 2 * np.pi, 25)])
skeleton, report = cageform.fit_skeleton(rest, frames, faces, max_distance=0.01)
print('%d bones, maximum error %.2f %% of the size' % (report.bones, 100 * report.max_distance))
print('the report agrees:', np.isclose(np.linalg.norm(skeleton.places(rest) - frames, axis=2).max(),
                                         report.max_distance * np.linalg.norm(np.ptp(rest, axis=0))))
translations, rotations, scales, axes = skeleton.transforms()
for bone, (parent, joint) in enumerate(zip(skeleton.parents, skeleton.joints)):
    turn = np.degrees(2 * np.arccos(np.abs(rotations[:, bone, 3]).clip(0, 1))).max()
    print('bone %d: parent %d, joint at x = %.1f, rotation up to %.0f degrees' % (bone, parent, joint[0], turn))
