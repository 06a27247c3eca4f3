// Pointers on a view: drag vertices, lasso, rotate and scale a selection, zoom with the wheel or two fingers.

function attachPointer(view, app) {
  const { div } = view, fingers = new Map();
  let gesture = null; // gesture of the pressed pointer: { move(place, event), end() }
  const pins = new PinPointers({
    placeOf: event => view.placeOf(event),
    press: (place, event) => pressFigure(app, view, place, event),
    hover: (place, event) => hoverFigure(app, view, place, event),
    pinch: fingers => startPinch(app, view, fingers),
  });

  const reach = event => (event.pointerType === 'touch' ? 26 : 13) / view.frame().scale;
  div.addEventListener('pointerdown', event => {
    if (event.button > 0) return;
    div.setPointerCapture(event.pointerId);
    event.preventDefault();
    if (app.dragsFigure) {
      app.pause?.();
      return attempt(app, () => pins.press(event));
    }
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (fingers.size === 2) {
      gesture?.end(true);
      gesture = startPinch(app, view, fingers);
    } else if (fingers.size === 1) {
      app.pause?.();
      gesture = startGesture(app, view, view.placeOf(event), reach(event), event);
    }
  });
  div.addEventListener('pointermove', event => {
    if (app.dragsFigure) return pins.move(event);
    if (fingers.has(event.pointerId)) {
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      gesture?.move(view.placeOf(event), event);
    } else {
      app.hover(nearestVertex(app, view.placeOf(event), 1.7 * reach(event)));
    }
  });
  const release = event => {
    pins.release(event);
    if (!fingers.delete(event.pointerId)) return;
    gesture?.end();
    gesture = null;
  };
  div.addEventListener('pointerup', release);
  div.addEventListener('pointercancel', release);
  div.addEventListener('pointerleave', event => { if (!fingers.has(event.pointerId)) app.hover(-1); pins.leave(event); });
  div.addEventListener('dblclick', event => {
    if (app.dragsFigure) return;
    const edge = kindOf(app.cage).nearestEdge(app.cage, app.shownPose, view.placeOf(event), 1.5 * reach(event));
    if (edge) attempt(app, () => app.addVertex(edge.vertex, edge.share));
  });
  div.addEventListener('wheel', event => {
    zoom(app, view.placeOf(event), Math.exp(0.0015 * Math.max(-200, Math.min(200, event.deltaY))));
    event.preventDefault();
  }, { passive: false });
}

App.prototype.hover = function (vertex) {
  if (vertex === this.hovered) return;
  this.hovered = vertex;
  this.redraw();
};

/** Returns the shown vertex nearest to a place; -1 if none is within reach. Prefers ends of curves to tangents at the same place. */
function nearestVertex(app, [x, y], reach) {
  const pose = app.shownPose, kind = kindOf(app.cage), isShown = kind.shownPoints(app.cage, pose, app.selection);
  let best = -1, least = reach;
  for (let i = 0; 2 * i < pose.length; ++i) {
    const d = Math.hypot(pose[2 * i] - x, pose[2 * i + 1] - y) - (kind.mark(i) === 'rect' ? 1e-3 * reach : 0);
    if (d < least && isShown(i)) { least = d; best = i; }
  }
  return best;
}
/** Returns the distance of a place from a segment, and the parameter of the nearest point, from `margin` to 1 - `margin`. */
function distanceToSide(p, q, [x, y], margin) {
  const [ux, uy] = [q[0] - p[0], q[1] - p[1]];
  const share = Math.max(margin, Math.min(1 - margin, ((x - p[0]) * ux + (y - p[1]) * uy) / (ux * ux + uy * uy) || 0));
  return { gap: Math.hypot(p[0] + share * ux - x, p[1] + share * uy - y), share };
}
/** Returns the side of a polygon nearest to a place: its first vertex and the parameter; null if none is within reach. */
function nearestSide(cage, pose, place, reach) {
  let best = null, least = reach;
  forEachEdge(cage.loops, (i, j) => {
    const { gap, share } = distanceToSide(pointAt(pose, i), pointAt(pose, j), place, 0.1);
    if (gap < least) { least = gap; best = { vertex: i, share }; }
  });
  return best;
}

function zoom(app, [x, y], factor) {
  const w = app.window;
  if (w.w * factor > 40 * app.figure.size || w.w * factor < app.figure.size / 200) return;
  app.window = { x: x + factor * (w.x - x), y: y + factor * (w.y - y), w: w.w * factor, h: w.h * factor };
  app.redraw();
}

