// Saves downloads in the formats of the programs.

function download(name, parts, type) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob(parts, { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** Returns the figure of the first view at some poses: a copy of the document at the first pose, and the points at all
 *  poses. Its viewBox contains all poses. */
function posedCopy(app, poses) {
  const copy = app.figure.makeCopy(), { figure } = app;
  app.ensureBound(app.types[0]);
  const all = poses.map(pose => app.cloneFigure(app.types[0], pose).slice());
  figure.write(copy, all[0]);
  const { root } = copy, view = numbersIn(root.getAttribute('viewBox') ?? '');
  const widest = Math.max(0, ...figure.shapes.map(shape => shape.radius ?? 0), ...figure.filters.map(({ reach, map }) => reach * largestScale(map)));
  const boxes = all.map(places => boundsOf(pairs(places)));
  const box = boundsOf([...boxes.flatMap(([x0, y0, x1, y1]) => [[x0 - widest, y0 - widest], [x1 + widest, y1 + widest]]),
    ...(view.length === 4 ? [[view[0], view[1]], [view[0] + view[2], view[1] + view[3]]] : [])]);
  const [width, height] = [box[2] - box[0], box[3] - box[1]];
  root.setAttribute('viewBox', `${box[0]} ${box[1]} ${width} ${height}`);
  for (const name of ['width', 'height', 'x', 'y']) {
    root.removeAttribute(name);
    root.style.removeProperty(name);
  }
  if (figure.css) {
    const style = svgElement('style');
    style.textContent = figure.css;
    root.querySelector('metadata').replaceWith(style); // the metadata element reserved the position
  }
  return { copy, all, width, height };
}
/** Returns the posed figure as SVG text. */
function posedSvg(app) {
  const { copy, width, height } = posedCopy(app, [app.pose]);
  return { text: new XMLSerializer().serializeToString(copy.root), width, height };
}

function saveSvg(app) { download(app.figure.name + '_posed.svg', [posedSvg(app).text, '\n'], 'image/svg+xml'); }

async function savePng(app) {
  const { text, width, height } = posedSvg(app), image = new Image(), scale = 1600 / Math.max(width, height);
  const sized = text.replace('<svg', `<svg width="${width * scale}" height="${height * scale}"`);
  image.src = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(sized);
  await image.decode();
  const canvas = document.createElement('canvas');
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
  const blob = await new Promise(done => canvas.toBlob(done, 'image/png'));
  download(app.figure.name + '_posed.png', [blob], 'image/png');
}

/** Returns an SVG document of lines around points, which the programs read as a cage or a pose. */
function linesSvg(points, elements) {
  const [x0, y0, x1, y1] = boundsOf(pairs(points)), pad = 0.05 * Math.hypot(x1 - x0, y1 - y0), width = 0.05 * pad;
  const view = [x0 - pad, y0 - pad, x1 - x0 + 2 * pad, y1 - y0 + 2 * pad].map(x => +x.toPrecision(9)).join(' ');
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="${view}">\n<g fill="none" stroke="#c2377a" stroke-width="${+width.toPrecision(3)}" ` +
    `stroke-linejoin="round">\n${elements.join('\n')}\n</g>\n</svg>\n`;
}
/** Returns a pose of a lattice: its rows, then its columns. */
function latticeSvg(cage, places) {
  return linesSvg(places, linesOf(cage).map(line => `<polyline points="${line.map(i => pointAt(places, i).join(',')).join(' ')}"/>`));
}
function latticeJson({ axes, frame, falloff }) {
  return JSON.stringify({ format: 'lattice/1', axes, frame_columns: [frame.slice(2, 4), frame.slice(4)], origin: frame.slice(0, 2), falloff }, null, 2) + '\n';
}
/** Returns the path of the edges at rest, each with its degree. */
function curvesData(curves) {
  return curves.map(loop => 'M' + loop[0][0].join(' ') + loop.map(edge => ' LQC'[edge.length - 1] + edge.slice(1).flat().join(' ')).join('') + 'Z').join('');
}

/** Saves a pose in the format that the programs read for a cage of this kind. */
function savePose(app) {
  const { figure: { name }, cage, pose } = app;
  if (cage.kind === 'lattice') download(name + '_pose.svg', [latticeSvg(cage, pose)], 'image/svg+xml');
  else if (cage.kind === 'curved') download(name + '_pose.svg', [linesSvg(pose, [`<path d="${curvesPath(cage, pose)}"/>`])], 'image/svg+xml');
  else download(name + '_pose.csv', [cageCsv(cage.loops, pose, `a pose of the cage of ${name}`)], 'text/csv');
}
function saveCage(app) {
  const { figure: { name }, cage } = app;
  if (cage.kind === 'lattice') download(name + '.lattice.json', [latticeJson(cage)], 'application/json');
  else if (cage.kind === 'curved') download(name + '_cage.svg', [linesSvg(cage.rest, [`<path d="${curvesData(cage.curves)}"/>`])], 'image/svg+xml');
  else download(name + '_cage.csv', [cageCsv(cage.loops, cage.rest, `the cage of ${name}`)], 'text/csv');
}

// ---- animations ----

/** Splits an affine map into a translation, a rotation (degrees), a skew along x (degrees) and a scale. */
function affineParts([a, b, c, d, e, f]) {
  const angle = Math.atan2(b, a), [cos, sin] = [Math.cos(angle), Math.sin(angle)], sx = Math.hypot(a, b), sy = cos * d - sin * c;
  const skew = sy === 0 ? 0 : Math.atan((cos * c + sin * d) / sy);
  return [[e, f], [angle * 180 / Math.PI], [skew * 180 / Math.PI], [sx, sy]];
}
/** Animates an attribute through values, one per frame, in a cycle. */
function animate(element, kind, attributes, values, seconds) {
  if (values.every(value => value === values[0])) return;
  svgElement(kind, { ...attributes, dur: seconds + 's', repeatCount: 'indefinite', values: [...values, values[0]].join(';') }, element);
}
/** Animates a transform through maps; `additive` says how they combine with the element's own transform. */
function animateMaps(element, name, maps, seconds, additive) {
  const parts = maps.map(affineParts);
  parts.forEach((part, k) => { // angles continue past a full turn
    if (k > 0) part[1][0] += 360 * Math.round((parts[k - 1][1][0] - part[1][0]) / 360);
  });
  ['translate', 'rotate', 'skewX', 'scale'].forEach((type, n) => {
    const values = parts.map(part => part[n].map(x => +x.toFixed(5)).join(' '));
    svgElement('animateTransform', { attributeName: name, type, additive: n === 0 ? additive : 'sum', dur: seconds + 's',
      repeatCount: 'indefinite', values: [...values, values[0]].join(';') }, element);
  });
}

/** Returns the animation as SVG text for browsers: frames of outlines, with linear interpolation between frames. */
function animatedSvg(app, framesPerSecond = 15) {
  const { clip, figure, engine } = app, count = Math.max(2, Math.min(600, Math.round(framesPerSecond * clip.length)));
  const poses = Array.from({ length: count }, (x, k) => clip.poseAt(k * clip.length / count, app.cage.rest, engine));
  const { copy, all } = posedCopy(app, poses), seconds = clip.length;
  figure.shapes.forEach((shape, i) => {
    const target = copy.targets[i];
    if (shape.outline) {
      animate(target, 'animate', { attributeName: 'd' }, all.map(places => pathData(shape, places, figure.decimals)), seconds);
      if (copy.marks[i]) animate(copy.marks[i], 'animate', { attributeName: 'd' }, all.map(places => vertexData(shape, places, figure.decimals)), seconds);
      return;
    }
    if (shape.transform) target.setAttribute('transform', shape.transform); else target.removeAttribute('transform');
    animateMaps(target, 'transform', all.map(places => boxMap(shape, places)), seconds, 'sum');
  });
  for (const gradient of copy.gradients)
    animateMaps(gradient.own, 'gradientTransform', all.map(places => figure.gradientMap(gradient, places)), seconds, 'replace');
  return new XMLSerializer().serializeToString(copy.root);
}
function saveAnimation(app) {
  if (app.clip.isEmpty) return app.say('Nothing to save: set key frames (K) at two times');
  download(app.figure.name + '_animated.svg', [animatedSvg(app), '\n'], 'image/svg+xml');
}

const WORD_OF_KIND = Object.fromEntries(Object.entries(KIND_OF_WORD).map(([word, kind]) => [kind, word]));
/** Returns the rows (time, value, kind) of a track, including the row of its next period. Curves with handles become many rows. */
function rowsOf(track, clip, engine) {
  const { keys, period } = track, [first] = keys;
  const rows = keys.some(key => key.in || key.out)
    ? Array.from({ length: 64 }, (x, k) => first.t + period * k / 64).map(t => [t, clip.valueOf(track, t % clip.length, engine), 'automatic'])
    : keys.map(({ t, v, kind }) => [t, v, WORD_OF_KIND[kind]]);
  return [...rows, [first.t + period, rows[0][1], rows[0][2]]];
}
/** Returns the animation in the format of the programs, with a control for every track and axis. */
function clipCsv(clip, engine, heading) {
  const lines = ['# ' + heading, 'length,' + clip.length];
  for (const track of clip.tracks) {
    for (const axis of [0, 1]) {
      const moved = track.targets.filter(target => target[1 + axis] !== 0);
      if (moved.length === 0) continue;
      lines.push('', `control,${track.name.replace(/,/g, '')} along ${'xy'[axis]}`, 'vertices,' + moved.map(target => `${target[0]}:${target[1 + axis]}`).join(','));
      lines.push('time,x,y,turn,kind', ...rowsOf(track, clip, engine).map(([t, v, kind]) => [t, axis === 0 ? v : 0, axis === 1 ? v : 0, 0, kind].join(',')));
    }
  }
  return lines.join('\n') + '\n';
}
function saveClip(app) {
  if (app.clip.isEmpty) return app.say('Nothing to save: set key frames (K) at two times');
  download(app.figure.name + '_clip.csv', [clipCsv(app.clip, app.engine, `an animation of the cage of ${app.figure.name}`)], 'text/csv');
}

// ---- 3D ----

/** Returns the posed mesh as OBJ: the original text with new positions and without normals. */
function objText(mesh, places) {
  let at = 0;
  return mesh.text.split('\n').filter(line => !/^\s*vn\s/.test(line)).map(line => {
    if (/^\s*v\s/.test(line)) return ['v', ...places.subarray(at, at += 3), ...line.trim().split(/\s+/).slice(4)].join(' ');
    return /^\s*f\s/.test(line) ? line.replace(/(\d)\/(-?\d*)\/-?\d+/g, (all, end, texture) => texture ? `${end}/${texture}` : end) : line;
  }).join('\n');
}
function posedPlaces(view) { return view.app.engine.cloneMesh(view.pose).slice(); }
function saveObj(view) { download(view.name + '_posed.obj', [objText(view.mesh, posedPlaces(view)), '\n'], 'model/obj'); }

/** Returns a cage as OBJ. */
function saveShell(view, places, what) {
  const { faces } = view.cage, lines = [];
  for (let k = 0; k < places.length; k += 3) lines.push(`v ${places[k]} ${places[k + 1]} ${places[k + 2]}`);
  for (let k = 0; k < faces.length; k += 3) lines.push(`f ${faces[k] + 1} ${faces[k + 1] + 1} ${faces[k + 2] + 1}`);
  download(`${view.name}_${what}.obj`, [lines.join('\n'), '\n'], 'model/obj');
}

/** Returns a mesh as binary glTF with one node, one mesh and one material. */
function glbBytes(name, places, normals, faces) {
  const least = [0, 1, 2].map(axis => places.reduce((m, x, k) => k % 3 === axis ? Math.min(m, x) : m, Infinity));
  const most = [0, 1, 2].map(axis => places.reduce((m, x, k) => k % 3 === axis ? Math.max(m, x) : m, -Infinity));
  const units = normals.map((x, k) => {
    const first = k - k % 3, length = Math.hypot(normals[first], normals[first + 1], normals[first + 2]);
    return length > 0 ? x / length : k % 3 === 2 ? 1 : 0;
  });
  const parts = [places, units, faces], sizes = parts.map(part => part.byteLength);
  const json = {
    asset: { version: '2.0', generator: 'cageform' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ name, mesh: 0 }],
    meshes: [{ name, primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, indices: 2, material: 0 }] }],
    materials: [{ name: 'clay', pbrMetallicRoughness: { baseColorFactor: [0.86, 0.35, 0.11, 1], metallicFactor: 0, roughnessFactor: 0.8 } }],
    buffers: [{ byteLength: sizes[0] + sizes[1] + sizes[2] }],
    bufferViews: sizes.map((byteLength, k) => ({ buffer: 0, byteOffset: sizes.slice(0, k).reduce((a, b) => a + b, 0), byteLength, target: k < 2 ? 34962 : 34963 })),
    accessors: [{ bufferView: 0, componentType: 5126, count: places.length / 3, type: 'VEC3', min: least, max: most },
      { bufferView: 1, componentType: 5126, count: units.length / 3, type: 'VEC3' }, { bufferView: 2, componentType: 5125, count: faces.length, type: 'SCALAR' }],
  };
  let text = new TextEncoder().encode(JSON.stringify(json));
  text = new Uint8Array([...text, ...Array((4 - text.length % 4) % 4).fill(32)]);
  const chunk = (size, kind) => new Uint32Array([size, kind]), size = sizes[0] + sizes[1] + sizes[2];
  return [new Uint32Array([0x46546c67, 2, 12 + 8 + text.length + 8 + size]), chunk(text.length, 0x4e4f534a), text, chunk(size, 0x4e4942), ...parts];
}
function saveGlb(view) {
  const places = posedPlaces(view), normals = view.app.engine.meshNormals(view.mesh.faces);
  download(view.name + '_posed.glb', glbBytes(view.name, places, normals, Uint32Array.from(view.mesh.faces)), 'model/gltf-binary');
}
