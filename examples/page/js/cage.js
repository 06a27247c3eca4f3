// Files of cages and poses, and loops of vertices: flat arrays x, y, x, y, …

/** Calls f(i, j) for every edge; i and j are its vertices. */
function forEachEdge(loops, f) {
  let begin = 0;
  for (const size of loops) {
    for (let k = 0; k < size; ++k) f(begin + k, begin + (k + 1) % size);
    begin += size;
  }
}
/** Returns the loop of a vertex, and the loop's first vertex. */
function loopOf(loops, vertex) {
  let begin = 0, loop = 0;
  while (vertex >= begin + loops[loop]) begin += loops[loop++];
  return { loop, begin };
}

/** Reads the first closed polygon of an SVG document, the format of the project's own cages. */
function cageOfSvg(text) {
  const polygon = parseSvg(text).querySelector('polygon');
  const rest = Float64Array.from(numbersIn(polygon.getAttribute('points')));
  return { loops: [rest.length / 2], rest };
}
/** Writes blocks of lines x,y with empty lines between them, which the programs read as --cage and --pose. */
function cageCsv(loops, places, heading) {
  let at = 0;
  const blocks = loops.map(size => {
    const lines = [];
    for (let k = 0; k < size; ++k, ++at) lines.push(`${places[2 * at]},${places[2 * at + 1]}`);
    return lines.join('\n');
  });
  return `# ${heading}\n${blocks.join('\n\n')}\n`;
}


// ---- files of cages ----

const MOST_CAGE_POINTS = 4000;
/** Reads a cage in a format of the programs; throws a message with the file's name. */
function readCage(text, name) {
  const refuse = why => { throw new Error(`${name}: ${why}`); };
  const cage = /\.json$/i.test(name) ? readLattice(text, refuse) : /\.csv$/i.test(name) ? readLoops(text, refuse) : readPath(text, refuse);
  const count = cage.axes ? cage.axes[0].points * cage.axes[1].points : cage.curves ? 3 * cage.curves.flat().length : cage.rest.length / 2;
  if (!(count <= MOST_CAGE_POINTS)) refuse(`has more than the ${MOST_CAGE_POINTS} points that this page can show`);
  return cage;
}
function readLattice(text, refuse) {
  let json = null;
  try { json = JSON.parse(text); } catch { refuse('is not JSON'); }
  const isNumbers = (list, size) => Array.isArray(list) && (size === undefined || list.length === size) && list.every(Number.isFinite);
  const { format, axes, frame_columns: columns, origin, falloff = 0 } = json ?? {};
  const isAxis = axis => [axis?.points, axis?.degree].every(n => Number.isInteger(n) && n >= 0) && isNumbers(axis.knots ?? []);
  if (format !== 'lattice/1' || !Array.isArray(axes) || axes.length !== 2 || !axes.every(isAxis)) refuse('is not a lattice with two axes');
  if (!isNumbers(origin, 2) || !Array.isArray(columns) || columns.length !== 2 || !columns.every(v => isNumbers(v, 2)) || !Number.isFinite(falloff))
    refuse('has no box');
  const own = axes.map(({ points, degree, knots }) => knots ? { points, degree, knots } : { points, degree });
  return { kind: 'lattice', axes: own, frame: [...origin, ...columns.flat()], falloff, frozen: 0, loops: [] };
}
function readLoops(text, refuse) {
  if (/^#\s*(chain|point)\b/m.test(text)) refuse('has chains or points inside the cage, which this page does not show');
  const blocks = text.replace(/\r/g, '').replace(/^#.*\n?/gm, '').split(/\n\s*\n/).map(block => block.trim()).filter(block => block);
  const loops = blocks.map(block => block.split('\n').map(line => line.split(',').map(Number)));
  if (loops.length === 0 || !loops.flat().every(p => p.length === 2 && p.every(Number.isFinite))) refuse('has lines that are not x,y');
  return { loops: loops.map(loop => loop.length), rest: Float64Array.from(loops.flat(2)) };
}
/** Reads the first path or polygon of an SVG document: a polygon if all is straight, else loops of curves. */
function readPath(text, refuse) {
  const element = parseSvg(text)?.querySelector('path,polygon');
  if (!element) refuse('has no path');
  if (element.closest('[transform]')) refuse('its path has a transform, which this page does not support');
  const subpaths = element.localName === 'path' ? parsePath(element.getAttribute('d') ?? '', new PathBuilder(Math.PI / 4)) : outlineOf(element);
  if (subpaths.length === 0) refuse('its path is empty');
  const open = subpaths.findIndex(({ closed }) => !closed);
  if (open >= 0) refuse(`subpath ${open} is not closed`);
  const size = sizeOf(subpaths.flatMap(({ start, segments }) => [start, ...segments.map(({ to }) => to)]).flat());
  const curves = subpaths.map(({ start, segments }) => {
    let from = start;
    const edges = segments.map(({ line, c1, c2, control, to }) => {
      const edge = line ? [from, to] : control ? [from, control, to] : [from, c1, c2, to];
      from = to;
      return edge;
    });
    const last = edges[edges.length - 1]; // closes the path; an edge within rounding is omitted
    if (edges.length > 1 && last.length === 2 && distance(...last) <= 1e-9 * size) {
      edges.pop();
      const before = edges[edges.length - 1];
      before[before.length - 1] = start;
    }
    return edges;
  });
  const isStraight = curves.flat().every(edge => edge.length === 2);
  return isStraight ? { loops: curves.map(loop => loop.length), rest: Float64Array.from(curves.flatMap(loop => loop.flatMap(([p]) => p))) }
    : { kind: 'curved', curves, loops: [], disk: 0 };
}

/** Tests whether a point is inside loops, by the even-odd rule. */
function isInside(loops, points, x, y) {
  let inside = false;
  forEachEdge(loops, (i, j) => {
    const ay = points[2 * i + 1], by = points[2 * j + 1];
    if ((ay > y) !== (by > y) && x < points[2 * i] + (y - ay) / (by - ay) * (points[2 * j] - points[2 * i])) inside = !inside;
  });
  return inside;
}
function loopsPath(loops, points, close = 'Z') {
  let text = '', at = 0;
  for (const size of loops) {
    for (let k = 0; k < size; ++k, ++at) text += `${k === 0 ? 'M' : 'L'}${points[2 * at]} ${points[2 * at + 1]}`;
    text += close;
  }
  return text;
}
