// Tests the run-time module in the folder of this file: node --test small.js
// small.json has results of the native library, written by native.py.

import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import * as runtime from './runtime.js';
import { assert, randomOf, sameBits } from './support.js';

const bytesOf = text => Uint8Array.from(Buffer.from(text, 'base64'));
const small = JSON.parse(await readFile(new URL('small.json', import.meta.url), 'utf8'));

await test('calls before init() are errors', () => {
  try {
    runtime.open(new Uint8Array(8));
  } catch (error) {
    return assert(error instanceof runtime.CageformError && error.message.includes('init'), error.stack);
  }
  throw new Error('opened');
});
await test('opens, clones and plays bitwise as the native library', async () => {
  await runtime.init();
  for (const one of small) {
    const figure = runtime.open(bytesOf(one.packedWithClip)),
      normals = one.normals !== undefined;
    sameBits(figure.clone(one.pose, { normals }).points, one.smallClone, one.name);
    sameBits(figure.clip('there and back').sample(0.7), one.sample, one.name);
    figure.free();
  }
});
await test('2,000 corrupt files are errors, and do not trap without the checksum', () => {
  const random = randomOf(9);
  let refusals = 0;
  for (let n = 0; n < 2000; ++n) {
    const { packedWithClip, pose } = small[n % small.length],
      spoilt = bytesOf(packedWithClip),
      skipChecksum = n % 3 === 0;
    for (let k = 0; k < 3; ++k) spoilt[random.pick(spoilt.length)] ^= 1 + random.pick(255);
    try {
      const figure = runtime.open(random.pick(4) ? spoilt : spoilt.subarray(0, random.pick(spoilt.length)), {
        skipChecksum,
      });
      figure.clone(pose);
      figure.free();
    } catch (error) {
      assert(error instanceof runtime.CageformError && error.status !== 'failed', `${n}: ${error.stack}`);
      ++refusals;
    }
  }
  assert(refusals > 1300, `${refusals} refusals`);
});
