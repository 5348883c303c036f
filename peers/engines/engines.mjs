#!/usr/bin/env node
// Exports one light for each engine, has the engine show it by the exported program, and compares with the light.
//
//   node peers/engines/engines.mjs target/release/lobe [NAME...]
import { execFileSync, spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { writeBalls } from './balls.mjs';
import { chromiumPath, openBrowser } from '../browser.mjs';
import { BLENDER, cacheOf, getPackages, getPython } from '../packages.mjs';
import { COSINE, DIRECTIONS, IDENTITY, SKY_DIRECTIONS, shJson, sunJson } from './light.mjs';
import { bestFrame, bestLevel, ggxAlbedo, sunError } from './light.mjs';

// The milliseconds in which an engine shows all balls.
const LIMIT = 300_000;

const cache = cacheOf('lobe-engines');
const lobe = process.argv[2] && path.resolve(process.argv[2]);
if (!lobe || !existsSync(lobe)) {
  console.error('usage: engines.mjs PROGRAM [NAME...], such as target/release/lobe three');
  process.exit(2);
}

const mixed = (share, a, b) => a.map((x, k) => share * x + (1 - share) * b[k]);
const SIZE = 256;
// The level that each engine reads for a roughness, by its own formula, and the roughness of a level by the inverse.
const quadratic = last => ({ last, read: r => last * r * (2 - r), held: k => 1 - Math.sqrt(1 - k / last) });
const linear = last => ({ last, read: r => last * r, held: k => k / last });
const doubling = {
  last: Math.log2(SIZE),
  read: r => 0.8 * Math.log2(SIZE * r * r),
  held: k => (k ? Math.min(1, Math.sqrt(2 ** (k / 0.8) / SIZE)) : 0),
};
// Its atlas has levels of the engine's own.
const own = { last: 5, read: r => 5 * r, held: k => k / 5 };
const asTheyAre = gains => gains;
// The reflectance of white metal towards the normal by the polynomial of Karis 2014.
function karisAlbedo(roughness) {
  const [x, y, z, w] = [[-1, 1], [-0.0275, 0.0425], [-0.572, 1.04], [0.022, -0.04]].map(([a, b]) => roughness * a + b);
  const a004 = Math.min(x * x, 2 ** -9.28) * x + y;
  return -1.04 * a004 + z + 1.04 * a004 + w;
}
// Of each engine: how it is run, the levels that it reads, what it makes of their gains for a roughness, and the
// largest difference that is allowed, by its textures and targets.
const ENGINES = {
  // What is lost by single scattering comes back as irradiance, which is read from faces of eight texels.
  three: {
    by: 'browser',
    levels: quadratic(5),
    gains: r => g => mixed(ggxAlbedo(r), g, COSINE),
    most: { numbers: 1e-3, matte: 6e-3, mirror: 1e-3, sky: 8e-3, rough: 5e-3, sun: 6e-3 },
  },
  // Alpha is the share of irradiance. Faces have eight bits.
  babylon: {
    by: 'browser',
    levels: doubling,
    gains: r => g => mixed(1 - r ** 2, g, COSINE),
    most: { matte: 1e-3, mirror: 5e-3, sky: 5e-3, rough: 1e-2, sun: 1e-3 },
  },
  // The engine filters an atlas of eight bits by few samples; its numbers and the cube of the sky have none of that.
  playcanvas: {
    by: 'browser',
    levels: own,
    gains: () => asTheyAre,
    most: { numbers: 1e-3, matte: 5e-2, mirror: 1e-3, sky: 1e-3, rough: 5e-2, sun: 1e-3 },
    off: 0.5,
  },
  // The canvas has eight bits, and the colors of cubes have six and five.
  filament: {
    by: 'browser',
    levels: quadratic(4),
    gains: () => asTheyAre,
    most: { matte: 5e-3, mirror: 2e-2, sky: 2e-2, rough: 2e-2, sun: 6e-3 },
    off: 0.25,
  },
  // What is lost by single scattering comes back as irradiance. Its reflectance is a polynomial.
  bevy: {
    by: 'cargo',
    levels: linear(4),
    gains: r => g => mixed(karisAlbedo(r), g, COSINE),
    most: { matte: 2e-3, mirror: 2e-3, sky: 2e-3, rough: 5e-3, sun: 5e-3 },
  },
  // Paths: the noise of the matte ball.
  mitsuba: { by: 'mitsuba==3.9.1', script: 'mitsuba', most: { matte: 5e-3, mirror: 1e-3, sun: 5e-3 } },
  // It takes the first row of the picture for the pole, half a texel away.
  blender: { by: BLENDER, script: 'blender', most: { matte: 1e-3, mirror: 5e-3, sun: 1e-3 } },
  // Blender imports the stage. Its importer makes a normalized DistantLight four times as strong as UsdLux says.
  usd: { by: BLENDER, script: 'blender', most: { matte: 1e-3, mirror: 5e-3, sun: 2e-3 }, gain: 4 },
};
const ROUGHNESS = [0.25, 0.5, 0.75];
// How far the level that is seen may be from the one that holds the roughness, unless the engine's row says otherwise:
// texels are averages, too, and steps of eight bits hide what levels of small roughness differ by.
const MOST_OFF = 0.15;

const asked = process.argv.slice(3);
// bevy takes a quarter of an hour to compile: it runs where it is asked for.
const names = asked.length ? asked : Object.keys(ENGINES).filter(name => ENGINES[name].by !== 'cargo');
const rows = [];
function row(engine, what, holds, found) {
  rows.push(holds);
  console.log(`${engine.padEnd(20)} ${what.padEnd(16)} ${(holds ? 'agrees' : 'DIFFERS').padEnd(8)} ${found}`);
}

// Python with one package of PyPI: that of a variable, or of the cache.
function pythonOf(wanted) {
  const [name] = wanted.split('==');
  return process.env[`LOBE_ENGINES_${name.toUpperCase()}`] ?? getPython(cache, wanted);
}

const folder = mkdtempSync(path.join(tmpdir(), 'lobe-engines-'));
const quietly = { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] };
const run = (...words) => execFileSync(lobe, ['--quiet', ...words], quietly);
writeFileSync(path.join(folder, 'light.sh.json'), shJson());
writeFileSync(path.join(folder, 'sun.json'), sunJson());
writeBalls(folder, ROUGHNESS);
run('env', 'reconstruct', 'light.sh.json', '-o', 'light.exr', '--size', '512');
run('export', 'light.exr', '--engine', names.join(','), '--suns', 'none', '-o', 'plain');
run('export', 'light.exr', '--engine', names.join(','), '--suns', 'sun.json', '-o', 'sun');
if (names.includes('three')) {
  cpSync(path.join(folder, 'plain', 'three'), path.join(folder, 'control', 'three'), { recursive: true });
  const chain = path.join('control', 'three', 'specular.ktx2');
  run('env', 'prefilter', 'light.exr', '--size', `${SIZE}`, '--last-size', '8', '-o', chain);
}

