// The state of the page: a figure, its cage and pose, the bindings, and undo.

class App {
  constructor(engine) {
    this.engine = engine;
    this.painter = new FieldPainter();
    this.views = [];
    this.selection = new Set();
    this.hovered = -1;
    this.showsWeights = false;
    this.showsCage = true;
    this.isEditing = false;
    this.dragsFigure = false;
    this.pinDrag = new PinDrag(this, engine.planePins(() => this.leadType));
    this.history = new History(this);
    this.sessions = new Map(); // states of figures shown before, by name
    this.timings = {}; // by coordinate type
    new ResizeObserver(() => this.redraw()).observe(document.getElementById('views'));
  }

  // ---- the figure ----

  /** Returns the state with its undo history; show() continues from it. */
  session() {
    const { figure, cage, pose, pins, clip, kinds, window, history: { earlier, later } } = this;
    return { figure, cage, pose, pins, clip, kinds, window, earlier, later };
  }
  /** Shows a figure in its cage, new or from a session. Throws if it cannot be bound, and then changes nothing. */
  show({ figure, cage, pose = cage.rest.slice(), pins = null, clip = new Clip(), kinds = {}, window = null, earlier = [], later = [] }) {
    const before = [this.figure, this.cage, this.pose, this.clip];
    [this.figure, this.cage, this.pose, this.clip] = [figure, cage, pose, clip];
    this.bound = {};
    this.fields = {};
    try {
      this.ensureBound(this.types[0]);
    } catch (error) {
      [this.figure, this.cage, this.pose, this.clip] = before;
      this.bound = {};
      throw error;
    }
    this.kinds = kinds;
    this.pins = pins;
    this.pinDrag.chosen = this.pinDrag.hovered = -1;
    this.selection.clear();
    this.hovered = -1;
    this.history.set(earlier, later);
    this.window = window;
    if (!window) this.fit();
    if (!this.matchViews()) this.views.forEach(view => view.rebuild());
    this.onClip?.();
    this.redraw();
  }
  /** Fits the posed figure and its cage into the views. */
  fit() {
    const pose = this.shownPose, box = boundsOf([...pairs(pose), ...pairs(this.cloneFigure(this.types[0], pose))]);
    const pad = 0.07 * Math.hypot(box[2] - box[0], box[3] - box[1]);
    this.window = { x: box[0] - pad, y: box[1] - pad, w: box[2] - box[0] + 2 * pad, h: box[3] - box[1] + 2.6 * pad }; // room for the caption
    this.redraw();
  }

  /** Chooses the coordinate types to show for polygons, one view for each. Other cages have one type. */
  setTypes(types) {
    this.chosenTypes = types;
    this.matchViews();
    this.redraw();
  }
  get types() { return kindOf(this.cage).types ?? this.chosenTypes ?? this.engine.polygonTypes.slice(0, 1); }
  /** Makes the views of the types to show; returns false if the views exist. */
  matchViews() {
    const { types } = this;
    if (types.join() === this.views.map(view => view.type).join()) return false;
    const parent = document.getElementById('views');
    this.views = types.map(type => new View(this, type));
    parent.replaceChildren(...this.views.map(view => view.div));
    parent.classList.toggle('many', types.length > 1);
    if (this.figure) this.views.forEach(view => view.rebuild());
    return true;
  }

  // ---- binding ----

  /** Returns coordinates of a type on the current cage, with the figure bound. */
  ensureBound(type) {
    if (this.bound[type]) return;
    const start = performance.now();
    this.engine.makeCoordinates(type, this.cage);
    this.bound[type] = this.engine.bind(type, 0, this.figure.points);
    this.timings[type] = { bind: performance.now() - start, clone: 0, clones: 0 };
    this.fields[type] = null;
    for (let k = 0; k < 20; ++k) this.cloneFigure(type, this.pose); // mean of 20 calls, because the browser's clock is coarse
  }
  fieldOf(type) {
    if (!this.fields[type]) {
      this.fields[type] = fieldMesh(kindOf(this.cage).outline(this.cage), 110);
      this.engine.bind(type, 1, this.fields[type].nodes);
    }
    return this.fields[type];
  }
  /** Binds again after the cage was edited. Throws if the cage is invalid; then nothing is bound. */
  rebind() {
    this.bound = {};
    for (const type of this.types) this.ensureBound(type);
  }

