// A figure: an SVG document, and the points of its shapes that are bound to a cage.
//
// Every segment of a shape is cut into pieces. The ends of each piece and the points at one and two thirds are bound. After
// the move, the cubic through these four points replaces the piece, so lines bend and curves stay smooth.

const NOT_DRAWN = 'defs,clipPath,mask,pattern,marker,symbol,filter,linearGradient,radialGradient';
const MOST_POINTS = 400000;  // per figure; with more, a frame takes seconds
const MANY_POINTS = 60000;  // with more, pieces get longer

function svgElement(name, attributes = {}, parent = null) {
  const element = document.createElementNS(SVG_NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent?.append(element);
  return element;
}

/** Returns the shadow tree of an element. Resets the inherited styles of the page, so that a drawing has only its own. */
function closedTree(host) {
  host.classList.add('closed');
  for (const name of document.styleSheets[0].cssRules[0].style) if (name.startsWith('--')) host.style.setProperty(name, 'initial'); // the page's own variables
  return host.shadowRoot ?? host.attachShadow({ mode: 'open' });
}

/** Copies attributes and style, except some attributes. The style is set by script, which the page's policy allows. */
function copyLook(from, to, left) {
  for (const { name, namespaceURI, value } of from.attributes) if (name !== 'style' && !left.test(name)) to.setAttributeNS(namespaceURI, name, value);
  to.style.cssText = from.style.cssText;
}

/** Replaces `use` elements by copies of their targets, which readSafeSvg() has counted. */
function expandUses(root, trees) {
  for (let uses = drawnUses(root); uses.length > 0; uses = drawnUses(root)) {
    for (const use of uses) {
      const target = trees.get(use.getAttribute('href')?.slice(1))?.firstElementChild;
      const group = svgElement('g');
      copyLook(use, group, /^(x|y|width|height|href)$/);
      const x = lengthOf(use, 'x'), y = lengthOf(use, 'y');
      if (x !== 0 || y !== 0) group.setAttribute('transform', `${use.getAttribute('transform') ?? ''} translate(${x} ${y})`);
      if (target) group.append(usedCopy(use, target));
      use.replaceWith(group);
    }
  }
}
const drawnUses = root => [...root.querySelectorAll('use')].filter(use => !use.closest(NOT_DRAWN));
/** Returns a copy of the target of a `use`; a symbol becomes a nested svg with the size given by the `use`. */
function usedCopy(use, target) {
  if (target.localName !== 'symbol' && target.localName !== 'svg') return document.importNode(target, true);
  const copy = svgElement('svg', { overflow: 'visible' });
  copyLook(target, copy, /^overflow$/);
  for (const name of ['width', 'height']) if (use.hasAttribute(name)) copy.setAttribute(name, use.getAttribute(name));
  copy.append(...document.importNode(target, true).childNodes);
  return copy;
}

/** Returns the map from an element's coordinates to the document's, as [a, b, c, d, e, f]. */
function mapToRoot(root, element) {
  const m = root.getScreenCTM().inverse().multiply(element.getScreenCTM());
  const map = [m.a, m.b, m.c, m.d, m.e, m.f];
  const isIdentity = map.every((x, k) => Math.abs(x - [1, 0, 0, 1, 0, 0][k]) < (k < 4 ? 1e-12 : 1e-9));
  return isIdentity ? [1, 0, 0, 1, 0, 0] : map;
}
const mapped = ([a, b, c, d, e, f], [x, y]) => [a * x + c * y + e, b * x + d * y + f];
function inverted([a, b, c, d, e, f]) {
  const det = a * d - b * c;
  return [d / det, -b / det, -c / det, a / det, (c * f - d * e) / det, (b * e - a * f) / det];
}
/** Returns the largest stretch of a map: its larger singular value. */
function largestScale([a, b, c, d]) {
  const sum = a * a + b * b + c * c + d * d, det = a * d - b * c;
  return Math.sqrt((sum + Math.sqrt(Math.max(0, sum * sum - 4 * det * det))) / 2);
}

const cubicAt = (p, s, t) => {
  const u = 1 - t, [w0, w1, w2, w3] = [u * u * u, 3 * u * u * t, 3 * u * t * t, t * t * t];
  return [0, 1].map(k => w0 * p[k] + w1 * s.c1[k] + w2 * s.c2[k] + w3 * s.to[k]);
};
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

class Figure {
  /** Reads the text of an SVG document; throws a message if it is not SVG or draws nothing. */
  constructor(text, name) {
    const { root, css, trees } = readSafeSvg(text, name);
    this.name = name;
    this.css = css;
    this.sheet = sheetOf(css); // for the shadow trees that the figure is shown in
    this.root = document.importNode(root, true);
    const shadow = closedTree(document.getElementById('stage'));
    shadow.adoptedStyleSheets = [this.sheet];
    shadow.replaceChildren(this.root);
    try {
      expandUses(this.root, trees);
      this.readShapes();
    } finally {
      shadow.replaceChildren();
    }
    if (this.points.length === 0) throw new Error(name + ' draws nothing that a cage can enclose');
  }

  readShapes() {
    const groups = new Map(), drawn = [...this.root.querySelectorAll(SHAPES + ',text,image')].filter(e => !e.closest(NOT_DRAWN) && isShown(e, groups));
    const shapes = drawn.map(element => this.readShape(element)).filter(shape => shape !== null);
    this.box = boundsOf(shapes.flatMap(shape => shape.corners));
    if (shapes.length > 0 && !this.box.every(x => Math.abs(x) < 1e15)) throw new Error(this.name + ' has coordinates out of range');
    const size = Math.hypot(this.box[2] - this.box[0], this.box[3] - this.box[1]);
    const points = [];
    this.decimals = Math.max(0, 5 - Math.floor(Math.log10(size || 1)));
    const step = stepOf(shapes, size / 40, this.name);
    this.shapes = shapes.map(shape => shape.outline ? bindOutline(shape, points, step) : bindBox(shape, points));
    this.points = new Float64Array(points.flat());
    this.size = size;
    this.gradients = this.shapes.flatMap((shape, index) => userSpaceGradients(this.root, shape, index));
    this.filters = filtersOf(this.root, this.shapes);
  }

  /** Returns a shape's outline in the document's coordinates, with its stroke; for text and images, the box. */
  readShape(element) {
    const map = mapToRoot(this.root, element), style = getComputedStyle(element);
    if (element.localName === 'text' || element.localName === 'image') {
      const { x, y, width, height } = element.getBBox();
      const corners = [[x, y], [x + width, y], [x, y + height], [x + width, y + height]];
      return width > 0 && height > 0 ? { element, map, corners: corners.map(p => mapped(map, p)) } : null;
    }
    const toRoot = p => mapped(map, p);
    const outline = outlineOf(element).map(({ start, segments, closed }) => ({
      start: toRoot(start), closed,
      segments: segments.map(s => ({ line: s.line, c1: toRoot(s.c1), c2: toRoot(s.c2), to: toRoot(s.to) })),
    })).filter(({ segments }) => segments.length > 0);
    if (outline.length === 0) return null;
    const stroked = style.stroke !== 'none';
    return {
      element, map, outline, filled: style.fill !== 'none', stroked,
      radius: stroked ? parseFloat(style.strokeWidth) / 2 * largestScale(map) : 0,
      miter: style.strokeLinejoin === 'miter' ? parseFloat(style.strokeMiterlimit) : 0,
      square: style.strokeLinecap === 'square',
      marker: style.markerMid,
      paint: { fill: style.fill, stroke: style.stroke },
      corners: outline.flatMap(({ start, segments }) => [start, ...segments.map(s => s.to)]),
    };
  }

  /** Returns the drawing as segments with radii (ax, ay, bx, by, radius), for make_cage. */
  drawnSegments() {
    const segments = [], tolerance = 5e-4 * this.size;
    for (const shape of this.shapes) {
      if (!shape.outline) {
        const [a, b, c, d] = shape.corners;
        for (const [p, q] of [[a, b], [b, d], [d, c], [c, a]]) segments.push(...p, ...q, 0);
        continue;
      }
      for (const subpath of shape.outline) drawSubpath(shape, subpath, tolerance, segments);
    }
    return segments;
  }

  /** Returns a copy of the document whose shapes are paths, which write() moves. */
  makeCopy() {
    const copy = this.root.cloneNode(true);
    const originals = [...this.root.querySelectorAll('*')], copies = [...copy.querySelectorAll('*')];
    const twin = new Map(originals.map((element, i) => [element, copies[i]]));
    const targets = this.shapes.map(shape => {
      const element = twin.get(shape.element);
      if (!shape.outline || element.localName === 'path') return element;
      const path = svgElement('path');
      const geometry = /^(x|y|width|height|rx|ry|cx|cy|r|x1|y1|x2|y2|points)$/;
      copyLook(element, path, geometry);
      path.append(...element.childNodes);
      element.replaceWith(path);
      return path;
    });
    const gradients = this.gradients.map(({ element, index, paint, base }) => {
      const own = twin.get(element).cloneNode(true);
      own.id = `${element.id}-${index}-${paint}`;
      twin.get(element).after(own);
      targets[index].style.setProperty(paint, `url("#${own.id}")`, 'important');
      return { own, shape: this.shapes[index], base };
    });
    const marks = this.shapes.map((shape, i) => shape.outline && shape.marker !== 'none' ? markVertices(shape, targets[i]) : null);
    const filters = this.filters.filter(({ region }) => region).map(filter => ({ ...filter, own: twin.get(filter.region) }));
    return { root: copy, targets, gradients, marks, filters };
  }

  /** Writes moved points into a copy. */
  write(copy, places) {
    this.shapes.forEach((shape, i) => {
      if (shape.outline) copy.targets[i].setAttribute('d', pathData(shape, places, this.decimals));
      else copy.targets[i].setAttribute('transform', `${shape.transform} matrix(${boxMap(shape, places).join(' ')})`);
      copy.marks[i]?.setAttribute('d', vertexData(shape, places, this.decimals));
    });
    for (const gradient of copy.gradients) gradient.own.setAttribute('gradientTransform', `matrix(${this.gradientMap(gradient, places).join(' ')})`);
    for (const filter of copy.filters) growRegion(filter, places);
  }
  gradientMap({ shape, base }, places) {
    return product(product(shape.back, product(affineFit(shape, this.points, places), shape.map)), base);
  }
}

/** Tests whether an element is visible; `known` caches this for groups. */
function isShown(element, known) {
  const style = getComputedStyle(element);
  const isVisible = e => {
    if (!(e instanceof SVGElement)) return true;
    if (!known.has(e)) {
      const { display, opacity } = getComputedStyle(e);
      known.set(e, display !== 'none' && parseFloat(opacity) !== 0 && isVisible(e.parentNode));
    }
    return known.get(e);
  };
  const isPainted = /^(text|image)$/.test(element.localName) || style.fill !== 'none' || style.stroke !== 'none';
  return isPainted && isVisible(element);
}

/** Returns the gradients in user space that paint a shape. They follow the affine map that fits its motion best. */
function userSpaceGradients(root, shape, index) {
  if (!shape.outline) return [];
  return ['fill', 'stroke'].flatMap(paint => {
    const id = /^url\("?#([^")]*)"?\)/.exec(shape.paint[paint])?.[1];
    const element = id && root.querySelector('#' + CSS.escape(id));
    if (!element || !/^(linear|radial)Gradient$/.test(element.localName)) return [];
    const inherited = name => { // attributes are inherited from referenced gradients
      for (let e = element, hops = 0; e && hops < 8; ++hops) {
        if (e.hasAttribute(name)) return e;
        const to = (e.getAttribute('href') ?? '').slice(1);
        e = to && root.querySelector('#' + CSS.escape(to));
      }
      return null;
    };
    if (inherited('gradientUnits')?.getAttribute('gradientUnits') !== 'userSpaceOnUse') return [];
    const m = inherited('gradientTransform')?.gradientTransform.baseVal.consolidate()?.matrix;
    return [{ element, index, paint, base: m ? [m.a, m.b, m.c, m.d, m.e, m.f] : [1, 0, 0, 1, 0, 0] }];
  });
}
/** Returns the affine map that fits the motion of a shape's points best; for lines it preserves lengths across the line. */
function affineFit(shape, rest, places) {
  const begin = 2 * shape.begin, end = begin + 2 * shape.pieces.reduce((sum, n) => sum + 3 * n + 1, 0), count = (end - begin) / 2;
  const mean = points => [0, 1].map(axis => { let sum = 0; for (let k = begin + axis; k < end; k += 2) sum += points[k]; return sum / count; });
  const [px, py] = mean(rest), [qx, qy] = mean(places);
  let [xx, xy, yy, ux, uy, vx, vy] = [0, 0, 0, 0, 0, 0, 0];
  for (let k = begin; k < end; k += 2) {
    const x = rest[k] - px, y = rest[k + 1] - py, u = places[k] - qx, v = places[k + 1] - qy;
    xx += x * x; xy += x * y; yy += y * y; ux += u * x; uy += u * y; vx += v * x; vy += v * y;
  }
  const least = 1e-6 * (xx + yy) || 1;
  xx += least; yy += least; ux += least; vy += least;
  const det = xx * yy - xy * xy;
  const [a, c, b, d] = [(ux * yy - uy * xy) / det, (uy * xx - ux * xy) / det, (vx * yy - vy * xy) / det, (vy * xx - vx * xy) / det];
  return [a, b, c, d, qx - a * px - c * py, qy - b * px - d * py];
}

