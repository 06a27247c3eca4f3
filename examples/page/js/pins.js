// Pins on the figure, which move the cage: the mode "Drag the figure", in 2D and 3D.
//
// An owner (App, MeshView) has `pose` and `pins`; both are replaced, never modified, so that undo can store references. Pins have
// `points` at rest and `targets`, an array of coordinates each; `turns`, null for pins without rotation; `held`, the fixed points of
// the cage; and `pose`, the pose that belongs to the targets.

const NO_PINS = { points: [], targets: [], turns: [], held: [], pose: null };
const PLANE_SAMPLES = 1500; // more samples move the cat by less than 0.2 % of its size
const SPACE_SAMPLES = 2000;
const SAMPLES_EACH = 10;   // at least, per handle
const MOST_AT_ONCE = 150;  // handles; larger cages are sampled in a worker
const DOUBLE_CLICK = 350;  // ms; within this time a second click does not remove the pin
const SETTLING = 300;      // maximum number of frames after the last change
// Initial pins of the sample figures: in the body, so that any limb can be pulled.
const START_PLACES = {
  cat: [[231, 407], [705, 406]],
  biped: [[205, 150], [295, 150]],
  character: [[0, 1.25, 0.14], [-0.15, 0.95, 0.1], [0.15, 0.95, 0.1]],
};

/** Adds `count` candidates to places, each the farthest from all previous places. */
function spreadPoints(candidates, places, count) {
  const gap = (p, q) => p.reduce((sum, x, k) => sum + (x - q[k]) ** 2, 0), all = [...places];
  if (candidates.length === 0) return all;
  const middle = candidates[0].map((x, k) => candidates.reduce((sum, p) => sum + p[k], 0) / candidates.length);
  const gaps = candidates.map(p => all.length > 0 ? Math.min(...all.map(q => gap(p, q))) : gap(p, middle));
  for (let n = 0; n < count; ++n) {
    const best = gaps.reduce((a, x, i) => x > gaps[a] ? i : a, 0);
    if (!(gaps[best] > 0)) break;
    all.push(candidates[best]);
    candidates.forEach((p, i) => { gaps[i] = n === 0 && places.length === 0 ? gap(p, candidates[best]) : Math.min(gaps[i], gap(p, candidates[best])); });
  }
  return all;
}

/** Returns pins for a new figure: one per dimension, among the fifth of its points nearest to their centre. */
function innerPoints(points) {
  if (points.length === 0) return [];
  const middle = points[0].map((x, k) => points.reduce((sum, p) => sum + p[k], 0) / points.length);
  const gap = p => Math.hypot(...p.map((x, k) => x - middle[k])), sorted = [...points].sort((p, q) => gap(p) - gap(q));
  return spreadPoints(sorted.slice(0, Math.max(3, Math.ceil(points.length / 5))), [], middle.length);
}

/** Moves the pose of an owner by its pins, frame by frame, until it settles. */
class PinDrag {
  /** `calls` are those of Engine.planePins() or spacePins(). The owner's boundFor() returns a new object after each bind. Its
   *  startPins() are points of the figure at rest, its fixedPoints those points of the cage that no pose moves. */
  constructor(owner, calls) {
    Object.assign(this, { owner, calls, running: 0, chosen: -1, hovered: -1, spin: 0, sampleTime: 0, frameTime: 0, folded: 0 });
  }

