// The 3D character. The user orbits the view and drags vertices of the cage. The mesh is cloned by WebAssembly, or on
// the graphics card by the library's GLSL.

/** Reads the vertices and triangles of an OBJ text; larger faces become fans. Throws if there are no faces. */
function parseObj(text, name) {
  const vertices = [], faces = [];
  for (const line of text.split('\n')) {
    const fields = line.trim().split(/\s+/);
    if (fields[0] === 'v') vertices.push(...fields.slice(1, 4).map(Number));
    if (fields[0] !== 'f') continue;
    const corners = fields.slice(1).map(f => { const n = parseInt(f, 10); return n < 0 ? vertices.length / 3 + n : n - 1; });
    for (let k = 2; k < corners.length; ++k) faces.push(corners[0], corners[k - 1], corners[k]);
  }
  if (faces.length === 0 || !faces.every(i => i >= 0 && 3 * i < vertices.length) || !vertices.every(Number.isFinite))
    throw new Error(name + ' is not an OBJ file with faces');
  return { text, vertices: Float64Array.from(vertices), faces: Uint32Array.from(faces) };
}

/** A dance of the cage: its poses over time (support/files/clip_file.hpp, 3D poses). */
class Dance {
  constructor(text) {
    this.keys = [];
    for (const line of text.split('\n').filter(l => l && !l.startsWith('#'))) {
      const [word, time] = line.split(',');
      if (word === 'length') this.length = Number(time);
      else if (word === 'pose') this.keys.push({ time: Number(time), places: [] });
      else this.keys[this.keys.length - 1].places.push(...line.split(',').map(Number));
    }
  }
  /** Returns the pose at a time: cubics through the keys, with slopes from parabolas. */
  poseAt(time) {
    const { keys, length } = this, count = keys.length;
    const at = time % length, k = keys.findLastIndex(key => key.time <= at);
    const place = n => keys[(n + count) % count].places, step = n => {
      const i = (n + count) % count;
      return (i + 1 < count ? keys[i + 1].time : length) - keys[i].time;
    };
    const [p, a, b, q] = [place(k - 1), place(k), place(k + 1), place(k + 2)], [hp, h, hq] = [step(k - 1), step(k), step(k + 1)];
    const t = (at - keys[k].time) / h;
    return Float64Array.from(a, (x, i) => {
      const before = (x - p[i]) / hp, chord = (b[i] - x) / h, after = (q[i] - b[i]) / hq;
      const u = (h * before + hp * chord) / (hp + h), v = (hq * chord + h * after) / (h + hq);
      return x + h * t * (u + t * (3 * chord - 2 * u - v + t * (u + v - 2 * chord)));
    });
  }
}

const MESH_FRAGMENT = `#version 300 es
precision highp float;
in vec3 at, normal;
out vec4 colour;
uniform float smooth_normals, shows_weights;
in float w;
/// Colours weights as in 2D: blue where negative, else from white over pink to plum, with a contour line every 0.1.
vec3 weight_colour() {
  float size = clamp(abs(w), 0.0, 1.0), change = max(fwidth(w), 1e-9), level = 10.0 * w;
  vec3 c = w < 0.0 ? vec3(0.1, 0.32, 0.8) : mix(vec3(0.95, 0.42, 0.66), vec3(0.5, 0.02, 0.36), smoothstep(0.35, 1.0, size));
  c = mix(vec3(1.0), c, smoothstep(0.0, w < 0.0 ? 0.2 : 0.5, size));
  float off = abs(level - round(level)) / (10.0 * change);
  return abs(level) > 0.5 ? c * mix(0.55, 1.0, smoothstep(0.4, 1.4, off)) : c;
}
void main() {
  vec3 n = normalize(smooth_normals > 0.5 ? normal : cross(dFdx(at), dFdy(at)));
  vec3 key = normalize(vec3(0.35, 0.8, 0.7)), fill = normalize(vec3(-0.8, 0.1, 0.3));
  float light = 0.30 + 0.62 * max(dot(n, key), 0.0) + 0.18 * max(dot(n, fill), 0.0);
  float rim = pow(1.0 - abs(n.z), 3.0) * 0.12;
  vec3 paint = shows_weights > 0.5 ? 0.9 * weight_colour() : vec3(0.93, 0.62, 0.36);
  colour = vec4(pow(paint * light + rim, vec3(0.9)), 1.0);
}`;
const MESH_VERTEX = `#version 300 es
in vec3 place, side;
in float weight;
uniform mat4 to_clip, to_eye;
out vec3 at, normal;
out float w;
void main() {
  w = weight;
  at = (to_eye * vec4(place, 1.0)).xyz;
  normal = mat3(to_eye) * side;
  gl_Position = to_clip * vec4(place, 1.0);
}`;
const skinVertex = (glsl, handles, sets) => `#version 300 es
#define CAGEFORM_UNIFORM_HANDLES ${handles}
${glsl}
in vec3 place;
in float weight;
${Array.from({ length: sets }, (x, k) => `in uvec4 joints${k}; in vec4 weights${k};`).join('\n')}
uniform mat4 to_clip, to_eye;
out vec3 at, normal;
out float w;
void main() {
  w = weight;
  vec3 moved = place;
${Array.from({ length: sets }, (x, k) => `  moved += cageform_skin(joints${k}, weights${k});`).join('\n')}
  at = (to_eye * vec4(moved, 1.0)).xyz;
  normal = vec3(0.0);
  gl_Position = to_clip * vec4(moved, 1.0);
}`;

