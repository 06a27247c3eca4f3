// The kinds of 2D cages: a polygon; a lattice, whose points are in rows and columns; and loops of curves, posed as
// cubics. All have points at rest, `rest`, in the order of a pose. A lattice also has `axes`, `frame` (origin and edges of its
// box), `falloff` and the number of `frozen` layers; a curved cage has `curves` (loops of edges, each of 2 to 4 points), `loops`
// (points per loop, 3 per edge) and `disk`: radius of the smallest disk / radius of the used disk, 0 for none.

const kindOf = cage => KINDS[cage?.kind ?? 'polygon'];
const pointAt = (points, i) => [points[2 * i], points[2 * i + 1]];
const putPoint = (points, i, [x, y]) => { points[2 * i] = x; points[2 * i + 1] = y; };
const allOf = count => Array.from({ length: count }, (x, i) => i);

/** Moves the points of a pose to those of another cage: new point i follows the old points of rows[i], a list of [point, share]. */
function followRows(rows, old, pose, rest) {
  return rest.map((x, k) => {
    const row = rows[k >> 1], of = i => 2 * i + k % 2, isSame = row.length === 1 && row[0][1] === 1 && x === old[of(row[0][0])];
    return isSame ? pose[of(row[0][0])] : row.reduce((sum, [i, share]) => sum + share * (pose[of(i)] - old[of(i)]), x);
  });
}
const sameRows = count => allOf(count).map(i => [[i, 1]]);

const KINDS = {
  polygon: {
    types: null, // the chosen types
    mark: () => 'circle',
    shownPoints: () => () => true,
    isFixed: () => false,
    describe: cage => `a cage of ${cage.rest.length / 2} vertices`,
    path: (cage, places) => loopsPath(cage.loops, places),
    outline: cage => ({ loops: cage.loops, points: cage.rest }),
    move: moveEach,
    reshaped: cage => cage,
    settled: (engine, cage) => cage,
    nearestEdge: nearestSide,
    withPoint(cage, vertex, share) {
      const { loop, begin } = loopOf(cage.loops, vertex), next = begin + (vertex + 1 - begin) % cage.loops[loop];
      const rows = sameRows(cage.rest.length / 2), added = [[vertex, 1 - share], [next, share]];
      rows.splice(vertex + 1, 0, added);
      const rest = [...cage.rest];
      rest.splice(2 * vertex + 2, 0, ...between(pointAt(cage.rest, vertex), pointAt(cage.rest, next), share));
      return { cage: { ...cage, loops: cage.loops.map((n, k) => n + (k === loop ? 1 : 0)), rest: Float64Array.from(rest) }, rows, chosen: vertex + 1 };
    },
    withoutPoints(cage, pose, gone) {
      const loops = [];
      let at = 0;
      for (const size of cage.loops) {
        let left = 0;
        for (let k = 0; k < size; ++k, ++at) left += gone.has(at) ? 0 : 1;
        if (left > 0 && left < 3) throw new Error('A loop needs at least three vertices');
        if (left > 0) loops.push(left);
      }
      if (loops.length === 0) throw new Error('A loop needs at least three vertices');
      return { cage: { ...cage, loops, rest: cage.rest.filter((x, k) => !gone.has(k >> 1)) },
        rows: sameRows(cage.rest.length / 2).filter((row, i) => !gone.has(i)) };
    },
  },

  lattice: {
    types: ['splines'],
    mark: () => 'circle',
    shownPoints: () => () => true,
    isFixed: isFrozen,
    describe: ({ axes: [{ points }, { points: rows }] }) => `a lattice of ${points} columns and ${rows} rows`,
    path: (cage, places) => linesOf(cage).map(line => line.map((i, k) => `${k === 0 ? 'M' : 'L'}${places[2 * i]} ${places[2 * i + 1]}`).join('')).join(''),
    outline(cage) {
      const [u, v] = cage.axes.map(({ points }) => points);
      const corners = [0, u - 1, u * v - 1, u * (v - 1)];
      return { loops: [4], points: Float64Array.from(corners.flatMap(i => pointAt(cage.rest, i))) };
    },
    move(cage, selection, f, from) { return moveEach(cage, [...selection].filter(i => !isFrozen(cage, i)), f, from); },
    /** Returns the lattice in the box spanned by its moved corners. */
    reshaped(cage) {
      const u = cage.axes[0].points, v = cage.axes[1].points, [o, a, b] = [0, u - 1, u * (v - 1)].map(i => pointAt(cage.rest, i));
      return { ...cage, frame: [...o, a[0] - o[0], a[1] - o[1], b[0] - o[0], b[1] - o[1]] };
    },
    settled: (engine, cage) => ({ ...cage, rest: engine.makeCoordinates('splines', cage) }),
    nearestEdge: () => null,
    withPoint: refuseToEdit,
    withoutPoints: refuseToEdit,
  },

  curved: {
    types: ['curved-green'],
    mark: i => i % 3 === 0 ? 'rect' : 'circle',
    shownPoints: shownOfCurves,
    isFixed: () => false,
    describe: cage => `a cage of ${cage.rest.length / 6} curves` + (cage.disk ? `, with a disk of radius ${diskOf(cage)[2].toPrecision(4)}` : ''),
    path: curvesPath,
    outline(cage) {
      const points = [], loops = cage.loops.map(size => size / 3 * CURVE_STEPS);
      forEachCurve(cage.loops, edge => {
        for (let k = 0; k < CURVE_STEPS; ++k) points.push(...pointOfCurve(edge.map(i => pointAt(cage.rest, i)), k / CURVE_STEPS));
      });
      return { loops, points: Float64Array.from(points) };
    },
    move: moveCurves,
    reshaped: cage => ({ ...cage, curves: curvesOf(cage) }),
    settled: (engine, cage) => ({ ...cage, rest: engine.makeCoordinates('curved-green', cage), loops: cage.curves.map(loop => 3 * loop.length) }),
    nearestEdge: nearestCurve,
    withPoint: withNode,
    withoutPoints: withoutNodes,
  },
};