  /** Prepares the solver for the current cage and pins; throws on an error. */
  prepare() {
    const { owner } = this, bound = owner.boundFor();
    if (this.bound !== bound) {
      this.bound = this.given = this.begun = null;
      if (!this.sample(bound)) throw new Error('The pins are being prepared');
    }
    if (!owner.pins) {
      const points = owner.startPins();
      owner.pins = { ...NO_PINS, points, turns: points.map(() => null) };
    }
    this.give();
    if (owner.pins.pose !== owner.pose) this.refresh();
  }
  /** Samples the interior of the cage: at once, or for large cages in a worker. In a worker it returns false and draws when the
   *  samples are complete. */
  sample(bound) {
    const { owner, calls } = this, handles = owner.pose.length / calls.dimension, given = owner.pinCage();
    const samples = Math.max(calls.dimension === 2 ? PLANE_SAMPLES : SPACE_SAMPLES, SAMPLES_EACH * handles), start = performance.now();
    const take = made => {
      calls.take(made);
      this.sampleTime = performance.now() - start;
      this.bound = bound;
    };
    if (handles <= MOST_AT_ONCE) {
      this.making = null;
      take(owner.engine.samplePins({ ...given, isMade: true }, samples));
      return true;
    }
    if (this.making === bound) return false;
    this.making = bound;
    this.maker.make('samplePins', given, samples, () => {}).then(made => {
      if (this.making !== bound) return;
      take(made);
      owner.redraw();
    }).catch(error => {
      if (this.making !== bound) return;
      this.refused = bound;
      owner.sayFault(error);
    });
    return false;
  }
  get isPrepared() { return this.bound === this.owner.boundFor() && !!this.owner.pins; }
  /** Returns whether pins can be shown; otherwise prepares them after the browser has drawn, and draws again. */
  readySoon() {
    const { owner } = this;
    try {
      if (this.isPrepared) this.give();
      if (this.isPrepared) return true;
    } catch (error) {
      owner.sayFault(error);
      return false;
    }
    if (this.isWaiting || this.refused === owner.boundFor()) return false;
    if (this.making === owner.boundFor() && this.bound !== this.making) return false;
    this.isWaiting = true;
    setTimeout(() => {
      this.isWaiting = false;
      try {
        this.prepare();
        owner.redraw();
      } catch (error) {
        if (this.making === owner.boundFor()) return;
        this.refused = owner.boundFor();
        owner.sayFault(error);
      }
    });
    return false;
  }

  /** Sets pins and held points in the library, without invalid pins. */
  give() {
    const { owner } = this;
    for (;;) {
      const { points, turns, held } = owner.pins, turned = points.map((p, i) => (turns[i] ?? null) !== null), key = [points, held, turned.join()];
      if (this.given && key.every((x, k) => x === this.given[k])) return;
      const culprit = this.calls.set(points, turned, [...held, ...owner.fixedPoints]);
      if (culprit < 0) {
        this.given = key;
        this.begun = null;
        return;
      }
      owner.pins = withoutPin(owner.pins, culprit);
    }
  }
  /** Sets the targets to the positions of the pins in the pose. */
  refresh() {
    const { owner } = this, { points, turns } = owner.pins, there = this.calls.locate(owner.pose);
    owner.pins = { ...owner.pins, targets: there.map(({ place }) => place), pose: owner.pose,
      turns: points.map((p, i) => (turns[i] ?? null) === null ? null : this.calls.turnOf(there[i].matrix)) };
  }
  /** Returns the positions of the pins in a pose. */
  placesIn(pose) { return this.calls.locate(pose).map(({ place }) => place); }

  // ---- changes; the caller stores the undo step ----

  /** Adds a pin by its rest point; its target is its position in the pose. Throws if the pin is not inside the cage. */
  add(point) {
    const { owner } = this, { points, targets, turns } = owner.pins, before = owner.pins;
    owner.pins = { ...before, points: [...points, point], targets: [...targets, point], turns: [...turns, null] };
    this.give();
    if (owner.pins.points.length <= points.length) {
      owner.pins = before;
      throw new Error('A pin must be inside the cage');
    }
    const [last] = this.calls.locate(owner.pose).slice(-1);
    owner.pins = { ...owner.pins, targets: [...targets, last.place], pose: owner.pose };
    this.chosen = points.length;
    return point;
  }
  remove(index) {
    this.owner.pins = withoutPin(this.owner.pins, index);
    this.give();
    this.chosen = this.hovered = -1;
  }
  moveTo(index, place) {
    const { pins } = this.owner;
    this.owner.pins = { ...pins, targets: pins.targets.map((p, i) => i === index ? place : p) };
    this.run();
  }
  turnTo(index, turn) {
    const { pins } = this.owner, turns = pins.turns.map((t, i) => i === index ? turn : t);
    this.owner.pins = { ...pins, turns };
    this.give();
    this.run();
  }
  get ringed() { return this.hovered >= 0 ? this.hovered : this.chosen; }
  knobAngle() {
    const turn = this.turnAt(this.ringed);
    return typeof turn === 'number' ? turn : this.spin;
  }
  turnAt(index) { return this.owner.pins.turns[index] ?? this.calls.turnOf(this.calls.locate(this.owner.pose)[index].matrix); }
  /** Fixes points of the cage at their positions in the pose, or releases them. */
  hold(points, isHeld = true) {
    const { pins } = this.owner, others = pins.held.filter(i => !points.includes(i));
    this.owner.pins = { ...pins, held: isHeld ? [...others, ...points] : others };
    this.give();
  }
  /** Moves held points. */
  moveHeld(pose) {
    this.owner.pins = { ...this.owner.pins, pose };
    this.owner.pose = pose;
    this.run();
  }

  // ---- frames ----

