// The WebAssembly module: calls, memory, errors. All other scripts of the package use this one.

import { importsOf, wasiHost } from './host.js';
import { CHOICES, CONSTANTS, STATUSES, STRUCTS } from './layout.js';

/** The invalid index. */
export const NONE = 0xffffffff;

export class CageformError extends Error {
  constructor(status, message, culprit = null, report = null) {
    super(message);
    this.name = 'CageformError';
    this.status = status;
    this.culprit = culprit;
    this.report = report;
  }
}

/** Throws an error for an invalid argument, before a call of the library. */
export function refuse(message) {
  throw new CageformError('invalid_argument', message);
}

/** The exception that unwinds a failed call. */
class CallAborted {
  constructor(code) {
    this.code = code;
  }
}

// Functions that modify an existing object, their first argument. If such a call runs out of memory, its allocations may
// belong to the object. The object is then never used again, not even to free it.
export const CHANGING = new Set([
  'cageform_free',
  'cageform_coordinates_solve',
  'cageform_binding_set_labels',
  'cageform_pins_set',
  'cageform_pins_hold',
  'cageform_pins_solve',
  'cageform_player_sample',
]);

const ARRAYS = { u8: Uint8Array, u32: Uint32Array, f32: Float32Array, f64: Float64Array };

export class Engine {
  /** An instance of a compiled module. */
  static async start(module) {
    const engine = new Engine();
    const own = {
      fail(code) {
        throw new CallAborted(code);
      },
      progress: (context, done) => engine.#tell(done),
      proc_exit() {
        throw new CallAborted(engine.codes.failed);
      },
    };
    const host = wasiHost(() => engine.calls.memory, own);
    engine.calls = (await WebAssembly.instantiate(module, importsOf(module, host))).exports;
    engine.calls._initialize();
    engine.progressAt = engine.calls.cageform_call_progress() >>> 0;
    return engine;
  }

  codes = Object.fromEntries(Object.entries(STATUSES).map(([code, name]) => [name, Number(code)]));
  ended = false; // after a bug of the library
  #busy = false;
  #left = new Set(); // addresses of partly modified objects
  #progress = null; // the callback of the current call
  #raised = null;

  get buffer() {
    return this.calls.memory.buffer;
  }