/** Moves points by f(x, y, i). */
function moveEach(cage, points, f, from) {
  const moved = from.slice();
  for (const i of points) putPoint(moved, i, f(...pointAt(from, i), i));
  return moved;
}

// ---- lattices ----

function refuseToEdit() { throw new Error('To add or remove points of a lattice, change its columns and rows'); }
const countsOf = cage => cage.axes.map(({ points }) => points);
/** Returns the rows of a lattice, then its columns, each as a list of points. */
function linesOf(cage) {
  const [u, v] = countsOf(cage);
  return [...allOf(v).map(j => allOf(u).map(i => i + u * j)), ...allOf(u).map(i => allOf(v).map(j => i + u * j))];
}
/** Tests whether a point is in a frozen layer. */
function isFrozen(cage, i) {
  const [u, v] = countsOf(cage), { frozen } = cage, isOuter = (at, count) => at < frozen || at + frozen >= count;
  return frozen > 0 && (isOuter(i % u, u) || isOuter(Math.floor(i / u), v));
}
const diagonalOf = frame => Math.hypot(...frame.slice(2));
const degreeOf = (word, points) => word === 'bernstein' ? points - 1 : Math.min(Number(word), points - 1);
/** Returns the axes of a lattice with the given numbers of columns and rows. */
const axesOf = (counts, word) => counts.map(points => ({ points, degree: degreeOf(word, points) }));
/** Returns the value of the degree field; '' if the axes have knots or different degrees. */
function degreeWord({ axes }) {
  return ['3', '2', '1', 'bernstein'].find(word => axes.every(({ points, degree, knots }) => !knots && degree === degreeOf(word, points))) ?? '';
}
/** Returns origin and edges of an axis-parallel box around segments (ax, ay, bx, by, radius each), with the programs' margin. */
function boxAround(segments) {
  const corners = allOf(segments.length / 5).flatMap(i => {
    const [ax, ay, bx, by, r] = segments.slice(5 * i, 5 * i + 5);
    return [[ax - r, ay - r], [ax + r, ay + r], [bx - r, by - r], [bx + r, by + r]];
  });
  const [x0, y0, x1, y1] = boundsOf(corners), diagonal = Math.hypot(x1 - x0, y1 - y0);
  const wider = side => (side < 1e-3 * diagonal ? 0.021 : 0.02) * diagonal, [u, v] = [x1 - x0, y1 - y0].map(side => side + 2 * wider(side));
  return [x0 - wider(x1 - x0), y0 - wider(y1 - y0), u, 0, 0, v];
}
/** Returns, for each point of a finer or coarser lattice, its weights with respect to the points of this lattice. */
function latticeRows(engine, cage, rest) {
  engine.makeCoordinates('splines', cage);
  engine.bind('splines', 1, rest);
  const rows = allOf(rest.length / 2).map(() => []);
  for (let v = 0; 2 * v < cage.rest.length; ++v) engine.weights('splines', 1, v).forEach((w, i) => { if (w !== 0) rows[i].push([v, w]); });
  return rows;
}
/** Returns the row or the column through a vertex, whichever is more perpendicular to the motion of the pointer. */
function lineAcross(cage, pose, vertex, from, to) {
  const move = [to[0] - from[0], to[1] - from[1]];
  const across = line => {
    const at = line.indexOf(vertex), p = pointAt(pose, line[Math.max(0, at - 1)]), q = pointAt(pose, line[Math.min(line.length - 1, at + 1)]);
    return Math.abs((q[0] - p[0]) * move[1] - (q[1] - p[1]) * move[0]) / (distance(p, q) || 1);
  };
  const [row, column] = linesOf(cage).filter(line => line.includes(vertex));
  return across(row) >= across(column) ? row : column;
}
/** Returns the row or column near a place, null if there is none. */
function lineNear(cage, pose, place, reach) {
  let best = null, least = reach;
  for (const line of linesOf(cage)) {
    for (let k = 0; k + 1 < line.length; ++k) {
      const d = distanceToSide(pointAt(pose, line[k]), pointAt(pose, line[k + 1]), place, 0).gap;
      if (d < least) { least = d; best = line; }
    }
  }
  return best;
}

