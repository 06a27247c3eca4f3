// Stores the user's work in the browser (IndexedDB), so that it survives a reload: the texts of opened files, and the state of each
// changed figure with its last undo steps. The page asks before it is closed only while something is not stored.

const KEPT_STEPS = 50;  // undo steps per figure
const KEEP_AFTER = 300; // ms

const answerOf = request => new Promise((done, failed) => {
  request.onsuccess = () => done(request.result);
  request.onerror = () => failed(request.error);
});

class Keeper {
  constructor(app) {
    Object.assign(this, { app, store: null, known: new Map(), filed: new Set(), unsaved: new Set(), writes: 0 });
    addEventListener('beforeunload', event => {
      this.write();
      if (!this.isSaved) event.preventDefault();
    });
  }
  get isSaved() { return this.unsaved.size + this.writes === 0; }

  /** Opens the store. Returns its contents: files and states by the keys of their figures, and the key of the shown figure. */
  async open() {
    try {
      const request = indexedDB.open('cageform', 1);
      request.onupgradeneeded = () => request.result.createObjectStore('work');
      this.store = await answerOf(request);
      const work = this.store.transaction('work').objectStore('work');
      const [keys, values] = await Promise.all([answerOf(work.getAllKeys()), answerOf(work.getAll())]);
      const all = kind => new Map(keys.flatMap(([own, key], k) => own === kind ? [[key, values[k]]] : []));
      const files = all('file');
      this.filed = new Set(files.keys());
      return { files, states: all('state'), shown: all('shown').get('') };
    } catch {
      this.store = null; // for instance in private windows
      return { files: new Map(), states: new Map() };
    }
  }
  /** Writes values, [[kind, key], value] each, to the store, all or none; undefined deletes an entry. */
  async put(...entries) {
    const transaction = this.store.transaction('work', 'readwrite'), work = transaction.objectStore('work');
    try {
      for (const [key, value] of entries) if (value === undefined) work.delete(key); else work.put(value, key);
    } catch (error) { // a value cannot be stored; without abort the earlier ones would stay
      transaction.abort();
      throw error;
    }
    await new Promise((done, failed) => {
      transaction.oncomplete = done;
      transaction.onabort = () => failed(transaction.error);
      transaction.commit(); // so that the values are stored even if the page is closed now
    });
  }

  /** Call after drawing: marks the figure as changed if its state differs from the last one. Animations change nothing. */
  look() {
    const { app } = this, { current: key, cage, pose, clip, kinds, history: { earlier, later } } = shownOwner(app);
    if (!app.files.has(key) && !DATA[key]) return;
    if (this.shown !== key && this.store) this.put([['shown', ''], this.shown = key]).catch(() => {});
    const before = this.known.get(key), isPlaying = app.timeline.playing || app.mesh.dancing;
    const state = [isPlaying ? before?.[0] : pose, cage, clip, kinds, earlier.length, earlier.at(-1), later.length];
    this.known.set(key, state);
    if (before && state.some((x, i) => x !== before[i] && before[i] !== undefined)) this.change(key); // the first drawing at rest is no change
  }
  /** Schedules writing of the state of a figure. */
  change(key) {
    if (!this.unsaved.has(key) && !this.store) this.app.say('This browser cannot store your work: save files before you leave the page');
    this.unsaved.add(key);
    this.timer ??= setTimeout(() => this.write(), KEEP_AFTER);
  }
  async write() {
    clearTimeout(this.timer);
    this.timer = undefined;
    if (!this.store || this.unsaved.size === 0) return;
    const { app, filed } = this, keys = [...this.unsaved], files = keys.filter(key => app.files.has(key) && !filed.has(key));
    this.unsaved.clear();
    ++this.writes;
    try {
      await this.put(...keys.map(key => [['state', key], this.stateOf(key)]), ...files.map(key => [['file', key], app.files.get(key)]));
      for (const key of files) filed.add(key);
    } catch (error) {
      this.store = null;
      for (const key of keys) this.unsaved.add(key);
      app.sayFault(new Error(`This browser can no longer store your work (${error.message}): save files before you leave the page`));
    }
    --this.writes;
  }
  /** Returns the state of a figure to store: everything that is not in its file. */
  stateOf(key) {
    const owner = ownerOf(this.app, key), { figure, mesh, dance, examplePose, ...state } = owner.current === key ? owner.session() : owner.sessions.get(key);
    return { ...state, earlier: state.earlier.slice(-KEPT_STEPS), later: state.later.slice(-KEPT_STEPS) };
  }
  forget(key) {
    this.known.delete(key);
    this.unsaved.delete(key);
    if (this.store) this.put([['file', key]], [['state', key]]).catch(() => {});
  }
}

const shownOwner = app => isInSpace() ? app.mesh : app;
/** Returns the owner (App or MeshView) of a figure that has been shown. */
const ownerOf = (app, key) => [app, app.mesh].find(({ current, sessions }) => current === key || sessions.has(key));

/** Restores the class Clip, which the store does not preserve. */
function withClips(state) {
  for (const part of [state, ...state.earlier, ...state.later])
    for (const { clip } of [part, ...Object.values(part.kinds ?? {})]) if (clip) Object.setPrototypeOf(clip, Clip.prototype);
  return state;
}