const matte = { name: 'matte', roughness: null };
const rough = ROUGHNESS.map(roughness => ({ name: `rough ${roughness}`, roughness }));
const surfaces = [matte, { name: 'mirror', roughness: 0 }, ...rough];

function judge(engine, version, values, ofSun) {
  const { most, gains, levels } = ENGINES[engine];
  const title = `${engine} ${version}`;
  for (const [what, expected] of [['numbers', COSINE], ['matte', COSINE], ['mirror', [1, 1]], ['sky', [1, 1]]]) {
    if (!values[what]) continue;
    const { name, error, next } = bestFrame(values[what], expected, what === 'sky' ? SKY_DIRECTIONS : undefined);
    row(title, what, name === IDENTITY && error <= most[what],
      `${name}, difference ${error.toExponential(1)}, allowed ${most[what]}, next frame ${next.toFixed(2)}`);
  }
  for (const roughness of levels ? ROUGHNESS : []) {
    const held = Array.from({ length: levels.last + 1 }, (_, k) => levels.held(k));
    const found = bestLevel(values[`rough ${roughness}`], held, gains(roughness));
    const read = levels.read(roughness);
    const holds = Math.abs(found.level - read) <= (ENGINES[engine].off ?? MOST_OFF) && found.error <= most.rough;
    const seen = `level ${found.level.toFixed(2)}, expected ${read.toFixed(2)} of ${levels.last}`;
    const difference = `difference ${found.error.toExponential(1)}, allowed ${most.rough}`;
    row(title, `rough ${roughness}`, holds, `${seen}; ${difference}`);
  }
  const error = sunError(ofSun, ENGINES[engine].gain);
  row(title, 'matte and a sun', error <= most.sun, `difference ${error.toExponential(1)}, allowed ${most.sun}`);
}

