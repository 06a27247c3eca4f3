// Buttons, keys, dropped files, and the start of the page.

const byId = id => document.getElementById(id);

const isInSpace = () => document.body.classList.contains('in-space');

// ---- figures ----

/** Opens a dropped or chosen file beside the others, and makes its cage with make_cage. */
async function openFile(app, file) {
  await attempt(app, async () => {
    const [, name, kind] = /^(.*?)(?:\.(svgz?|obj))?(?:\.gz)?$/is.exec(file.name), { text, note } = await readText(file);
    if (/obj/i.test(kind)) return openMesh(app, name, parseObj(text, file.name), note);
    const figure = new Figure(text, name), key = crypto.randomUUID();
    const cage = await makeCage(app, 'makeCage', figure.drawnSegments(), wantedVertices());
    showFigure(app, key, { figure, cage });
    addFile(app, key, { name, text, isMesh: false });
    app.say(`${name}: ${tellMade(cage, cage.rest.length / 2)}, at least ${cage.clearance.toPrecision(3)} from the drawing${note}`);
  });
}
/** Shows a mesh in a new cage: in addition to the others, or in place of the figure `key`. */
async function openMesh(app, name, mesh, note = '', key = crypto.randomUUID()) {
  const vertices = Math.max(8, Math.min(400, Math.round(Number(byId('mesh-count').value)) || 112));
  const cage = await makeCage(app, 'makeShell', mesh, vertices);
  showSpace(app, key, { name, mesh, cage });
  addFile(app, key, { name, text: mesh.text, isMesh: true });
  app.say(`${name}: ${tellMade(cage, cage.vertices.length / 3)}${note}`);
}
/** Opens files one after the other, because make_cage makes one cage at a time. */
function openFiles(app, files) {
  for (const file of files) app.opening = Promise.resolve(app.opening).then(() => openFile(app, file));
}
/** Adds a button for an opened file, and stores the file. */
function addFile(app, key, { name, text, isMesh }) {
  if (!app.files.has(key)) {
    const titles = [...app.files.values()].map(file => file.title), titleOf = n => n === 1 ? name : `${name} (${n})`;
    let n = 1;
    while (titles.includes(titleOf(n))) ++n;
    app.files.set(key, { name, text, isMesh, title: titleOf(n), opened: Date.now() });
    addFileButton(app, key);
  }
  app.keeper.change(key);
  markFigure(app);
}
function addFileButton(app, key) {
  const button = document.createElement('button');
  button.dataset.figure = key;
  button.textContent = app.files.get(key).title;
  button.onclick = () => chooseFigure(app, key);
  byId('files').append(button);
}
/** Closes the shown file. */
async function closeFile(app) {
  const { current: key, sessions, history: { earlier } } = shownOwner(app);
  if (earlier.length > 0 && !confirm(`Close ${app.files.get(key).title}? Its pose and undo are lost.`)) return;
  app.files.delete(key);
  document.querySelector(`[data-figure="${key}"]`).remove();
  if (isInSpace()) app.mesh.current = undefined;
  await chooseFigure(app, isInSpace() ? app.current : 'cat');
  sessions.delete(key);
  app.kept.delete(key);
  app.keeper.forget(key);
}
const wantedVertices = () => Math.max(4, Math.min(80, Math.round(Number(byId('count').value)) || 24));
const tellMade = ({ milliseconds }, count) =>
  `make_cage took ${milliseconds < 1000 ? milliseconds.toFixed(0) + ' ms' : (milliseconds / 1000).toFixed(1) + ' s'} for ${count} vertices`;

/** Makes a cage with make_cage; shows a progress bar with a stop button. A later call stops an earlier one and keeps the bar. */
async function makeCage(app, method, given, vertices) {
  const work = app.work = {};
  byId('work').hidden = false;
  const tell = done => {
    byId('work-bar').value = done;
    byId('work-text').textContent = `make_cage: ${Math.round(100 * done)} %`;
  };
  tell(0);
  try {
    return await app.cageMaker.make(method, given, vertices, tell);
  } finally {
    if (app.work === work) byId('work').hidden = true;
  }
}

