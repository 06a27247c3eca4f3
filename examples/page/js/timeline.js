// The panel of the clip: time, key frames, playback, and the graph editor.

class Timeline {
  constructor(app) {
    this.app = app;
    this.time = 0;
    this.chosen = null; // the selected key of the curve
    app.pause = () => this.pause();
    app.onSelect = vertex => this.showVertex(vertex);
    app.onClip = () => { this.chosen = null; this.update(); };
    const at = id => document.getElementById(id);
    this.strip = at('timeline');
    this.chart = at('curve');
    at('play').onclick = () => this.toggle();
    at('key').onclick = () => this.setKey();
    at('unkey').onclick = () => this.removeKey();
    at('no-clip').onclick = () => this.replaceClip(new Clip(app.clip.length));
    at('length').onchange = event => this.change(() => app.clip.setLength(Math.max(0.2, Number(event.target.value) || 2.4)));
    at('tolerance').onchange = event => this.change(() => { app.clip.tolerance = Number(event.target.value); });
    at('track').onchange = () => { this.chosen = null; this.update(); };
    for (const button of document.querySelectorAll('#kinds button')) button.onclick = () => this.setKind(Number(button.dataset.kind));
    this.strip.addEventListener('pointerdown', event => this.press(event));
    this.chart.addEventListener('pointerdown', event => this.pressChart(event));
    at('curves').addEventListener('toggle', () => this.update());
    for (const element of [this.strip, this.chart]) new ResizeObserver(() => this.update()).observe(element);
  }

  // ---- time ----

  toggle() {
    if (this.playing) return this.pause();
    if (this.app.clip.isEmpty) return this.app.say('Nothing to play: set key frames (K) at two times, or load the cat walk');
    this.app.isEditing = false;
    let begin = null; // in the time of animation frames, which differs from performance.now()
    const step = now => {
      begin ??= now - 1000 * this.time;
      this.setTime(((now - begin) / 1000) % this.app.clip.length);
      this.playing = requestAnimationFrame(step);
    };
    this.playing = requestAnimationFrame(step);
    document.getElementById('play').textContent = 'Pause';
  }
  pause() {
    cancelAnimationFrame(this.playing);
    this.playing = 0;
    document.getElementById('play').textContent = 'Play';
  }
  setTime(time) {
    const { app } = this;
    this.time = Math.max(0, Math.min(time, app.clip.length));
    try {
      if (!app.clip.isEmpty) app.pose = app.clip.poseAt(this.time, app.cage.rest, app.engine);
    } catch (error) {
      this.pause();
      app.sayFault(error);
    }
    this.drawStrip();
    this.drawHead();
    app.redraw();
  }

  // ---- changes ----

  change(f) {
    this.app.history.remember();
    f();
    this.setTime(this.time);
    this.update();
  }
  replaceClip(clip) {
    this.pause();
    this.change(() => { this.app.clip = clip; });
    this.time = Math.min(this.time, clip.length);
    if (clip.isEmpty) this.app.pose = this.app.cage.rest.slice();
    this.chosen = null;
    this.update();
  }
  setKey() {
    const { app } = this;
    this.pause();
    app.history.remember();
    app.clip.setKey(this.time, app.pose, app.cage.rest, app.engine);
    app.say(`Key frame at ${this.time.toFixed(2)} s`);
    this.update();
  }
  removeKey() {
    this.change(() => {
      if (!this.app.clip.removeKey(this.time, this.app.clip.length / 100)) this.app.say('No key frame of a pose at this time');
    });
  }

