// Calls of the library through the npm package (`cageform`), and of the functions of page.cpp. Points and poses are flat arrays of
// coordinates.

/** Returns the bytes of gzip data; null if there are more than `most`. */
async function unpacked(packed, most = Infinity) {
  const reader = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip')).getReader(), parts = [];
  let size = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    parts.push(part.value);
    size += part.value.length;
    if (size <= most) continue;
    reader.cancel();
    return null;
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}
/** Decodes base64 and unpacks the gzip data. */
const unpack = text => unpacked(Uint8Array.from(atob(text), c => c.charCodeAt(0)));

/** Returns the name of a coordinate type for readers. */
const titleOf = type => type[0].toUpperCase() + type.slice(1).replaceAll('-', ' ');

/** Coordinates and two batches of bound points: those of the figure, and the nodes where weights are shown. */
class Bound {
  /** The first `count` points of the cage move; the others stay at rest. */
  constructor(coordinates, count = coordinates.vertices) {
    coordinates.solve();
    Object.assign(this, { coordinates, count, rest: coordinates.rest(), batches: [] });
  }
  /** Returns the movable points of the cage at rest. */
  get points() { return this.rest.slice(0, this.count * this.coordinates.dimension); }
  /** Returns the indices of the fixed points. */
  get still() { return Array.from({ length: this.coordinates.vertices - this.count }, (x, i) => this.count + i); }
  /** Returns a pose of all points of the cage. */
  full(pose) {
    const { coordinates: { vertices, dimension }, rest, count } = this;
    if (count === vertices) return pose;
    const all = rest.slice(0, vertices * dimension);
    all.set(pose);
    return all;
  }

  bind(batch, points, outside) {
    this.#free(this.batches[batch]);
    const { hasWeightsOutside } = this.coordinates;
    this.batches[batch] = this.coordinates.bind(points, hasWeightsOutside ? {} : { outside });
    return this.batches[batch].report;
  }
  /** Returns the moved points of a batch, a view that the next call may change. */
  clone(batch, pose) {
    const { figure } = this.batches[batch], all = this.full(pose);
    return figure.cloneView(figure.vertices < figure.handles ? figure.poseHandles(all) : all).points;
  }
  free() {
    this.batches.forEach(this.#free);
    this.coordinates.free();
  }
  #free(binding) {
    binding?.figure.free();
    binding?.free();
  }
}

class Engine {
  /** An instance of the library; `onProgress` receives the completed fraction of long computations. */
  static async start(module, onProgress = () => {}) {
    await cageform.start(module, null, true);
    return Object.assign(new Engine(), { library: cageform.started(), progress: onProgress, plane: new Map(), space: null });
  }

  bytes() { return this.library.buffer.byteLength; }
  /** Returns the bytes that a function creates; `given` returns its arguments. */
  made(name, given) {
    return this.library.scoped(scope => cageform.taken(this.library, scope, this.library.make(scope, name, given(scope)))).buffer;
  }

  // ---- 2D figures, by coordinate type ----

  /** Returns the types that support any polygon. */
  get polygonTypes() {
    const cage = cageform.Cage.polygon([0, 0, 2, 1, 4, 0, 2, 4]); // not convex
    return cageform.Coordinates.kinds.filter(kind => {
      try {
        new cageform.Coordinates(cage, { kind, scalar: 'float64' }).free();
        return true;
      } catch {
        return false;
      }
    });
  }
  /** Makes coordinates of a type on a cage; returns the movable points of the cage at rest. Throws if the cage is invalid. */
  makeCoordinates(type, cage) {
    const { Cage, Coordinates } = cageform, scalar = 'float64';
    let made;
    if (cage.kind === 'lattice') {
      const { axes, frame: [x, y, ...sides], falloff } = cage, along = name => axes.map(axis => axis[name]);
      const box = Cage.lattice({ points: along('points'), degree: along('degree'), knots: along('knots'), origin: [x, y],
        axes: [sides.slice(0, 2), sides.slice(2)], falloff });
      made = new Bound(new Coordinates(box, { scalar }), axes[0].points * axes[1].points);
    } else if (cage.kind === 'curved') {
      const curves = Cage.curves(cage.curves.flat(), cage.curves.map(loop => loop.length));
      made = new Bound(new Coordinates(curves, { scalar, disk: Array.from(cage.around ?? diskOf(cage)) }));
    } else {
      made = new Bound(new Coordinates(Cage.polygon(cage.rest, cage.loops), { kind: type, scalar }));
    }
    this.plane.get(type)?.free();
    this.plane.set(type, made);
    return made.points;
  }
  /** Binds points. Points outside stay (Sibson) or move with the boundary, as in the programs. */
  bind(type, batch, points) {
    return this.plane.get(type).bind(batch, points, type.startsWith('sibson') && batch === 0 ? 'keep-in-place' : 'nearest-boundary');
  }
  /** Returns the moved points of a batch, a view that the next call may change. */
  clone(type, batch, pose) { return this.plane.get(type).clone(batch, pose); }
  weights(type, batch, vertex) { return this.weightsOf(this.plane.get(type).batches[batch], vertex); }
  weightsOf(binding, vertex) {
    return this.library.scoped(scope => {
      const { members, numbers } = scope.output(binding.points, 1, Float64Array);
      this.library.check(this.library.call('page_weights', binding._at, vertex, members.data));
      return numbers().slice();
    });
  }