/** Shows a new 2D figure; stores the state of the previous one. */
function showFigure(app, name, session) {
  app.pause();
  if (app.current && app.current !== name) app.sessions.set(app.current, app.session());
  app.show(session);
  app.current = name;
  markKind(app);
  showPlane(app);
}
function markFigure(app) {
  const { current: shown } = shownOwner(app);
  byId('close').hidden = !app.files.has(shown);
  for (const button of document.querySelectorAll('#figures [data-figure]')) button.classList.toggle('chosen', button.dataset.figure === shown);
  for (const id of ['mesh-pose', 'mesh-dance']) byId(id).disabled = shown !== 'character';
  markHistory(app);
}
function markHistory(app) {
  const { earlier, later } = historyOf(app);
  byId('undo').disabled = earlier.length === 0;
  byId('redo').disabled = later.length === 0;
}
const historyOf = app => isInSpace() ? app.mesh.history : app.history;
const pinDragOf = app => isInSpace() ? app.mesh.pinDrag : app.pinDrag;

function showPlane(app) {
  dance(app, false);
  document.body.classList.remove('in-space');
  markFigure(app);
  app.redraw();
}
/** Shows a mesh: new if a session is given, otherwise with its last state. */
function showSpace(app, name, session) {
  app.pause();
  dance(app, false);
  document.body.classList.add('in-space');
  if (session) app.mesh.leave(name, session);
  markFigure(app);
  app.mesh.redraw();
}
function dance(app, isOn) {
  byId('mesh-dance').setAttribute('aria-pressed', isOn);
  app.mesh.toggleDance(isOn);
}
/** Shows a figure with its last state, also from before a reload; the sample figures have their own cages. */
async function chooseFigure(app, key) {
  await attempt(app, async () => {
    const file = app.files.get(key), kept = app.kept.get(key);
    app.kept.delete(key);
    if (kept) withClips(kept);
    if (file?.isMesh || key === 'character') {
      if (key === app.mesh.current) return showSpace(app, key, null);
      return showSpace(app, key, app.mesh.sessions.get(key) ??
        { ...file ? { mesh: parseObj(file.text, file.name) } : await readCharacter(DATA.character), ...kept });
    }
    if (key === app.current) return showPlane(app);
    showFigure(app, key, app.sessions.get(key) ?? { ...file ? { figure: new Figure(file.text, file.name) }
      : { figure: new Figure(DATA[key].figure, key), cage: cageOfSvg(DATA[key].cage) }, ...kept });
  });
}
function chooseTypes(app, word) {
  app.setTypes(word === 'all' ? app.engine.polygonTypes : [word]);
  for (const button of document.querySelectorAll('#types button')) button.classList.toggle('chosen', button.dataset.type === word);
}
/** Shows the figure in a cage of another kind. */
function chooseKind(app, name) {
  app.pause();
  if (app.isEditing) toggle(app, 'edit', 'isEditing');
  app.changeKind(name);
}
async function openCage(app, file) {
  await attempt(app, async () => {
    const cage = readCage((await readText(file)).text, file.name);
    app.pause();
    if (app.isEditing) toggle(app, 'edit', 'isEditing');
    app.changeKind(cage.kind ?? 'polygon', kindOf(cage).settled(app.engine, cage));
  });
}
/** Shows the kind of the cage and its numbers in the tools. */
function markKind(app) {
  const { cage } = app, kind = cage.kind ?? 'polygon';
  document.body.dataset.cage = kind;
  for (const button of document.querySelectorAll('#cages button')) button.classList.toggle('chosen', button.dataset.cage === kind);
  for (const button of document.querySelectorAll('#types button')) button.disabled = kind !== 'polygon';
  byId('walk').disabled = app.current !== 'cat' || kind !== 'polygon';
  byId('edit').title = kind === 'lattice' ? "E: move, rotate and scale the lattice's box; the figure is bound again"
    : 'E: drag vertices of the rest cage; the figure is bound again';
  if (kind === 'lattice') {
    [byId('columns').value, byId('rows').value] = countsOf(cage);
    byId('degree').value = degreeWord(cage);
    byId('falloff').value = cage.falloff / diagonalOf(cage.frame);
    byId('frozen').value = cage.frozen;
  } else if (kind === 'curved') {
    byId('disk').value = cage.disk;
  }
}
function connectKinds(app) {
  for (const button of document.querySelectorAll('#cages button')) button.onclick = () => attempt(app, () => chooseKind(app, button.dataset.cage));
  byId('open-cage').onchange = event => { if (event.target.files[0]) openCage(app, event.target.files[0]); event.target.value = ''; };
  const count = id => Math.max(2, Math.min(20, Math.round(Number(byId(id).value)) || 4));
  const change = f => attempt(app, () => { app.pause(); f(); });
  for (const id of ['columns', 'rows', 'degree'])
    byId(id).onchange = () => change(() => app.changeAxes(axesOf([count('columns'), count('rows')], byId('degree').value || '3')));
  byId('frozen').onchange = event => change(() => {
    const frozen = Math.max(0, Math.min(9, Math.round(Number(event.target.value)) || 0)), cage = { ...app.cage, frozen };
    const rows = sameRows(cage.rest.length / 2).map((row, i) => isFrozen(cage, i) ? [] : row);
    if (rows.every(row => row.length === 0)) { markKind(app); throw new Error(`With ${frozen} frozen layers the lattice has no movable points`); }
    app.changeCage({ frozen }, true, rows);
  });
  connectSlider(app, 'falloff', share => ({ falloff: share * diagonalOf(app.cage.frame) }));
  connectSlider(app, 'disk', disk => ({ disk }));
}
/** Changes the cage while a slider moves, as one undo step. */
function connectSlider(app, id, changes) {
  let isMoving = false;
  byId(id).oninput = event => attempt(app, () => {
    app.pause();
    app.changeCage(changes(Number(event.target.value)), !isMoving);
    isMoving = true;
  });
  byId(id).onchange = () => { isMoving = false; };
}
/** Chooses what a drag moves: the figure (with pins) or the cage. */
function setMode(app, name) {
  app.dragsFigure = name === 'figure';
  document.body.dataset.mode = name;
  for (const button of document.querySelectorAll('#modes button')) {
    button.classList.toggle('chosen', button.dataset.drag === name);
    button.setAttribute('aria-pressed', button.dataset.drag === name);
  }
  if (app.dragsFigure && app.isEditing) toggle(app, 'edit', 'isEditing');
  app.select([]);
  app.hovered = app.mesh.near = app.mesh.selected = -1;
  for (const { div } of app.views) div.style.cursor = '';
  app.redraw();
  app.mesh.redraw();
}
/** A toggle button. */
function toggle(app, id, name) {
  app[name] = !app[name];
  byId(id).setAttribute('aria-pressed', app[name]);
  app.redraw();
  app.mesh.redraw();
}

