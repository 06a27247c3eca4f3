// Motions of a cage: tracks of key frames. A track moves some vertices, each along its direction. The library compiles
// a track to cubic pieces and certifies their maximum distance from the curve of the keys.

const KIND = { hold: 0, linear: 1, bezier: 4, automatic: 5 };
const KIND_OF_WORD = { hold: KIND.hold, linear: KIND.linear, automatic: KIND.automatic, ease: KIND.bezier };
const EASE = 0.42; // part of an interval, as in CSS

/** Repeats the keys of a track until they cover a clip, plus one period at both ends, so that slopes agree there. */
function repeatedKeys(track, length) {
  const { keys, period } = track, begin = keys[0].t, all = [];
  const first = Math.floor(-begin / period) - 1, last = Math.ceil((length - begin) / period) + 1;
  for (let turn = first; turn < last; ++turn) {
    const shift = p => p && [p[0] + turn * period, p[1]];
    keys.forEach((key, index) => all.push({ ...key, t: key.t + turn * period, in: shift(key.in), out: shift(key.out), index, turn }));
  }
  all.forEach((key, i) => { // missing handles are horizontal
    const before = i > 0 ? key.t - all[i - 1].t : 0, after = i + 1 < all.length ? all[i + 1].t - key.t : 0;
    key.in ??= [key.t - EASE * before, key.v];
    key.out ??= [key.t + EASE * after, key.v];
  });
  return all;
}
/** Returns the slope of an automatic key, as the library does (Fritsch, Butland 1984). */
function automaticSlope(keys, i) {
  const length = k => keys[k + 1].t - keys[k].t, chord = k => (keys[k + 1].v - keys[k].v) / length(k);
  const isEnd = i === 0 || i + 1 === keys.length;
  const before = chord(i === 0 ? 0 : i - 1), after = chord(i + 1 === keys.length ? i - 1 : i);
  if (isEnd) return before;
  if (!(before * after > 0)) return 0;
  const h = length(i - 1), k = length(i), part = (h + 2 * k) / (3 * (h + k));
  return before * after / (part * after + (1 - part) * before);
}
/** Returns the Bézier curve from key i to the next: four points of time and value. */
function keyInterval(keys, i) {
  const a = keys[i], b = keys[i + 1], third = (b.t - a.t) / 3;
  if (a.kind === KIND.hold) return [[a.t, a.v], [a.t + third, a.v], [b.t - third, a.v], [b.t, a.v]];
  if (a.kind === KIND.linear)
    return [[a.t, a.v], [a.t + third, a.v + (b.v - a.v) / 3], [b.t - third, b.v - (b.v - a.v) / 3], [b.t, b.v]];
  const slope = k => keys[k].kind === KIND.automatic ? automaticSlope(keys, k)
    : (keys[Math.min(k + 1, keys.length - 1)].v - keys[k].v) / ((keys[Math.min(k + 1, keys.length - 1)].t - keys[k].t) || 1);
  const arriving = k => keys[k].kind === KIND.linear || keys[k].kind === KIND.hold
    ? (keys[k].v - keys[k - 1].v) / (keys[k].t - keys[k - 1].t) : slope(k);
  const out = a.kind === KIND.bezier ? a.out : [a.t + third, a.v + third * slope(i)];
  const into = b.kind === KIND.bezier ? b.in : [b.t - third, b.v - third * arriving(i + 1)];
  return [[a.t, a.v], out, into, [b.t, b.v]];
}

class Clip {
  constructor(length = 2.4) {
    this.length = length;
    this.tolerance = 1 / 1920; // the library's default
    this.tracks = [];          // { name, period, keys: [{ t, v, kind, in, out }], targets: [[vertex, dx, dy]], vertex, axis }
  }
  copy() {
    const { length, tolerance, tracks } = this;
    return Object.assign(new Clip(length), { tolerance, tracks: structuredClone(tracks).map(t => ({ ...t, fitted: undefined })) });
  }
  get isEmpty() { return this.tracks.length === 0; }
  get poseTracks() { return this.tracks.filter(track => track.vertex !== undefined); }
  /** Returns the times of the key frames of poses. */
  get keyTimes() { return this.poseTracks[0]?.keys.map(key => key.t) ?? []; }