  #tell(done) {
    try {
      return this.#progress(done) === false ? 0 : 1;
    } catch (error) {
      this.#raised = { error };
      return 0;
    }
  }

  /** Throws if the library has stopped. */
  #goesOn() {
    if (this.ended)
      throw new CageformError('failed', 'the library stopped after an internal error; init() starts it again');
  }
  /** Throws if a call is not possible now. */
  ready() {
    this.#goesOn();
    if (this.#busy) refuse('progress() may not call the library');
  }

  /** Calls a function and returns its result. A call that runs out of memory returns this status, and its memory is freed. */
  call(name, ...given) {
    this.ready();
    if (this.#left.size > 0 && this.#left.has(given[0])) return this.codes.object_of_another_kind;
    const { calls } = this,
      stack = calls.__stack_pointer.value;
    this.#busy = true;
    try {
      calls.cageform_call_begin();
      return calls[name](...given);
    } catch (error) {
      calls.__stack_pointer.value = stack;
      if (error instanceof CallAborted) {
        if (CHANGING.has(name)) this.#left.add(given[0]);
        else calls.cageform_call_undo();
        return error.code;
      }
      this.ended = true;
      return this.codes.failed;
    } finally {
      this.#busy = false;
    }
  }

  /** Throws the error of a status that is not ok. */
  check(code, report = null) {
    if (code === 0) return;
    const status = STATUSES[code] ?? 'failed';
    if (report !== null) report.status = status;
    this.#goesOn();
    throw new CageformError(
      status,
      report?.message || this.text(this.call('cageform_status_text', code)),
      report?.culprit ?? null,
      report,
    );
  }

  text(at, length) {
    const bytes = new Uint8Array(this.buffer, at >>> 0, length);
    return new TextDecoder().decode(length === undefined ? bytes.subarray(0, bytes.indexOf(0)) : bytes);
  }

  /** Returns the address of new memory, for free(). */
  allocate(bytes) {
    this.ready();
    const at = bytes > NONE ? 0 : this.calls.malloc(Math.max(bytes, 1)) >>> 0;
    if (at === 0) throw new CageformError('out_of_memory', 'not enough memory');
    return at;
  }
  free(at) {
    if (!this.ended) this.calls.free(at);
  }

  /** Returns a view of numbers in memory, valid until the memory grows. */
  view(kind, at, count) {
    return new ARRAYS[kind](this.buffer, at, count);
  }

  /** Calls use(scope); memory of the scope is freed afterwards. */
  scoped(use) {
    this.ready();
    const scope = new Scope(this);
    try {
      return use(scope);
    } finally {
      scope.free();
    }
  }

  /** Makes an object: calls a function whose argument after `given` is the output pointer. Returns the object's address. With
   *  the status `accepts`, there is an object, too. */
  make(scope, name, given, { report = null, progress = null, accepts = 0 } = {}) {
    const made = scope.struct(4);
    const code = this.run(name, [...given, made, ...(report === null ? [] : [report])], progress);
    if (code !== accepts) this.check(code, report === null ? null : scope.report(report));
    return this.view('u32', made, 1)[0];
  }

  /** Calls a function with a progress callback. Rethrows an exception of the callback. */
  run(name, given, progress) {
    this.#progress = progress;
    this.#raised = null;
    const code = this.call(name, ...given);
    const raised = this.#raised;
    this.#progress = this.#raised = null;
    if (raised !== null) throw raised.error;
    return code;
  }
}

/** The memory of a call. */
export class Scope {
  #taken = [];
  constructor(engine) {
    this.engine = engine;
  }

  free() {
    for (const at of this.#taken) this.engine.free(at);
  }

  #take(bytes) {
    const at = this.engine.allocate(bytes);
    this.#taken.push(at);
    return at;
  }

  /** Allocates a struct with the given members, the others 0; or a number of zero bytes. */
  struct(name, members = {}) {
    const size = typeof name === 'number' ? name : STRUCTS[name].size;
    const at = this.#take(size);
    this.engine.view('u8', at, size).fill(0);
    if (typeof name === 'string') {
      if (STRUCTS[name].fields.size !== undefined) this.#write(at, name, { size });
      this.#write(at, name, members);
    }
    return at;
  }
  /** Allocates an array of structs. */
  structs(name, all) {
    const { size } = STRUCTS[name],
      at = this.struct(Math.max(all.length, 1) * size);
    all.forEach((members, n) => this.#write(at + n * size, name, members));
    return at;
  }
  #write(at, name, members) {
    const data = new DataView(this.engine.buffer);
    for (const [field, value] of Object.entries(members)) {
      const [kind, offset] = STRUCTS[name].fields[field];
      const place = at + offset;
      if (kind === 'u32') [value].flat().forEach((number, n) => data.setUint32(place + 4 * n, number, true));
      else if (kind === 'i32') data.setInt32(place, Number(value), true);
      else if (kind === 'f64') [value].flat(2).forEach((number, n) => data.setFloat64(place + 8 * n, number, true));
      else this.#write(place, kind, value);
    }
  }
  /** Returns members of a struct in memory. */
  read(name, at) {
    const data = new DataView(this.engine.buffer),
      read = {};
    for (const [field, [kind, offset, count]] of Object.entries(STRUCTS[name].fields)) {
      const place = at + offset;
      if (kind === 'u32' && count > 1)
        read[field] = Array.from({ length: count }, (_, k) => data.getUint32(place + 4 * k, true));
      else if (kind === 'u32') read[field] = data.getUint32(place, true);
      else if (kind === 'i32') read[field] = data.getInt32(place, true);
      else if (kind === 'f64' && count > 1)
        read[field] = Array.from({ length: count }, (_, k) => data.getFloat64(place + 8 * k, true));
      else if (kind === 'f64') read[field] = data.getFloat64(place, true);
      else if (kind === 'u8') read[field] = this.engine.text(place);
      else if (kind !== 'u64' && count === 1) read[field] = this.read(kind, place);
    }
    return read;
  }

  layout(name) {
    return STRUCTS[name];
  }

  /** Copies a typed array, and returns its address; 0 for null. */
  array(numbers, alignment = 8) {
    if (numbers === null) return 0;
    const bytes = new Uint8Array(numbers.buffer, numbers.byteOffset, numbers.byteLength);
    const at = aligned(this.#take(bytes.length + alignment), alignment);
    this.engine.view('u8', at, bytes.length).set(bytes);
    return at;
  }
  string(text) {
    return this.array(new TextEncoder().encode(text + '\0'));
  }

  /** Returns the members of a cageform_points for a copy of the numbers. */
  points({ numbers, dimension, count }) {
    return {
      data: this.array(numbers),
      count,
      bytes: numbers.byteLength,
      scalar: scalarOf(numbers.constructor),
      dimension,
    };
  }
  /** Returns the members of a cageform_output with memory for points, and a function that reads the points. */
  output(count, dimension, Kind) {
    const bytes = count * dimension * Kind.BYTES_PER_ELEMENT;
    const at = aligned(this.#take(bytes + 8), 8);
    const members = { data: at, count, bytes, scalar: scalarOf(Kind), dimension };
    return { members, numbers: () => new Kind(this.engine.buffer, at, count * dimension) };
  }

  running(progress) {
    if (progress === undefined || progress === null) return 0;
    return this.struct('cageform_running', { progress: this.engine.progressAt });
  }
  newReport() {
    return this.struct('cageform_report', { culprit: NONE });
  }
  report(at) {
    return new Report(this.read('cageform_report', at), this.engine);
  }
}

export const aligned = (at, alignment) => Math.ceil(at / alignment) * alignment;
export const scalarOf = Kind => (Kind === Float32Array ? CONSTANTS.FLOAT : CONSTANTS.DOUBLE);

const ELEMENTS = {
  [CONSTANTS.VERTEX]: 'vertex',
  [CONSTANTS.EDGE]: 'edge',
  [CONSTANTS.FACE]: 'face',
  [CONSTANTS.LOOP]: 'loop',
};

const ENDS = Object.keys(CHOICES.wrapEnd);

/** An error or a warning about a cage. */
export class Fault {
  constructor(its, engine) {
    const element = (kind, index) => (ELEMENTS[kind] === undefined ? null : { kind: ELEMENTS[kind], index });
    this.text = engine.text(its.text);
    this.isWarning = its.status === 0;
    this.a = element(its.aIs, its.a);
    this.b = element(its.bIs, its.b);
  }
  toString() {
    const named = [this.a, this.b]
      .filter(Boolean)
      .map(({ kind, index }) => `${kind} ${index}`)
      .join(', ');
    return this.text + (named ? ` (${named})` : '');
  }
}

/** The result of a call. */
export class Report {
  constructor({ size, reserved, status, culprit, frame, fault, settled, ended, ofTarget, ...numbers }, engine) {
    this.status = STATUSES[status] ?? 'failed';
    this.culprit = culprit === NONE ? null : culprit;
    Object.assign(this, numbers);
    this.settled = settled !== 0;
    this.ended = ENDS[ended];
    this.ofTarget = ofTarget !== 0;
    this.fault = fault.text === 0 ? null : new Fault(fault, engine);
  }
  toString() {
    const lines = this.message ? [this.message] : [];
    for (const [name, value] of Object.entries(this)) {
      if (typeof value === 'number' && value !== 0 && name !== 'culprit')
        lines.push(`${name}: ${Number(value.toPrecision(4))}`);
    }
    return lines.join('\n') || 'ok';
  }
}

/** An object of the library with a reference count: it is freed when its owner and all its users have released it. */
class Kept {
  constructor(engine, at, keeps = [], memory = []) {
    Object.assign(this, { engine, at, keeps, memory, users: 1 });
    for (const other of keeps) ++other.users;
  }
  release() {
    if (--this.users > 0) return;
    const { engine } = this;
    if (!engine.ended) {
      if (this.at !== 0) engine.call('cageform_free', this.at);
      for (const at of this.memory) engine.free(at);
    }
    for (const other of this.keeps) other.release();
  }
}

const dropped = new FinalizationRegistry(kept => kept.release());

/** The first argument of internal constructors. */
export const MADE = Symbol('made');

/** The base of classes that own an object of the library. */
export class Owner {
  #kept = null;

  /** Takes ownership of an object. */
  _adopt(engine, at, keeps, memory) {
    this.#kept = new Kept(engine, at, keeps, memory);
    dropped.register(this, this.#kept, this);
  }
  get _kept() {
    if (this.#kept === null) throw new CageformError('object_of_another_kind', 'the object is freed');
    return this.#kept;
  }
  get _engine() {
    return this._kept.engine;
  }
  get _at() {
    return this._kept.at;
  }

  /** Frees the memory now, before garbage collection. Objects created from this one stay usable. */
  free() {
    if (this.#kept === null) return;
    this.#kept.engine.ended || this.#kept.engine.ready();
    dropped.unregister(this);
    const kept = this.#kept;
    this.#kept = null;
    kept.release();
  }
}

/** Returns an argument; throws if it is not an object of a class and of this engine. */
export function objectOf(Class, given, name, engine = null) {
  if (!(given instanceof Class))
    throw new CageformError(
      given === null || given === undefined ? 'argument_null' : 'object_of_another_kind',
      `${name}: a ${Class.name} is needed`,
    );
  if (engine !== null && given._engine !== engine)
    throw new CageformError('object_of_another_kind', `${name}: it belongs to another instance of the library`);
  return given;
}

let current = null;

/** Returns an array of numbers; copies views of the library's memory, because a call may grow and move this memory. */
export const outside = array => (current !== null && array.buffer === current.buffer ? array.slice() : array);

/** Returns the started library: the full one, or the one with the functions of every frame. */
export function started(bind = false) {
  if (current === null || (bind && current.calls.cageform_bind === undefined))
    refuse(
      bind && current !== null
        ? "this needs init() of 'cageform', not of 'cageform/runtime'"
        : 'call await init() first',
    );
  current.ready();
  return current;
}

/** Starts the library of a module, unless a library with its functions is running. */
export async function start(source, file, bind) {
  const has = engine => engine.calls[bind ? 'cageform_bind' : 'cageform_open'] !== undefined;
  const serves = () => current !== null && !current.ended && has(current);
  if (serves()) return;
  const module = await compile(source ?? file);
  const engine = await Engine.start(module).catch(error => refuse('init: the module cannot start: ' + error.message));
  if (!has(engine)) refuse('init: the module lacks required functions');
  if (!serves()) current = engine;
}

/** Returns a compiled module from bytes, an address, a response or its promise, or a compiled module. */
async function compile(source) {
  const given = await source;
  if (given instanceof WebAssembly.Module) return given;
  let bytes = given;
  if (given instanceof URL || typeof given === 'string') bytes = await load(given);
  else if (typeof Response !== 'undefined' && given instanceof Response) bytes = await given.arrayBuffer();
  if (!(bytes instanceof ArrayBuffer) && !ArrayBuffer.isView(bytes))
    refuse('init: bytes, a compiled module, a response or an address is needed');
  return WebAssembly.compile(bytes).catch(error => refuse('init: ' + error.message));
}
async function load(address) {
  if (String(address).startsWith('file:') && typeof process !== 'undefined' && process.versions?.node) {
    const files = 'node:fs/promises'; // in a variable, so that bundlers ignore it; browsers do not have it
    return (await import(/* webpackIgnore: true */ /* @vite-ignore */ files)).readFile(new URL(address));
  }
  const response = await fetch(address);
  if (!response.ok) refuse(`init: ${address}: ${response.status}`);
  return response.arrayBuffer();
}