  /** Makes a cage for segments (ax, ay, bx, by, radius each). */
  makeCage(segments, vertices) {
    const all = Array.from({ length: segments.length / 5 }, (x, i) => segments.slice(5 * i, 5 * i + 5)), { progress } = this;
    const points = all.flatMap(([ax, ay, bx, by]) => [ax, ay, bx, by]), radii = all.map(segment => segment[4]);
    const { cage, report } = cageform.makeCage(points, Uint32Array.from({ length: 2 * all.length }, (x, i) => i),
      { dimension: 2, vertices, radii, progress });
    return { loops: Array.from(cage.loops), rest: cage.vertices, clearance: report.clearance, seconds: report.seconds };
  }
  /** Compiles keys (time, value, kind, in-handle, out-handle each) to cubic pieces with a certified error. */
  fit(keys, tolerance) {
    const [error, ...pieces] = new Float64Array(this.made('page_compile', scope => [scope.array(Float64Array.from(keys)), keys.length / 7, tolerance]));
    return { error, pieces: Float64Array.from(pieces) };
  }

  // ---- the 3D mesh ----

  /** Makes a cage for a mesh; takes a second or two. */
  makeShell(mesh, vertices) {
    const { cage, report } = cageform.makeCage(mesh.vertices, mesh.faces, { vertices, progress: this.progress });
    return { vertices: cage.vertices, faces: Uint32Array.from(cage.faces.flat()), clearance: report.clearance };
  }
  makeSpace({ vertices, faces }) {
    const made = new Bound(new cageform.Coordinates(cageform.Cage.mesh(vertices, faces)));
    this.space?.free();
    this.space = made;
  }
  bindMesh(mesh, cage) {
    this.makeSpace(cage);
    return this.space.bind(0, mesh.vertices);
  }
  cloneMesh(pose) {
    const places = this.space.clone(0, pose);
    this.placesAt = places.byteOffset; // this address does not change
    return places;
  }
  /** Returns the normals of the mesh as moved by cloneMesh(). */
  meshNormals(faces) {
    const { library, placesAt, space: { batches: [{ points }] } } = this;
    return library.scoped(scope => {
      const { members, numbers } = scope.output(points, 3, Float32Array);
      library.call('page_normals', placesAt, points, scope.array(faces), faces.length, members.data);
      return numbers().slice();
    });
  }
  /** Returns the weight of a vertex at every point of the mesh. */
  meshField(vertex) { return this.weightsOf(this.space.batches[0], vertex); }
  /** Returns joints and weights, `influences` for each point. */
  meshSkin(influences, count) {
    const all = this.made('page_skin', () => [this.space.batches[0]._at, influences]);
    return { weights: new Float32Array(all, 0, influences * count), joints: new Uint16Array(all, 4 * influences * count) };
  }
  glsl() { return this.library.text(this.library.call('page_glsl')); }

  // ---- pins ----

  /** Returns the functions for a PinDrag: for a 2D figure with coordinates of a type, or for the mesh. */
  planePins(typeOf) { return new PinCalls(this.library, () => this.plane.get(typeOf()), 2, planeTurn); }
  spacePins() { return new PinCalls(this.library, () => this.space, 3, spaceTurn); }
  /** Samples the interior of a cage for pins. Makes the coordinates first if they do not exist. */
  samplePins({ type, cage, isMade }, samples) {
    if (!isMade && cage.faces) this.makeSpace(cage);
    else if (!isMade) this.makeCoordinates(type, cage);
    const made = new cageform.Samples((cage.faces ? this.space : this.plane.get(type)).coordinates, { samples });
    try {
      return { samples: made.pack() };
    } finally {
      made.free();
    }
  }
}