  /** Returns the pieces of a track and their error; the first call computes them. */
  fitOf(track, engine) {
    if (!track.fitted || track.fitted.tolerance !== this.tolerance) {
      const keys = repeatedKeys(track, this.length);
      const numbers = keys.flatMap(key => [key.t, key.v, key.kind, ...key.in, ...key.out]);
      track.fitted = { ...engine.fit(numbers, this.tolerance), tolerance: this.tolerance };
    }
    return track.fitted;
  }
  valueOf(track, time, engine) {
    const { pieces } = this.fitOf(track, engine);
    let low = 0, high = pieces.length / 5;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (pieces[5 * middle] <= time) low = middle; else high = middle;
    }
    const [begin, c0, c1, c2, c3] = pieces.subarray(5 * low, 5 * low + 5), h = time - begin;
    return c0 + h * (c1 + h * (c2 + h * c3));
  }
  poseAt(time, rest, engine, tracks = this.tracks) {
    const pose = rest.slice();
    for (const track of tracks) {
      const value = this.valueOf(track, time, engine);
      for (const [vertex, dx, dy] of track.targets) {
        pose[2 * vertex] += value * dx;
        pose[2 * vertex + 1] += value * dy;
      }
    }
    return pose;
  }

  /** Sets a key frame of a pose, without the displacements of other tracks. */
  setKey(time, pose, rest, engine) {
    time = Math.min(time, this.length * (1 - 1e-6));
    const others = this.poseAt(time, rest, engine, this.tracks.filter(track => track.vertex === undefined));
    if (this.poseTracks.length === 0) {
      for (let i = 0; 2 * i < rest.length; ++i)
        for (const axis of [0, 1]) this.tracks.push(poseTrack(i, axis, this.length, []));
    }
    for (const track of this.poseTracks) {
      const v = pose[2 * track.vertex + track.axis] - others[2 * track.vertex + track.axis];
      track.keys = track.keys.filter(key => Math.abs(key.t - time) > 1e-6);
      track.keys.push({ t: time, v, kind: KIND.automatic, in: null, out: null });
      track.keys.sort((a, b) => a.t - b.t);
      track.fitted = undefined;
    }
  }
  removeKey(time, reach) {
    const near = this.keyTimes.filter(t => Math.abs(t - time) <= reach);
    if (near.length === 0) return false;
    for (const track of this.poseTracks) {
      track.keys = track.keys.filter(key => !near.includes(key.t));
      track.fitted = undefined;
    }
    this.tracks = this.tracks.filter(track => track.keys.length > 0);
    return true;
  }
  /** Moves the key frames of one time to another time without key frames. */
  moveKeys(from, to) {
    to = Math.max(0, Math.min(this.length * 0.999, to));
    if (this.keyTimes.some(t => t !== from && Math.abs(t - to) < 0.01)) return from;
    for (const track of this.poseTracks) {
      for (const key of track.keys) if (key.t === from) moveKey(key, to, key.v);
      track.keys.sort((a, b) => a.t - b.t);
      track.fitted = undefined;
    }
    return to;
  }
  setLength(length) {
    const factor = length / this.length, scaled = p => p && [p[0] * factor, p[1]];
    for (const track of this.tracks) {
      track.period *= factor;
      track.keys = track.keys.map(key => ({ ...key, t: key.t * factor, in: scaled(key.in), out: scaled(key.out) }));
      track.fitted = undefined;
    }
    this.length = length;
  }

  /** Converts the tracks to another cage: point i follows the old points of rows[i], a list of [point, share]. */
  follow(rows) {
    const own = (vertex, axis) => this.poseTracks.find(track => track.vertex === vertex && track.axis === axis), [first] = this.poseTracks;
    const others = this.tracks.filter(track => track.vertex === undefined).map(track => {
      const moves = new Map();
      for (const [i, dx, dy] of track.targets) moves.set(i, [dx + (moves.get(i)?.[0] ?? 0), dy + (moves.get(i)?.[1] ?? 0)]);
      const targets = rows.map((row, i) => [i, ...[0, 1].map(k => row.reduce((sum, [j, share]) => sum + share * (moves.get(j)?.[k] ?? 0), 0))]);
      return { ...track, targets: targets.filter(([, dx, dy]) => dx !== 0 || dy !== 0) };
    });
    const poses = !first ? [] : rows.flatMap((row, i) => [0, 1].map(axis => {
      const followed = row.map(([j, share]) => [own(j, axis), share]), keys = (followed[0]?.[0] ?? first).keys;
      const isSame = row.length === 1 && row[0][1] === 1;
      return poseTrack(i, axis, first.period, isSame ? keys : keys.map((key, k) =>
        ({ ...key, v: followed.reduce((sum, [track, share]) => sum + share * track.keys[k].v, 0), in: null, out: null })));
    }));
    this.tracks = [...others, ...poses];
  }

  /** Reads a clip file of the programs (support/files/clip_file.hpp). */
  static fromCsv(text, rest) {
    const clip = new Clip();
    let control = null;
    for (const line of text.split('\n').map(l => l.trim()).filter(l => l && !l.startsWith('#'))) {
      const fields = line.split(',').map(f => f.trim()), [word] = fields;
      if (word === 'length') clip.length = Number(fields[1]);
      else if (word === 'control') clip.tracks.push(...tracksOf(control, rest)), control = { name: fields[1], shares: [], pivot: [0, 0], rows: [] };
      else if (word === 'vertices') control.shares.push(...fields.slice(1).map(f => f.split(':').map(Number)));
      else if (word === 'pivot') control.pivot = fields.slice(1).map(Number);
      else if (control && Number.isFinite(parseFloat(word)))
        control.rows.push({ t: Number(word), move: [Number(fields[1]), Number(fields[2]), Number(fields[3]) * Math.PI / 180], kind: KIND_OF_WORD[fields[4]] });
    }
    clip.tracks.push(...tracksOf(control, rest));
    return clip;
  }
}

function poseTrack(vertex, axis, period, keys) {
  const name = `vertex ${vertex}, ${'xy'[axis]}`;
  return { name, vertex, axis, period, keys, targets: [[vertex, axis === 0 ? 1 : 0, axis]] };
}
/** Returns the tracks of a control, which translates by x and y and rotates; small rotations move along the tangent. */
function tracksOf(control, rest) {
  if (!control) return [];
  const { rows, pivot, shares } = control, period = rows[rows.length - 1].t - rows[0].t;
  return [0, 1, 2].filter(axis => rows.some(row => row.move[axis] !== 0)).map(axis => ({
    name: `${control.name}, ${['x', 'y', 'turn'][axis]}`,
    period,
    keys: rows.slice(0, -1).map(({ t, move, kind }) => ({ t, v: move[axis], kind, in: null, out: null })),
    targets: shares.map(([i, w = 1]) => axis === 0 ? [i, w, 0] : axis === 1 ? [i, 0, w]
      : [i, -w * (rest[2 * i + 1] - pivot[1]), w * (rest[2 * i] - pivot[0])]),
  }));
}
/** Moves a key with its handles. */
function moveKey(key, t, v) {
  const shift = p => p && [p[0] + t - key.t, p[1] + v - key.v];
  Object.assign(key, { in: shift(key.in), out: shift(key.out) });
  Object.assign(key, { t, v });
}