  /** Goes to the next or the previous key frame. */
  goToKey(isNext) {
    const { time } = this, times = this.app.clip.keyTimes.filter(t => isNext ? t > time + 1e-6 : t < time - 1e-6);
    if (times.length > 0) this.setTime(isNext ? times[0] : times[times.length - 1]);
  }
  /** Handles an arrow key. On the time line it moves the time, with Shift the key frame. In the chart it selects a key or moves it. */
  pressArrow({ target, shiftKey }, dx, dy) {
    const { app } = this, to = this.time + dx * app.clip.length / 48;
    if (target === this.strip) {
      this.pause();
      const key = shiftKey ? app.clip.keyTimes.find(t => Math.abs(t - this.time) < app.clip.length / 100) : undefined;
      if (key === undefined) this.setTime(to);
      else this.change(() => { this.time = app.clip.moveKeys(key, to); });
      return true;
    }
    if (target !== this.chart || !this.track) return false;
    const { keys } = this.track;
    this.pause();
    if (dx !== 0 || this.chosen === null) {
      this.chosen = this.chosen === null ? 0 : (this.chosen + dx + keys.length) % keys.length;
      this.setTime(keys[this.chosen].t);
      this.drawChart();
    } else {
      const { low, high } = this.chartFrame();
      this.change(() => {
        this.dragKey({ index: this.chosen }, keys[this.chosen].v - dy * ((high - low) / 50 || 1) * (shiftKey ? 5 : 1));
        this.track.fitted = undefined;
      });
    }
    return true;
  }

  // ---- the time line ----

  timeAt(event) {
    const box = this.strip.getBoundingClientRect();
    return (event.clientX - box.left - 10) / (box.width - 20) * this.app.clip.length;
  }
  press(event) {
    const { app } = this, reach = 9 / this.strip.clientWidth * app.clip.length;
    this.pause();
    let key = app.clip.keyTimes.find(t => Math.abs(t - this.timeAt(event)) < reach), moved = false;
    follow(this.strip, event, e => {
      if (key === undefined) return this.setTime(this.timeAt(e));
      if (!moved) app.history.remember();
      moved = true;
      key = app.clip.moveKeys(key, this.timeAt(e));
      this.setTime(key);
      this.update();
    });
    this.setTime(key ?? this.timeAt(event));
  }
  drawStrip() {
    const { strip, app } = this, width = strip.clientWidth, height = strip.clientHeight, { length } = app.clip;
    const x = t => 10 + t / length * (width - 20), step = length > 12 ? 2 : length > 5 ? 1 : length > 2.6 ? 0.5 : 0.2;
    strip.replaceChildren();
    svgElement('line', { x1: x(0), x2: x(length), y1: 22, y2: 22, stroke: '#9aa6b5', 'stroke-width': 2 }, strip);
    for (let t = 0; t <= length + 1e-9; t += step) {
      svgElement('line', { x1: x(t), x2: x(t), y1: 18, y2: 26, stroke: '#9aa6b5' }, strip);
      svgElement('text', { x: x(t), y: 12, 'font-size': 10, 'text-anchor': 'middle', fill: 'currentColor' }, strip).textContent = +t.toFixed(2);
    }
    for (const t of app.clip.keyTimes)
      svgElement('path', { d: `M${x(t)} ${height - 21}l6 7l-6 7l-6-7z`, fill: '#c2377a', stroke: '#fff' }, strip);
    svgElement('line', { x1: x(this.time), x2: x(this.time), y1: 0, y2: height, stroke: '#1f6fb8', 'stroke-width': 2 }, strip);
    document.getElementById('time').textContent = this.time.toFixed(2) + ' s';
    strip.setAttribute('aria-valuemax', +length.toFixed(2));
    strip.setAttribute('aria-valuenow', this.time.toFixed(2));
  }

  // ---- curves ----

  get track() { return this.app.clip.tracks[document.getElementById('track').value] ?? this.app.clip.tracks[0]; }

  /** Selects the curve of the selected vertex. */
  showVertex(vertex) {
    const index = this.app.clip.tracks.findIndex(track => track.vertex === vertex);
    const menu = document.getElementById('track');
    if (index < 0 || this.track?.vertex === vertex) return;
    menu.value = index;
    this.chosen = null;
    this.update();
  }
  update() {
    const { app } = this, menu = document.getElementById('track');
    if (!app.clip) return;
    document.getElementById('length').value = +app.clip.length.toFixed(2);
    document.getElementById('tolerance').value = [...document.getElementById('tolerance').options]
      .map(o => o.value).find(v => Math.abs(v - app.clip.tolerance) < 1e-6) ?? '0.000520833';
    const names = app.clip.tracks.map(track => track.name);
    if ([...menu.options].map(o => o.text).join('|') !== names.join('|')) {
      const before = menu.selectedOptions[0]?.text;
      menu.replaceChildren(...names.map((name, k) => new Option(name, k, false, name === before)));
    }
    this.drawStrip();
    this.drawChart();
  }