// The chain of `lobe env prefilter` without options in the place of the one for three.js: its faces are those of the
// other hand, its levels are linear. Both must be seen.
function control({ error, values }) {
  if (error) return row('control', 'runs', false, error);
  const { name } = bestFrame(values.mirror, [1, 1]);
  row('control', 'mirror', name === '-x +y +z', `${name}, which is the other hand`);
  const levels = quadratic(5), mirrored = values['rough 0.5'];
  const held = Array.from({ length: levels.last + 1 }, (_, k) => levels.held(k));
  // Seen in the other hand, the balls are those of directions with x turned around.
  const other = ([x, y, z]) => DIRECTIONS.findIndex(d => Math.hypot(d[0] + x, d[1] - y, d[2] - z) < 1e-9);
  const turned = DIRECTIONS.map(d => mirrored[other(d)]);
  const found = bestLevel(turned, held, ENGINES.three.gains(0.5));
  const differs = Math.abs(found.level - levels.read(0.5)) > MOST_OFF;
  row('control', 'rough 0.5', differs, `level ${found.level.toFixed(2)}, not ${levels.read(0.5)}`);
}

// Compiles the exported programs into the crate of the folder, in the cache, and runs it.
function judgeBevy() {
  const crate = path.join(cache, 'bevy');
  cpSync(path.join(import.meta.dirname, 'bevy'), crate, { recursive: true });
  for (const what of ['plain', 'sun']) {
    cpSync(path.join(folder, what, 'bevy', 'sky.rs'), path.join(crate, 'src', `${what}.rs`));
  }
  const env = { ...process.env, CARGO_TARGET_DIR: path.join(crate, 'target') };
  execFileSync('cargo', ['build', '--locked'], { cwd: crate, env, stdio: ['ignore', 'ignore', 'inherit'] });
  const show = (what, surfaces) => {
    const out = path.join(folder, `bevy-${what}.json`);
    const looked = JSON.stringify({ surfaces, directions: DIRECTIONS, sky: SKY_DIRECTIONS });
    const { status, stderr } =
      spawnSync(path.join(crate, 'target/debug/lobe-bevy-balls'), [what, folder, out, looked], { encoding: 'utf8' });
    return status === 0 ? JSON.parse(readFileSync(out)) : { error: stderr.trim().split('\n').pop() };
  };
  const [plain, sun] = [show('plain', surfaces), show('sun', [matte])];
  if (plain.error || sun.error) row('bevy', 'runs', false, plain.error ?? sun.error);
  else judge('bevy', plain.version, plain.values, sun.values.matte);
}

const inBrowser = names.filter(name => ENGINES[name].by === 'browser');
if (inBrowser.length) {
  const modules = getPackages(import.meta.dirname, cache);
  if (!chromiumPath()) {
    console.error('no Chromium: install it, or say where it is with CHROMIUM');
    process.exit(2);
  }
  const { chromium } = createRequire(path.join(modules, 'x.js'))('playwright-core');
  const browser = await openBrowser({ chromium }, { page: import.meta.dirname, modules, files: folder }, LIMIT);
  // A module of this folder looks at one export.
  const shown = (engine, from, what) =>
    browser.found({ engine, folder: `/files/${from}/${engine}`, surfaces: JSON.stringify(what) });
  for (const engine of inBrowser) {
    const [plain, sun] = [await shown(engine, 'plain', surfaces), await shown(engine, 'sun', [matte])];
    if (plain.error || sun.error) row(engine, 'runs', false, plain.error ?? sun.error);
    else judge(engine, plain.version, plain.values, sun.values.numbers ?? sun.values.matte);
  }
  if (inBrowser.includes('three')) control(await shown('three', 'control', surfaces));
  await browser.close();
}
if (names.includes('bevy')) judgeBevy();
for (const engine of names.filter(name => !['browser', 'cargo'].includes(ENGINES[name].by))) {
  const python = pythonOf(ENGINES[engine].by);
  if (!python) {
    console.log(`${engine}: SKIPPED, pip has no ${ENGINES[engine].by} here`);
    continue;
  }
  const show = what => {
    const out = path.join(folder, `${engine}-${what}.json`);
    const script = path.join(import.meta.dirname, `${ENGINES[engine].script}_balls.py`);
    const { status, stderr } = spawnSync(python, [script, path.join(folder, what, engine), out], { encoding: 'utf8' });
    return status === 0 ? JSON.parse(readFileSync(out)) : { error: stderr.trim().split('\n').pop() };
  };
  const [plain, sun] = [show('plain'), show('sun')];
  if (plain.error || sun.error) row(engine, 'runs', false, plain.error ?? sun.error);
  else judge(engine, plain.version, plain.values, sun.values.numbers ?? sun.values.matte);
}
if (process.env.KEEP) console.log(folder);
else rmSync(folder, { recursive: true });
const differ = rows.filter(holds => !holds).length;
console.log(differ ? `${differ} of ${rows.length} differ` : `all ${rows.length} agree`);
process.exit(differ ? 1 : 0);