function boundsOf(points) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const [x, y] of points) {
    box[0] = Math.min(box[0], x); box[1] = Math.min(box[1], y);
    box[2] = Math.max(box[2], x); box[3] = Math.max(box[3], y);
  }
  return box;
}

const polygonLength = (from, { c1, c2, to }) => distance(from, c1) + distance(c1, c2) + distance(c2, to);
const pieceCount = (length, step) => Math.min(400, Math.max(1, Math.ceil(length / step)));
/** Returns the maximum length of pieces, larger for figures with many pieces. Throws if even whole segments are too many. */
function stepOf(shapes, step, name) {
  const lengths = shapes.flatMap(({ outline }) => outline ?? []).flatMap(({ start, segments }) =>
    segments.map((segment, k) => polygonLength(k === 0 ? start : segments[k - 1].to, segment)));
  if (3 * lengths.length > MOST_POINTS) throw new Error(name + ' has too many points for this page');
  const count = () => lengths.reduce((sum, length) => sum + 3 * pieceCount(length, step), 0);
  for (let k = 0; k < 10 && count() > MANY_POINTS; ++k) step *= 2;
  return step;
}

/** Appends the points of a shape's pieces, no longer than `step`, to `points`. */
function bindOutline(shape, points, step) {
  const begin = points.length;
  const counts = shape.outline.map(({ start, segments }) => {
    points.push(start);
    let from = start;
    const each = [];
    for (const segment of segments) {
      const n = pieceCount(polygonLength(from, segment), step);
      for (let k = 1; k <= 3 * n; ++k) points.push(k === 3 * n ? segment.to : cubicAt(from, segment, k / (3 * n)));
      each.push(n);
      from = segment.to;
    }
    return each;
  });
  const pieces = counts.map(each => each.reduce((sum, n) => sum + n, 0));
  return { ...shape, begin, counts, pieces, back: inverted(shape.map) };
}