/** Returns the columns of a 4 × 4 matrix product. */
function matrixProduct(a, b) {
  const c = new Float32Array(16);
  for (let j = 0; j < 4; ++j) for (let i = 0; i < 4; ++i) for (let k = 0; k < 4; ++k) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}
function perspective(aspect, near, far) {
  const f = 1 / Math.tan(0.3);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0]);
}

/** The sample character: its mesh and cage, a pose and a dance. */
async function readCharacter(data) {
  const [mesh, cage, pose, dance] = await Promise.all([data.mesh, data.cage, data.pose, data.dance].map(async packed =>
    new TextDecoder().decode(await unpack(packed))));
  return { name: 'Character', mesh: parseObj(mesh), cage: parseObj(cage), examplePose: parseObj(pose).vertices, dance: new Dance(dance) };
}

class MeshView {
  constructor(app) {
    this.app = app;
    this.canvas = document.getElementById('mesh');
    this.overlay = document.getElementById('mesh-cage');
    this.turn = 0.3; this.rise = 0.12; this.far = 1; this.near = this.selected = -1;
    this.skinSets = 4;
    this.history = new History(this);
    this.pinDrag = new PinDrag(this, app.engine.spacePins());
    this.pinMarks = new PinMarks(document.getElementById('mesh-pins'), this.pinDrag);
    this.sessions = new Map(); // states of meshes shown before, by name
    attachOrbit(this);
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
  }

