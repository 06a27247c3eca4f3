// Figures and clips: the functions of every frame.

import { CageformError, MADE, NONE, Owner, aligned, refuse, scalarOf, started } from './engine.js';
import { bytesOf, classOf, nameOf, number, options, output, points, whole } from './numbers.js';
import { STATUSES, STRUCTS } from './layout.js';

/** Calls a function that fills a struct, and returns the struct's members. */
export function described(engine, name, at, struct) {
  return engine.scoped(scope => {
    const its = scope.struct(struct);
    engine.check(engine.call(name, at, its));
    return scope.read(struct, its);
  });
}

/** Calls use(scope, members of an output struct), which calls a function that writes points and returns its status. */
export function written(engine, count, dimension, Kind, out, name, use) {
  return engine.scoped(scope => {
    const { members, numbers } = scope.output(count, dimension, Kind);
    engine.check(use(scope, scope.struct('cageform_output', members)));
    const to = output(out, count * dimension, Kind, name);
    to.set(numbers());
    return to;
  });
}

export class Figure extends Owner {
  #Kind = null;
  #room = null; // memory for poses and clones: structs and numbers

  /** Internal: open(), Binding and level() make figures. */
  constructor(made, engine, at, keeps = [], memory = []) {
    super();
    if (made !== MADE) refuse('open() and bind() make figures');
    this._adopt(engine, at, keeps, memory);
    const {
      points: count,
      handles,
      vertices,
      clips,
      levels,
      scalar,
      dimension,
      hasNormals,
      hasTangents,
      hasLabels,
      origin,
    } = described(engine, 'cageform_figure_describe', at, 'cageform_figure_info');
    this.#Kind = classOf(scalar);
    Object.assign(this, {
      points: count,
      handles,
      vertices,
      clips,
      levels,
      dimension,
      scalar: nameOf(this.#Kind),
      hasNormals: hasNormals !== 0,
      hasTangents: hasTangents !== 0,
      hasLabels: hasLabels !== 0,
      origin: origin.slice(0, dimension),
    });
  }

  rest(out) {
    const { _engine: engine, _at: at } = this;
    return written(engine, this.handles, this.dimension, this.#Kind, out, 'out', (scope, to) =>
      engine.call('cageform_figure_rest', at, to),
    );
  }

  labels() {
    const { _engine: engine, _at: at } = this;
    return engine.scoped(scope =>
      Array.from({ length: this.handles }, (x, handle) => {
        const text = scope.struct(4),
          length = scope.struct(4);
        engine.check(engine.call('cageform_figure_label', at, handle, text, length));
        return engine.text(engine.view('u32', text, 1)[0], engine.view('u32', length, 1)[0]);
      }),
    );
  }

  level(level) {
    const { _engine: engine, _at: at } = this;
    if (whole(level, 'level') > this.levels)
      throw new CageformError('index_out_of_bounds', `level: the figure has ${this.levels}`, level);
    return new Figure(
      MADE,
      engine,
      engine.scoped(scope => engine.make(scope, 'cageform_open_level', [at, level, 0])),
      [this._kept],
    );
  }

  /** Allocates the memory for clones, once. It is freed with the figure. */
  #prepare(vectors) {
    if (this.#room !== null && this.#room.vectors >= vectors) return this.#room;
    const { _kept: kept, dimension } = this,
      { engine } = kept,
      Kind = this.#Kind;
    const lengths = {
      pose: dimension,
      points: dimension,
      normals: vectors > 0 ? dimension : 0,
      tangents: vectors > 1 ? 4 : 0,
    };
    const fields = STRUCTS.cageform_output.fields,
      words = STRUCTS.cageform_output.size / 4;
    const room = { vectors, places: {}, structs: {}, views: {}, template: new Uint32Array(4 * words) };
    let bytes = 4 * STRUCTS.cageform_output.size;
    for (const [name, length] of Object.entries(lengths)) {
      const count = name === 'pose' ? this.handles : this.points,
        at = aligned(bytes, 64);
      room.places[name] = { at, size: count * length };
      bytes = at + count * length * Kind.BYTES_PER_ELEMENT;
    }
    room.memory = engine.allocate(bytes + 64);
    room.start = aligned(room.memory, 64);
    Object.entries(room.places).forEach(([name, place], n) => {
      place.at += room.start;
      room.structs[name] = room.start + n * STRUCTS.cageform_output.size;
      const members = {
        data: place.at,
        count: name === 'pose' ? this.handles : this.points,
        bytes: place.size * Kind.BYTES_PER_ELEMENT,
        scalar: scalarOf(Kind),
        dimension: lengths[name],
      };
      for (const [field, value] of Object.entries(members)) room.template[n * words + fields[field][1] / 4] = value;
    });
    if (this.#room !== null) engine.free(this.#room.memory);
    kept.memory = [...kept.memory.filter(at => at !== this.#room?.memory), room.memory];
    return (this.#room = room);
  }
  #view(room, name) {
    const known = room.views[name];
    if (known !== undefined && known.length > 0) return known; // its memory has not grown
    const { at, size } = room.places[name];
    return (room.views[name] = new this.#Kind(this._engine.buffer, at, size));
  }
  /** Clones in the library's memory. */
  #cloned(pose, { normals = false, tangents = false }) {
    const { _engine: engine, _at: at, dimension } = this,
      Kind = this.#Kind;
    engine.ready();
    if (tangents && dimension === 2) refuse('tangents: only 3D figures have tangents');
    const given = points(pose, 'pose', { dimension, Kind });
    if (given.count !== this.handles)
      throw new CageformError('pose_size_differs', `pose: ${this.handles} points are needed, not ${given.count}`);
    const room = this.#prepare(tangents ? 2 : normals ? 1 : 0),
      { structs } = room;
    this.#view(room, 'pose').set(given.numbers);
    engine.view('u32', room.start, room.template.length).set(room.template); // a function may write to structs that it receives
    engine.check(
      engine.call(
        'cageform_clone',
        at,
        structs.pose,
        structs.points,
        normals || tangents ? structs.normals : 0,
        tangents ? structs.tangents : 0,
        0,
      ),
    );
    return room;
  }

  clone(pose, chosen) {
    const { out, normals, tangents } = options(chosen, ['out', 'normals', 'tangents']);
    const room = this.#cloned(pose, { normals, tangents });
    const copy = (name, given, to) => {
      if (!given && name !== 'points') return undefined;
      const from = this.#view(room, name),
        array = output(given, from.length, this.#Kind, to);
      array.set(from);
      return array;
    };
    return {
      points: copy('points', out, 'out'),
      normals: copy('normals', normals, 'normals'),
      tangents: copy('tangents', tangents, 'tangents'),
    };
  }

  cloneView(pose, chosen) {
    const { normals, tangents } = options(chosen, ['normals', 'tangents']);
    const room = this.#cloned(pose, { normals, tangents });
    return {
      points: this.#view(room, 'points'),
      normals: normals || tangents ? this.#view(room, 'normals') : undefined,
      tangents: tangents ? this.#view(room, 'tangents') : undefined,
    };
  }

  gradients(ofPoints, out) {
    const { _engine: engine, _at: at, dimension } = this,
      Kind = this.#Kind;
    const given = points(ofPoints, 'ofPoints', { dimension, Kind });
    return written(engine, this.handles, dimension, Kind, out, 'out', (scope, to) =>
      engine.call('cageform_clone_transposed', at, scope.struct('cageform_points', scope.points(given)), to, 0),
    );
  }

  poseHandles(vertices, out) {
    const { _engine: engine, _at: at, dimension } = this,
      Kind = this.#Kind;
    const given = points(vertices, 'vertices', { dimension, Kind });
    return written(engine, this.handles, dimension, Kind, out, 'out', (scope, to) =>
      engine.call('cageform_pose_handles', at, scope.struct('cageform_points', scope.points(given)), to),
    );
  }

  clip(clip) {
    const { _engine: engine, _at: at } = this;
    return engine.scoped(scope => {
      let found = clip;
      if (typeof clip === 'string') {
        const name = new TextEncoder().encode(clip),
          to = scope.struct(4);
        engine.check(engine.call('cageform_figure_find_clip', at, scope.array(name), name.length, to));
        found = engine.view('u32', to, 1)[0];
        if (found === NONE) throw new CageformError('index_out_of_bounds', `no clip '${clip}'`);
      }
      whole(found, 'clip');
      return new Clip(MADE, engine, engine.make(scope, 'cageform_play', [at, found, 0]), [this._kept]);
    });
  }
}

export class Clip extends Owner {
  #Kind = null;
  #dimension = 0;

  /** Internal: Figure.clip() and compileClip() make clips. */
  constructor(made, engine, at, keeps = [], memory = [], bytes = null) {
    super();
    if (made !== MADE) refuse('Figure.clip() and compileClip() make clips');
    this._adopt(engine, at, keeps, memory);
    const { begin, end, vertices, scalar, dimension, name, nameLength } = described(
      engine,
      'cageform_player_describe',
      at,
      'cageform_clip_info',
    );
    this.#Kind = classOf(scalar);
    this.#dimension = dimension;
    Object.assign(this, {
      begin,
      end,
      vertices,
      scalar: nameOf(this.#Kind),
      dimension,
      bytes,
      name: name === 0 ? null : engine.text(name, nameLength),
    });
  }

  sample(time, out) {
    const { _engine: engine, _at: at } = this;
    number(time, 'time');
    return written(engine, this.vertices, this.#dimension, this.#Kind, out, 'out', (scope, to) =>
      engine.call('cageform_player_sample', at, time, to),
    );
  }
}

/** Copies a file's bytes to memory aligned to 64. Returns the address of the bytes and that of the allocation. */
export function fileAt(engine, bytes) {
  const memory = engine.allocate(bytes.length + 64),
    at = aligned(memory, 64);
  engine.view('u8', at, bytes.length).set(bytes);
  return { memory, at };
}

export function open(source, chosen) {
  const engine = started(),
    bytes = bytesOf(source, 'source');
  const { skipChecksum } = options(chosen, ['skipChecksum']);
  const { memory, at } = fileAt(engine, bytes);
  return new Figure(
    MADE,
    engine,
    orFree(engine, memory, () =>
      engine.scoped(scope => {
        const own = scope.struct('cageform_open_options', { skipChecksum: Boolean(skipChecksum) });
        const made = scope.struct(4),
          culprit = scope.struct(4);
        const code = engine.call('cageform_open', at, bytes.length, own, made, culprit),
          tag = engine.view('u32', culprit, 1)[0];
        if (code !== 0 && tag !== 0) {
          const part = String.fromCharCode(...new Uint8Array(Uint32Array.of(tag).buffer));
          throw new CageformError(
            STATUSES[code],
            `${engine.text(engine.call('cageform_status_text', code))} (part ${part})`,
            part,
          );
        }
        engine.check(code);
        return engine.view('u32', made, 1)[0];
      }),
    ),
    [],
    [memory],
  );
}

/** Returns the result of make(); frees the memory if make() throws. */
export function orFree(engine, memory, make) {
  try {
    return make();
  } catch (error) {
    engine.free(memory);
    throw error;
  }
}
