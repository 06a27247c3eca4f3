// Outlines of SVG shapes as subpaths of cubic segments, in the shape's coordinates. Numbers are read from the
// text, because the browser's lists have single precision.

const NUMBERS = /[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?/gi;
const numbersIn = text => (text.match(NUMBERS) ?? []).map(Number);

const between = (a, b, t) => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
const lineSegment = (from, to) => ({ line: true, c1: between(from, to, 1 / 3), c2: between(from, to, 2 / 3), to });

/** Collects subpaths { start, segments: [{ line, c1, c2, to }], closed }; a quadratic segment also has its `control` point. Arcs
 *  become cubics of at most `widest` radians. */
class PathBuilder {
  constructor(widest = Math.PI / 2) { this.subpaths = []; this.at = [0, 0]; this.widest = widest; }
  move(p) { this.current = null; this.at = p; }
  open() {
    if (!this.current) this.subpaths.push(this.current = { start: this.at, segments: [], closed: false });
    return this.current.segments;
  }
  line(p) { this.open().push(lineSegment(this.at, p)); this.at = p; }
  cubic(c1, c2, to) { this.open().push({ line: false, c1, c2, to }); this.at = to; }
  quadratic(c, to) {
    this.cubic(between(this.at, c, 2 / 3), between(to, c, 2 / 3), to);
    this.current.segments.at(-1).control = c;
  }
  close() {
    if (!this.current) return;
    const { start } = this.current;
    if (start[0] !== this.at[0] || start[1] !== this.at[1]) this.line(start);
    this.current.closed = true;
    this.move(start);
  }
  /** Converts an elliptic arc from its end points (SVG 2, appendix B.2.4) to cubics. */
  arc(rx, ry, degrees, large, sweep, to) {
    const [x0, y0] = this.at;
    rx = Math.abs(rx); ry = Math.abs(ry);
    if (rx === 0 || ry === 0) return this.line(to);
    if (x0 === to[0] && y0 === to[1]) return;
    const c = Math.cos(degrees * Math.PI / 180), s = Math.sin(degrees * Math.PI / 180);
    const dx = (x0 - to[0]) / 2, dy = (y0 - to[1]) / 2;
    const x = c * dx + s * dy, y = -s * dx + c * dy;
    const lambda = (x / rx) ** 2 + (y / ry) ** 2, grow = lambda > 1 ? Math.sqrt(lambda) : 1;
    rx *= grow; ry *= grow;
    const root = Math.sqrt(Math.max(0, 1 / Math.max(lambda / grow ** 2, 1e-300) - 1)) * (large === sweep ? -1 : 1);
    const cx = root * rx * y / ry, cy = -root * ry * x / rx;
    const from = Math.atan2((y - cy) / ry, (x - cx) / rx);
    let turn = Math.atan2((-y - cy) / ry, (-x - cx) / rx) - from;
    if (sweep && turn < 0) turn += 2 * Math.PI;
    if (!sweep && turn > 0) turn -= 2 * Math.PI;
    const mx = (x0 + to[0]) / 2, my = (y0 + to[1]) / 2;
    const place = (u, v) => [c * (cx + rx * u) - s * (cy + ry * v) + mx, s * (cx + rx * u) + c * (cy + ry * v) + my];
    const pieces = Math.max(1, Math.ceil(Math.abs(turn) / this.widest - 1e-9)), step = turn / pieces;
    const k = 4 / 3 * Math.tan(step / 4);
    for (let i = 0; i < pieces; ++i) {
      const a = from + i * step, b = a + step;
      this.cubic(place(Math.cos(a) - k * Math.sin(a), Math.sin(a) + k * Math.cos(a)),
                 place(Math.cos(b) + k * Math.sin(b), Math.sin(b) - k * Math.cos(b)),
                 i + 1 < pieces ? place(Math.cos(b), Math.sin(b)) : to);
    }
  }
}

/** Reads the numbers of arcs, whose flags need no separators: "a1 1 0 01.5.5". */
function arcNumbers(text) {
  const numbers = [];
  const token = /[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?/giy;
  for (let at = 0; at < text.length;) {
    const place = numbers.length % 7;
    if (/[\s,]/.test(text[at])) { ++at; continue; }
    if (place === 3 || place === 4) { numbers.push(Number(text[at++])); continue; }
    token.lastIndex = at;
    const found = token.exec(text);
    if (!found) break;
    numbers.push(Number(found[0]));
    at = token.lastIndex;
  }
  return numbers;
}

const COMMAND_SIZE = { m: 2, l: 2, h: 1, v: 1, c: 6, s: 4, q: 4, t: 2, a: 7, z: 0 };

/** Returns the subpaths of a path's data, up to the first error, as SVG requires. */
function parsePath(text, path = new PathBuilder()) {
  let smooth = null, last = ''; // the last control point, for S and T, and its command
  for (const [, letter, rest] of text.matchAll(/([mlhvcsqtaz])([^mlhvcsqtaz]*)/gi)) {
    let kind = letter.toLowerCase();
    const relative = letter === kind, size = COMMAND_SIZE[kind];
    const numbers = kind === 'a' ? arcNumbers(rest) : numbersIn(rest);
    if (kind === 'z') { path.close(); last = ''; continue; }
    for (let i = 0; i + size <= numbers.length; i += size) {
      const [ox, oy] = relative ? path.at : [0, 0];
      const n = numbers.slice(i, i + size), point = k => [n[k] + ox, n[k + 1] + oy];
      const mirrored = after => after.includes(last || '-') ? [2 * path.at[0] - smooth[0], 2 * path.at[1] - smooth[1]] : path.at;
      let control = null;
      if (kind === 'm') { path.move(point(0)); kind = 'l'; }
      else if (kind === 'l') path.line(point(0));
      else if (kind === 'h') path.line([n[0] + ox, path.at[1]]);
      else if (kind === 'v') path.line([path.at[0], n[0] + oy]);
      else if (kind === 'c') { control = point(2); path.cubic(point(0), control, point(4)); }
      else if (kind === 's') { control = point(0); path.cubic(mirrored('cs'), control, point(2)); }
      else if (kind === 'q') { control = point(0); path.quadratic(control, point(2)); }
      else if (kind === 't') { control = mirrored('qt'); path.quadratic(control, point(0)); }
      else if (kind === 'a') path.arc(n[0], n[1], n[2], n[3] !== 0, n[4] !== 0, point(5));
      [smooth, last] = [control, kind];
    }
  }
  return path.subpaths;
}
/** Returns a length of a shape: a number as written, or another length as the browser resolves it. */
function lengthOf(element, name) {
  const text = element.getAttribute(name) ?? '';
  return /^\s*[+-]?[\d.]+(e[+-]?\d+)?(px)?\s*$/i.test(text) ? parseFloat(text) : element[name]?.baseVal?.value ?? 0;
}

function ellipsePath(cx, cy, rx, ry) {
  const path = new PathBuilder();
  if (!(rx > 0 && ry > 0)) return [];
  path.move([cx + rx, cy]);
  for (const [x, y] of [[0, 1], [-1, 0], [0, -1], [1, 0]]) path.arc(rx, ry, 0, false, true, [cx + x * rx, cy + y * ry]);
  path.close();
  return path.subpaths;
}

function rectPath(x, y, width, height, rx, ry) {
  const path = new PathBuilder();
  if (!(width > 0 && height > 0)) return [];
  rx = Math.min(rx, width / 2); ry = Math.min(ry, height / 2);
  const round = rx > 0 && ry > 0;
  if (!round) rx = ry = 0;
  const turn = to => { if (round) path.arc(rx, ry, 0, false, true, to); };
  path.move([x + rx, y]);
  path.line([x + width - rx, y]); turn([x + width, y + ry]);
  path.line([x + width, y + height - ry]); turn([x + width - rx, y + height]);
  path.line([x + rx, y + height]); turn([x, y + height - ry]);
  path.line([x, y + ry]); turn([x + rx, y]);
  path.close();
  return path.subpaths;
}

/** Returns the outline of a basic shape or path, in its own coordinates. */
function outlineOf(element) {
  const get = name => lengthOf(element, name);
  switch (element.localName) {
    case 'path': return parsePath(element.getAttribute('d') ?? '');
    case 'circle': return ellipsePath(get('cx'), get('cy'), get('r'), get('r'));
    case 'ellipse': return ellipsePath(get('cx'), get('cy'), get('rx'), get('ry'));
    case 'rect': {
      const has = name => element.hasAttribute(name);
      const rx = has('rx') ? get('rx') : get('ry'), ry = has('ry') ? get('ry') : get('rx');
      return rectPath(get('x'), get('y'), get('width'), get('height'), rx, ry);
    }
    case 'line': {
      const path = new PathBuilder();
      path.move([get('x1'), get('y1')]);
      path.line([get('x2'), get('y2')]);
      return path.subpaths;
    }
    default: {
      const numbers = numbersIn(element.getAttribute('points') ?? ''), path = new PathBuilder();
      for (let i = 0; i + 1 < numbers.length; i += 2) path[i === 0 ? 'move' : 'line'](numbers.slice(i, i + 2));
      if (element.localName === 'polygon') path.close();
      return path.subpaths;
    }
  }
}