  /** Shows a mesh, new or with its last state; stores the state of the previous one. */
  leave(current, session) {
    if (this.current && this.current !== current) this.sessions.set(this.current, this.session());
    this.show(session);
    this.current = current;
  }
  session() {
    const { name, mesh, cage, pose, pins, examplePose, dance, history: { earlier, later } } = this;
    return { name, mesh, cage, pose, pins, examplePose, dance, earlier, later };
  }
  /** Binds a mesh to its cage; throws if this is not possible. */
  show({ name, mesh, cage, pose = cage.vertices.slice(), pins = null, examplePose = null, dance = null, earlier = [], later = [] }) {
    const start = performance.now();
    this.app.engine.bindMesh(mesh, cage);
    Object.assign(this, { name, mesh, cage, bindTime: performance.now() - start, pose, cloneTime: 0, skin: null, near: -1, selected: -1,
      shaded: -1, examplePose, dance, pins, bound: {} });
    this.pinDrag.stop();
    this.pinDrag.chosen = this.pinDrag.hovered = -1;
    this.history.set(earlier, later);
    this.edges = uniqueEdges(cage.faces);
    this.makeOverlay();
    this.makeBuffers();
    this.fit();
  }
  /** Fits the posed cage into the view. */
  fit() {
    const box = [0, 1, 2].map(axis => {
      const values = this.pose.filter((v, k) => k % 3 === axis);
      return [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
    });
    this.middle = box.map(([a, b]) => (a + b) / 2);
    this.size = Math.hypot(...box.map(([a, b]) => b - a));
    this.far = 1;
    this.redraw();
  }

  // ---- undo ----

  state() {
    const { pose, pins } = this;
    return { pose, pins };
  }
  restore({ pose, pins }) {
    this.pinDrag.stop();
    Object.assign(this, { pose, pins: pins ?? this.pins });
    this.redraw();
  }

  // ---- pins ----

  get engine() { return this.app.engine; }
  pinCage() { return { cage: { vertices: this.cage.vertices, faces: this.cage.faces } }; }
  boundFor() { return this.bound; }
  get fixedPoints() { return []; }
  /** Returns vertices of the mesh at rest, at most a few thousand. */
  pinCandidates() {
    const { vertices } = this.mesh, step = Math.ceil(vertices.length / 12000);
    return allOf(Math.floor(vertices.length / 3 / step)).map(i => Array.from(vertices.subarray(3 * i * step, 3 * i * step + 3)));
  }
  startPins() {
    const all = this.pinCandidates(), own = START_PLACES[this.current], gap = (p, q) => Math.hypot(...p.map((x, k) => x - q[k]));
    return own ? own.map(place => all.reduce((a, b) => gap(b, place) < gap(a, place) ? b : a)) : innerPoints(all);
  }
  sayFault(error) { this.app.sayFault(error); }
  say(text) { this.app.say(text); }
  /** Sets a pin far from all other pins. */
  addFarPin() {
    this.pinDrag.prepare();
    const points = spreadPoints(this.pinCandidates(), this.pins.points, 1);
    if (points.length > this.pins.points.length) setPin(this.pinDrag, points[points.length - 1]);
    this.redraw();
  }
  /** Returns the pins on the screen, each with its depth. */
  pinPlaces() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return this.pinDrag.placesIn(this.pose).map(place => this.project(...place, width, height));
  }
  drawPins(middle) {
    const places = this.app.dragsFigure && this.pinDrag.readySoon() ? this.pinPlaces() : [];
    this.pinMarks.draw(places, 1, true, i => places[i][2] > middle);
  }

  // ---- motion ----