/** Text and images are moved by the affine map that fits their box's corners. */
function bindBox(shape, points) {
  const begin = points.length;
  points.push(...shape.corners);
  return { ...shape, begin, back: inverted(shape.map), transform: shape.element.getAttribute('transform') ?? '' };
}

/** Returns control points and end of the cubic through the four points from index `at`, along one axis. */
const controlsAt = (of, at) => {
  const p = of(at), q = of(at + 1), r = of(at + 2), s = of(at + 3);
  return [(-5 * p + 18 * q - 9 * r + 2 * s) / 6, (2 * p - 9 * q + 18 * r - 5 * s) / 6, s];
};
function pathData(shape, places, decimals) {
  return writePath(shape, places, decimals, shape.counts.map(each => each.flatMap(n => Array(n).fill(1))));
}
/** Returns the path with one segment for each of the original path, so that markers are drawn at its vertices only. */
function vertexData(shape, places, decimals) { return writePath(shape, places, decimals, shape.counts); }
function writePath(shape, places, decimals, counts) {
  const [a, b, c, d, e, f] = shape.back;
  const x = i => (a * places[2 * i] + c * places[2 * i + 1] + e), y = i => (b * places[2 * i] + d * places[2 * i + 1] + f);
  const scale = 10 ** decimals, short = n => Math.round(n * scale) / scale;
  const data = [];
  let at = shape.begin;
  counts.forEach((each, k) => {
    data.push('M', short(x(at)), short(y(at)));
    for (const n of each) { // its start tangent is that of the first piece, its end tangent that of the last
      const [first, last] = [at, at + 3 * (n - 1)], xs = controlsAt(x, last), ys = controlsAt(y, last);
      data.push('C', short(controlsAt(x, first)[0]), short(controlsAt(y, first)[0]), short(xs[1]), short(ys[1]), short(xs[2]), short(ys[2]));
      at += 3 * n;
    }
    ++at;
    if (shape.outline[k].closed) data.push('Z');
  });
  return data.join(' ');
}

