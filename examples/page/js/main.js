// Buttons, keys, dropped files; and the start.

const byId = id => document.getElementById(id);

/** The project's own figures, with their own cages. */
function openFigure(app, name) {
  app.setFigure(new Figure(DATA[name].figure, name), cageOfSvg(DATA[name].cage));
}

/** Lets the browser draw before what takes long. */
const nextFrame = () => new Promise(done => requestAnimationFrame(() => setTimeout(done)));

/** A dropped or opened file gets a cage by make_cage. */
async function openFile(app, file) {
  if (/\.obj$/i.test(file.name)) return openMesh(app, file);
  try {
    const figure = new Figure(await file.text(), file.name.replace(/\.svg$/i, ''));
    showPlane(app);
    const start = performance.now(), made = app.engine.makeCage(figure.drawnSegments(), wantedVertices());
    const time = performance.now() - start;
    app.setFigure(figure, made);
    markFigure(null);
    app.say(`${figure.name}: make_cage took ${time.toFixed(0)} ms for ${made.rest.length / 2} vertices, ` +
            `${made.clearance.toPrecision(3)} from what is drawn at least`);
  } catch (error) {
    app.sayFault(error);
  }
}
async function openMesh(app, file) {
  await attempt(app, async () => {
    const mesh = parseObj(await file.text(), file.name);
    showSpace(app);
    await makeShell(app, file.name.replace(/\.obj$/i, ''), mesh);
    markFigure(null);
  });
}
async function makeShell(app, name, mesh) {
  app.say('make_cage is at work: some seconds');
  await nextFrame();
  app.mesh.makeCage(name, mesh, Math.max(8, Math.min(400, Math.round(Number(byId('mesh-count').value)) || 112)));
}
const wantedVertices = () => Math.max(4, Math.min(80, Math.round(Number(byId('count').value)) || 24));

function markFigure(name) {
  for (const button of document.querySelectorAll('#figures button')) button.classList.toggle('chosen', button.dataset.figure === name);
  byId('walk').disabled = name !== 'cat';
  for (const id of ['mesh-pose', 'mesh-dance']) byId(id).disabled = name !== 'character';
}
function showPlane(app) {
  dance(app, false);
  document.body.classList.remove('in-space');
  app.redraw();
}
function showSpace(app) {
  app.pause();
  dance(app, false);
  document.body.classList.add('in-space');
}
function dance(app, isOn) {
  byId('mesh-dance').setAttribute('aria-pressed', isOn);
  app.mesh.toggleDance(isOn);
}
async function chooseFigure(app, name) {
  try {
    if (name === 'character') {
      showSpace(app);
      markFigure(name);
      await app.mesh.openCharacter(DATA.character);
      return markFigure(name);
    }
    openFigure(app, name);
    showPlane(app);
    markFigure(name);
  } catch (error) {
    app.sayFault(error);
  }
}
function chooseTypes(app, word) {
  app.setTypes(word === 'all' ? [0, 1, 2, 3] : [Number(word)]);
  for (const button of document.querySelectorAll('#types button')) button.classList.toggle('chosen', button.dataset.type === word);
}
/** A button that is on or off. */
function toggle(app, id, name) {
  app[name] = !app[name];
  byId(id).setAttribute('aria-pressed', app[name]);
  app.redraw();
}

