#!/usr/bin/env node
// Poses animated glTF files with Lobe and with three.js, and prints a table of the largest differences.
//
//   node peers/motion/motion.mjs target/release/examples/poses [FILE...]
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { dancer } from './character.mjs';
import { makeModel } from './made.mjs';
import { models } from './models.mjs';
import { cache, getPackages } from './packages.mjs';
import { openWithThree, poseAt, vertexOf } from './three.mjs';

// Positions are relative to the largest side of the box around the pose, normals are unit vectors.
const MOST = 1e-5;
// Times as parts of each animation: both ends, and some between keys.
const PARTS = [0, 0.13, 0.37, 0.5, 0.81, 1];

const poses = process.argv[2] && path.resolve(process.argv[2]);
if (!poses || !existsSync(poses)) {
  console.error('usage: motion.mjs PROGRAM [FILE...], such as target/release/examples/poses');
  process.exit(2);
}

// The largest differences of one animation of a file over all times and vertices. With `late`, three.js is late by that part of
// the animation.
function compare(file, three, animation, folder, late = 0) {
  const duration = three.gltf.animations[animation].duration;
  const times = PARTS.map((part) => part * duration);
  const out = path.join(folder, 'poses');
  execFileSync(poses, [file, String(three.animations[animation]), out, ...times.map(String)], { stdio: ['ignore', 'inherit', 'inherit'] });
  const meshes = JSON.parse(readFileSync(`${out}.json`));
  const bytes = readFileSync(out);
  const numbers = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  const most = { vertices: 0, place: 0, normal: undefined, shaded: undefined };
  let at = 0;
  for (const time of times) {
    poseAt(three, animation, time + late * duration);
    const box = new three.THREE.Box3();
    let far = 0;
    for (const { node, mesh, primitive, vertices } of meshes) {
      const theirs = three.meshes.get(`${node} ${mesh} ${primitive}`);
      if (theirs === undefined) throw new Error(`three.js shows no node ${node} with primitive ${primitive} of mesh ${mesh}`);
      // Where a file has no normals, Lobe adds vertices behind those of the file to make triangles flat.
      const count = theirs.geometry.attributes.position.count;
      for (let vertex = 0; vertex < count; vertex++) {
        const { place, normal, shaded } = vertexOf(three, theirs, vertex);
        const ours = (first) => new three.THREE.Vector3().fromArray(numbers, at + 3 * (first + vertex));
        box.expandByPoint(place);
        far = Math.max(far, place.distanceTo(ours(0)));
        if (normal !== undefined) {
          most.normal = Math.max(most.normal ?? 0, normal.distanceTo(ours(vertices)));
          most.shaded = Math.max(most.shaded ?? 0, shaded.distanceTo(ours(vertices)));
        }
      }
      most.vertices += time === times[0] ? count : 0;
      at += 6 * vertices;
    }
    const size = box.getSize(new three.THREE.Vector3());
    most.place = Math.max(most.place, far / Math.max(size.x, size.y, size.z));
  }
  return most;
}

const modules = getPackages();
const folder = mkdtempSync(path.join(tmpdir(), 'lobe-motion-'));
let failures = 0;
try {
  const given = process.argv.slice(3).map((file) => ({ name: path.basename(file), file }));
  const files = given.length > 0 ? given : [...models(cache), await dancer(cache, modules), { name: 'made', file: makeModel(folder) }];
  console.log('| file | animation | vertices | joints | positions | normals | normals of shaders | |');
  console.log('|---|---|---|---|---|---|---|---|');
  for (const { name, file } of files) {
    const three = await openWithThree(file, modules);
    const joints = (three.json.skins ?? []).map((skin) => skin.joints.length).join(' + ');
    three.animations.forEach((animation, index) => {
      const { vertices, place, normal, shaded } = compare(file, three, index, folder);
      const agrees = place < MOST && (normal ?? 0) < MOST;
      failures += agrees ? 0 : 1;
      const numbers = [place, normal, shaded].map((number) => number?.toExponential(1) ?? 'none');
      console.log('| ' + [name, String(animation).replaceAll('|', '/'), vertices, joints, ...numbers, agrees ? 'agrees' : 'FAILS'].join(' | ') + ' |');
    });
    // The control: what is late by a thousandth is noticed.
    const { place } = compare(file, three, 0, folder, 1e-3);
    failures += place > MOST ? 0 : 1;
    console.log(`| ${name} | the first, late by 0.001 of it | | | ${place.toExponential(1)} | | | ${place > MOST ? 'differs' : 'FAILS'} |`);
  }
} finally {
  rmSync(folder, { recursive: true });
}
process.exit(failures > 0 ? 1 : 0);