/** Returns a path over a shape that draws the markers at its vertices; the shape itself draws none. */
function markVertices(shape, target) {
  const path = target.cloneNode(false);
  path.removeAttribute('id');
  for (const [name, value] of [['marker-start', 'none'], ['marker-mid', shape.marker], ['marker-end', 'none'],
    ['fill-opacity', '0'], ['stroke-opacity', '0']]) path.style.setProperty(name, value, 'important');
  target.style.setProperty('marker-mid', 'none', 'important');
  target.after(path);
  return path;
}

/** Returns the filtered elements as { element, reach, map, back, inside, region }. `reach` is the distance, in the element's units,
 *  by which a filter extends the drawing. `inside` are the shapes of the element. `region` is a filter in user space, or null. */
function filtersOf(root, shapes) {
  return [...root.querySelectorAll('*')].flatMap(element => {
    const value = element.closest(NOT_DRAWN) ? 'none' : getComputedStyle(element).filter;
    if (!value || value === 'none') return [];
    const id = referenced(value)[0], filter = id && root.querySelector('#' + CSS.escape(id)), map = mapToRoot(root, element);
    const inside = shapes.filter(shape => element.contains(shape.element));
    if (inside.length === 0) return [];
    const region = filter?.getAttribute('filterUnits') === 'userSpaceOnUse' ? filter : null;
    const rest = region && ['x', 'y', 'width', 'height'].map(name => region[name].baseVal.value);
    const reach = filter ? [...filter.children].reduce((sum, primitive) => sum + reachOf(primitive), 0) : 3 * Math.max(0, ...numbersIn(value));
    return [{ element, reach, map, back: inverted(map), inside, region, rest: rest && [rest[0], rest[1], rest[0] + rest[2], rest[1] + rest[3]] }];
  });
}
function reachOf(primitive) {
  const most = (...names) => Math.max(0, ...names.flatMap(name => numbersIn(primitive.getAttribute(name) ?? '').map(Math.abs)));
  return 3 * most('stdDeviation') + most('dx', 'dy') + most('radius') + (primitive.localName === 'feDisplacementMap' ? most('scale') / 2 : 0);
}
/** Enlarges a region in user space so that it contains the moved element as it contained the element at rest. */
function growRegion({ own, inside, back, reach, rest }, places) {
  const corners = inside.flatMap(shape => {
    const end = shape.begin + (shape.outline ? shape.pieces.reduce((sum, n) => sum + 3 * n + 1, 0) : 4), r = shape.radius ?? 0;
    const [x0, y0, x1, y1] = boundsOf(pairs(places.subarray(2 * shape.begin, 2 * end)));
    return [[x0 - r, y0 - r], [x1 + r, y0 - r], [x0 - r, y1 + r], [x1 + r, y1 + r]].map(p => mapped(back, p));
  });
  const [x0, y0, x1, y1] = boundsOf(corners);
  const box = boundsOf([[rest[0], rest[1]], [rest[2], rest[3]], [x0 - reach, y0 - reach], [x1 + reach, y1 + reach]]);
  for (const [name, value] of [['x', box[0]], ['y', box[1]], ['width', box[2] - box[0]], ['height', box[3] - box[1]]]) own.setAttribute(name, value);
}