  /** Returns the maps from time and value to pixels of the chart, and back. */
  chartFrame() {
    const { clip } = this.app, keys = repeatedKeys(this.track, clip.length);
    const values = this.track.keys.map(key => key.v);
    for (const key of keys) if (key.kind === KIND.bezier) values.push(key.in[1], key.out[1]);
    const low = Math.min(...values), high = Math.max(...values), pad = 0.12 * (high - low) || 1;
    const width = this.chart.clientWidth, height = this.chart.clientHeight;
    const sx = (width - 60) / clip.length, sy = -(height - 30) / (high - low + 2 * pad);
    return {
      keys, low, high, width, height,
      x: t => 45 + sx * t, y: v => height - 18 + sy * (v - low + pad),
      back: ([px, py]) => [(px - 45) / sx, low - pad + (py - height + 18) / sy],
    };
  }
  drawChart() {
    const { chart, app } = this;
    chart.replaceChildren();
    document.getElementById('fit').textContent = '';
    if (!document.getElementById('curves').open || !chart.clientWidth) return;
    if (!this.track) {
      svgElement('text', { x: 20, y: 40, fill: 'currentColor' }, chart).textContent = 'No key frames: set some (K), or load the cat walk.';
      return;
    }
    const f = this.chartFrame(), { length } = app.clip;
    for (const v of [f.low, (f.low + f.high) / 2, f.high]) {
      svgElement('line', { x1: f.x(0), x2: f.x(length), y1: f.y(v), y2: f.y(v), stroke: '#9aa6b5', 'stroke-opacity': 0.4 }, chart);
      svgElement('text', { x: 40, y: f.y(v) + 4, 'font-size': 11, 'text-anchor': 'end', fill: 'currentColor' }, chart).textContent = +v.toPrecision(3);
    }
    const within = svgElement('svg', { x: f.x(0), y: 0, width: f.x(length) - f.x(0), height: f.height, viewBox: `${f.x(0)} 0 ${f.x(length) - f.x(0)} ${f.height}`, overflow: 'hidden' }, chart);
    let curve = '';
    for (let i = 0; i + 1 < f.keys.length; ++i) {
      const [a, b, c, d] = keyInterval(f.keys, i).map(([t, v]) => `${f.x(t)} ${f.y(v)}`);
      curve += `M${a}C${b} ${c} ${d}`;
    }
    svgElement('path', { id: 'key-curve', d: curve, fill: 'none', stroke: '#f0b24a', 'stroke-width': 7, 'stroke-opacity': 0.55 }, within);
    this.drawPieces(within, f);
    this.drawKeys(chart, f);
    this.head = svgElement('line', { y1: 0, y2: f.height, stroke: '#1f6fb8', 'stroke-opacity': 0.6 }, chart);
    this.drawHead();
  }
  drawPieces(parent, f) {
    const { app, track } = this, { pieces, error } = app.clip.fitOf(track, app.engine), { length } = app.clip;
    let shown = 0;
    for (let k = 0; k < pieces.length; k += 5) {
      const begin = pieces[k], end = k + 5 < pieces.length ? pieces[k + 5] : f.keys[f.keys.length - 1].t, h = end - begin;
      if (end <= 0 || begin >= length) continue;
      const [, c0, c1, c2, c3] = pieces.subarray(k, k + 5);
      const values = [c0, c0 + c1 * h / 3, c0 + 2 * c1 * h / 3 + c2 * h * h / 3, c0 + h * (c1 + h * (c2 + h * c3))];
      const [p, q, r, s] = values.map((v, n) => `${f.x(begin + n * h / 3)} ${f.y(v)}`);
      svgElement('path', { d: `M${p}C${q} ${r} ${s}`, fill: 'none', stroke: shown++ % 2 ? '#1f6fb8' : '#0b7d5c', 'stroke-width': 1.8 }, parent);
      svgElement('line', { x1: f.x(begin), x2: f.x(begin), y1: f.y(c0) - 5, y2: f.y(c0) + 5, stroke: '#5d6878' }, parent);
    }
    document.getElementById('fit').textContent =
      `${shown} cubic pieces; certified error at most ${error === 0 ? '0' : error.toPrecision(2)}, tolerance ${+app.clip.tolerance.toPrecision(3)}`;
  }
  drawKeys(chart, f) {
    for (const key of f.keys) {
      if (key.t < -1e-9 || key.t > this.app.clip.length + 1e-9) continue;
      if (key.kind === KIND.bezier) {
        for (const [t, v] of [key.in, key.out]) {
          svgElement('line', { x1: f.x(key.t), y1: f.y(key.v), x2: f.x(t), y2: f.y(v), stroke: '#c2377a', 'stroke-opacity': 0.6 }, chart);
          svgElement('circle', { cx: f.x(t), cy: f.y(v), r: 4.5, fill: '#fff', stroke: '#c2377a' }, chart);
        }
      }
      const isChosen = key.index === this.chosen;
      svgElement('rect', { x: f.x(key.t) - 5, y: f.y(key.v) - 5, width: 10, height: 10, fill: isChosen ? '#c2377a' : '#fff', stroke: '#c2377a', 'stroke-width': 1.5 }, chart);
    }
  }
  drawHead() {
    if (!this.head?.isConnected) return;
    const x = 45 + this.time / this.app.clip.length * (this.chart.clientWidth - 60);
    for (const name of ['x1', 'x2']) this.head.setAttribute(name, x);
  }

