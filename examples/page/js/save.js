// What is saved: downloads in the formats of the programs.

function download(name, parts, type) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob(parts, { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** The posed figure of the first view as SVG text; its viewBox grows to hold what has moved. */
function posedSvg(app) {
  const copy = app.figure.makeCopy();
  app.ensureBound(app.types[0]);
  const places = app.cloneFigure(app.types[0], app.pose);
  app.figure.write(copy, places);
  const { root } = copy, widest = Math.max(0, ...app.figure.shapes.map(shape => shape.radius ?? 0));
  const box = boundsOf(pairs(places)), view = numbersIn(root.getAttribute('viewBox') ?? '');
  const all = boundsOf([[box[0] - widest, box[1] - widest], [box[2] + widest, box[3] + widest],
    ...(view.length === 4 ? [[view[0], view[1]], [view[0] + view[2], view[1] + view[3]]] : [])]);
  const [w, h] = [all[2] - all[0], all[3] - all[1]];
  root.setAttribute('viewBox', `${all[0]} ${all[1]} ${w} ${h}`);
  for (const name of ['width', 'height', 'x', 'y', 'style']) root.removeAttribute(name);
  root.setAttribute('xmlns', SVG_NS);
  return { text: new XMLSerializer().serializeToString(root), width: w, height: h };
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

function savePose(app) {
  download(app.figure.name + '_pose.csv', [cageCsv(app.cage.loops, app.pose, `a pose of the cage of ${app.figure.name}`)], 'text/csv');
}
function saveCage(app) {
  download(app.figure.name + '_cage.csv', [cageCsv(app.cage.loops, app.cage.rest, `the cage of ${app.figure.name}`)], 'text/csv');
}
