"""Plots the weight of a cage vertex for two coordinate types: python3 plot_weights.py OUT.png (needs matplotlib)"""

import sys

import matplotlib
import numpy as np

import cageform

matplotlib.use('Agg')
import matplotlib.pyplot as plt

corner = np.array([(0, 0), (6, 0), (6, 2), (2, 2), (2, 4), (6, 4), (6, 6), (0, 6)], dtype=float)


def main(out):
    x, y = np.meshgrid(np.linspace(0, 6, 400), np.linspace(0, 6, 400))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    figure, both = plt.subplots(1, 2, figsize=(10, 5))
    for axes, kind in zip(both, ('mean-value', 'harmonic')):
        binding = cageform.Coordinates(cageform.Cage.polygon(corner), kind).bind(points, outside='keep-in-place')
        weights = binding.weights()[:, 3]
        weights[binding.outside] = np.nan
        drawn = axes.contourf(x, y, weights.reshape(x.shape), np.linspace(-0.2, 1, 25), cmap='RdBu_r', vmin=-1, vmax=1)
        axes.plot(*np.append(corner, corner[:1], axis=0).T, color='black')
        axes.set(xlim=(-0.2, 6.2), ylim=(-0.2, 6.2))
        axes.set_title(kind)
        axes.set_aspect('equal')
    figure.suptitle('the weight of the vertex at (2, 2)')
    figure.colorbar(drawn, ax=both)
    figure.savefig(out, dpi=80)


if __name__ == '__main__':
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    main(sys.argv[1])