// ---- curves ----

const CURVE_STEPS = 16; // segments per curve, where a polygon is needed
const THIRDS = 1e-9;    // relative to the size: control points this near to the thirds of an edge are those of a line

/** Calls f(edge, index) for every edge, given by its four points: end, tangents, end. */
function forEachCurve(loops, f) {
  let begin = 0;
  for (const size of loops) {
    for (let k = 0; k < size; k += 3) f([begin + k, begin + k + 1, begin + k + 2, begin + (k + 3) % size], (begin + k) / 3);
    begin += size;
  }
}
/** Returns the points of the edge that begins with a given end or has a given tangent. */
function edgeOf(loops, point) {
  const { begin, loop } = loopOf(loops, point), first = point - point % 3;
  return [first, first + 1, first + 2, begin + (first + 3 - begin) % loops[loop]];
}
function edgeBefore(loops, node) {
  const { begin, loop } = loopOf(loops, node);
  return edgeOf(loops, node === begin ? begin + loops[loop] - 3 : node - 3);
}
/** Returns the control points of the parts before and after t (de Casteljau). */
function splitCurve(points, t) {
  const before = [points[0]], after = [points[points.length - 1]];
  for (let level = points; level.length > 1;) {
    level = level.slice(1).map((p, k) => between(level[k], p, t));
    before.push(level[0]);
    after.unshift(level[level.length - 1]);
  }
  return [before, after];
}
const pointOfCurve = (points, t) => splitCurve(points, t)[0][points.length - 1];
const thirdsOf = (a, d) => [between(a, d, 1 / 3), between(a, d, 2 / 3)];
function isLine([a, b, c, d], tolerance) {
  const [p, q] = thirdsOf(a, d);
  return distance(b, p) <= tolerance && distance(c, q) <= tolerance;
}
function sizeOf(points) {
  const [x0, y0, x1, y1] = boundsOf(pairs(points));
  return Math.hypot(x1 - x0, y1 - y0);
}
/** Returns the edges at rest with their lowest degree; unchanged quadratics keep their control point. */
function curvesOf({ curves, loops, rest }) {
  const tolerance = THIRDS * sizeOf(rest), old = curves.flat(), all = [];
  forEachCurve(loops, (edge, e) => {
    const [a, b, c, d] = edge.map(i => pointAt(rest, i)), middle = old[e].length === 3 ? old[e][1] : null;
    const p = between(a, b, 1.5), q = between(d, c, 1.5); // the control point of a quadratic, computed from each tangent
    if (isLine([a, b, c, d], tolerance)) all.push([a, d]);
    else if (middle && distance(p, q) <= tolerance) all.push([a, distance(p, middle) <= tolerance ? middle : p, d]);
    else all.push([a, b, c, d]);
  });
  return loops.map(size => all.splice(0, size / 3));
}
/** Returns centre and radius of the disk of a curved cage, concentric with the smallest disk around its points; radius 0: none. */
function diskOf({ curves, disk }) {
  if (!disk) return [0, 0, 0];
  const margin = 1e-6; // keeps all points off the circle
  const [x, y, radius] = smallestDisk(curves.flat().flatMap(edge => cubicOf(edge).slice(1)));
  return [x, y, (1 + margin) * radius / disk];
}
/** Returns centre and radius of the smallest disk around points (Welzl 1991, point by point). */
function smallestDisk(points) {
  const holds = ([x, y, r], p) => distance([x, y], p) <= r * (1 + 1e-12);
  const onTwo = (p, q) => [...between(p, q, 0.5), distance(p, q) / 2];
  const onThree = (p, q, r) => {
    const [bx, by, cx, cy] = [q[0] - p[0], q[1] - p[1], r[0] - p[0], r[1] - p[1]], twice = 2 * (bx * cy - by * cx);
    const [b2, c2] = [bx * bx + by * by, cx * cx + cy * cy], [x, y] = [(cy * b2 - by * c2) / twice, (bx * c2 - cx * b2) / twice];
    return Number.isFinite(x + y) ? [p[0] + x, p[1] + y, Math.hypot(x, y)]
      : [onTwo(p, q), onTwo(q, r), onTwo(r, p)].reduce((a, b) => a[2] > b[2] ? a : b);
  };
  let disk = [...points[0], 0];
  points.forEach((p, i) => {
    if (holds(disk, p)) return;
    disk = onTwo(p, points[0]);
    for (let j = 1; j < i; ++j) {
      if (holds(disk, points[j])) continue;
      disk = onTwo(p, points[j]);
      for (let k = 0; k < j; ++k) if (!holds(disk, points[k])) disk = onThree(p, points[j], points[k]);
    }
  });
  return disk;
}
/** Returns a curved cage with the edges of a polygon, and the rows that map the polygon's points to its points. */
function curvesOfPolygon({ loops, rest }) {
  const edges = [], rows = [];
  forEachEdge(loops, (i, j) => {
    edges.push([pointAt(rest, i), pointAt(rest, j)]);
    rows.push([[i, 1]], [[i, 2 / 3], [j, 1 / 3]], [[i, 1 / 3], [j, 2 / 3]]);
  });
  return { cage: { kind: 'curved', curves: loops.map(size => edges.splice(0, size)), disk: 0 }, rows };
}

