// 3D pins: the element under the pointer, drags parallel to the screen, rotations about the line of sight.

const shifted = (place, by) => place.map((x, k) => x + by[k]);

MeshView.prototype.depthOf = function (place) { return this.project(...place, 1, 1)[2]; };

/** Returns, of the face under the pointer, the mesh vertex nearest to the pointer; -1 if there is none. */
function vertexUnder(view, [x, y]) {
  const { mesh: { vertices, faces }, pose, canvas: { clientWidth: width, clientHeight: height } } = view, count = vertices.length / 3;
  const places = view.app.engine.cloneMesh(pose), m = view.toClip, on = new Float32Array(3 * count);
  for (let k = 0; k < 3 * count; k += 3) {
    const [px, py, pz] = [places[k], places[k + 1], places[k + 2]], w = m[3] * px + m[7] * py + m[11] * pz + m[15];
    on[k] = width / 2 * (1 + (m[0] * px + m[4] * py + m[8] * pz + m[12]) / w) - x;
    on[k + 1] = height / 2 * (1 - (m[1] * px + m[5] * py + m[9] * pz + m[13]) / w) - y;
    on[k + 2] = w;
  }
  let best = -1, least = Infinity;
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
    const u = on[b] * on[c + 1] - on[b + 1] * on[c], v = on[c] * on[a + 1] - on[c + 1] * on[a], w = on[a] * on[b + 1] - on[a + 1] * on[b];
    if (!((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) || u + v + w === 0) continue;
    const depth = (u * on[a + 2] + v * on[b + 2] + w * on[c + 2]) / (u + v + w);
    if (depth < least) { least = depth; best = f; }
  }
  if (best < 0) return -1;
  const gap = i => Math.hypot(on[3 * i], on[3 * i + 1]);
  return [0, 1, 2].map(k => faces[best + k]).reduce((a, b) => gap(b) < gap(a) ? b : a);
}

/** Starts the gesture of a press on the mesh; `nearest` finds a vertex of the cage. */
function pressMesh(view, place, event, nearest) {
  const isTouch = event.pointerType === 'touch', reach = isTouch ? 24 : 11, slop = isTouch ? 7 : 3, drag = view.pinDrag;
  view.onDrag?.(); // stops a dance
  drag.prepare();
  const places = view.pinPlaces(), pin = nearestPin(places, place, reach);
  const targetFrom = depth => (to, from) => shifted(from, shiftOnScreen(view, depth, to[0] - place[0], to[1] - place[1]));
  if (pin < 0 && isOnRing(drag, places, place, 1, reach))
    return turnPin(drag, drag.ringed, places[drag.ringed], place, (turn, angle) => turnedOnScreen(view, turn, angle));
  if (pin >= 0) return dragPin(drag, 'pin', view.pins.points[pin], place, slop, targetFrom(places[pin][2]));
  const vertex = vertexUnder(view, place), held = vertex < 0 && view.app.showsCage ? nearest(place, reach) : -1;
  if (held >= 0) return holdMeshVertex(view, held, place, slop);
  if (vertex < 0) return turnView(view, place);
  const near = nearestPin(places, place, ringRadius()), set = () => setPin(drag, Array.from(view.mesh.vertices.subarray(3 * vertex, 3 * vertex + 3)));
  if (near >= 0) return dragPin(drag, 'near', view.pins.points[near], place, slop, targetFrom(places[near][2]), set);
  try {
    const point = set();
    return dragPin(drag, 'new', point, place, slop, targetFrom(view.depthOf(view.pins.targets[view.pins.points.indexOf(point)])));
  } catch (error) {
    view.sayFault(error);
    return turnView(view, place);
  }
}
function hoverMesh(view, place, event) {
  if (!view.mesh || !view.pinDrag.isPrepared || !view.toClip) return;
  hoverPin(view.pinDrag, view.pinPlaces(), place, 1, event.pointerType === 'touch' ? 24 : 11);
}
/** Drags a vertex of the cage and fixes it; a click releases it. */
function holdMeshVertex(view, vertex, place, slop) {
  const { pose: begin } = view, depth = view.places[vertex][2];
  return holdPoints(view, [vertex], vertex, place, slop, (pose, to) => {
    shiftOnScreen(view, depth, to[0] - place[0], to[1] - place[1]).forEach((x, k) => { pose[3 * vertex + k] = begin[3 * vertex + k] + x; });
  });
}
function turnView(view, place) {
  const turn = orbit(view);
  let last = place;
  view.pinDrag.chosen = -1;
  return { kind: 'ground', move(to) { turn(to[0] - last[0], to[1] - last[1]); last = to; view.redraw(); }, end() {} };
}

// ---- 3D rotations: the axis times the angle ----

/** Returns a rotation followed by a clockwise rotation about the line of sight. */
function turnedOnScreen({ toEye: m }, turn, angle) {
  return vectorOf(quaternionProduct(quaternionOf([-angle * m[2], -angle * m[6], -angle * m[10]]), quaternionOf(turn)));
}
function quaternionOf(turn) {
  const angle = Math.hypot(...turn), share = angle > 0 ? Math.sin(angle / 2) / angle : 0.5;
  return [Math.cos(angle / 2), ...turn.map(x => share * x)];
}
function vectorOf([w, ...v]) {
  const size = Math.hypot(...v), sign = w < 0 ? -1 : 1, share = size > 0 ? 2 * Math.atan2(size, sign * w) / size : 2;
  return v.map(x => sign * share * x);
}
function quaternionProduct([a, b, c, d], [e, f, g, h]) {
  return [a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g, a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e];
}
/** Returns the rotation nearest to a column-major matrix: Newton's method for the polar decomposition (Higham 1986). */
function spaceTurn(matrix) {
  let m = matrix;
  const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
  for (let n = 0; n < 30; ++n) {
    const [a, b, c] = [m.slice(0, 3), m.slice(3, 6), m.slice(6)], cofactors = [cross(b, c), cross(c, a), cross(a, b)].flat();
    const determinant = a.reduce((sum, x, k) => sum + x * cofactors[k], 0);
    if (!(determinant > 0)) break; // inverted
    m = m.map((x, k) => 0.5 * (x + cofactors[k] / determinant));
  }
  const trace = m[0] + m[4] + m[8], v = [m[5] - m[7], m[6] - m[2], m[1] - m[3]], sine = Math.hypot(...v);
  if (sine > 1e-9) return v.map(x => x / sine * Math.atan2(sine, trace - 1));
  if (trace > 0) return [0, 0, 0];
  const axis = [0, 1, 2].map(k => [m[k], m[3 + k], m[6 + k]].map((x, j) => x + (j === k ? 1 : 0))).reduce((p, q) => Math.hypot(...q) > Math.hypot(...p) ? q : p);
  return axis.map(x => Math.PI * x / Math.hypot(...axis));
}
