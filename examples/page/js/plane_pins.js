// 2D pins: the element under the pointer.

/** Starts the gesture of a press on a view. */
function pressFigure(app, view, place, event) {
  const unit = 1 / view.frame().scale, isTouch = event.pointerType === 'touch', reach = (isTouch ? 26 : 12) * unit, slop = (isTouch ? 7 : 3) * unit;
  const drag = app.pinDrag, { cage } = app;
  app.leadBy(view);
  drag.prepare();
  const places = drag.placesIn(app.pose), shifted = (to, from) => [from[0] + to[0] - place[0], from[1] + to[1] - place[1]];
  const pin = nearestPin(places, place, reach);
  if (pin < 0 && isOnRing(drag, places, place, unit, reach))
    return turnPin(drag, drag.ringed, places[drag.ringed], place, (turn, angle) => turn + angle);
  if (pin >= 0) return dragPin(drag, 'pin', app.pins.points[pin], place, slop, shifted);
  const vertex = app.showsCage ? nearestVertex(app, place, reach) : -1, isOnFigure = view.isOnFigure(event) || nearestPoint(app, view.type, place, reach) >= 0;
  if (vertex >= 0 && !kindOf(cage).isFixed(cage, vertex) && (!isOnFigure || distance(pointAt(app.pose, vertex), place) < reach / 2))
    return holdVertex(app, vertex, place, slop);
  if (!isOnFigure) return moveView(app, view, event);
  const near = nearestPin(places, place, ringRadius() * unit), set = () => setPin(drag, pointUnder(app, view.type, place));
  if (near >= 0) return dragPin(drag, 'near', app.pins.points[near], place, slop, shifted, set);
  try {
    return dragPin(drag, 'new', set(), place, slop, shifted);
  } catch (error) {
    app.sayFault(error);
    return moveView(app, view, event);
  }
}
function hoverFigure(app, view, place, event) {
  const unit = 1 / view.frame().scale;
  if (!app.pinDrag.isPrepared) return;
  app.hover(app.showsWeights ? nearestVertex(app, place, 20 * unit) : -1);
  hoverPin(app.pinDrag, app.pinDrag.placesIn(app.pose), place, unit, (event.pointerType === 'touch' ? 26 : 12) * unit);
  view.div.style.cursor = app.pinDrag.hovered >= 0 || view.isOnFigure(event) ? 'pointer' : 'grab';
}
/** Returns the bound point whose posed position is nearest to a place; -1 if none is within reach. */
function nearestPoint(app, type, [x, y], reach = Infinity) {
  const places = app.cloneFigure(type, app.pose);
  let best = -1, least = reach * reach;
  for (let i = 0; 2 * i < places.length; ++i) {
    const d = (places[2 * i] - x) ** 2 + (places[2 * i + 1] - y) ** 2;
    if (d < least) { least = d; best = i; }
  }
  return best;
}
/** Returns the rest point that the pose moves to a place, or near it if there is none. */
function pointUnder(app, type, place) {
  const { figure: { points, size }, pose } = app, nearest = pointAt(points, nearestPoint(app, type, place));
  const { found, miss } = app.pinDrag.calls.find(nearest, place, pose);
  return miss < 1e-3 * size ? found : nearest;
}
/** Drags a point of the cage and its tangents, and fixes them; a click releases them. */
function holdVertex(app, vertex, place, slop) {
  const { cage, pose: begin } = app, moveBy = (dx, dy, from) => kindOf(cage).move(cage, [vertex], (x, y) => [x + dx, y + dy], from);
  const trial = moveBy(app.figure.size, 0, begin), held = allOf(begin.length / 2).filter(i => trial[2 * i] !== begin[2 * i]);
  return holdPoints(app, held, vertex, place, slop, (pose, to) => {
    for (const i of held) putPoint(pose, i, [begin[2 * i] + to[0] - place[0], begin[2 * i + 1] + to[1] - place[1]]);
  });
}
/** Moves the view with the pointer. */
function moveView(app, view, event) {
  let last = view.placeOf(event);
  app.pinDrag.chosen = -1;
  return {
    kind: 'ground',
    move(to, now) {
      const { window } = app;
      app.window = { ...window, x: window.x + last[0] - to[0], y: window.y + last[1] - to[1] };
      last = view.placeOf(now);
      app.redraw();
    },
    end() {},
  };
}
/** Sets a pin far from all other pins. */
function addFarPin(app) {
  const { pinDrag: drag } = app;
  drag.prepare();
  const { pins } = app, points = spreadPoints(app.pinCandidates(), pins.points, 1);
  if (points.length > pins.points.length) setPin(drag, points[points.length - 1]);
  app.redraw();
}
