// A glTF file with what the models from registries do not have: step and cubic-spline samplers, morph targets, a mirror.
import { writeFileSync } from 'node:fs';
import path from 'node:path';

// Cells along a side: 10 201 vertices.
const CELLS = 100;

// Accessors and one buffer, as they are added.
class Numbers {
  json = { accessors: [], bufferViews: [] };
  parts = [];
  length = 0;

  add(type, values, Kind = Float32Array) {
    const size = { SCALAR: 1, VEC3: 3, VEC4: 4, MAT4: 16 }[type];
    const bytes = Buffer.from(new Kind(values).buffer);
    const componentType = { Float32Array: 5126, Uint32Array: 5125, Uint16Array: 5123 }[Kind.name];
    this.json.bufferViews.push({ buffer: 0, byteOffset: this.length, byteLength: bytes.length });
    this.json.accessors.push({ bufferView: this.json.bufferViews.length - 1, componentType, count: values.length / size, type });
    if (type === 'VEC3') {
      const axis = (k) => values.filter((_, i) => i % 3 === k);
      const extreme = (pick) => [0, 1, 2].map((k) => Math.fround(axis(k).reduce((a, b) => pick(a, b))));
      Object.assign(this.json.accessors.at(-1), { min: extreme(Math.min), max: extreme(Math.max) });
    }
    this.parts.push(bytes);
    this.length += bytes.length;
    return this.json.accessors.length - 1;
  }
}

function turn([x, y, z], angle) {
  const length = Math.hypot(x, y, z);
  return [x, y, z].map((c) => (c / length) * Math.sin(angle / 2)).concat(Math.cos(angle / 2));
}

// A sheet from (0, 0) to (1, 1), with normals, morph targets and the weights of three joints along x.
function sheet(numbers) {
  const [positions, normals, lift, lean, joints, weights, indices] = [[], [], [], [], [], [], []];
  for (let j = 0; j <= CELLS; j++) {
    for (let i = 0; i <= CELLS; i++) {
      const [x, y] = [i / CELLS, j / CELLS];
      positions.push(x, y, 0);
      normals.push(0, 0, 1);
      lift.push(0, 0, 0.2 * Math.sin(5 * x) * Math.cos(4 * y));
      lean.push(0.3 * x, -0.2 * y, 0.1);
      const first = Math.max(0, 1 - 2 * x);
      const last = Math.max(0, 2 * x - 1);
      joints.push(0, 1, 2, 0);
      weights.push(first, 1 - first - last, last, 0);
      const at = j * (CELLS + 1) + i;
      if (i < CELLS && j < CELLS) indices.push(at, at + 1, at + CELLS + 2, at, at + CELLS + 2, at + CELLS + 1);
    }
  }
  return {
    indices: numbers.add('SCALAR', indices, Uint32Array),
    attributes: {
      POSITION: numbers.add('VEC3', positions),
      NORMAL: numbers.add('VEC3', normals),
      JOINTS_0: numbers.add('VEC4', joints, Uint16Array),
      WEIGHTS_0: numbers.add('VEC4', weights),
    },
    targets: [{ POSITION: numbers.add('VEC3', lift) }, { POSITION: numbers.add('VEC3', lean), NORMAL: numbers.add('VEC3', lean) }],
  };
}

// Writes the file into a folder; returns its path.
export function makeModel(folder) {
  const numbers = new Numbers();
  const skinned = sheet(numbers);
  const { JOINTS_0, WEIGHTS_0, ...attributes } = skinned.attributes;
  const bind = (x) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, 0, 0, 1];
  const binds = numbers.add('MAT4', [bind(0), bind(0.5), bind(1)].flat());
  const samplers = [];
  const channels = [];
  const animate = (node, path, interpolation, times, type, values) => {
    samplers.push({ input: numbers.add('SCALAR', times), output: numbers.add(type, values.flat()), interpolation });
    channels.push({ sampler: samplers.length - 1, target: { node, path } });
  };
  const flat = [0, 0, 0, 0];
  animate(1, 'rotation', 'CUBICSPLINE', [0, 0.8, 2], 'VEC4', [
    flat, turn([1, 2, 3], 0.3), [0.4, -0.3, 0.2, 0], [0.1, 0.5, 0, -0.2], turn([0, 1, 0.2], 1.4), [0.2, 0.2, 0.3, 0.1], flat, turn([0, 0, 1], -0.9), flat,
  ]);
  animate(2, 'rotation', 'LINEAR', [0.25, 1.5], 'VEC4', [turn([0, 1, 0], -0.5), turn([1, 1, 0], 2.5).map((c) => -c)]);
  animate(2, 'scale', 'STEP', [0, 1, 1.7], 'VEC3', [[1, 1, 1], [1.5, 0.7, 1], [1, 2, 0.5]]);
  animate(3, 'translation', 'CUBICSPLINE', [0.5, 1.5], 'VEC3', [[0, 0, 0], [0.5, 0, 0], [1, 2, 0], [0, -1, 1], [0.4, 0.3, 0.2], [0, 0, 0]]);
  animate(0, 'weights', 'CUBICSPLINE', [0, 1, 2], 'SCALAR', [0, 0, 0.2, 0, 1, 2, 0.5, -1, 1, 0.4, 0, 0, 0, 0, 0.3, 1, 0, 0]);
  animate(4, 'weights', 'STEP', [0, 1], 'SCALAR', [0.5, 0, 1, 1]);
  animate(4, 'scale', 'LINEAR', [0, 2], 'VEC3', [[-1, 1, 1], [-2, 0.5, 1]]);
  const json = {
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0, 1, 4] }],
    nodes: [
      { mesh: 0, skin: 0, translation: [0.3, 0.2, 0.1] },
      { children: [2], scale: [1, 1.2, 0.9] },
      { children: [3], translation: [0.5, 0, 0] },
      { translation: [0.5, 0, 0] },
      { mesh: 1, translation: [2, 0, 0], rotation: turn([1, 0, 1], 0.7) },
    ],
    meshes: [{ primitives: [skinned] }, { primitives: [{ ...skinned, attributes }], weights: [0.1, 0.2] }],
    skins: [{ joints: [1, 2, 3], inverseBindMatrices: binds }],
    animations: [{ name: 'everything', channels, samplers }],
    ...numbers.json,
    buffers: [{ byteLength: numbers.length, uri: 'made.bin' }],
  };
  writeFileSync(path.join(folder, 'made.bin'), Buffer.concat(numbers.parts));
  const file = path.join(folder, 'made.gltf');
  writeFileSync(file, JSON.stringify(json));
  return file;
}