/** Starts the gesture of a press at a point. */
function startGesture(app, view, place, reach, event) {
  const grips = app.gripsOf(app.shownPose, 1 / view.frame().scale);
  if (grips) {
    if (distance(grips.turn, place) < reach) return dragSelection(app, turnAbout(grips.middle, place));
    const corner = grips.corners.findIndex(p => distance(p, place) < reach);
    if (corner >= 0) return dragSelection(app, scaleAbout(grips.corners[(corner + 2) % 4], place));
  }
  const found = app.showsCage ? nearestVertex(app, place, reach) : -1, isBox = app.isEditing && app.cage.kind === 'lattice';
  const vertex = found >= 0 && !isBox && kindOf(app.cage).isFixed(app.cage, found) ? -1 : found;
  const shift = to => (x, y) => [x + to[0] - place[0], y + to[1] - place[1]];
  if (event.shiftKey && app.showsCage && app.cage.kind === 'lattice' && !isBox) {
    if (found >= 0) return dragLine(app, found, place, shift);
    const line = lineNear(app.cage, app.shownPose, place, reach);
    if (line) { app.select(line); app.redraw(); return dragSelection(app, shift); }
  }
  if (vertex < 0) return startLasso(app, view, place, event.shiftKey);
  if (event.shiftKey) toggleSelected(app, vertex);
  else if (!app.selection.has(vertex)) app.select([vertex]);
  app.hovered = vertex;
  app.onSelect?.(vertex);
  app.redraw();
  return dragSelection(app, shift);
}
function toggleSelected(app, vertex) {
  app.select(app.selection.has(vertex) ? [...app.selection].filter(i => i !== vertex) : [...app.selection, vertex]);
}
/** Drags the row or column of a lattice through a vertex: the one that the pointer first crosses. A click selects the vertex. */
function dragLine(app, vertex, place, shift) {
  let drag = null;
  return {
    move(to, event) {
      if (!drag) {
        if (to[0] === place[0] && to[1] === place[1]) return;
        app.select(lineAcross(app.cage, app.shownPose, vertex, place, to));
        drag = dragSelection(app, shift);
      }
      drag.move(to, event);
    },
    end() {
      if (drag) return drag.end();
      toggleSelected(app, vertex);
      app.onSelect?.(vertex);
      app.redraw();
    },
  };
}
const turnAbout = (middle, from) => to => {
  const angle = Math.atan2(to[1] - middle[1], to[0] - middle[0]) - Math.atan2(from[1] - middle[1], from[0] - middle[0]);
  return turned(middle, angle);
};
const turned = (middle, angle) => (x, y) => {
  const c = Math.cos(angle), s = Math.sin(angle), [u, v] = [x - middle[0], y - middle[1]];
  return [middle[0] + c * u - s * v, middle[1] + s * u + c * v];
};
const scaleAbout = (fixed, from) => to => {
  const [fx, fy] = [0, 1].map(k => (to[k] - fixed[k]) / (from[k] - fixed[k] || 1));
  return (x, y) => [fixed[0] + fx * (x - fixed[0]), fixed[1] + fy * (y - fixed[1])];
};

/** Moves the selection by mapTo(place) for the pointer's position; Alt breaks smooth ends of curves. */
function dragSelection(app, mapTo) {
  const begin = app.shownPose;
  let moved = false;
  app.drag = true;
  return {
    move(place, event) {
      if (app.selection.size === 0) return; // all are frozen
      if (!moved) app.history.remember();
      moved = true;
      app.moveSelected(mapTo(place), begin, event.altKey);
    },
    end() {
      app.drag = false;
      if (moved) app.finishEdit();
      app.redraw();
    },
  };
}

function startLasso(app, view, place, adds) {
  app.lasso = { view, points: [...place] };
  return {
    move(to) { app.lasso.points.push(...to); app.redraw(); },
    end(isCancelled = false) {
      const { points } = app.lasso, pose = app.shownPose;
      app.lasso = null;
      app.redraw();
      if (isCancelled) return;
      const isShown = kindOf(app.cage).shownPoints(app.cage, pose, app.selection);
      const caught = allOf(pose.length / 2).filter(i => isShown(i) && isInside([points.length / 2], points, ...pointAt(pose, i)));
      app.select(adds ? [...app.selection, ...caught] : caught);
    },
  };
}

/** Handles two fingers: the points under them stay under them, without rotation. */
function startPinch(app, view, fingers) {
  const span = () => {
    const [a, b] = [...fingers.values()];
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], size: Math.hypot(a[0] - b[0], a[1] - b[1]) };
  };
  let last = span();
  const placeAt = ([clientX, clientY]) => view.placeOf({ clientX, clientY });
  return {
    move() {
      const now = span();
      if (fingers.size !== 2) return;
      const from = placeAt(last.middle), to = placeAt(now.middle);
      app.window = { ...app.window, x: app.window.x + from[0] - to[0], y: app.window.y + from[1] - to[1] };
      zoom(app, placeAt(now.middle), last.size / Math.max(now.size, 1));
      last = now;
      app.redraw();
    },
    end() {},
  };
}
