// The library: page.cpp compiled to WebAssembly. Its functions take and return arrays of numbers.

const TYPE_NAMES = ['Mean value', 'Harmonic', 'Green', 'Sibson', 'Lattice', 'Curved Green'];
const LATTICE_TYPE = 4, CURVED_TYPE = 5;

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
/** Returns the bytes of gzip data in base64. */
const unpack = text => unpacked(Uint8Array.from(atob(text), c => c.charCodeAt(0)));

class Engine {
  /** The library in an instance of its own; `onProgress` gets the fraction done of long computations. */
  static async start(module, onProgress = () => {}) {
    const engine = new Engine();
    const host = wasiHost(() => engine.calls.memory, { progress: onProgress });
    engine.calls = (await WebAssembly.instantiate(module, importsOf(module, host))).exports;
    engine.calls._initialize();
    return engine;
  }

  bytes() { return this.calls.memory.buffer.byteLength; }
  /** Writes numbers to the input, several arrays one after the other. */
  give(...arrays) {
    const size = arrays.reduce((sum, a) => sum + a.length, 0);
    let at = this.calls.page_input(size);
    for (const array of arrays) {
      new Float64Array(this.calls.memory.buffer, at, array.length).set(array);
      at += 8 * array.length;
    }
  }
  /** Returns `size` numbers that the last call wrote; a view that the next call may change. */
  taken(size, from = 0) { return new Float64Array(this.calls.memory.buffer, this.calls.page_output() + 8 * from, size); }
  text(at) {
    const bytes = new Uint8Array(this.calls.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }
  check(status) {
    if (status !== 0) throw new Error(this.text(this.calls.page_message()));
  }

  /** Makes coordinates of a type on a cage; throws the cage's fault. */
  makeCoordinates(type, cage) {
    if (cage.kind === 'lattice') return this.makeLattice(cage);
    if (cage.kind === 'curved') return this.makeCurves(cage);
    this.give(cage.loops, cage.rest);
    this.check(this.calls.page_cage(type, cage.loops.length, cage.rest.length / 2));
  }
  /** Makes the coordinates of a lattice, and returns its points at rest. */
  makeLattice({ axes, frame, falloff }) {
    this.give(axes.flatMap(({ points, degree, knots = [] }) => [points, degree, knots.length, ...knots]), frame, [falloff]);
    this.check(this.calls.page_lattice());
    return this.taken(2 * axes[0].points * axes[1].points).slice();
  }
  /** Makes the coordinates of a curved cage, and returns its points at rest. */
  makeCurves(cage) {
    const edges = cage.curves.flat();
    this.give(cage.curves.map(loop => loop.length), edges.map(edge => edge.length - 1), edges.flat(2), cage.around ?? diskOf(cage));
    this.check(this.calls.page_curves(cage.curves.length, edges.length));
    return this.taken(6 * edges.length).slice();
  }
  /** Returns origin and columns of a box about segments (ax, ay, bx, by, radius each), for a lattice. */
  boxAbout(segments) {
    this.give(segments);
    this.check(this.calls.page_box(segments.length / 5));
    return Array.from(this.taken(6));
  }
  bind(type, batch, points) {
    this.give(points);
    this.check(this.calls.page_bind(type, batch, points.length / 2));
    const [outside, unreached, notFinite, leastWeight] = this.taken(4);
    return { outside, unreached, notFinite, leastWeight };
  }
  /** Returns the `count` moved points of a batch; a view that the next call may change. */
  clone(type, batch, pose, count) {
    this.give(pose);
    const at = this.calls.page_clone(type, batch, pose.length / 2);
    if (at === 0) throw new Error(this.text(this.calls.page_message()));
    return new Float64Array(this.calls.memory.buffer, at, 2 * count);
  }
  weights(type, batch, vertex) { return this.taken(this.calls.page_weights(type, batch, vertex)); }

  /** Makes a cage for segments (ax, ay, bx, by, radius each). */
  makeCage(segments, vertices) {
    this.give(segments);
    this.check(this.calls.page_make_cage(segments.length / 5, vertices));
    const [loops, clearance, seconds] = this.taken(3);
    const sizes = Array.from(this.taken(loops, 3));
    const count = sizes.reduce((sum, n) => sum + n, 0);
    return { loops: sizes, rest: this.taken(2 * count, 3 + loops).slice(), clearance, seconds };
  }
  /** Compiles keys (time, value, kind, in-handle, out-handle each) to cubic pieces with a certified error. */
  fit(keys, tolerance) {
    this.give(keys);
    const count = this.calls.page_fit(keys.length / 7, tolerance);
    if (count < 0) throw new Error(this.text(this.calls.page_message()));
    return { error: this.taken(1)[0], pieces: this.taken(5 * count, 1).slice() };
  }

  /** Makes a cage for a mesh, which takes a second or two. */
  makeShell(mesh, vertices) {
    this.give(mesh.vertices, mesh.faces);
    this.check(this.calls.page_make_shell(mesh.vertices.length / 3, mesh.faces.length / 3, vertices));
    const [count, faces, clearance] = this.taken(3);
    return { vertices: this.taken(3 * count, 3).slice(), faces: this.taken(3 * faces, 3 + 3 * count).slice(), clearance };
  }
  bindMesh(mesh, cage) {
    this.give(cage.vertices, cage.faces, mesh.vertices, mesh.faces);
    this.check(this.calls.page_mesh(cage.vertices.length / 3, cage.faces.length / 3, mesh.vertices.length / 3,
                                    mesh.faces.length / 3));
    return { outside: this.taken(1)[0] };
  }
  cloneMesh(pose, count) {
    this.give(pose);
    const at = this.calls.page_mesh_clone(pose.length / 3);
    if (at === 0) throw new Error(this.text(this.calls.page_message()));
    return new Float32Array(this.calls.memory.buffer, at, 3 * count);
  }
  /** Returns the weight of a vertex at every point of the mesh. */
  meshField(vertex) { return this.taken(this.calls.page_mesh_field(vertex)); }
  meshNormals(count) { return new Float32Array(this.calls.memory.buffer, this.calls.page_mesh_normals(), 3 * count); }
  meshSkin(influences, count) {
    this.check(this.calls.page_mesh_skin(influences));
    return {
      joints: new Uint16Array(this.calls.memory.buffer, this.calls.page_mesh_joints(), influences * count).slice(),
      weights: new Float32Array(this.calls.memory.buffer, this.calls.page_mesh_weights(), influences * count).slice(),
    };
  }

  /** Returns the calls that a PinDrag makes: of a figure in the plane by coordinates of a type, or in space. */
  planePins(typeOf) { return pinCalls(this, 2, 'page_pins_', () => [typeOf()], planeTurn); }
  spacePins() { return pinCalls(this, 3, 'page_mesh_pins_', () => [], spaceTurn); }
  /** Samples the inside of a cage for pins, of coordinates that are there or are made first; returns the samples as numbers. */
  samplePins({ type, cage, isMade }, samples) {
    if (!isMade && cage.faces) this.bindMesh({ vertices: [], faces: [] }, cage);
    else if (!isMade) this.makeCoordinates(type, cage);
    const size = cage.faces ? this.calls.page_mesh_pins_sample(samples) : this.calls.page_pins_sample(type, samples);
    this.check(size === 0 ? 1 : 0);
    return { samples: this.taken(size).slice() };
  }
  /** Returns the point at rest that a pose takes to a place, and how far off the place that is. */
  findUnder(type, start, place, pose) {
    this.give(start, place, pose);
    this.calls.page_pins_find(type, pose.length / 2);
    const [x, y, miss] = this.taken(3);
    return { found: [x, y], miss };
  }

  glsl() { return this.text(this.calls.page_glsl()); }
}

/** The library's calls for the pins of a figure, of so many dimensions. Pins, targets and places are arrays of coordinates. */
function pinCalls(engine, dimension, prefix, typeOf, turnOf) {
  const call = (name, ...numbers) => engine.calls[prefix + name](...numbers);
  return {
    turnOf, dimension,
    take({ samples }) {
      engine.give(samples);
      engine.check(call('take', ...typeOf()));
    },
    /** Returns the pin that no cage holds, -1 if all is well. */
    set(points, turned, held) {
      const turns = turned.includes(true);
      engine.give(points.flat(), turns ? turned.map(Number) : [], held);
      const status = call('set', ...typeOf(), points.length, held.length, turns), [culprit] = engine.taken(1);
      if (status !== 0 && culprit < points.length) return culprit;
      engine.check(status);
      return -1;
    },
    begin(pose) {
      engine.give(pose);
      engine.check(call('begin', pose.length / dimension));
    },
    solve(targets, turns, pose) {
      const isTurned = turns.some(turn => turn !== null), none = dimension === 2 ? [0] : [0, 0, 0];
      engine.give(targets.flat(), isTurned ? turns.flatMap(turn => turn ?? none) : [], pose);
      engine.check(call('solve', targets.length, pose.length / dimension, isTurned));
      const [settled, miss, iterations, folded] = engine.taken(4);
      return { settled: settled !== 0, miss, iterations, folded, pose: engine.taken(pose.length, 4).slice() };
    },
    locate(pose) {
      engine.give(pose);
      engine.check(call('locate', pose.length / dimension));
      const each = dimension + dimension * dimension, numbers = Array.from(engine.taken(each * engine.calls[prefix + 'count']()));
      return Array.from({ length: numbers.length / each }, (x, i) => {
        const own = numbers.slice(i * each, (i + 1) * each);
        return { place: own.slice(0, dimension), matrix: own.slice(dimension) };
      });
    },
  };
}
/** Returns the angle of the rotation nearest to a matrix, column after column. */
const planeTurn = ([a, b, c, d]) => Math.atan2(b - c, a + d);

/** Makes cages in its own thread, one at a time, so that the page stays responsive. */
class CageMaker {
  constructor(module) { this.module = module; }

  /** Calls makeCage() or makeShell() there; throws on a fault, or if it is stopped. */
  make(method, given, vertices, onProgress) {
    this.stop();
    const text = `${wasiHost}\n${importsOf}\n${Engine}
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
        worker.onmessage = worker.onerror = null; // what it has sent already is another cage's news
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
