"""Fits a cage to given points by gradient descent: Figure.gradients is the transpose of Figure.clone."""

import numpy as np

import cageform

rng = np.random.default_rng(1)
angles = np.arange(24) * 2 * np.pi / 24
ring = np.stack([2 * np.cos(angles), np.sin(angles)], axis=1)
figure = cageform.Coordinates(cageform.Cage.polygon(ring)).bind(rng.uniform((-1, -0.4), (1, 0.4), (2000, 2))).figure
hidden = ring + 0.3 * rng.normal(size=ring.shape).cumsum(axis=0) / 5
targets = figure.clone(hidden)

# Conjugate gradients for the sum of squares, which is quadratic in the pose.
pose = figure.rest()
gradient = -figure.gradients(figure.clone(pose) - targets)
direction = gradient
for step in range(60):
    moved = figure.clone(figure.rest() + direction) - figure.clone(figure.rest())  # linear in the direction
    length = (gradient * direction).sum() / (moved ** 2).sum()
    pose = pose + length * direction
    if step % 10 == 9:
        print('%d steps: %.2e' % (step + 1, np.abs(figure.clone(pose) - targets).max()))
    last, gradient = gradient, -figure.gradients(figure.clone(pose) - targets)
    direction = gradient + (gradient ** 2).sum() / (last ** 2).sum() * direction
