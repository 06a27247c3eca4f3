"""A clip: three poses at three times become curves. Packs them with the figure into a file, and plays the file."""

import tempfile

import numpy as np

import cageform

square = np.array([(0, 0), (4, 0), (4, 4), (0, 4)], dtype=np.float32)
points = np.random.default_rng(1).uniform(0.5, 3.5, (1000, 2)).astype(np.float32)
binding = cageform.Coordinates(cageform.Cage.polygon(square), dtype=np.float32).bind(points)
leaning = square + np.array([(0, 0), (0, 0), (2, 0), (2, 0)], dtype=np.float32)
clip, report = cageform.compile_clip([0, 1, 2], [square, leaning, square], after='cycle')
packed, report = binding.pack(tolerance=1e-3, clips={'lean': clip})
with tempfile.NamedTemporaryFile(suffix='.cage') as file:
    packed.tofile(file.name)
    figure = cageform.open(file.name)
    played = figure.clip('lean')
    for time in (0, 0.5, 1, 2.5):
        moved = figure.clone(played.sample(time))
        print('%.1f s: mean position %.2f, %.2f' % (time, *moved.mean(axis=0)))
