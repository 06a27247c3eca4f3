// The tests in node: node --test node.js, in a folder with the installed package. DATA has native.json and oracle/.

import { execFileSync } from 'node:child_process';
import { readFile, writeFile } from 'node:fs/promises';
import { test } from 'node:test';
import * as cageform from 'cageform';
import * as runtime from 'cageform/runtime';
import { tests } from './cases.js';
import { equal } from './support.js';

const context = {
  cageform,
  runtime,
  file: path => readFile(`${process.env.DATA}/${path}`, 'utf8'),
  bytes: name =>
    readFile(new URL(import.meta.resolve?.(`cageform/${name}`) ?? `./node_modules/cageform/${name}`, import.meta.url)),
};
for (const { name, run } of tests.filter(one => one.before)) await test(name, () => run(context));
await test('several calls of init() start the library once', () => Promise.all([cageform.init(), cageform.init()]));
for (const { name, run } of tests.filter(one => !one.before))
  await test(name, async t => {
    const said = await run(context);
    if (said) t.diagnostic(said);
  });
await test('the program of the README prints the output shown there', async () => {
  const text = await readFile('node_modules/cageform/README.md', 'utf8');
  const [, program, printed] = text.match(/```js\n([^]*?)```\n\nIt prints\n\n((?: {4}.*\n)+)/);
  await writeFile('readme.js', program);
  const said = execFileSync(process.execPath, ['readme.js'], { encoding: 'utf8' });
  equal(said, printed.replaceAll(/^ {4}/gm, ''), 'output');
});