/** Returns the affine map that fits the motion of a box's corners best, applied after the element's own transform. */
function boxMap(shape, places) {
  const p = k => [places[2 * (shape.begin + k)], places[2 * (shape.begin + k) + 1]], r = shape.corners;
  const half = (i, j, k, l, of) => [0, 1].map(n => (of(i)[n] - of(j)[n] + of(k)[n] - of(l)[n]) / 2);
  const middle = of => [0, 1].map(n => (of(0)[n] + of(1)[n] + of(2)[n] + of(3)[n]) / 4), rest = k => r[k];
  const [u0, v0, m0] = [half(1, 0, 3, 2, rest), half(2, 0, 3, 1, rest), middle(rest)];
  const [u, v, m] = [half(1, 0, 3, 2, p), half(2, 0, 3, 1, p), middle(p)];
  const back = inverted([...u0, ...v0, ...m0]), now = [...u, ...v, ...m];
  const moved = product(now, back);                         // in document coordinates
  return product(shape.back, product(moved, shape.map)); // in element coordinates
}
function product([a, b, c, d, e, f], [g, h, i, j, k, l]) {
  return [a * g + c * h, b * g + d * h, a * i + c * j, b * i + d * j, a * k + c * l + e, b * k + d * l + f];
}

/** Returns the segments of a subpath's outline, with its stroke's mitres and square caps. */
function drawSubpath(shape, { start, segments: curves, closed }, tolerance, segments) {
  const points = [start], corner = [true];
  for (const s of curves) {
    const from = points[points.length - 1];
    const bend = Math.hypot(from[0] - 2 * s.c1[0] + s.c2[0], from[1] - 2 * s.c1[1] + s.c2[1]) +
                 Math.hypot(s.c1[0] - 2 * s.c2[0] + s.to[0], s.c1[1] - 2 * s.c2[1] + s.to[1]);
    const n = s.line ? 1 : Math.min(100, Math.ceil(Math.sqrt(bend / tolerance)) + 1);
    for (let k = 1; k <= n; ++k) { points.push(k === n ? s.to : cubicAt(from, s, k / n)); corner.push(k === n); }
  }
  const last = points.length - 1, r = shape.radius + tolerance;
  for (let i = 0; i < last; ++i) segments.push(...points[i], ...points[i + 1], r);
  if (!closed && shape.filled) segments.push(...points[last], ...start, tolerance);
  if (!shape.stroked) return;
  const direction = (p, q) => { const l = distance(p, q) || 1; return [(q[0] - p[0]) / l, (q[1] - p[1]) / l]; };
  for (let i = closed ? 0 : 1; i < last; ++i) {
    const before = points[i === 0 ? last - 1 : i - 1], p = points[i], u = direction(before, p), v = direction(p, points[i + 1]);
    const sine = Math.sqrt(Math.max(0, (1 + u[0] * v[0] + u[1] * v[1]) / 2));
    const out = [u[0] - v[0], u[1] - v[1]], size = Math.hypot(...out);
    if (!corner[i] || size < 1e-6 || sine * shape.miter < 1) continue;
    segments.push(...p, ...p.map((x, k) => x + shape.radius / sine * out[k] / size), 0);
  }
  if (!shape.square || closed) return;
  for (const [end, inner] of [[0, 1], [last, last - 1]]) {
    const u = direction(points[inner], points[end]), p = points[end];
    for (const s of [-1, 1])
      segments.push(...p, p[0] + shape.radius * (u[0] - s * u[1]), p[1] + shape.radius * (u[1] + s * u[0]), 0);
  }
}