  stepVertex(by) {
    const count = this.pose.length / 3;
    this.selected = this.selected < 0 ? (by > 0 ? 0 : count - 1) : (this.selected + by + count) % count;
    this.near = this.selected;
    this.redraw();
  }
  /** Moves the selected vertex by pixels, as one undo step. */
  nudge(dx, dy) {
    this.history.remember();
    dragMeshVertex(this, this.selected)(dx, dy);
  }
  /** Plays the dance, or stops it. */
  toggleDance(isOn) {
    cancelAnimationFrame(this.dancing);
    this.dancing = 0;
    if (!isOn || !this.dance) return;
    this.history.remember();
    let begin = null; // in the time of animation frames, which differs from performance.now()
    const step = now => {
      if (!this.dance || !document.body.classList.contains('in-space')) return;
      begin ??= now;
      this.pose = this.dance.poseAt((now - begin) / 1000);
      this.draw();
      this.dancing = requestAnimationFrame(step);
    };
    this.dancing = requestAnimationFrame(step);
  }
  makeOverlay() {
    this.overlay.replaceChildren();
    this.lines = this.edges.map(() => svgElement('line', {}, this.overlay));
    this.dots = Array.from({ length: this.cage.vertices.length / 3 }, () => svgElement('circle', {}, this.overlay));
  }
  makeBuffers() {
    const gl = this.gl ??= this.canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error('This browser has no WebGL 2');
    this.program ??= compileProgram(gl, MESH_VERTEX, MESH_FRAGMENT);
    this.buffers ??= { place: gl.createBuffer(), side: gl.createBuffer(), weight: gl.createBuffer(), index: gl.createBuffer() };
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers.index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(this.mesh.faces), gl.STATIC_DRAW);
  }

  /** Makes joints and weights for the graphics card with skin_weights of the library. */
  makeSkin() {
    const { gl, skinSets } = this, count = this.mesh.vertices.length / 3, handles = this.cage.vertices.length / 3;
    const start = performance.now(), { joints, weights } = this.app.engine.meshSkin(4 * skinSets, count);
    this.skinTime = performance.now() - start;
    const program = compileProgram(gl, skinVertex(this.app.engine.glsl(), handles, skinSets), MESH_FRAGMENT);
    const store = (target, data) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(target, buffer);
      gl.bufferData(target, data, gl.STATIC_DRAW);
      return buffer;
    };
    this.skin = {
      program, rest: store(gl.ARRAY_BUFFER, Float32Array.from(this.mesh.vertices)), joints: store(gl.ARRAY_BUFFER, joints),
      weights: store(gl.ARRAY_BUFFER, weights), block: gl.createBuffer(), displacements: new Float32Array(4 * handles),
    };
    gl.uniformBlockBinding(program, gl.getUniformBlockIndex(program, 'CageformDisplacements'), 0);
  }

  redraw() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => { this.isWaiting = false; this.draw(); });
  }
  draw() {
    if (!this.mesh || !this.canvas.clientWidth) return;
    const { gl, canvas } = this, sharp = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * sharp) || canvas.height !== Math.round(height * sharp)) {
      canvas.width = Math.round(width * sharp);
      canvas.height = Math.round(height * sharp);
    }
    this.aim(width / height);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (this.onCard && !this.skin) this.makeSkin();
    const start = performance.now();
    if (this.onCard) this.feedSkin(); else this.feedPlaces();
    this.feedWeights(this.onCard ? this.skin.program : this.program);
    this.cloneTime = this.cloneTime ? 0.9 * this.cloneTime + 0.1 * (performance.now() - start) : performance.now() - start;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers.index);
    gl.drawElements(gl.TRIANGLES, this.mesh.faces.length, gl.UNSIGNED_INT, 0);
    this.drawCage(width, height);
    this.drawPins(this.project(...this.middle, width, height)[2]);
    this.tell();
    this.app.keeper.look();
  }

  /** Returns the matrices of an orbit around the character. */
  aim(aspect) {
    const [c, s] = [Math.cos(this.turn), Math.sin(this.turn)], [cr, sr] = [Math.cos(this.rise), Math.sin(this.rise)];
    const [x, y, z] = this.middle, away = this.size * 1.35 * this.far * Math.max(1, 0.8 / aspect);
    const rotation = [c, s * sr, -s * cr, 0, 0, cr, sr, 0, s, -c * sr, c * cr, 0, 0, 0, 0, 1];
    const shift = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1];
    this.toEye = matrixProduct([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -away, 1], matrixProduct(rotation, shift));
    this.toClip = matrixProduct(perspective(aspect, away / 50, away * 4), this.toEye);
  }
  /** Projects a point to pixels of the canvas and a depth. */
  project(x, y, z, width, height) {
    const m = this.toClip, w = m[3] * x + m[7] * y + m[11] * z + m[15];
    return [width / 2 * (1 + (m[0] * x + m[4] * y + m[8] * z + m[12]) / w), height / 2 * (1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w), w];
  }

  use(program) {
    const { gl } = this;
    gl.useProgram(program);
    gl.uniformMatrix4fv(gl.getUniformLocation(program, 'to_clip'), false, this.toClip);
    gl.uniformMatrix4fv(gl.getUniformLocation(program, 'to_eye'), false, this.toEye);
    gl.uniform1f(gl.getUniformLocation(program, 'smooth_normals'), this.onCard ? 0 : 1);
  }
  attribute(program, name, buffer, size, stride = 0, offset = 0, kind = 'float') {
    const { gl } = this, at = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(at);
    if (kind === 'float') gl.vertexAttribPointer(at, size, gl.FLOAT, false, stride, offset);
    else gl.vertexAttribIPointer(at, size, gl.UNSIGNED_SHORT, stride, offset);
  }
  feedPlaces() {
    const { gl, buffers, mesh: { faces }, app: { engine } } = this;
    for (let k = 0; k < gl.getParameter(gl.MAX_VERTEX_ATTRIBS); ++k) gl.disableVertexAttribArray(k);
    this.use(this.program);
    for (const [name, take] of [['place', () => engine.cloneMesh(this.pose)], ['side', () => engine.meshNormals(faces)]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
      gl.bufferData(gl.ARRAY_BUFFER, take(), gl.STREAM_DRAW);
      this.attribute(this.program, name, buffers[name], 3);
    }
  }
  feedSkin() {
    const { gl } = this;
    const { program, rest, joints, weights, block, displacements } = this.skin;
    for (let k = 0; k < gl.getParameter(gl.MAX_VERTEX_ATTRIBS); ++k) gl.disableVertexAttribArray(k);
    this.use(program);
    this.attribute(program, 'place', rest, 3);
    for (let k = 0; k < this.skinSets; ++k) {
      this.attribute(program, 'joints' + k, joints, 4, 8 * this.skinSets, 8 * k, 'count');
      this.attribute(program, 'weights' + k, weights, 4, 16 * this.skinSets, 16 * k);
    }
    for (let i = 0; 3 * i < this.pose.length; ++i)
      for (let k = 0; k < 3; ++k) displacements[4 * i + k] = this.pose[3 * i + k] - this.cage.vertices[3 * i + k];
    gl.bindBuffer(gl.UNIFORM_BUFFER, block);
    gl.bufferData(gl.UNIFORM_BUFFER, displacements, gl.STREAM_DRAW);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, block);
  }

  /** Returns the vertex whose weights are shown; -1 if none. */
  get weightVertex() { return this.app.showsWeights ? this.near >= 0 ? this.near : this.selected : -1; }
  feedWeights(program) {
    const { gl } = this, vertex = this.weightVertex;
    gl.uniform1f(gl.getUniformLocation(program, 'shows_weights'), vertex >= 0 ? 1 : 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.weight);
    if (vertex >= 0 && vertex !== this.shaded) {
      gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(this.app.engine.meshField(vertex)), gl.DYNAMIC_DRAW);
      this.shaded = vertex;
    }
    if (vertex >= 0) this.attribute(program, 'weight', this.buffers.weight, 1);
  }

  drawCage(width, height) {
    this.overlay.classList.toggle('bare', !this.app.showsCage);
    const places = this.places = [];
    for (let k = 0; k < this.pose.length; k += 3) places.push(this.project(this.pose[k], this.pose[k + 1], this.pose[k + 2], width, height));
    const middle = this.project(...this.middle, width, height)[2];
    this.edges.forEach(([i, j], k) => {
      for (const [name, value] of Object.entries({ x1: places[i][0], y1: places[i][1], x2: places[j][0], y2: places[j][1] }))
        this.lines[k].setAttribute(name, value.toFixed(1));
    });
    this.dots.forEach((dot, i) => {
      dot.setAttribute('cx', places[i][0].toFixed(1));
      dot.setAttribute('cy', places[i][1].toFixed(1));
      const isMarked = i === this.near || i === this.selected;
      dot.setAttribute('r', isMarked ? 6 : 3.6);
      const isHeld = this.app.dragsFigure && this.pins?.held.includes(i);
      dot.setAttribute('class', isHeld ? 'held' : isMarked ? 'near' : places[i][2] > middle ? 'back' : '');
    });
  }
  tell() {
    const clone = this.onCard ? `displacements uploaded in ${this.cloneTime.toFixed(2)} ms (skin of ${4 * this.skinSets} weights made in ${this.skinTime.toFixed(0)} ms)`
      : `cloned, with normals, in ${this.cloneTime.toFixed(2)} ms`;
    tellLegend(this.app, this.weightVertex);
    tellHint(this.app, this.pinDrag);
    if (this.app.notice) return;
    this.app.say(`${this.name}: ${(this.mesh.vertices.length / 3).toLocaleString('en')} points in a cage of ${this.cage.vertices.length / 3} vertices, ` +
                 `mean value; bound in ${this.bindTime.toFixed(0)} ms, ${clone}` + (this.selected >= 0 ? `; vertex ${this.selected} selected` : '') + tellPins(this.pinDrag), false);
  }
}