  run() {
    this.left = SETTLING;
    if (this.running) return;
    const step = () => {
      this.running = 0;
      if (this.frame()) this.running = requestAnimationFrame(step);
    };
    this.running = requestAnimationFrame(step);
  }
  stop() {
    cancelAnimationFrame(this.running);
    this.running = this.folded = 0;
  }
  /** Computes and draws the next frame; returns whether more frames are needed. */
  frame() {
    const { owner } = this, { pins } = owner;
    if (!pins || pins.pose !== owner.pose || !this.isPrepared || pins.points.length + pins.held.length === 0) return false; // the pose was set elsewhere
    const start = performance.now();
    let settled = true;
    try {
      if (this.begun !== owner.pose) this.calls.begin(owner.pose);
      const solved = this.calls.solve(pins.targets, pins.turns, owner.pose);
      owner.pose = this.begun = solved.pose;
      owner.pins = { ...pins, pose: solved.pose };
      ({ settled, folded: this.folded } = solved);
    } catch (error) {
      owner.sayFault(error);
    }
    const spent = performance.now() - start;
    this.frameTime = this.frameTime ? 0.9 * this.frameTime + 0.1 * spent : spent;
    owner.draw();
    return !settled && --this.left > 0;
  }

  letGo() {
    this.chosen = -1;
    if (document.activeElement?.matches('.pin')) document.activeElement.blur();
    this.owner.redraw();
  }
  /** Selects the next or the previous pin. */
  step(by) {
    const count = this.owner.pins?.points.length ?? 0;
    this.wantsFocus = true;
    if (count > 0) this.chosen = this.chosen < 0 ? (by > 0 ? 0 : count - 1) : (this.chosen + by + count) % count;
    this.owner.redraw();
  }
}
function withoutPin(pins, index) {
  const others = list => list.filter((x, i) => i !== index);
  return { ...pins, points: others(pins.points), targets: others(pins.targets), turns: others(pins.turns) };
}

// ---- marks ----

const isCoarse = () => matchMedia('(pointer: coarse)').matches;
const ringRadius = () => isCoarse() ? 42 : 28; // pixels; a drag from within this radius moves the pin

/** The dots of pins and the ring of the selected pin, in an SVG; Tab moves the focus to the next dot. */
class PinMarks {
  constructor(parent, drag) {
    this.drag = drag;
    this.group = svgElement('g', { class: 'pins' }, parent);
    this.ring = svgElement('circle', { class: 'ring' }, this.group);
    this.knob = svgElement('circle', { class: 'knob' }, this.group);
    this.dots = [];
  }
  /** Draws pins at places; `unit` is the size of a pixel. */
  draw(places, unit, isLead = true, isBehind = () => false) {
    const { drag } = this, turns = drag.owner.pins?.turns ?? [], radius = (isCoarse() ? 9 : 7) * unit;
    while (this.dots.length > places.length) this.dots.pop().remove();
    while (this.dots.length < places.length) {
      const index = this.dots.length, dot = svgElement('circle', { class: 'pin', tabindex: 0, role: 'application' }, this.group);
      dot.addEventListener('focus', () => { drag.chosen = index; drag.owner.redraw(); });
      this.dots.push(dot);
    }
    this.dots.forEach((dot, i) => putAttributes(dot, {
      cx: places[i][0], cy: places[i][1], r: radius, 'aria-label': `Pin ${i + 1} of ${places.length}${turns[i] === null ? '' : ', rotated'}; arrows move it, brackets rotate it, Delete removes it`,
      class: ['pin', i === drag.chosen ? 'chosen' : '', i === drag.hovered ? 'near' : '', turns[i] === null ? '' : 'turned', isBehind(i) ? 'back' : ''].join(' ') }));
    if (isLead && drag.wantsFocus && this.dots[drag.chosen]) {
      drag.wantsFocus = false;
      this.dots[drag.chosen].focus({ preventScroll: true });
    }
    const at = places[drag.ringed], size = ringRadius() * unit;
    this.ring.style.display = this.knob.style.display = at ? '' : 'none';
    if (!at) return;
    const angle = drag.knobAngle() - Math.PI / 2;
    putAttributes(this.ring, { cx: at[0], cy: at[1], r: size });
    putAttributes(this.knob, { cx: at[0] + size * Math.cos(angle), cy: at[1] + size * Math.sin(angle), r: 5 * unit });
  }
}
function putAttributes(element, values) { for (const [name, value] of Object.entries(values)) element.setAttribute(name, value); }

// ---- gestures: { kind, move(place, event), end(isCancelled) } ----

