#!/usr/bin/env node
// Writes files with Lobe, has other programs read them, and prints a table: what each reader made of each file.
//
//   node peers/readers/readers.mjs target/release/lobe
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

import { chromiumPath, openBrowser } from '../browser.mjs';
import { cacheOf, getPackages, getPython } from '../packages.mjs';
import { FACES, N, difference, pfm, texel } from './cube.mjs';

// The milliseconds in which an engine loads a file.
const LIMIT = 90_000;

const cache = cacheOf('lobe-readers');
const lobe = process.argv[2] && path.resolve(process.argv[2]);
if (!lobe || !existsSync(lobe)) {
  console.error('usage: readers.mjs PROGRAM, such as target/release/lobe');
  process.exit(2);
}

const rows = [];
// A line of the table. `verdict` is 'reads', 'refuses' (known, and said in the guide), 'SKIPPED' or 'FAILS'.
function row(file, reader, verdict, note) {
  rows.push(verdict);
  console.log(`${file.padEnd(22)} ${reader.padEnd(12)} ${verdict.padEnd(8)} ${note}`);
}

function expect(file, reader, holds, note) {
  row(file, reader, holds ? 'reads' : 'FAILS', note);
}

const folder = mkdtempSync(path.join(tmpdir(), 'lobe-readers-'));
const at = name => path.join(folder, name);
const run = (...words) => execFileSync(lobe, ['--quiet', ...words], { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
// Which cube files load in which engines; the guide has the same table. Of others, a refusal is what is known.
const FLOATS = ['rgba16f.dds', 'rgba16f-mips.dds', 'rgba32f.dds'];
const LOADS = {
  three: ['%.hdr', 'bc6h.dds'],
  babylon: FLOATS,
  playcanvas: [...FLOATS, 'r11g11b10f.ktx', 'r11g11b10f-mips.ktx'],
  filament: ['r11g11b10f.ktx', 'r11g11b10f-mips.ktx'],
};

function writeCubes() {
  for (const [k, face] of FACES.entries()) writeFileSync(at(`${face}.pfm`), pfm(k));
  const cubes = [];
  for (const ending of ['ktx2', 'dds']) {
    for (const texels of ['rgba16f', 'rgba32f', 'rgb9e5', 'bc6h']) {
      const name = `${texels}.${ending}`;
      run('env', 'convert', '%.pfm', '--size', `${N}`, '--texels', texels, '-o', name);
      cubes.push(name);
    }
    run('env', 'convert', '%.pfm', '--size', `${N}`, '--texels', 'rgba16f', '--mips', '-o', `rgba16f-mips.${ending}`);
    cubes.push(`rgba16f-mips.${ending}`);
  }
  run('env', 'convert', '%.pfm', '--size', `${N}`, '--texels', 'rgba16f', '--mips', '--zstd', '-o', 'rgba16f-zstd.ktx2');
  run('env', 'convert', '%.pfm', '--size', `${N}`, '-o', '%.hdr');
  run('env', 'convert', '%.pfm', '--size', `${N}`, '-o', 'r11g11b10f.ktx');
  run('env', 'convert', '%.pfm', '--size', `${N}`, '--mips', '-o', 'r11g11b10f-mips.ktx');
  run('env', 'convert', '%.pfm', '--size', `${N}`, '--left-handed', '-o', 'mirrored.dds');
  return [...cubes, 'rgba16f-zstd.ktx2', '%.hdr', 'r11g11b10f.ktx', 'r11g11b10f-mips.ktx'];
}

const VULKAN = { rgba16f: 97, rgba32f: 109, rgb9e5: 123, bc6h: 143 };

async function parseKtx2(cubes, modules) {
  const { read } = await import(pathToFileURL(path.join(modules, 'ktx-parse/dist/index.mjs')));
  for (const name of cubes.filter(name => name.endsWith('.ktx2'))) {
    const file = read(new Uint8Array(readFileSync(at(name))));
    const levels = /mips|zstd/.test(name) ? Math.log2(N) + 1 : 1;
    const holds = file.faceCount === 6 && file.levels.length === levels && file.pixelWidth === N
      && file.vkFormat === VULKAN[name.split(/[-.]/)[0]];
    let note = `format ${file.vkFormat}, ${file.faceCount} faces, ${file.levels.length} levels`;
    let same = true;
    if (name === 'rgba32f.ktx2') {
      const data = file.levels[0].levelData;
      const numbers = new Float32Array(data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength));
      same = numbers.every((x, i) => {
        const [c, texelIndex] = [i % 4, Math.floor(i / 4)];
        const expected = texel(Math.floor(texelIndex / (N * N)), texelIndex % N, Math.floor(texelIndex / N) % N);
        return x === (c === 3 ? 1 : Math.fround(expected[c]));
      });
      note += same ? ', every texel exact' : ', texels differ';
    }
    expect(name, 'ktx-parse', holds && same, note);
  }
}

// What an engine's own loader finds in a file, and what it says.
const loaded = async (browser, engine, file) =>
  ({ said: [], ...await browser.found({ engine, file: `/files/${file}` }) });

async function loadCubes(cubes, browser) {
  for (const engine of Object.keys(LOADS)) {
    for (const name of cubes) {
      if (engine !== 'three' && name.includes('%')) continue;
      if (['three', 'babylon'].includes(engine) && name.endsWith('.ktx')) continue;
      if (engine === 'filament' && name.endsWith('.dds')) continue;
      const { result, error, said } = await loaded(browser, engine, name);
      const off = result ? difference(result) : Infinity;
      // A sixteenth is a texel. A block of BC6H has colors on a line, which these are not: it is off by a texel and a half.
      const right = off < 1 / 8;
      const must = LOADS[engine].includes(name);
      const why = right ? `largest difference ${off.toFixed(4)}` : error ?? said[0]?.replace(/^BJS - \[.*?\]: /, '') ?? `wrong by ${off.toFixed(2)}`;
      row(name, engine, right ? 'reads' : must ? 'FAILS' : 'refuses', why.replace(/\s+/g, ' ').slice(0, 90));
    }
  }
  const { result } = await loaded(browser, 'babylon', 'mirrored.dds');
  const noticed = result && difference(result) > 1 / 16;
  row('mirrored.dds', 'babylon', noticed ? 'reads' : 'FAILS', 'the control: a mirror image, noticed as one');
}

// The numbers of a safetensors file of transfer: [receivers, channels, n²].
function readTransfer(name) {
  const bytes = readFileSync(at(name));
  const length = Number(bytes.readBigUInt64LE(0));
  const { shape, data_offsets: [start, end] } = JSON.parse(bytes.subarray(8, 8 + length)).transfer;
  return { shape, numbers: new Float32Array(bytes.buffer.slice(bytes.byteOffset + 8 + length + start, bytes.byteOffset + 8 + length + end)) };
}

const MODELS = {
  'baked.glb': [],
  'compressed.glb': ['--clusters', '8', '--components', '4', '--weights', '16'],
};

async function validateModels(modules) {
  const validator = createRequire(path.join(modules, 'x.js'))('gltf-validator');
  const bake = ['bake', 'built-in:ball', '--order', '3', '--samples', '64'];
  run(...bake, '-o', 'transfer.safetensors');
  for (const [name, words] of Object.entries(MODELS)) {
    run(...bake, ...words, '-o', name);
    const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(at(name))), { uri: name });
    const { numErrors, numWarnings, numInfos, numHints, messages } = issues;
    const first = messages.find(m => m.severity <= 1);
    const note = `${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, ${numHints} hints`;
    expect(name, 'validator', numErrors + numWarnings === 0, first ? `${note}: ${first.message}` : note);
  }
}