function curvesPath({ loops }, places) {
  let path = '';
  forEachCurve(loops, ([a, b, c, d]) => {
    if (loopOf(loops, a).begin === a) path += 'M' + pointAt(places, a).join(' ');
    path += 'C' + [b, c, d].flatMap(i => pointAt(places, i)).join(' ');
    if (d !== a + 3) path += 'Z';
  });
  return path;
}

/** Returns a test of whether a point is shown: all ends, and tangents of edges that are bent or have a selected point. */
function shownOfCurves({ loops }, places, selection) {
  const tolerance = THIRDS * sizeOf(places), isShown = allOf(places.length / 2).map(i => i % 3 === 0);
  forEachCurve(loops, edge => {
    if (edge.some(i => selection.has(i)) || !isLine(edge.map(i => pointAt(places, i)), tolerance)) isShown[edge[1]] = isShown[edge[2]] = true;
  });
  return i => isShown[i];
}
/** Returns the thin lines from shown tangents to their ends. */
function tangentLines(cage, places, isShown) {
  let path = '';
  forEachCurve(cage.loops, edge => {
    const [a, b, c, d] = edge.map(i => pointAt(places, i).join(' '));
    if (isShown(edge[1])) path += `M${a}L${b}M${d}L${c}`;
  });
  return path;
}
/** Tests whether the tangents of a node are collinear at rest, within a degree. */
function isSmooth({ rest }, before, node, after) {
  const [p, q, r] = [before, node, after].map(i => pointAt(rest, i)), u = [q[0] - p[0], q[1] - p[1]], v = [r[0] - q[0], r[1] - q[1]];
  return Math.hypot(...u) * Math.hypot(...v) > 0 && Math.abs(Math.atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])) <= Math.PI / 180;
}
/** Moves points by f(x, y, i). An end also moves its tangents, but lines stay lines. A tangent of a smooth node rotates the other
 *  one, unless `isBroken`. */