function connectButtons(app) {
  for (const button of document.querySelectorAll('#figures button')) button.onclick = () => chooseFigure(app, button.dataset.figure);
  for (const button of document.querySelectorAll('#types button')) button.onclick = () => chooseTypes(app, button.dataset.type);
  const actions = {
    undo: () => app.history.undo(),
    redo: () => app.history.redo(),
    rest: () => { app.history.remember(); app.pose = app.cage.rest.slice(); app.redraw(); },
    weights: () => toggle(app, 'weights', 'showsWeights'),
    cage: () => toggle(app, 'cage', 'showsCage'),
    edit: () => { app.pause(); toggle(app, 'edit', 'isEditing'); },
    add: () => app.selection.size === 1 ? app.addVertex([...app.selection][0]) : app.say('Select one vertex first'),
    remove: () => app.selection.size > 0 ? app.removeSelected() : app.say('Select vertices first'),
    make: () => {
      const made = app.makeCage(wantedVertices());
      app.replaceCage({ cage: made, pose: made.rest.slice() }, [], () => { app.clip = new Clip(app.clip.length); });
      app.say(`make_cage took ${made.milliseconds.toFixed(0)} ms for ${made.rest.length / 2} vertices`);
    },
    walk: () => { app.timeline.replaceClip(Clip.fromCsv(DATA.walk, app.cage.rest)); app.timeline.toggle(); },
    'save-svg': () => saveSvg(app),
    'save-png': () => savePng(app),
    'save-pose': () => savePose(app),
    'save-cage': () => saveCage(app),
    'mesh-rest': () => poseMesh(app, app.mesh.cage.vertices),
    'mesh-pose': () => poseMesh(app, app.mesh.examplePose),
    'mesh-dance': () => dance(app, byId('mesh-dance').getAttribute('aria-pressed') !== 'true'),
    'mesh-make': async () => {
      dance(app, false);
      await makeShell(app, app.mesh.name, app.mesh.mesh);
      markFigure(null);
    },
    'mesh-gpu': () => { app.mesh.cloneTime = 0; toggleMesh(app); },
  };
  for (const [id, action] of Object.entries(actions)) byId(id).onclick = () => attempt(app, action);
}
function poseMesh(app, pose) {
  dance(app, false);
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

/** Moves, turns or scales the selection by a key, as one step of undo. */
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
function connectKeys(app) {
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const presses = { w: 'weights', c: 'cage', e: 'edit', r: 'rest', k: 'key', ' ': 'play', Delete: 'remove', Backspace: 'remove', Insert: 'add' };
  addEventListener('keydown', event => {
    if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) || document.body.classList.contains('in-space')) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, step = app.figure.size / 400 * (event.shiftKey ? 10 : 1);
    if (event.ctrlKey || event.metaKey) {
      if (key !== 'z' && key !== 'y') return;
      app.history[key === 'y' || event.shiftKey ? 'redo' : 'undo']();
    } else if (arrows[key]) {
      if (event.target.id === 'timeline') app.timeline.setTime(app.timeline.time + arrows[key][0] * app.clip.length / 48);
      else nudge(app, (x, y) => [x + step * arrows[key][0], y + step * arrows[key][1]]);
    } else if (key === '[' || key === ']') {
      nudge(app, turned(middleOfSelection(app), (key === '[' ? -1 : 1) * Math.PI / 36));
    } else if (key === '-' || key === '+' || key === '=') {
      const [mx, my] = middleOfSelection(app), f = key === '-' ? 1 / 1.05 : 1.05;
      nudge(app, (x, y) => [mx + f * (x - mx), my + f * (y - my)]);
    } else if (key === 'a' || key === 'Escape') {
      app.selection = new Set(key === 'a' ? Array.from({ length: app.pose.length / 2 }, (x, i) => i) : []);
      app.redraw();
    } else if (/^[1-5]$/.test(key)) {
      chooseTypes(app, key === '5' ? 'all' : String(key - 1));
    } else if (presses[key]) {
      if (event.target.tagName === 'BUTTON' && key === ' ') return; // the button's own
      byId(presses[key]).click();
    } else {
      return;
    }
    event.preventDefault();
  });
}
function connectDrops(app) {
  const mark = isOver => document.body.classList.toggle('dropping', isOver);
  addEventListener('dragover', event => { event.preventDefault(); mark(true); });
  addEventListener('dragleave', event => { if (!event.relatedTarget) mark(false); });
  addEventListener('drop', event => {
    event.preventDefault();
    mark(false);
    if (event.dataTransfer.files[0]) openFile(app, event.dataTransfer.files[0]);
  });
  byId('open').onchange = event => { if (event.target.files[0]) openFile(app, event.target.files[0]); event.target.value = ''; };
}

async function startPage() {
  const app = new App(await Engine.start(DATA.wasm));
  app.clip = new Clip();
  app.mesh = new MeshView(app);
  app.timeline = new Timeline(app);
  connectButtons(app);
  connectKeys(app);
  connectDrops(app);
  chooseTypes(app, '1');
  await chooseFigure(app, 'cat');
  app.draw();
  app.timeline.update();
  window.page = app; // for tests, and for who looks
  app.readyAfter = performance.now();
  document.documentElement.dataset.ready = 'yes';
}
startPage().catch(error => { byId('status').textContent = 'This browser cannot run the page: ' + error.message; });
