#!/usr/bin/env node
// Lights animated characters by spheres and by traced paths, and prints a table: how near the pictures are, and how near one is
// that is late, the control.
//
//   node peers/motion/lit.mjs target/release/lobe [NAME...]
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { dancer } from './character.mjs';
import { models } from './models.mjs';
import { cache, getPackages } from './packages.mjs';

// Times as parts of the first animation, off its keys and ends.
const PARTS = [0.13, 0.37, 0.81];
const LIGHT = ['--env', 'bundled:sunset', '--size', '160x160'];
const SPHERES = [4, 64];
const LATE = 0.1;
// More spheres are no worse. What hides nothing of itself is so by this many decibels, as every sphere reaches out of it a little.
const WORSE = 2;
// Paths for each pixel of the truth: their noise is some decibels below what is measured.
const PATHS = 128;

const lobe = process.argv[2] && path.resolve(process.argv[2]);
if (!lobe || !existsSync(lobe)) {
  console.error('usage: lit.mjs PROGRAM [NAME...], such as target/release/lobe Fox');
  process.exit(2);
}
const folder = mkdtempSync(path.join(tmpdir(), 'lobe-lit-'));
const at = (name) => path.join(folder, name);
const run = (...words) => execFileSync(lobe, ['--quiet', ...words.map(String)], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });
const render = (method, file, time, out, ...words) => run('render', method, file, ...LIGHT, '--time', time, ...words, '-o', at(out));
const decibels = (picture) => JSON.parse(run('compare', at(picture), at('truth.exr'), '--json')).psnr;

// The end of the first animation: the last key of its samplers.
function duration(file) {
  const bytes = readFileSync(file);
  const json = JSON.parse(bytes.readUInt32LE(0) === 0x46546c67 ? bytes.subarray(20, 20 + bytes.readUInt32LE(12)) : bytes);
  return Math.max(...json.animations[0].samplers.map(({ input }) => json.accessors[input].max[0]));
}

let failures = 0;
try {
  const names = process.argv.slice(3);
  const files = [...models(cache), await dancer(cache, getPackages())].filter(({ name }) => names.length === 0 || names.includes(name));
  if (files.length === 0) throw new Error(`no model is called ${names.join(' or ')}`);
  console.log(`| file | time, s | ${SPHERES.map((n) => `${n} spheres, dB`).join(' | ')} | late, dB | |`);
  console.log(`|---|---|${SPHERES.map(() => '---|').join('')}---|---|`);
  for (const { name, file } of files) {
    for (const part of PARTS) {
      const time = part * duration(file);
      render('trace', file, time, 'truth.exr', '--bounces', 0, '--samples', PATHS);
      const near = SPHERES.map((count) => {
        render('moving', file, time, 'spheres.exr', '--method', 'exponentials', '--order', 4, '--spheres', count);
        return decibels('spheres.exr');
      });
      // The control: what is late by a tenth of the animation is farther from the truth.
      render('moving', file, time + LATE * duration(file), 'late.exr', '--method', 'exponentials', '--order', 4, '--spheres', SPHERES.at(-1));
      const late = decibels('late.exr');
      const isNearer = near.at(-1) > late && near.at(-1) > near[0] - WORSE;
      failures += isNearer ? 0 : 1;
      console.log(`| ${[name, time.toFixed(2), ...[...near, late].map((n) => n.toFixed(1)), isNearer ? 'nearer' : 'FAILS'].join(' | ')} |`);
    }
  }
} finally {
  rmSync(folder, { recursive: true });
}
process.exit(failures > 0 ? 1 : 0);