function moveCurves(cage, selection, f, from, isBroken = false) {
  const moved = from.slice(), chosen = new Set(selection), tolerance = THIRDS * sizeOf(from);
  const move = i => putPoint(moved, i, f(...pointAt(from, i), i));
  chosen.forEach(move);
  forEachCurve(cage.loops, ([a, b, c, d]) => {
    const isFree = !chosen.has(b) && !chosen.has(c);
    if (isFree && isLine([a, b, c, d].map(i => pointAt(from, i)), tolerance)) {
      if (chosen.has(a) || chosen.has(d)) thirdsOf(pointAt(moved, a), pointAt(moved, d)).forEach((p, k) => putPoint(moved, k === 0 ? b : c, p));
    } else {
      if (chosen.has(a) && !chosen.has(b)) move(b);
      if (chosen.has(d) && !chosen.has(c)) move(c);
    }
  });
  if (isBroken) return moved;
  forEachCurve(cage.loops, ([node, after]) => {
    const before = edgeBefore(cage.loops, node)[2];
    if (chosen.has(node) || chosen.has(before) === chosen.has(after) || !isSmooth(cage, before, node, after)) return;
    const [own, other] = chosen.has(before) ? [before, after] : [after, before];
    const p = pointAt(moved, node), q = pointAt(moved, own), length = distance(p, q);
    if (length > 0) putPoint(moved, other, between(p, q, -distance(p, pointAt(from, other)) / length));
  });
  return moved;
}