async function loadModels(browser) {
  const { shape: [receivers], numbers } = readTransfer('transfer.safetensors');
  const sum = numbers.reduce((total, x) => total + x, 0);
  for (const name of Object.keys(MODELS)) {
    const { result, error } = await loaded(browser, 'model', name);
    if (!result) {
      expect(name, 'three', false, error);
      continue;
    }
    const vertices = result.position?.count;
    const names = Object.keys(result).filter(attribute => attribute.startsWith('_'));
    const total = names.reduce((all, attribute) => all + result[attribute].sum, 0);
    const same = name !== 'baked.glb' || Math.abs(total - sum) < 1e-6 * numbers.reduce((all, x) => all + Math.abs(x), 0);
    expect(name, 'three', vertices === receivers && names.length > 0 && same,
      `${vertices} vertices, ${names.length} attributes of transfer${name === 'baked.glb' ? `, sum ${total.toFixed(2)} against ${sum.toFixed(2)}` : ''}`);
  }
}

function readExr(python) {
  run('env', 'convert', 'bundled:sunset', '--size', '32', '-o', 'full.exr');
  run('env', 'convert', 'bundled:sunset', '--size', '32', '--half', '-o', 'half.exr');
  run('env', 'convert', 'bundled:sunset', '--size', '32', '-o', 'full.pfm');
  run('render', 'trace', 'built-in:ball', '--env', 'bundled:studio', '--size', '80x70', '--samples', '2', '-o', 'truth.exr');
  run('bake', 'built-in:cornell', '--texels', '64', '--order', '3', '--samples', '4', '-o', 'lightmap.exr');
  const names = ['full.exr', 'half.exr', 'truth.exr', 'lightmap.exr'];
  const found = JSON.parse(execFileSync(python, [path.join(import.meta.dirname, 'exr.py'), ...names.map(at)], { maxBuffer: 1 << 24 }));
  const floats = readFileSync(at('full.pfm'));
  const data = floats.subarray(floats.length - 3 * 4 * 64 * 32);
  let red = 0;
  for (let i = 0; i < data.length; i += 12) red += data.readFloatLE(i);
  for (const name of ['full.exr', 'half.exr']) {
    const { R } = found[at(name)].channels;
    const close = Math.abs(R.sum - red) < (name === 'half.exr' ? 1e-3 : 1e-6) * red;
    expect(name, 'OpenEXR', close && `${R.size}` === '32,64', `sum of red ${R.sum.toFixed(3)} against ${red.toFixed(3)}`);
  }
  const truth = found[at('truth.exr')];
  const layers = ['R', 'variance.G', 'albedo.B', 'normal.X', 'depth.Z', 'coverage.A'];
  expect('truth.exr', 'OpenEXR', layers.every(name => `${truth.channels[name]?.size}` === '70,80'), `${Object.keys(truth.channels).length} channels`);
  const lightmap = found[at('lightmap.exr')];
  const lobeNote = JSON.parse(lightmap.attributes.lobe ?? '{}');
  expect('lightmap.exr', 'OpenEXR', Object.keys(lightmap.channels).length === 27 && lobeNote.format === 'lobe-lightmap',
    `${Object.keys(lightmap.channels).length} channels, format ${lobeNote.format}`);
}

try {
  const modules = getPackages(import.meta.dirname, cache);
  const python = getPython(cache, 'OpenEXR', 'numpy');
  console.log(`${'file'.padEnd(22)} ${'reader'.padEnd(12)}`);
  const cubes = writeCubes();
  await parseKtx2(cubes, modules);
  await validateModels(modules);
  readExr(python);
  if (chromiumPath()) {
    const browser = await openBrowser(
      createRequire(path.join(modules, 'x.js'))('playwright-core'),
      { page: import.meta.dirname, modules, files: folder },
      LIMIT,
    );
    await loadModels(browser);
    await loadCubes(cubes, browser);
    await browser.close();
  } else {
    row('all', 'browser', 'SKIPPED', 'no Chromium; install it, or name it in CHROMIUM');
  }
} finally {
  rmSync(folder, { recursive: true, force: true });
}
const count = verdict => rows.filter(found => found === verdict).length;
console.log(`${count('reads')} read, ${count('refuses')} refused as known, ${count('SKIPPED')} skipped, ${count('FAILS')} failed`);
process.exit(count('FAILS') ? 1 : 0);