  pressChart(event) {
    if (!this.track) return;
    const box = this.chart.getBoundingClientRect(), f = this.chartFrame();
    const place = e => [e.clientX - box.left, e.clientY - box.top];
    const near = ([t, v]) => distance([f.x(t), f.y(v)], place(event)) < (event.pointerType === 'touch' ? 22 : 10);
    const key = f.keys.find(k => near([k.t, k.v]));
    const handle = !key && f.keys.filter(k => k.kind === KIND.bezier)
      .flatMap(k => [['in', k], ['out', k]]).find(([side, k]) => near(k[side]));
    if (!key && !handle) {
      this.pause();
      follow(this.chart, event, e => this.setTime(f.back(place(e))[0]));
      return this.setTime(f.back(place(event))[0]);
    }
    this.pause();
    this.chosen = (key ?? handle[1]).index;
    this.app.history.remember();
    follow(this.chart, event, e => {
      const [t, v] = f.back(place(e));
      if (key) this.dragKey(key, v); else this.dragHandle(handle, t, v);
      this.track.fitted = undefined;
      this.setTime(this.time);
      this.drawChart();
    });
    this.drawChart();
  }
  dragKey({ index }, v) {
    const own = this.track.keys[index];
    moveKey(own, own.t, v);
  }
  /** Limits a handle to the interval between its key and the next, so that the curve is a function of time. */
  dragHandle([side, { index, turn }], t, v) {
    const keys = repeatedKeys(this.track, this.app.clip.length), i = keys.findIndex(k => k.index === index && k.turn === turn);
    const own = this.track.keys[index], shift = turn * this.track.period;
    const other = keys[side === 'in' ? i - 1 : i + 1]?.t ?? t;
    const [low, high] = side === 'in' ? [other, keys[i].t] : [keys[i].t, other];
    for (const s of ['in', 'out']) own[s] ??= [keys[i][s][0] - shift, keys[i][s][1]];
    own[side] = [Math.max(low, Math.min(high, t)) - shift, v];
  }
  setKind(kind) {
    const key = this.track?.keys[this.chosen];
    if (!key) return this.app.say('Select a key on the curve first');
    this.change(() => {
      Object.assign(key, { kind, in: null, out: null });
      this.track.fitted = undefined;
    });
  }
}

/** Calls f for every move of a pressed pointer until it is released. */
function follow(element, event, f) {
  element.setPointerCapture(event.pointerId);
  const end = () => {
    element.removeEventListener('pointermove', f);
    element.removeEventListener('pointerup', end);
    element.removeEventListener('pointercancel', end);
  };
  element.addEventListener('pointermove', f);
  element.addEventListener('pointerup', end);
  element.addEventListener('pointercancel', end);
  event.preventDefault();
}