/** Adds a button for each coordinate type, with a number that is also its key. */
function addTypes(app) {
  [...app.engine.polygonTypes, 'all'].forEach((type, i) => {
    const button = document.createElement('button');
    Object.assign(button, { textContent: type === 'all' ? 'Side by side' : titleOf(type), title: i + 1, onclick: () => chooseTypes(app, type) });
    button.dataset.type = type;
    byId('types').append(button);
  });
}
function connectButtons(app) {
  for (const button of document.querySelectorAll('#figures button')) button.onclick = () => chooseFigure(app, button.dataset.figure);
  for (const button of document.querySelectorAll('#modes button')) button.onclick = () => setMode(app, button.dataset.drag);
  const actions = {
    undo: () => historyOf(app).undo(),
    redo: () => historyOf(app).redo(),
    rest: () => {
      if (isInSpace()) return poseMesh(app, app.mesh.cage.vertices);
      app.pause();
      app.history.remember();
      app.pose = app.cage.rest.slice();
      app.redraw();
    },
    'fit-view': () => (isInSpace() ? app.mesh : app).fit(),
    close: () => closeFile(app),
    more: () => byId('more').setAttribute('aria-expanded', byId('bar').classList.toggle('open')),
    weights: () => toggle(app, 'weights', 'showsWeights'),
    cage: () => toggle(app, 'cage', 'showsCage'),
    edit: () => {
      app.pause();
      if (app.dragsFigure) setMode(app, 'cage');
      toggle(app, 'edit', 'isEditing');
      app.select(app.cage.kind === 'lattice' && app.isEditing ? [0] : []);
    },
    add: () => app.selection.size === 1 ? app.addVertex([...app.selection][0]) : app.say('Select one vertex first'),
    remove: () => app.selection.size > 0 ? app.removeSelected() : app.say('Select vertices first'),
    'pin-add': () => isInSpace() ? app.mesh.addFarPin() : addFarPin(app),
    'pin-remove': () => removeChosenPin(pinDragOf(app)),
    'pin-clear': () => removeAllPins(pinDragOf(app)),
    make: async () => {
      const { figure } = app, made = await makeCage(app, 'makeCage', figure.drawnSegments(), wantedVertices());
      if (figure !== app.figure) return;
      app.replaceCage({ cage: made, pose: made.rest.slice(), clip: new Clip(app.clip.length) });
      app.say(tellMade(made, made.rest.length / 2));
    },
    walk: () => { app.timeline.replaceClip(Clip.fromCsv(DATA.walk, app.cage.rest)); app.timeline.toggle(); },
    'save-svg': () => saveSvg(app),
    'save-png': () => savePng(app),
    'save-animation': () => saveAnimation(app),
    'save-pose': () => savePose(app),
    'save-cage': () => saveCage(app),
    'save-clip': () => saveClip(app),
    'mesh-pose': () => poseMesh(app, app.mesh.examplePose),
    'mesh-dance': () => dance(app, byId('mesh-dance').getAttribute('aria-pressed') !== 'true'),
    'mesh-make': () => openMesh(app, app.mesh.name, app.mesh.mesh, '', app.files.has(app.mesh.current) ? app.mesh.current : undefined),
    'mesh-gpu': () => { app.mesh.cloneTime = 0; toggleMesh(app); },
    'save-obj': () => saveObj(app.mesh),
    'save-glb': () => saveGlb(app.mesh),
    'save-mesh-pose': () => saveShell(app.mesh, app.mesh.pose, 'pose'),
    'save-mesh-cage': () => saveShell(app.mesh, app.mesh.cage.vertices, 'cage'),
    'work-stop': () => app.cageMaker.stop(),
  };
  for (const [id, action] of Object.entries(actions)) byId(id).onclick = () => attempt(app, action);
}
function poseMesh(app, pose) {
  dance(app, false);
  app.mesh.history.remember();
  app.mesh.pose = pose.slice();
  app.mesh.redraw();
}
async function attempt(app, action) {
  try { await action(); } catch (error) { app.sayFault(error); }
}
function toggleMesh(app) {
  app.mesh.onCard = !app.mesh.onCard;
  byId('mesh-gpu').setAttribute('aria-pressed', app.mesh.onCard);
  app.mesh.redraw();
}

