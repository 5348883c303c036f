// Baked scenes go through programs that write glTF files anew, and are rendered: roundtrips.mjs LOBE
//
// The picture must be that of the scene as it was baked, or `lobe render baked` must say what is lost.
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

import { BLENDER, cacheOf, getPackages, getPython } from '../packages.mjs';

const lobe = process.argv[2] && path.resolve(process.argv[2]);
if (!lobe || !existsSync(lobe)) {
  console.error('usage: node peers/roundtrips/roundtrips.mjs target/release/lobe');
  process.exit(2);
}

// What is baked, and the options of its compression.
const BAKES = {
  plain: [],
  'compressed, floats': ['--clusters', '16', '--components', '6', '--weights', '32'],
  'compressed, 16 bits': ['--clusters', '16', '--components', '6'],
};
// Relative RMS errors of pictures. Other orders of vertices change the last bits; a number of 12 bits within -1 and 1
// has steps of 1/2047.
const EXACT = 1e-5;
const TWELVE_BITS = 5e-3;

const cache = cacheOf('lobe-roundtrips');
const modules = getPackages(import.meta.dirname, cache);
const python = getPython(cacheOf('lobe-engines'), BLENDER);
const parts = ['core', 'extensions', 'functions'].map(part => `@gltf-transform/${part}`);
const NAMES = [...parts, 'draco3dgltf', 'meshoptimizer'];
const require = createRequire(path.join(modules, 'x.js'));
const load = name => import(pathToFileURL(require.resolve(name)));
const [core, extensions, functions, draco, meshoptimizer] = await Promise.all(NAMES.map(load));
const { MeshoptEncoder, MeshoptDecoder } = meshoptimizer;
await Promise.all([MeshoptEncoder.ready, MeshoptDecoder.ready]);
const io = new core.NodeIO().registerExtensions(extensions.ALL_EXTENSIONS).registerDependencies({
  'meshopt.encoder': MeshoptEncoder,
  'meshopt.decoder': MeshoptDecoder,
  'draco3d.encoder': await draco.default.createEncoderModule(),
  'draco3d.decoder': await draco.default.createDecoderModule(),
});

const transformed = (...steps) => async (source, target) => {
  const document = await io.read(source);
  document.setLogger(new core.Logger(core.Verbosity.ERROR));
  if (steps.length) await document.transform(...steps);
  await io.write(target, document);
};
const run = (program, ...args) => (source, target) => {
  const { status, stderr, stdout } = spawnSync(program, args.map(arg => ({ IN: source, OUT: target })[arg] ?? arg));
  if (status !== 0 || !existsSync(target)) throw new Error(`${stderr}${stdout}`.trim().split('\n').at(-1));
};
const blender = path.join(import.meta.dirname, 'blender_roundtrip.py');
const { prune, weld, flatten, join, reorder, quantize, meshopt, draco: dracoed } = functions;

// What each program leaves: the largest error, or words of the line that says what is lost; an array by bake.
const PROGRAMS = {
  'glTF-Transform copy': [transformed(), EXACT],
  'glTF-Transform prune': [transformed(prune()), EXACT],
  'glTF-Transform weld': [transformed(weld()), EXACT],
  'glTF-Transform join': [transformed(flatten(), join()), EXACT],
  'glTF-Transform reorder': [transformed(reorder({ encoder: MeshoptEncoder })), EXACT],
  'glTF-Transform quantize': [transformed(quantize()), TWELVE_BITS],
  'glTF-Transform meshopt': [transformed(meshopt({ encoder: MeshoptEncoder })), TWELVE_BITS],
  'glTF-Transform draco': [transformed(dracoed()), TWELVE_BITS],
  gltfpack: [run(path.join(modules, '.bin/gltfpack'), '-i', 'IN', '-o', 'OUT'), 'another program left it out'],
  'Blender, with extras': [
    run(python, blender, 'IN', 'OUT', 'extras'),
    { plain: EXACT, 'compressed, floats': EXACT, 'compressed, 16 bits': 'has clusters as colors' },
  ],
  'Blender, attributes alone': [run(python, blender, 'IN', 'OUT'), 'no extras.lobe that describes it'],
};

const folder = mkdtempSync(path.join(tmpdir(), 'lobe-roundtrips-'));
let wrong = 0;
function row(bake, program, agrees, text) {
  wrong += !agrees;
  console.log(`${bake.padEnd(20)} ${program.padEnd(26)} ${agrees ? 'agrees' : 'DIFFERS'}  ${text}`);
}

// The picture of a file, or the line of the error.
function rendered(file) {
  const picture = file.replace(/glb$/, 'exr');
  const view = ['--env', 'bundled:sunset', '--suns', 'none', '--size', '160x120', '--background', 'none'];
  const { status, stderr } = spawnSync(lobe, ['render', 'baked', file, ...view, '-o', picture, '--quiet']);
  return status === 0 ? { picture } : { line: String(stderr).trim().replaceAll(`${folder}/`, '') };
}

// The relative RMS difference of two pictures.
function difference(a, b) {
  const found = JSON.parse(execFileSync(lobe, ['compare', a, b, '--json', '--quiet']));
  return Math.sqrt(found.relmse);
}

async function judge(bake, source, expected, name) {
  const [write, left] = PROGRAMS[name];
  const allowed = left[bake] ?? left;
  const target = source.replace(/\.glb$/, `.${name.replace(/\W+/g, '-')}.glb`);
  try {
    await write(source, target);
  } catch (error) {
    return row(bake, name, false, `does not write it: ${error.message.split('\n')[0]}`);
  }
  const { picture, line } = rendered(target);
  if (!picture) return row(bake, name, typeof allowed === 'string' && line.includes(allowed), line);
  const off = difference(expected, picture);
  row(bake, name, off <= allowed, `difference ${off.toExponential(1)}, allowed ${allowed}`);
}

for (const [bake, options] of Object.entries(BAKES)) {
  const source = path.join(folder, `${bake.replace(/\W+/g, '-')}.glb`);
  const fixed = ['--order', '3', '--samples', '64', '--no-split', '--quiet'];
  execFileSync(lobe, ['bake', 'built-in:columns', '-o', source, ...fixed, ...options]);
  const { picture: expected, line } = rendered(source);
  if (!expected) throw new Error(line);
  for (const name of Object.keys(PROGRAMS)) await judge(bake, source, expected, name);
}
rmSync(folder, { recursive: true });
console.log(wrong ? `${wrong} differ` : 'all agree');
process.exitCode = wrong ? 1 : 0;