/** Moves a pin with the pointer to `targetAt(place, from)`. A press is on a `pin`, `near` a pin, or has set a
 *  `new` pin. A click on a pin removes it; a click near a pin calls `onClick`. */
function dragPin(drag, kind, point, place, slop, targetAt, onClick = () => removeByClick(drag, point)) {
  const { owner } = drag, index = () => owner.pins.points.indexOf(point), from = owner.pins.targets[index()];
  let moved = false;
  drag.chosen = index();
  drag.wantsFocus = true;
  return {
    kind,
    get moved() { return moved; },
    move(to) {
      if (index() < 0 || (!moved && distance(to, place) < slop)) return;
      if (!moved && kind !== 'new') owner.history.remember();
      moved = true;
      drag.moveTo(index(), targetAt(to, from));
    },
    end(isCancelled) {
      if (moved) {
        drag.onMoved?.();
      } else if (kind === 'new' && isCancelled) {
        owner.history.undo();
        owner.history.later = [];
        owner.history.changed();
      } else if (kind !== 'new' && !isCancelled && index() >= 0) {
        attempt(owner.app ?? owner, onClick);
      }
      owner.redraw();
    },
  };
}
/** Drags points of the cage and holds them; a click on `vertex` lets them go. put(pose, to) moves the points in a pose. */
function holdPoints(owner, points, vertex, place, slop, put) {
  const { pinDrag: drag } = owner;
  let moved = false;
  return {
    kind: 'pin',
    move(to) {
      if (!moved && distance(to, place) < slop) return;
      if (!moved) owner.history.remember();
      if (!moved) drag.hold(points);
      moved = true;
      const pose = owner.pose.slice();
      put(pose, to);
      drag.moveHeld(pose);
    },
    end(isCancelled) {
      if (!moved && !isCancelled && owner.pins.held.includes(vertex)) {
        owner.history.remember();
        drag.hold(points, false);
      }
      owner.redraw();
    },
  };
}
/** Removes a pin, unless the click is the second click of a double click that set the pin. */
function removeByClick(drag, point) {
  const { owner, newest } = drag;
  if (newest?.point === point && performance.now() - newest.time < DOUBLE_CLICK) return;
  owner.history.remember();
  drag.remove(owner.pins.points.indexOf(point));
}
/** Sets a pin at a rest point, as one undo step; returns the point. */
function setPin(drag, point) {
  const before = drag.owner.state();
  drag.add(point);
  drag.owner.history.remember(before);
  drag.newest = { point, time: performance.now() };
  drag.wantsFocus = true;
  return point;
}

/** Rotates a pin by its ring; a click on the ring makes the rotation free again. `turnedBy(turn, angle)` adds a screen angle. */
function turnPin(drag, index, centre, place, turnedBy) {
  const { owner } = drag, point = owner.pins.points[index], from = drag.turnAt(index), angleOf = p => Math.atan2(p[1] - centre[1], p[0] - centre[0]);
  let moved = false, angle = 0, last = angleOf(place);
  drag.chosen = index;
  return {
    kind: 'pin',
    move(to) {
      const now = angleOf(to), at = owner.pins.points.indexOf(point);
      if (at < 0 || now === last) return;
      angle += Math.atan2(Math.sin(now - last), Math.cos(now - last));
      last = now;
      if (!moved) owner.history.remember();
      moved = true;
      drag.spin = angle;
      drag.turnTo(at, turnedBy(from, angle));
    },
    end() {
      const at = owner.pins.points.indexOf(point);
      drag.spin = 0;
      if (!moved && at >= 0 && owner.pins.turns[at] !== null) {
        owner.history.remember();
        drag.turnTo(at, null);
      }
      if (moved) drag.onMoved?.();
      owner.redraw();
    },
  };
}

