// Checks and conversion of the caller's numbers.

import { CONSTANTS } from './layout.js';
import { CageformError, outside, refuse } from './engine.js';

const isList = given => Array.isArray(given) || (ArrayBuffer.isView(given) && !(given instanceof DataView));

/** Returns an array of a class: the caller's own if it has this class, else a copy. */
function converted(Kind, given, name) {
  if (given instanceof Kind) return given;
  try {
    return Kind.from(given);
  } catch {
    return refuse(`${name}: numbers are needed`);
  }
}

/** Returns points { numbers, dimension, count } from a flat array or an array of arrays. Does not convert the numbers of a
 *  Float32Array or a Float64Array; `Kind` requires one of the two. */
export function points(given, name, { dimension, Kind = null }) {
  if (given === null || given === undefined) throw new CageformError('argument_null', `${name}: an array is needed`);
  if (!isList(given)) refuse(`${name}: an array is needed`);
  let flat = given;
  if (Array.isArray(given) && isList(given[0])) {
    if (given.some(row => !isList(row) || row.length !== dimension))
      throw new CageformError('dimension_differs', `${name}: ${dimension} numbers per point are needed`);
    flat = given.map(row => Array.from(row)).flat();
  }
  if (flat.length % dimension !== 0)
    throw new CageformError('dimension_differs', `${name}: ${flat.length} numbers are not a multiple of ${dimension}`);
  if (Array.isArray(flat) && flat.some(number => typeof number !== 'number')) refuse(`${name}: numbers are needed`);
  const wanted = Kind ?? (flat instanceof Float32Array ? Float32Array : Float64Array);
  const numbers = outside(converted(wanted, flat, name));
  return { numbers, dimension, count: numbers.length / dimension };
}

/** Returns the numbers of nested arrays as a flat array. Throws if the length of an array differs from its first sibling's. */
export function flattened(given, name) {
  if (!Array.isArray(given) || !isList(given[0])) return given;
  const rows = given.map((row, k) => (isList(row) ? Array.from(flattened(row, `${name}[${k}]`)) : [row]));
  for (const [k, { length }] of rows.entries()) {
    if (length !== rows[0].length)
      throw new CageformError(
        'counts_do_not_match',
        `${name}[${k}] has ${length} number${length === 1 ? '' : 's'}, ${name}[0] ${rows[0].length}`,
      );
  }
  return rows.flat();
}

/** Returns the array to write: the caller's, which must have this size, or a new one. */
export function output(given, size, Kind, name) {
  if (given === undefined || given === null || given === true) return new Kind(size);
  if (!(given instanceof Kind)) throw new CageformError('scalar_differs', `${name}: a ${Kind.name} is needed`);
  if (given.length !== size)
    throw new CageformError('output_too_small', `${name}: ${size} numbers are needed, not ${given.length}`);
  return given;
}

/** Returns the integers of a flat array or of an array of arrays. */
export function indices(given, name) {
  if (given instanceof Uint32Array) return given.slice();
  if (given === null || given === undefined) throw new CageformError('argument_null', `${name}: an array is needed`);
  if (!isList(given)) refuse(`${name}: an array is needed`);
  const flat = Array.isArray(given) ? given.map(row => (isList(row) ? Array.from(row) : row)).flat() : given;
  for (const number of flat) whole(number, name);
  return converted(Uint32Array, flat, name);
}

export function whole(given, name, from = 0) {
  if (!Number.isInteger(given) || given < from || given > 0xffffffff)
    refuse(`${name}: an integer from ${from} to 2^32 - 1 is needed`);
  return given;
}
export function number(given, name) {
  if (typeof given !== 'number') refuse(`${name}: a number is needed`);
  return given;
}
export function numbers(given, count, name) {
  if (!isList(given) || given.length !== count) refuse(`${name}: ${count} numbers are needed`);
  return Array.from(given, x => number(x, name));
}
export function string(given, name) {
  if (typeof given !== 'string') refuse(`${name}: a string is needed`);
  return given;
}
export function progressOf(given) {
  if (given !== undefined && given !== null && typeof given !== 'function') refuse('progress: a function is needed');
  return given ?? null;
}
export function options(given, known) {
  if (given === undefined) return {};
  if (given === null || typeof given !== 'object') refuse('options: an object is needed');
  for (const name of Object.keys(given)) {
    if (!known.includes(name)) refuse(`unknown option ${name}; options: ${known.join(', ')}`);
  }
  return given;
}
export function choice(choices, chosen, name) {
  const given = Object.hasOwn(choices, chosen) || typeof chosen !== 'string' ? chosen : chosen.replaceAll('_', '-');
  if (!Object.hasOwn(choices, given)) {
    const names = Object.keys(choices)
      .map(own => `'${own}'`)
      .join(', ');
    throw new CageformError('choice_unknown', `${name}: one of ${names} is needed`);
  }
  return choices[given];
}

const SCALARS = { float32: Float32Array, float64: Float64Array };
export const scalarClass = given => choice(SCALARS, given, 'scalar');
/** The array class of a scalar code of the library. */
export const classOf = scalar => (scalar === CONSTANTS.FLOAT ? Float32Array : Float64Array);
export const nameOf = Kind => (Kind === Float32Array ? 'float32' : 'float64');

/** Returns the bytes of an ArrayBuffer or of any view. */
export function bytesOf(given, name) {
  if (given instanceof ArrayBuffer) return new Uint8Array(given);
  if (ArrayBuffer.isView(given)) return outside(new Uint8Array(given.buffer, given.byteOffset, given.byteLength));
  throw new CageformError(
    given === null || given === undefined ? 'argument_null' : 'invalid_argument',
    `${name}: bytes are needed`,
  );
}
