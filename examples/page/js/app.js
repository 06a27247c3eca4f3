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
    this.history = new History(this);
    this.sessions = new Map(); // of figures shown before, by name
    this.timings = TYPE_NAMES.map(() => ({ bind: 0, clone: 0, clones: 0 }));
    new ResizeObserver(() => this.redraw()).observe(document.getElementById('views'));
  }

  // ---- the figure ----

  /** Returns the state with its undo history; show() continues from it. */
  session() {
    const { figure, cage, pose, clip, window, history: { earlier, later } } = this;
    return { figure, cage, pose, clip, window, earlier, later };
  }
  /** Shows a figure in its cage, as new or from a session. Throws if it cannot be bound; then nothing changes. */
  show({ figure, cage, pose = cage.rest.slice(), clip = new Clip(), window = null, earlier = [], later = [] }) {
    const before = [this.figure, this.cage, this.pose, this.clip];
    [this.figure, this.cage, this.pose, this.clip] = [figure, cage, pose, clip];
    this.bound = TYPE_NAMES.map(() => null);
    this.fields = TYPE_NAMES.map(() => null);
    try {
      this.ensureBound(this.types?.[0] ?? 0);
    } catch (error) {
      [this.figure, this.cage, this.pose, this.clip] = before;
      this.bound = TYPE_NAMES.map(() => null);
      throw error;
    }
    this.selection.clear();
    this.hovered = -1;
    this.history.set(earlier, later);
    this.window = window;
    if (!window) this.fit();
    this.views.forEach(view => view.rebuild());
    this.onClip?.();
    this.redraw();
  }
  /** Fits the posed figure and its cage into the views. */
  fit() {
    const pose = this.shownPose, box = boundsOf([...pairs(pose), ...pairs(this.cloneFigure(this.types?.[0] ?? 0, pose))]);
    const pad = 0.07 * Math.hypot(box[2] - box[0], box[3] - box[1]);
    this.window = { x: box[0] - pad, y: box[1] - pad, w: box[2] - box[0] + 2 * pad, h: box[3] - box[1] + 2.6 * pad }; // room for the caption
    this.redraw();
  }

  /** Chooses the coordinate types to show, one view for each. */
  setTypes(types) {
    this.types = types;
    const parent = document.getElementById('views');
    this.views = types.map(type => new View(this, type));
    parent.replaceChildren(...this.views.map(view => view.div));
    parent.classList.toggle('many', types.length > 1);
    if (this.figure) this.views.forEach(view => view.rebuild());
    this.redraw();
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
    for (let k = 0; k < 20; ++k) this.cloneFigure(type, this.pose); // the browser's clock is coarse: a mean
  }
  fieldOf(type) {
    if (!this.fields[type]) {
      this.fields[type] = fieldMesh(this.cage, 110);
      this.engine.bind(type, 1, this.fields[type].nodes);
    }
    return this.fields[type];
  }
  /** Binds again after the cage was edited. Throws the cage's fault; then nothing is bound. */
  rebind() {
    this.bound = TYPE_NAMES.map(() => null);
    for (const type of this.types) this.ensureBound(type);
  }

  /** Returns the figure's points, moved by the pose. */
  cloneFigure(type, pose) {
    const start = performance.now(), places = this.engine.clone(type, 0, pose, this.figure.points.length / 2);
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
    this.tell();
  }

  /** Writes the measurements below the views and in them. */
  tell() {
    const number = new Intl.NumberFormat('en');
    for (const view of this.views) {
      const { bind, clone, clones } = this.timings[view.type], name = TYPE_NAMES[view.type];
      view.caption.innerHTML = '';
      const title = document.createElement('b');
      title.textContent = name;
      const outside = this.bound[view.type]?.outside;
      view.caption.append(title, view.fault ? ': ' + view.fault
        : `  bound in ${bind.toFixed(bind < 10 ? 1 : 0)} ms, cloned in ${clones ? (clone / clones).toPrecision(2) : '…'} ms` +
          (outside ? `, ${number.format(outside)} points outside` : ''));
    }
    tellLegend(this, this.weightVertex);
    if (this.notice) return;
    const count = this.cage.rest.length / 2;
    this.say(`${this.figure.name}: ${number.format(this.figure.points.length / 2)} points in a cage of ${count} vertices` +
             (this.selection.size > 0 ? `, ${this.selection.size} selected` : '') +
             (this.weightVertex >= 0 ? `; weights of vertex ${this.weightVertex}` : '') +
             (this.isEditing ? '; the cage at rest is being edited' : ''), false);
  }
  /** Writes a sentence below the views; a fault or a notice stays for some seconds. */
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

  /** Moves the selected vertices; f(x, y, i) returns the new position of each. */
  moveSelected(f, from = this.shownPose) {
    const moved = from.slice();
    for (const i of this.selection) [moved[2 * i], moved[2 * i + 1]] = f(from[2 * i], from[2 * i + 1], i);
    this.setShownPose(moved);
  }
  setShownPose(places) {
    if (this.isEditing) {
      const change = places.map((x, k) => x - this.cage.rest[k]);
      this.cage = { ...this.cage, rest: places };
      this.pose = this.pose.map((x, k) => x + change[k]);
      this.isStale = true;
    } else {
      this.pose = places;
    }
    this.redraw();
  }
  /** Binds again after the cage was edited; undoes the edit if binding fails. */
  finishEdit() {
    if (!this.isStale) return;
    this.isStale = false;
    try {
      this.rebind();
    } catch (error) {
      this.history.undo();
      this.history.later = [];
      this.sayFault(new Error('That cage cannot be used: ' + error.message));
    }
    this.redraw();
  }
  /** Replaces the cage, and keeps the pose; does not throw. */
  replaceCage({ cage, pose }, selection, editClip) {
    this.history.remember();
    [this.cage, this.pose] = [cage, pose];
    editClip();
    this.selection = new Set(selection);
    this.hovered = -1;
    this.isStale = true;
    this.finishEdit();
    this.views.forEach(view => view.rebuildCage());
    this.onClip?.();
    this.redraw();
  }
  addVertex(vertex, share = 0.5) {
    const { loop, begin } = loopOf(this.cage.loops, vertex), next = begin + (vertex + 1 - begin) % this.cage.loops[loop];
    this.replaceCage(withVertex(this.cage, this.pose, vertex, share), [vertex + 1],
                     () => this.clip.insertVertex(vertex, next, share));
  }
  removeSelected() {
    const next = withoutVertices(this.cage, this.pose, this.selection);
    if (!next) return this.sayFault(new Error('A loop needs at least three vertices'));
    const gone = this.selection;
    this.replaceCage(next, [], () => this.clip.removeVertices(gone));
  }
  /** Selects the next or the previous vertex; `adds` keeps the current selection. */
  stepVertex(by, adds) {
    const count = this.pose.length / 2, last = [...this.selection].pop();
    const next = last === undefined ? (by > 0 ? 0 : count - 1) : (last + by + count) % count;
    if (!adds) this.selection.clear();
    this.selection.delete(next); // a set keeps the order of insertion
    this.selection.add(next);
    this.hovered = -1;
    this.onSelect?.(next);
    this.redraw();
  }

  // ---- undo ----

  state() {
    const { cage, pose, clip } = this;
    return { cage, pose, clip: clip.copy() };
  }
  restore({ cage, pose, clip }) {
    const isOther = cage !== this.cage;
    Object.assign(this, { cage, pose, clip });
    if (isOther) {
      this.selection.clear();
      this.hovered = -1;
      this.rebind();
      this.views.forEach(view => view.rebuildCage());
    }
    this.onClip?.();
    this.redraw();
  }

  /** Returns the box around the selection, with its corners for scaling and its point for turning; null for fewer than two vertices. */
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
  remember() {
    this.earlier.push(this.owner.state());
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
  document.getElementById('legend-vertex').textContent = vertex < 0 ? 'the vertex under the pointer or selected' : 'vertex ' + vertex;
}
