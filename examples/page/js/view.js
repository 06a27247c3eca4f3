// A view of the posed figure with one coordinate type: the figure as SVG in its own shadow tree (so that its styles
// and ids stay separate), weights on a canvas, and the cage on top.

class View {
  constructor(app, type) {
    this.app = app;
    this.type = type;
    this.div = document.createElement('div');
    this.div.className = 'view';
    this.div.dataset.type = type;
    const host = document.createElement('div');
    this.shadow = closedTree(host);
    this.field = document.createElement('canvas');
    this.field.className = 'field-canvas';
    this.overlay = svgElement('svg', { class: 'overlay' });
    this.caption = document.createElement('div');
    this.caption.className = 'caption';
    this.div.append(host, this.field, this.overlay, this.caption);
    attachPointer(this, app);
  }

  /** Shows the figure and the cage of the app. */
  rebuild() {
    this.copy = this.app.figure.makeCopy();
    const { root } = this.copy;
    for (const name of ['width', 'height']) root.style.setProperty(name, '100%', 'important');
    root.setAttribute('preserveAspectRatio', 'xMidYMid meet');
    root.style.overflow = 'visible';
    this.shadow.adoptedStyleSheets = [this.app.figure.sheet];
    this.shadow.replaceChildren(root);
    this.rebuildCage();
  }
  rebuildCage() {
    const parts = this.parts = {};
    this.overlay.replaceChildren();
    parts.rest = svgElement('path', { class: 'edge rest' }, this.overlay);
    parts.edges = svgElement('path', { class: 'edge' }, this.overlay);
    parts.tangents = svgElement('path', { class: 'edge tangent' }, this.overlay);
    parts.box = svgElement('rect', { class: 'box' }, this.overlay);
    parts.grips = [0, 1, 2, 3, 4].map(k => svgElement(k < 4 ? 'rect' : 'circle', { class: 'grip' }, this.overlay));
    parts.lasso = svgElement('path', { class: 'lasso' }, this.overlay);
    const { mark } = kindOf(this.app.cage);
    parts.dots = allOf(this.app.pose.length / 2).map(i => svgElement(mark(i), {}, this.overlay));
    parts.pins = new PinMarks(this.overlay, this.app.pinDrag);
  }

  /** Returns the map from the figure's coordinates to pixels of this view: p · scale + (x, y). */
  frame() {
    const { x, y, w, h } = this.app.window, width = this.div.clientWidth, height = this.div.clientHeight;
    const scale = Math.min(width / w, height / h);
    return { scale, x: width / 2 - scale * (x + w / 2), y: height / 2 - scale * (y + h / 2), width, height };
  }
  /** Returns the point under a pointer in the figure's coordinates. */
  placeOf(event) {
    const { scale, x, y } = this.frame(), box = this.div.getBoundingClientRect();
    return [(event.clientX - box.left - this.div.clientLeft - x) / scale, (event.clientY - box.top - this.div.clientTop - y) / scale];
  }

  drawFigure(places) { this.app.figure.write(this.copy, places); }

  drawFrame() {
    const { x, y, w, h } = this.app.window, box = `${x} ${y} ${w} ${h}`;
    if (this.copy.root.getAttribute('viewBox') !== box) {
      this.copy.root.setAttribute('viewBox', box);
      this.overlay.setAttribute('viewBox', box);
    }
  }

  drawCage(pose) {
    const { app, parts } = this, unit = 1 / this.frame().scale, { cage, selection } = app, kind = kindOf(cage);
    const isShown = kind.shownPoints(cage, pose, selection);
    this.overlay.classList.toggle('bare', !app.showsCage);
    parts.edges.setAttribute('d', kind.path(cage, pose));
    parts.rest.setAttribute('d', app.isEditing ? '' : kind.path(cage, cage.rest));
    parts.tangents.setAttribute('d', cage.kind === 'curved' ? tangentLines(cage, pose, isShown) : '');
    const radius = (matchMedia('(pointer: coarse)').matches ? 8 : 5.5) * unit * (app.views.length > 1 ? 0.8 : 1);
    parts.dots.forEach((dot, i) => {
      const [x, y] = pointAt(pose, i), isEnd = kind.mark(i) === 'rect', r = cage.kind === 'curved' && !isEnd ? 0.7 * radius : radius;
      const place = isEnd ? { x: x - r, y: y - r, width: 2 * r, height: 2 * r } : { cx: x, cy: y, r };
      for (const [name, value] of Object.entries(place)) dot.setAttribute(name, value);
      dot.setAttribute('class', ['dot', selection.has(i) ? 'chosen' : '', app.hovered === i ? 'near' : '',
        kind.isFixed(cage, i) ? 'still' : '', isShown(i) ? '' : 'unseen', app.dragsFigure && app.pins?.held.includes(i) ? 'held' : ''].join(' '));
    });
    this.drawGrips(app.gripsOf(pose, unit), unit);
    parts.lasso.setAttribute('d', app.lasso?.view === this ? loopsPath([app.lasso.points.length / 2], app.lasso.points) : '');
  }
  drawPins(places) { this.parts.pins.draw(places, 1 / this.frame().scale, this.type === this.app.leadType); }
  /** Tests whether the figure is drawn under the pointer. */
  isOnFigure({ clientX, clientY }) {
    return this.shadow.elementsFromPoint(clientX, clientY).some(e => e !== this.copy.root && this.copy.root.contains(e));
  }
  drawGrips(grips, unit) {
    const { box, grips: marks } = this.parts;
    for (const mark of [box, ...marks]) mark.style.display = grips ? '' : 'none';
    if (!grips) return;
    const [x0, y0, x1, y1] = grips.box, size = 9 * unit;
    for (const [name, value] of Object.entries({ x: x0, y: y0, width: x1 - x0, height: y1 - y0 })) box.setAttribute(name, value);
    grips.corners.forEach(([x, y], k) => {
      for (const [name, value] of Object.entries({ x: x - size / 2, y: y - size / 2, width: size, height: size }))
        marks[k].setAttribute(name, value);
    });
    for (const [name, value] of Object.entries({ cx: grips.turn[0], cy: grips.turn[1], r: 6 * unit })) marks[4].setAttribute(name, value);
  }

  /** Draws the weights of a vertex over the posed cage; nothing if `vertex` is -1. */
  drawField(vertex, pose) {
    const { app } = this, canvas = this.field, sharp = Math.min(2, devicePixelRatio || 1), f = this.frame();
    const width = Math.round(f.width * sharp), height = Math.round(f.height * sharp);
    if (vertex < 0) {
      if (canvas.width !== 1) canvas.width = canvas.height = 1;
      return;
    }
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const frame = { scale: f.scale * sharp, x: f.x * sharp, y: f.y * sharp }, mesh = app.fieldOf(this.type);
    const weights = Float32Array.from(app.engine.weights(this.type, 1, vertex));
    const places = app.engine.clone(this.type, 1, pose);
    const picture = app.painter.paint(mesh, places, weights, frame, width, height);
    const context = canvas.getContext('2d');
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    if (!picture) return;
    context.save();
    if (app.cage.kind !== 'lattice') { // the outline of a lattice bends between its points
      const clip = new Path2D(kindOf(app.cage).path(app.cage, pose.map((v, k) => v * frame.scale + (k % 2 ? frame.y : frame.x))));
      context.clip(clip, 'evenodd');
    }
    context.drawImage(picture, 0, 0);
    context.restore();
  }
}
