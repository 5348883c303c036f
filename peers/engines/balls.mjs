// Balls in glTF files, for engines that take materials from files only.
import { writeFileSync } from 'node:fs';
import path from 'node:path';

const ROWS = 96;
const BOX = { min: [-1, -1, -1], max: [1, 1, 1] };

// Writes matte.glb, mirror.glb and rough-R.glb into a folder.
export function writeBalls(folder, roughness) {
  writeFileSync(path.join(folder, 'matte.glb'), ball(0, 1));
  writeFileSync(path.join(folder, 'mirror.glb'), ball(1, 0));
  for (const r of roughness) writeFileSync(path.join(folder, `rough-${r}.glb`), ball(1, r));
}

// A white ball of radius 1 whose normals are its positions. A matte one has no mirror on its skin.
function ball(metallicFactor, roughnessFactor) {
  const columns = 2 * ROWS, positions = [], indices = [];
  for (let i = 0; i <= ROWS; i++) {
    for (let j = 0; j <= columns; j++) {
      const [theta, phi] = [Math.PI * i / ROWS, 2 * Math.PI * j / columns];
      positions.push(Math.sin(theta) * Math.cos(phi), Math.cos(theta), Math.sin(theta) * Math.sin(phi));
    }
  }
  for (let i = 0; i < ROWS; i++) {
    for (let j = 0; j < columns; j++) {
      const a = i * (columns + 1) + j, c = a + columns + 1;
      indices.push(a, a + 1, c, a + 1, c + 1, c);
    }
  }
  const parts = [Buffer.from(new Uint32Array(indices).buffer), Buffer.from(new Float32Array(positions).buffer)];
  const material = { pbrMetallicRoughness: { baseColorFactor: [1, 1, 1, 1], metallicFactor, roughnessFactor } };
  if (!metallicFactor) material.extensions = { KHR_materials_specular: { specularFactor: 0 } };
  const gltf = {
    asset: { version: '2.0' },
    extensionsUsed: metallicFactor ? undefined : ['KHR_materials_specular'],
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 1, NORMAL: 1 }, indices: 0, material: 0 }] }],
    materials: [material],
    accessors: [
      { bufferView: 0, componentType: 5125, count: indices.length, type: 'SCALAR' },
      { bufferView: 1, componentType: 5126, count: positions.length / 3, type: 'VEC3', ...BOX },
    ],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: parts[0].length, target: 34963 },
      { buffer: 0, byteOffset: parts[0].length, byteLength: parts[1].length, target: 34962 },
    ],
    buffers: [{ byteLength: parts[0].length + parts[1].length }],
  };
  return glb(JSON.stringify(gltf), Buffer.concat(parts));
}

function glb(text, data) {
  const json = Buffer.from(text.padEnd(Math.ceil(text.length / 4) * 4));
  const chunk = (kind, bytes) => Buffer.concat([Buffer.from(new Uint32Array([bytes.length, kind]).buffer), bytes]);
  const chunks = Buffer.concat([chunk(0x4e4f534a, json), chunk(0x004e4942, data)]);
  return Buffer.concat([Buffer.from(new Uint32Array([0x46546c67, 2, 12 + chunks.length]).buffer), chunks]);
}