/** Handles several pointers on an element, each with its own gesture; two pointers without pins zoom. */
class PinPointers {
  /** `on` has placeOf(event), press(place, event), hover(place, event) and pinch(fingers). */
  constructor(on) {
    this.on = on;
    this.fingers = new Map();  // positions on the screen, by pointer
    this.gestures = new Map();
  }
  press(event) {
    const gesture = this.on.press(this.on.placeOf(event), event), others = [...this.gestures.values()];
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    this.gestures.set(event.pointerId, { gesture, time: event.timeStamp });
    const isFree = ({ gesture: { kind, moved }, time }) => kind === 'ground' || (kind !== 'pin' && !moved && event.timeStamp - time < DOUBLE_CLICK);
    if (others.length !== 1 || !isFree(others[0]) || gesture.kind === 'pin') return;
    gesture.end(true);
    others[0].gesture.end(true);
    const shared = this.on.pinch(this.fingers);
    for (const each of this.gestures.values()) each.gesture = shared;
  }
  leave(event) { if (!this.gestures.has(event.pointerId)) this.on.hover([Infinity, Infinity], event); }
  move(event) {
    const place = this.on.placeOf(event), pressed = this.gestures.get(event.pointerId);
    if (!pressed) return this.on.hover(place, event);
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    pressed.gesture.move(place, event);
  }
  release(event) {
    const pressed = this.gestures.get(event.pointerId);
    this.fingers.delete(event.pointerId);
    this.gestures.delete(event.pointerId);
    if (!pressed) return;
    pressed.gesture.end(event.type === 'pointercancel');
    for (const each of this.gestures.values()) if (each.gesture === pressed.gesture) each.gesture = { kind: 'done', move() {}, end() {} };
  }
}

/** Returns the index of the pin in `places` nearest to a place; -1 if none is within reach. */
function nearestPin(places, place, reach) {
  let best = -1, least = reach;
  places.forEach((p, i) => { const d = distance(p, place); if (d < least) { least = d; best = i; } });
  return best;
}
/** Tests whether a place is on the ring of the selected pin; `unit` is the size of a pixel. */
function isOnRing(drag, places, place, unit, reach) {
  const at = places[drag.ringed];
  return at !== undefined && Math.abs(distance(at, place) - ringRadius() * unit) < 0.6 * reach;
}
/** Highlights the pin under the pointer, while the pointer is inside its ring. */
function hoverPin(drag, places, place, unit, reach) {
  const near = nearestPin(places, place, reach), isAbout = drag.hovered >= 0 && distance(places[drag.hovered] ?? [Infinity, 0], place) < ringRadius() * unit + reach;
  const hovered = near >= 0 ? near : isAbout ? drag.hovered : -1;
  if (hovered === drag.hovered) return;
  drag.hovered = hovered;
  drag.owner.redraw();
}

// ---- keys ----

/** Moves the selected pin by pixels; returns false if none is selected. */
function nudgePin(drag, targetBy) {
  const { owner, chosen } = drag;
  if (!(chosen >= 0 && chosen < owner.pins.points.length)) return false;
  drag.prepare();
  owner.history.remember();
  drag.moveTo(chosen, targetBy(owner.pins.targets[chosen]));
  drag.onMoved?.();
  return true;
}
/** Rotates the selected pin. */
function turnByKey(drag, turnedBy) {
  const { owner, chosen } = drag;
  if (!(chosen >= 0 && chosen < owner.pins.points.length)) return;
  drag.prepare();
  owner.history.remember();
  drag.turnTo(chosen, turnedBy(drag.turnAt(chosen)));
}
function removeChosenPin(drag) {
  const { owner, chosen } = drag;
  if (!(chosen >= 0 && chosen < owner.pins?.points.length)) return owner.say('Select a pin first: Tab selects the next one');
  drag.prepare();
  owner.history.remember();
  drag.remove(chosen);
  owner.redraw();
}
function removeAllPins(drag) {
  const { owner } = drag;
  drag.prepare();
  if (owner.pins.points.length + owner.pins.held.length === 0) return;
  owner.history.remember();
  owner.pins = { ...NO_PINS, pose: owner.pose };
  drag.give();
  drag.chosen = drag.hovered = -1;
  owner.redraw();
}

// ---- words ----

const tellPins = ({ owner, frameTime, folded }) => !owner.pins || !document.body.matches('[data-mode=figure]') ? ''
  : `, ${owner.pins.points.length} pin${owner.pins.points.length === 1 ? '' : 's'}` + (owner.pins.held.length > 0 ? `, ${owner.pins.held.length} points of the cage fixed` : '') +
    (frameTime ? `; ${frameTime.toFixed(2)} ms per frame` : '') + (folded > 0 ? `; ${folded} inverted regions` : '');
/** Shows hints: first the basic gestures, then others; none for gestures that the user has made. */
function tellHint(app, drag) {
  const count = drag.owner.pins?.points.length ?? 0, hint = document.getElementById('hint');
  const text = !app.dragsFigure ? '' : count === 1 && app.hinted > 0 ? 'A single pin moves the whole figure: click another place to hold it'
    : ['Click the figure to set a pin, drag it', 'A click on a pin removes it; its ring rotates it'][app.hinted] ?? '';
  hint.hidden = text === '';
  if (hint.textContent !== text) hint.textContent = text;
}