/** Moves, rotates or scales the selection by a key, as one undo step. */
function nudge(app, f) {
  if (app.selection.size === 0) return;
  app.pause();
  app.history.remember();
  app.moveSelected(f);
  app.finishEdit();
}
function middleOfSelection(app) {
  const pose = app.shownPose, box = boundsOf([...app.selection].map(i => [pose[2 * i], pose[2 * i + 1]]));
  return [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
}
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const PRESSES = { w: 'weights', c: 'cage', r: 'rest', f: 'fit-view' };
const PIN_PRESSES = { Delete: 'pin-remove', Backspace: 'pin-remove', Insert: 'pin-add' };
const PLANE_PRESSES = { e: 'edit', k: 'key', ' ': 'play', Delete: 'remove', Backspace: 'remove', Insert: 'add' };

function connectKeys(app) {
  addEventListener('keydown', event => {
    if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, plane = !isInSpace();
    const isPress = /^(BUTTON|SUMMARY)$/.test(event.target.tagName) && key === ' '; // the key presses the button itself
    if (isPress || event.altKey) return;
    if (event.ctrlKey || event.metaKey) {
      if (key !== 'z' && key !== 'y') return;
      historyOf(app)[key === 'y' || event.shiftKey ? 'redo' : 'undo']();
    } else if (key === 'Escape' && !byId('work').hidden) {
      app.cageMaker.stop();
    } else if (key === 'n' || key === 'p') {
      if (app.dragsFigure) pinDragOf(app).step(key === 'n' ? 1 : -1);
      else (plane ? app : app.mesh).stepVertex(key === 'n' ? 1 : -1, event.shiftKey);
    } else if (app.dragsFigure && PIN_PRESSES[key]) {
      byId(PIN_PRESSES[key]).click();
    } else if (PRESSES[key] ?? (plane && PLANE_PRESSES[key])) {
      byId(PRESSES[key] ?? PLANE_PRESSES[key]).click();
    } else if (!(plane ? pressInPlane(app, key, event) : pressInSpace(app.mesh, key, event))) {
      return;
    }
    event.preventDefault();
  });
}
/** Selects the row of the last selected vertex; a second call selects its column. */
function selectLine(app) {
  const last = [...app.selection].pop(), isAll = line => line.every(i => app.selection.has(i) || isFrozen(app.cage, i));
  if (last === undefined) return app.say('Select a point of the lattice first');
  const [row, column] = linesOf(app.cage).filter(line => line.includes(last)), line = isAll(row) && app.selection.size <= row.length ? column : row;
  app.select([...line.filter(i => i !== last), last]);
  app.redraw();
}
/** Handles a key for a 2D figure; returns false if it has no effect. */
function pressInPlane(app, key, event) {
  const step = app.figure.size / 400 * (event.shiftKey ? 10 : 1);
  if (ARROWS[key]) {
    const [dx, dy] = ARROWS[key];
    if (app.timeline.pressArrow(event, dx, dy)) return true;
    if (app.dragsFigure && nudgePin(app.pinDrag, ([x, y]) => [x + step * dx, y + step * dy])) return true;
    if (app.selection.size > 0) nudge(app, (x, y) => [x + step * dx, y + step * dy]);
    else app.window = { ...app.window, x: app.window.x + dx * app.window.w / 20, y: app.window.y + dy * app.window.w / 20 };
    app.redraw();
  } else if (app.dragsFigure && (key === '[' || key === ']')) {
    turnByKey(app.pinDrag, turn => turn + (key === '[' ? -1 : 1) * Math.PI / 36);
  } else if (key === '[' || key === ']') {
    nudge(app, turned(middleOfSelection(app), (key === '[' ? -1 : 1) * Math.PI / 36));
  } else if (key === '-' || key === '+' || key === '=') {
    const [mx, my] = middleOfSelection(app), f = key === '-' ? 1 / 1.05 : 1.05;
    nudge(app, (x, y) => [mx + f * (x - mx), my + f * (y - my)]);
  } else if (app.dragsFigure && (key === 'a' || key === 'Escape')) {
    app.pinDrag.letGo();
  } else if (key === 'a' || key === 'Escape') {
    app.select(key === 'a' ? allOf(app.pose.length / 2).filter(i => app.cage.kind !== 'curved' || i % 3 === 0) : []);
    app.redraw();
  } else if (key === 'l' && app.cage.kind === 'lattice') {
    selectLine(app);
  } else if (/^[1-9]$/.test(key)) {
    document.querySelector(`#types [title="${key}"]`)?.click();
  } else if (key === ',' || key === '.') {
    app.timeline.goToKey(key === '.');
  } else if (key === 'PageUp' || key === 'PageDown') {
    const { x, y, w, h } = app.window;
    zoom(app, [x + w / 2, y + h / 2], key === 'PageUp' ? 1 / 1.2 : 1.2);
  } else {
    return false;
  }
  return true;
}
/** Handles a key for a mesh; returns false if it has no effect. */
function pressInSpace(mesh, key, event) {
  if (ARROWS[key]) {
    const [dx, dy] = ARROWS[key], step = event.shiftKey ? 20 : 2;
    if (mesh.app.dragsFigure && nudgePin(mesh.pinDrag, place => shifted(place, shiftOnScreen(mesh, mesh.depthOf(place), step * dx, step * dy)))) return true;
    if (mesh.selected >= 0) mesh.nudge(step * dx, step * dy);
    else orbit(mesh)(12 * dx, 12 * dy);
  } else if (mesh.app.dragsFigure && (key === '[' || key === ']')) {
    turnByKey(mesh.pinDrag, turn => turnedOnScreen(mesh, turn, (key === '[' ? -1 : 1) * Math.PI / 36));
  } else if (key === 'Escape') {
    mesh.pinDrag.letGo();
    mesh.selected = -1;
  } else if (/^(-|\+|=|PageUp|PageDown)$/.test(key)) {
    mesh.far = Math.max(0.2, Math.min(4, mesh.far * (/^(-|PageDown)$/.test(key) ? 1.1 : 1 / 1.1)));
  } else {
    return false;
  }
  mesh.redraw();
  return true;
}
function connectDrops(app) {
  const mark = isOver => document.body.classList.toggle('dropping', isOver);
  addEventListener('dragover', event => { event.preventDefault(); mark(true); });
  addEventListener('dragleave', event => { if (!event.relatedTarget) mark(false); });
  addEventListener('drop', event => {
    event.preventDefault();
    mark(false);
    openFiles(app, event.dataTransfer.files);
  });
  byId('open').onchange = event => { openFiles(app, event.target.files); event.target.value = ''; };
}

/** Animates the first scene until the first input; does nothing if the user prefers reduced motion. */
function playFirstScene(app) {
  if (matchMedia('(prefers-reduced-motion: reduce)').matches) return;
  byId('walk').click();
  app.history.set([], []);
  const stop = event => {
    for (const kind of ['pointerdown', 'keydown']) removeEventListener(kind, stop, true);
    const isPlay = event.target.id === 'play' || event.key === ' '; // these stop the motion themselves
    if (!isPlay) app.pause();
  };
  for (const kind of ['pointerdown', 'keydown']) addEventListener(kind, stop, true);
}

async function startPage() {
  const module = await WebAssembly.compile(await unpack(DATA.wasm)), app = new App(await Engine.start(module));
  app.cageMaker = new CageMaker(module);
  app.pinDrag.maker = new CageMaker(module);
  app.clip = new Clip();
  app.mesh = new MeshView(app);
  app.mesh.pinDrag.maker = new CageMaker(module);
  app.timeline = new Timeline(app);
  app.mesh.onDrag = () => dance(app, false);
  app.history.onChange = app.mesh.history.onChange = () => markHistory(app);
  app.onCage = () => markKind(app);
  app.keeper = new Keeper(app);
  const { files, states, shown } = await app.keeper.open();
  app.files = new Map([...files].sort(([, a], [, b]) => a.opened - b.opened));
  app.kept = states;
  for (const key of app.files.keys()) addFileButton(app, key);
  app.hinted = 0; // number of hints followed
  app.pinDrag.onMoved = app.mesh.pinDrag.onMoved = () => { ++app.hinted; };
  addTypes(app);
  connectButtons(app);
  connectKinds(app);
  connectKeys(app);
  connectDrops(app);
  chooseTypes(app, 'harmonic');
  setMode(app, 'figure');
  await chooseFigure(app, 'cat');
  if (!app.figure) await chooseFigure(app, 'cat'); // no stored work
  if (shown) {
    await app.keeper.put([['shown', '']]).catch(() => {}); // a figure that crashes the page is not shown again
    await chooseFigure(app, shown);
  }
  app.draw();
  app.timeline.update();
  if (files.size + states.size === 0) playFirstScene(app);
  window.page = app; // for tests and for the console
  app.readyAfter = performance.now();
  document.documentElement.dataset.ready = 'yes';
}
startPage().catch(error => { byId('status').textContent = 'This browser cannot run the page: ' + error.message; });
