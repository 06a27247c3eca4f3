// Prints the sizes of the package in bytes: node sizes.js FOLDER TARBALL

const { readFileSync, readdirSync } = require('node:fs');
const { brotliCompressSync, gzipSync } = require('node:zlib');

const [folder, tarball] = process.argv.slice(2);
const sizes = files => {
  const bytes = Buffer.concat(files.map(file => readFileSync(`${folder}/${file}`)));
  return [bytes.length, gzipSync(bytes, { level: 9 }).length, brotliCompressSync(bytes).length];
};
const scripts = readdirSync(folder).filter(file => file.endsWith('.js'));
const rows = [
  ['cageform.wasm', ['cageform.wasm']],
  ['runtime.wasm', ['runtime.wasm']],
  ['scripts', scripts],
  [
    'scripts of cageform/runtime',
    scripts.filter(file => !['index.js', 'cages.js', 'bindings.js', 'pins.js', 'wraps.js'].includes(file)),
  ],
];
console.log(`${'bytes'.padEnd(30)}${'raw'.padStart(10)}${'gzip'.padStart(10)}${'brotli'.padStart(10)}`);
for (const [name, files] of rows)
  console.log(
    name.padEnd(30) +
      sizes(files)
        .map(size => String(size).padStart(10))
        .join(''),
  );
console.log(`${tarball.padEnd(30)}${String(readFileSync(tarball).length).padStart(10)}`);