  /** Returns the figure's points, moved by the pose. */
  cloneFigure(type, pose) {
    const start = performance.now(), places = this.engine.clone(type, 0, pose);
    const timing = this.timings[type];
    timing.clone += performance.now() - start;
    ++timing.clones;
    if (timing.clones > 2000) Object.assign(timing, { clone: timing.clone / 2, clones: timing.clones / 2 });
    return places;
  }

  // ---- drawing ----

  get shownPose() { return this.isEditing ? this.cage.rest : this.pose; }
  /** Returns the vertex whose weights are shown: the one under the pointer, else the only selected one; -1 if none. */
  get weightVertex() {
    if (!this.showsWeights || this.drag) return this.showsWeights && this.selection.size === 1 ? [...this.selection][0] : -1;
    return this.hovered >= 0 ? this.hovered : this.selection.size === 1 ? [...this.selection][0] : -1;
  }

  redraw() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => { this.isWaiting = false; this.draw(); });
  }
  draw() {
    if (!this.figure || document.body.classList.contains('in-space')) return;
    const pose = this.shownPose;
    for (const view of this.views) {
      view.drawFrame();
      try {
        this.ensureBound(view.type);
        view.drawFigure(this.cloneFigure(view.type, pose));
        view.drawField(this.weightVertex, pose);
        view.fault = '';
      } catch (error) {
        view.fault = error.message;
      }
      view.drawCage(pose);
    }
    this.drawPins();
    this.tell();
    this.keeper?.look();
  }

  // ---- pins ----

  /** The coordinate type that pins use: that of the view touched last. */
  get leadType() { return this.types.includes(this.lead) ? this.lead : this.types[0]; }
  leadBy({ type }) { this.lead = type; }
  pinCage() {
    const { cage } = this;
    return { type: this.leadType, cage: cage.kind === 'curved' ? { ...cage, around: diskOf(cage) } : cage };
  }
  boundFor() {
    this.ensureBound(this.leadType);
    return this.bound[this.leadType];
  }
  /** Returns the bound points inside the cage at rest, at most a few thousand. */
  pinCandidates() {
    const { points } = this.figure, outline = kindOf(this.cage).outline(this.cage), step = Math.ceil(points.length / 8000);
    return allOf(Math.floor(points.length / 2 / step)).map(i => pointAt(points, i * step)).filter(p => isInside(outline.loops, outline.points, ...p));
  }
  startPins() { return START_PLACES[this.current] ?? innerPoints(this.pinCandidates()); }
  /** Returns the points of the cage that poses do not move. */
  get fixedPoints() { return allOf(this.pose.length / 2).filter(i => kindOf(this.cage).isFixed(this.cage, i)); }
  drawPins() {
    const { pinDrag: drag } = this, isShown = this.dragsFigure && !this.isEditing && drag.readySoon();
    const places = isShown ? drag.placesIn(this.pose) : [];
    for (const view of this.views) view.drawPins(places);
  }

  /** Writes the measurements below the views and in them. */
  tell() {
    const number = new Intl.NumberFormat('en');
    for (const view of this.views) {
      const { bind = 0, clone = 0, clones = 0 } = this.timings[view.type] ?? {}, name = titleOf(view.type);
      view.caption.innerHTML = '';
      const title = document.createElement('b');
      title.textContent = name;
      const outside = this.bound[view.type]?.outside;
      view.caption.append(title, view.fault ? ': ' + view.fault
        : `  bound in ${bind.toFixed(bind < 10 ? 1 : 0)} ms, cloned in ${clones ? (clone / clones).toPrecision(2) : '…'} ms` +
          (outside ? `, ${number.format(outside)} points outside` : ''));
    }
    tellLegend(this, this.weightVertex);
    tellHint(this, this.pinDrag);
    if (this.notice) return;
    this.say(`${this.figure.name}: ${number.format(this.figure.points.length / 2)} points in ${kindOf(this.cage).describe(this.cage)}` +
             (this.selection.size > 0 ? `, ${this.selection.size} selected` : '') + tellPins(this.pinDrag) +
             (this.weightVertex >= 0 ? `; weights of vertex ${this.weightVertex}` : '') +
             (this.isEditing ? '; editing the rest cage' : ''), false);
  }
  /** Writes a message below the views; errors and notices are shown for some seconds. */
  say(text, stays = true, isFault = false) {
    const place = document.getElementById('status');
    if (place.textContent !== text) place.textContent = text;
    place.classList.toggle('fault', isFault);
    if (!stays) return;
    clearTimeout(this.notice);
    this.notice = setTimeout(() => { this.notice = 0; this.redraw(); }, 6000);
  }
  sayFault(error) { this.say(error.message, true, true); }

  // ---- changes ----

  /** Selects vertices, except those that poses do not move. The box of a lattice is edited as a whole. */
  select(vertices) {
    const isBox = this.isEditing && this.cage.kind === 'lattice', chosen = [...vertices];
    this.selection = new Set(isBox && chosen.length > 0 ? allOf(this.cage.rest.length / 2)
      : chosen.filter(i => isBox || !kindOf(this.cage).isFixed(this.cage, i)));
  }
  /** Moves the selected vertices and their tangents; f(x, y, i) returns the new position of each. Nodes of curves stay smooth
   *  where they are smooth at rest, unless `isBroken`. */
  moveSelected(f, from = this.shownPose, isBroken = false) {
    const isBox = this.isEditing && this.cage.kind === 'lattice';
    this.setShownPose(isBox ? moveEach(this.cage, this.selection, f, from) : kindOf(this.cage).move(this.cage, this.selection, f, from, isBroken));
  }
  setShownPose(places) {
    if (this.isEditing) {
      const change = places.map((x, k) => x - this.cage.rest[k]);
      this.cage = { ...this.cage, rest: places };
      this.pose = this.pose.map((x, k) => x + change[k]);
      this.isStale = this.isReshaped = true;
    } else {
      this.pose = places;
    }
    this.redraw();
  }
  /** Binds again after the cage was edited; undoes the edit if binding fails. */
  finishEdit() {
    if (!this.isStale) return;
    const kind = kindOf(this.cage), { cage, pose, isReshaped } = this;
    this.isStale = this.isReshaped = false;
    try {
      if (isReshaped) {
        this.cage = kind.settled(this.engine, kind.reshaped(cage));
        this.pose = followRows(sameRows(pose.length / 2), cage.rest, pose, this.cage.rest);
      }
      this.rebind();
    } catch (error) {
      this.history.undo();
      this.history.later = [];
      this.sayFault(new Error('This cage cannot be used: ' + error.message));
    }
    this.redraw();
  }
  /** Replaces the cage and its pose and bindings; does not throw. */
  replaceCage({ cage, pose, clip = this.clip, kinds = this.kinds }, selection = [], isStep = true) {
    if (isStep) this.history.remember();
    Object.assign(this, { cage, pose, clip, kinds });
    if (this.pins) this.pins = { ...this.pins, held: [] };
    this.select(selection);
    this.hovered = -1;
    this.isStale = true;
    this.finishEdit();
    if (!this.matchViews()) this.views.forEach(view => view.rebuildCage());
    this.onCage?.();
    this.onClip?.();
    this.redraw();
  }
  /** Returns this state with another cage; `rows` map the points of this cage to its points. Throws if the cage is invalid. */
  followedBy(cage, rows, { cage: old, pose, clip } = this) {
    const settled = kindOf(cage).settled(this.engine, cage), moved = clip.copy();
    moved.follow(rows);
    return { cage: settled, pose: followRows(rows, old.rest, pose, settled.rest), clip: moved };
  }
  addVertex(vertex, share = 0.5) {
    const { cage, rows, chosen } = kindOf(this.cage).withPoint(this.cage, vertex, share);
    this.replaceCage(this.followedBy(cage, rows), [chosen]);
  }
  removeSelected() {
    const { cage, rows } = kindOf(this.cage).withoutPoints(this.cage, this.pose, this.selection);
    this.replaceCage(this.followedBy(cage, rows));
  }
  /** Changes numbers of a lattice or a curved cage; the points keep their displacements, or `rows` map them. */
  changeCage(changes, isStep, rows = sameRows(this.cage.rest.length / 2)) {
    this.replaceCage(this.followedBy({ ...this.cage, ...changes }, rows), this.selection, isStep);
  }
  /** Changes points and degree of a lattice; the new pose is the deformation of the old lattice at the new points. */
  changeAxes(axes) {
    if (JSON.stringify(axes) === JSON.stringify(this.cage.axes)) return;
    this.selection.clear(); // its points no longer exist
    this.changeCage({ axes }, true, latticeRows(this.engine, this.cage, this.engine.makeCoordinates('splines', { ...this.cage, axes })));
  }

  /** Shows the figure in a cage of another kind, with its last state or new; or in a given cage, at rest. */
  changeKind(name, given = null) {
    const { cage, pose, clip } = this, kind = cage.kind ?? 'polygon', kinds = { ...this.kinds, [kind]: { cage, pose, clip } };
    if (name === kind && !given) return;
    const left = kinds[name], isLeft = left && (left.cage.of ?? kinds.polygon.cage) === kinds.polygon.cage;
    if (given) this.replaceCage({ cage: given, pose: given.rest.slice(), clip: new Clip(clip.length), kinds });
    else this.replaceCage({ ...(isLeft ? { ...left, clip: left.clip.copy() } : this.newCage(name, kinds.polygon)), kinds });
  }
  newCage(name, polygon) {
    if (name === 'curved') {
      const { cage, rows } = curvesOfPolygon(polygon.cage);
      return this.followedBy({ ...cage, of: polygon.cage }, rows, polygon);
    }
    const axes = axesOf([4, 4], '3'), frame = boxAround(this.figure.drawnSegments());
    const cage = kindOf({ kind: name }).settled(this.engine, { kind: name, axes, frame, falloff: 0, frozen: 0, loops: [] });
    return { cage, pose: cage.rest.slice(), clip: new Clip(polygon.clip.length) };
  }
  /** Selects the next or the previous vertex; `adds` keeps the current selection. */
  stepVertex(by, adds) {
    const count = this.pose.length / 2, last = [...this.selection].pop();
    let next = last === undefined ? (by > 0 ? 0 : count - 1) : (last + by + count) % count;
    for (let k = 0; k < count && kindOf(this.cage).isFixed(this.cage, next); ++k) next = (next + by + count) % count;
    const chosen = adds ? [...this.selection].filter(i => i !== next) : []; // a set keeps the order of insertion
    this.select([...chosen, next]);
    this.hovered = -1;
    this.onSelect?.(next);
    this.redraw();
  }

  // ---- undo ----

  state() {
    const { cage, pose, pins, clip, kinds } = this;
    return { cage, pose, pins, clip: clip.copy(), kinds };
  }
  restore({ cage, pose, pins, clip, kinds }) {
    const isOther = cage !== this.cage;
    this.pinDrag.stop();
    Object.assign(this, { cage, pose, pins: pins ?? this.pins, clip, kinds });
    if (isOther) {
      this.selection.clear();
      this.hovered = -1;
      this.rebind();
      if (!this.matchViews()) this.views.forEach(view => view.rebuildCage());
      this.onCage?.();
    }
    this.onClip?.();
    this.redraw();
  }

  /** Returns the box around the selection, with corner grips for scaling and a grip for rotation; null for fewer than two vertices. */
  gripsOf(pose, unit) {
    if (this.selection.size < 2 || !this.showsCage || this.lasso) return null;
    const pad = 16 * unit, box = boundsOf([...this.selection].map(i => [pose[2 * i], pose[2 * i + 1]]));
    const [x0, y0, x1, y1] = [box[0] - pad, box[1] - pad, box[2] + pad, box[3] + pad];
    return {
      box: [x0, y0, x1, y1], corners: [[x0, y0], [x1, y0], [x1, y1], [x0, y1]],
      turn: [(x0 + x1) / 2, y0 - 26 * unit], middle: [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2],
    };
  }
}

/** Undo and redo. The owner's state() returns a state, and restore() sets it. */
class History {
  constructor(owner) { this.owner = owner; this.set([], []); }
  set(earlier, later) { [this.earlier, this.later] = [earlier, later]; this.changed(); }
  /** Stores the state before a change. */
  remember(state = this.owner.state()) {
    this.earlier.push(state);
    if (this.earlier.length > 200) this.earlier.shift();
    this.later = [];
    this.changed();
  }
  undo() { this.go(this.earlier, this.later); }
  redo() { this.go(this.later, this.earlier); }
  go(from, to) {
    if (from.length === 0) return;
    to.push(this.owner.state());
    this.owner.restore(from.pop());
    this.changed();
  }
  changed() { this.onChange?.(); }
}

/** Shows the legend of the weights' colours, with the vertex they belong to; -1 if there is none yet. */
function tellLegend(app, vertex) {
  document.getElementById('legend').hidden = !app.showsWeights;
  document.getElementById('legend-vertex').textContent = vertex < 0 ? 'the vertex under the pointer, or the selected one' : 'vertex ' + vertex;
}
