"""Moves the points of an SVG with a cage: python3 svg_points.py FIGURE.svg CAGE.svg POSE.svg OUT.svg

Moves points of polygons and polylines, and all coordinates of paths with absolute M, L, C and Z, so that curves stay
curves. deform_svg supports all of SVG, and subdivides lines and curves where they bend.
"""

import re
import sys
import xml.etree.ElementTree as ET

import numpy as np

import cageform

NUMBER = r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?'


def text_of(element):
    """Returns the name and the text of the attribute with an element's points; the text is None if it has none."""
    name = 'd' if element.tag.endswith('}path') else 'points'
    return name, element.get(name)


def points_of(element):
    name, text = text_of(element)
    if name == 'd' and re.search(r'[a-df-zHVSQTA]', text):
        raise SystemExit('only absolute M, L, C and Z are supported here: use deform_svg')
    return np.array([float(number) for number in re.findall(NUMBER, text)]).reshape(-1, 2)


def cage_of(path):
    """Returns the first polygon or path of a file."""
    for element in ET.parse(path).iter():
        if text_of(element)[1]:
            return points_of(element)
    raise SystemExit('%s contains no polygon and no path' % path)


def main(figure, cage, pose, out):
    tree = ET.parse(figure)
    drawn = [element for element in tree.iter() if text_of(element)[1]]
    points = [points_of(element) for element in drawn]
    binding = cageform.Coordinates(cageform.Cage.polygon(cage_of(cage))).bind(np.concatenate(points))
    moved = binding.figure.clone(cage_of(pose))
    print(binding.report)
    start = 0
    for element, own in zip(drawn, points):
        numbers = iter(moved[start:start + len(own)].ravel())
        name, text = text_of(element)
        element.set(name, re.sub(NUMBER, lambda _: '%.3f' % next(numbers), text))
        start += len(own)
    ET.register_namespace('', 'http://www.w3.org/2000/svg')
    tree.write(out)


if __name__ == '__main__':
    if len(sys.argv) != 5:
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
