// A cage and its pose: loops of vertices, as flat arrays x, y, x, y, …

/** Calls f(i, j) for every edge, by its vertices. */
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

/** Returns a cage and a pose with one more vertex, after `vertex`, at a share of the edge to the next. */
function withVertex(cage, pose, vertex, share) {
  const { loop, begin } = loopOf(cage.loops, vertex);
  const next = begin + (vertex + 1 - begin) % cage.loops[loop];
  const insert = points => {
    const all = [...points], place = k => points[2 * vertex + k] + share * (points[2 * next + k] - points[2 * vertex + k]);
    all.splice(2 * vertex + 2, 0, place(0), place(1));
    return Float64Array.from(all);
  };
  return { cage: { loops: cage.loops.map((n, k) => n + (k === loop ? 1 : 0)), rest: insert(cage.rest) }, pose: insert(pose) };
}
/** Removes some vertices; returns null if a loop would have fewer than three. */
function withoutVertices(cage, pose, gone) {
  const keep = points => points.filter((x, k) => !gone.has(k >> 1));
  const loops = [];
  let at = 0;
  for (const size of cage.loops) {
    let left = 0;
    for (let k = 0; k < size; ++k, ++at) left += gone.has(at) ? 0 : 1;
    if (left > 0 && left < 3) return null;
    if (left > 0) loops.push(left);
  }
  return loops.length > 0 ? { cage: { loops, rest: keep(cage.rest) }, pose: keep(pose) } : null;
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