/** Returns the edge nearest to a place, by its first end and the parameter on it; null if none is within reach. */
function nearestCurve(cage, pose, place, reach) {
  let best = null, least = reach;
  forEachCurve(cage.loops, edge => {
    const points = edge.map(i => pointAt(pose, i)), steps = 64;
    for (let k = 0; k < steps; ++k) {
      const { gap, share } = distanceToSide(pointOfCurve(points, k / steps), pointOfCurve(points, (k + 1) / steps), place, 0);
      if (gap < least) { least = gap; best = { vertex: edge[0], share: Math.max(0.1, Math.min(0.9, (k + share) / steps)) }; }
    }
  });
  return best;
}
/** Divides an edge without moving anything, at rest or posed. */
function withNode(cage, vertex, t) {
  const [a, b, c, d] = edgeOf(cage.loops, vertex), { begin, loop } = loopOf(cage.loops, a), s = 1 - t;
  const rows = sameRows(cage.rest.length / 2);
  rows.splice(b, 2, [[a, s], [b, t]], [[a, s * s], [b, 2 * s * t], [c, t * t]], [[a, s ** 3], [b, 3 * s * s * t], [c, 3 * s * t * t], [d, t ** 3]],
              [[b, s * s], [c, 2 * s * t], [d, t * t]], [[c, s], [d, t]]);
  const curves = cage.curves.map((edges, k) => k !== loop ? edges
    : edges.flatMap((edge, e) => begin + 3 * e === a ? splitCurve(edge, t) : [edge]));
  return { cage: { ...cage, curves }, rows, chosen: a + 3 };
}
/** Joins the edges at nodes and keeps the outer tangents. Two lines become a line. */
function withoutNodes(cage, pose, gone) {
  const nodes = [...gone].filter(i => i % 3 === 0);
  if (nodes.length === 0) throw new Error('Select ends of curves (squares) to delete them');
  let next = { cage, pose, rows: sameRows(cage.rest.length / 2) };
  for (const node of nodes.sort((a, b) => b - a)) next = withoutNode(next, node); // from the last one, so that indices stay valid
  return next;
}
function withoutNode({ cage, pose, rows }, node) {
  const { loop, begin } = loopOf(cage.loops, node), size = cage.loops[loop], isFirst = node === begin;
  if (size < 9) throw new Error('A loop needs at least two curves');
  const before = edgeBefore(cage.loops, node), after = edgeOf(cage.loops, node), edges = [...cage.curves[loop]], tolerance = THIRDS * sizeOf(pose);
  const [one, other] = [before, after].map(([a]) => edges[(a - begin) / 3]), areLines = one.length === 2 && other.length === 2;
  const joined = areLines ? [one[0], other[1]] : [one[0], cubicOf(one)[1], cubicOf(other)[2], other[other.length - 1]];
  [rows, pose] = [[...rows], pairs(pose)];
  if (areLines && [before, after].every(edge => isLine(edge.map(i => pose[i]), tolerance))) {
    const [a, d] = [before[0], after[3]], mixed = t => [...rows[a].map(([i, w]) => [i, (1 - t) * w]), ...rows[d].map(([i, w]) => [i, t * w])];
    [rows[before[1]], rows[after[2]]] = [mixed(1 / 3), mixed(2 / 3)];
    [pose[before[1]], pose[after[2]]] = thirdsOf(pose[a], pose[d]);
  }
  if (isFirst) { // the loop then begins at the next end
    edges.pop();
    edges.shift();
    edges.push(joined);
  } else {
    edges.splice((before[0] - begin) / 3, 2, joined);
  }
  for (const list of [rows, pose]) {
    const own = list.splice(begin, size).filter((x, k) => ![before[2], node, after[1]].includes(begin + k));
    if (isFirst) own.push(own.shift());
    list.splice(begin, 0, ...own);
  }
  const replaced = { ...cage, curves: cage.curves.map((each, k) => k === loop ? edges : each), loops: cage.loops.map((n, k) => n - (k === loop ? 3 : 0)) };
  return { cage: replaced, pose: Float64Array.from(pose.flat()), rows };
}
const cubicOf = edge => edge.length === 2 ? [edge[0], ...thirdsOf(...edge), edge[1]]
  : edge.length === 3 ? [edge[0], between(edge[0], edge[1], 2 / 3), between(edge[2], edge[1], 2 / 3), edge[2]] : edge;