function uniqueEdges(faces) {
  const seen = new Set(), edges = [];
  for (let f = 0; f < faces.length; f += 3) {
    for (let k = 0; k < 3; ++k) {
      const a = faces[f + k], b = faces[f + (k + 1) % 3], name = Math.min(a, b) + '-' + Math.max(a, b);
      if (!seen.has(name)) { seen.add(name); edges.push([a, b]); }
    }
  }
  return edges;
}

/** Handles pointers: one drags a vertex or rotates the view; two zoom by moving apart, like the wheel. */
function attachOrbit(view) {
  const { canvas } = view, fingers = new Map();
  let gesture = null;
  const placeOf = event => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  const nearest = (place, reach) => {
    let best = -1, least = Infinity;
    (view.places ?? []).forEach(([x, y, depth], i) => {
      const d = Math.hypot(x - place[0], y - place[1]);
      if (d < reach && depth + 0.02 * d < least) { least = depth + 0.02 * d; best = i; }
    });
    return best;
  };
  const pins = new PinPointers({
    placeOf,
    press: (place, event) => pressMesh(view, place, event, nearest),
    hover: (place, event) => hoverMesh(view, place, event),
    pinch(fingers) {
      const zoom = pinchMesh(view, fingers);
      return { kind: 'ground', move() { zoom(); view.redraw(); }, end() {} };
    },
  });
  const reachOf = event => event.pointerType === 'touch' ? 24 : 11;
  canvas.addEventListener('pointerdown', event => {
    if (!view.mesh) return;
    canvas.setPointerCapture(event.pointerId);
    event.preventDefault();
    if (view.app.dragsFigure) return attempt(view.app, () => pins.press(event));
    fingers.set(event.pointerId, placeOf(event));
    view.near = view.app.showsCage ? nearest(placeOf(event), reachOf(event)) : -1;
    if (fingers.size === 1) view.selected = view.near;
    gesture = fingers.size === 2 ? pinchMesh(view, fingers) : view.near >= 0 ? rememberedDrag(view, view.near) : orbit(view);
    view.redraw();
  });
  canvas.addEventListener('pointermove', event => {
    if (view.app.dragsFigure) return pins.move(event);
    const before = fingers.get(event.pointerId), now = placeOf(event);
    if (before) {
      fingers.set(event.pointerId, now);
      gesture?.(now[0] - before[0], now[1] - before[1]);
    } else {
      const near = nearest(now, reachOf(event));
      if (near === view.near) return;
      view.near = near;
    }
    view.redraw();
  });
  const release = event => {
    pins.release(event);
    if (fingers.delete(event.pointerId)) gesture = null;
  };
  canvas.addEventListener('pointerleave', event => pins.leave(event));
  canvas.addEventListener('pointerup', release);
  canvas.addEventListener('pointercancel', release);
  canvas.addEventListener('wheel', event => {
    view.far = Math.max(0.2, Math.min(4, view.far * Math.exp(0.001 * event.deltaY)));
    view.redraw();
    event.preventDefault();
  }, { passive: false });
}
const orbit = view => (dx, dy) => {
  view.turn += dx * 0.008;
  view.rise = Math.max(-1.5, Math.min(1.5, view.rise + dy * 0.008));
};
/** Converts a shift on the screen in pixels to a 3D shift at a depth. */
function shiftOnScreen({ toEye: m, canvas }, depth, dx, dy) {
  const unit = depth * Math.tan(0.3) * 2 / canvas.clientHeight;
  return [0, 1, 2].map(k => unit * (dx * m[4 * k] - dy * m[4 * k + 1]));
}
/** Drags a vertex parallel to the screen, at its depth. */
function dragMeshVertex(view, vertex) {
  return (dx, dy) => {
    const pose = view.pose.slice(); // a copy, because undo stores poses
    shiftOnScreen(view, view.places[vertex][2], dx, dy).forEach((x, k) => { pose[3 * vertex + k] += x; });
    view.pose = pose;
  };
}
/** Drags a vertex as one undo step, and stops a dance. */
function rememberedDrag(view, vertex) {
  const drag = dragMeshVertex(view, vertex);
  let moved = false;
  return (dx, dy) => {
    if (!moved) view.onDrag?.();
    if (!moved) view.history.remember();
    moved = true;
    drag(dx, dy);
  };
}
function pinchMesh(view, fingers) {
  const size = () => { const [a, b] = [...fingers.values()]; return b ? distance(a, b) : 1; };
  let last = size();
  return () => {
    const now = size();
    view.far = Math.max(0.2, Math.min(4, view.far * last / Math.max(1, now)));
    last = now;
  };
}