/** The library's functions for the pins of a figure. Pins, targets and places are arrays of coordinates. */
class PinCalls {
  constructor(library, boundOf, dimension, turnOf) {
    Object.assign(this, { library, boundOf, dimension, turnOf, at: 0, count: 0 });
    for (const name of ['set', 'begin', 'solve', 'locate', 'find']) cageform.CHANGING.add('page_pins_' + name);
  }
  /** Calls a function with a pose and the arguments `given(scope)`, and returns `size` result numbers. */
  call(name, pose, given, size) {
    return this.library.scoped(scope => {
      const full = Float64Array.from(this.boundOf().full(pose)), at = scope.array(full), out = scope.output(size, 1, Float64Array);
      this.library.check(this.library.call('page_pins_' + name, this.at, ...given(scope), at, full.length / this.dimension, out.members.data));
      return { numbers: out.numbers().slice(), pose: this.library.view('f64', at, pose.length).slice() };
    });
  }
  take({ samples }) {
    const made = cageform.openSamples(samples, { skipChecksum: true });
    this.library.call('cageform_free', this.at);
    this.at = this.count = 0;
    try {
      this.at = this.library.scoped(scope => this.library.make(scope, 'page_pins_create', [this.boundOf().coordinates._at, made._at]));
    } finally {
      made.free();
    }
  }
  /** Sets the pins and held points. Returns an invalid pin, -1 if all are valid. */
  set(points, turned, held) {
    const { library, at } = this, { coordinates, still } = this.boundOf();
    return library.scoped(scope => {
      const all = Uint32Array.from([...held, ...still]), culprit = scope.struct(4);
      const status = library.call('page_pins_set', at, coordinates._at, scope.array(Float64Array.from(points.flat())), points.length,
        turned.includes(true) ? scope.array(Uint8Array.from(turned)) : 0, scope.array(all), all.length, culprit);
      const [pin] = library.view('u32', culprit, 1);
      if (status !== 0 && pin < points.length) return pin;
      library.check(status);
      this.count = points.length;
      return -1;
    });
  }
  begin(pose) { this.call('begin', pose, () => [], 0); }
  solve(targets, turns, pose) {
    const none = this.dimension === 2 ? [0] : [0, 0, 0], isTurned = turns.some(turn => turn !== null);
    const given = scope => [targets.flat(), isTurned ? turns.flatMap(turn => turn ?? none) : null]
      .map(all => scope.array(all && Float64Array.from(all)));
    const { numbers: [settled, miss, iterations, folded], pose: moved } = this.call('solve', pose, given, 4);
    return { settled: settled !== 0, miss, iterations, folded, pose: moved };
  }
  /** Returns the position of each pin in a pose, and the Jacobian matrix of the pose there. */
  locate(pose) {
    const each = this.dimension + this.dimension ** 2, numbers = Array.from(this.call('locate', pose, () => [], each * this.count).numbers);
    return Array.from({ length: this.count }, (x, i) => {
      const own = numbers.slice(i * each, (i + 1) * each);
      return { place: own.slice(0, this.dimension), matrix: own.slice(this.dimension) };
    });
  }
  /** Returns the rest point that a pose moves to a place, and the remaining distance from the place. */
  find(start, place, pose) {
    const given = scope => [this.boundOf().coordinates._at, scope.array(Float64Array.from([...start, ...place]))];
    const [x, y, miss] = this.call('find', pose, given, 3).numbers;
    return { found: [x, y], miss };
  }
}
/** Returns the angle of the rotation nearest to a column-major matrix. */
const planeTurn = ([a, b, c, d]) => Math.atan2(b - c, a + d);

/** Makes cages in a worker, one at a time, so that the page stays responsive. */
class CageMaker {
  constructor(module) { this.module = module; }

  /** Calls makeCage() or makeShell() in the worker; throws on an error or if stopped. */
  make(method, given, vertices, onProgress) {
    this.stop();
    const text = `${cageformPackage}\nconst cageform = cageformPackage();\n${Bound}\n${Engine}
      onmessage = async ({ data: { module, method, given, vertices } }) => {
        try {
          let told = 0;
          const engine = await Engine.start(module, done => { if (done > told + 0.005) postMessage({ done: told = done }); });
          postMessage({ result: engine[method](given, vertices) });
        } catch (error) {
          postMessage({ fault: error.message });
        }
      };`;
    const url = URL.createObjectURL(new Blob([text], { type: 'text/javascript' })), worker = new Worker(url);
    const start = performance.now();
    return new Promise((done, failed) => {
      this.stop = () => {
        worker.onmessage = worker.onerror = null; // messages in transit belong to the earlier cage
        worker.terminate();
        URL.revokeObjectURL(url);
        this.stop = () => {};
        failed(new Error('make_cage was stopped'));
      };
      worker.onmessage = ({ data }) => {
        if (data.done !== undefined) return onProgress(data.done);
        if (data.fault) failed(new Error(data.fault)); else done({ ...data.result, milliseconds: performance.now() - start });
        this.stop();
      };
      worker.onerror = event => { failed(new Error(event.message)); this.stop(); };
      worker.postMessage({ module: this.module, method, given, vertices });
    });
  }
  stop() {} // nothing is running
}
