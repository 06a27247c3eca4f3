// The tests in node: node --test node.js, in a folder where the package is installed. DATA has native.json and oracle/.

import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import * as cageform from 'cageform';
import * as runtime from 'cageform/runtime';
import { tests } from './cases.js';

const context = {
  cageform,
  runtime,
  file: path => readFile(`${process.env.DATA}/${path}`, 'utf8'),
  bytes: name =>
    readFile(new URL(import.meta.resolve?.(`cageform/${name}`) ?? `./node_modules/cageform/${name}`, import.meta.url)),
};
for (const { name, run } of tests.filter(one => one.before)) await test(name, () => run(context));
await test('init() starts the library, several times once', () => Promise.all([cageform.init(), cageform.init()]));
for (const { name, run } of tests.filter(one => !one.before))
  await test(name, async t => {
    const said = await run(context);
    if (said) t.diagnostic(said);
  });
