// A dancer of 21 623 vertices: a character (VRM 1.0) and a movement (VRM Animation) that others made, put together by the library
// of that format, @pixiv/three-vrm-animation. Here the pose of each frame is only written down as keys of glTF.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { buildGlb, importFrom, plainFile, splitFile } from './three.mjs';

const BEVY_VRM1 = '0.2.0';
const FRAMES_PER_SECOND = 30;
// A number whose keys differ by less does not move: two digits above the rounding of f32 in a chain of some ten joints.
const STILL = 1e-5;

// crates.io: the assets of the crate bevy_vrm1. AliciaSolid belongs to Dwango and may be used as its own conditions say (the URL in
// the file's `meta`); the movement is the first of pixiv's seven free ones.
export async function dancer(cache, modules) {
  const folder = path.join(cache, `bevy_vrm1-${BEVY_VRM1}`);
  const file = path.join(folder, 'dancer.glb');
  if (existsSync(file)) return { name: 'dancer', file };
  mkdirSync(folder, { recursive: true });
  execFileSync('cargo', ['info', '--quiet', `bevy_vrm1@${BEVY_VRM1}`], { cwd: folder, env: { ...process.env, CARGO_HOME: folder }, stdio: ['ignore', 'ignore', 'inherit'] });
  const sources = path.join(folder, 'registry', 'src');
  const assets = path.join(sources, readdirSync(sources)[0], `bevy_vrm1-${BEVY_VRM1}`, 'assets');
  const character = path.join(assets, 'vrm', 'AliciaSolid.vrm');
  const keys = await framesOf(character, path.join(assets, 'vrma', 'VRMA_01.vrma'), modules);
  writeFileSync(file, withKeys(character, keys));
  return { name: 'dancer', file };
}

// The local rotation and translation of every node and the weights of every mesh at every frame, as the library poses them.
async function framesOf(character, movement, modules) {
  const THREE = await importFrom(modules, 'three/build/three.module.js');
  const { GLTFLoader } = await importFrom(modules, 'three/examples/jsm/loaders/GLTFLoader.js');
  const { VRMLoaderPlugin } = await importFrom(modules, '@pixiv/three-vrm/lib/three-vrm.module.js');
  const { VRMAnimationLoaderPlugin, createVRMAnimationClip } = await importFrom(modules, '@pixiv/three-vrm-animation/lib/three-vrm-animation.module.js');
  const load = (file, plugin) => {
    const loader = new GLTFLoader();
    loader.register((parser) => new plugin(parser));
    return new Promise((done, failed) => loader.parse(buildGlb(plainFile(file)), '', done, failed));
  };
  const gltf = await load(character, VRMLoaderPlugin);
  const { vrm, vrmAnimations } = { ...gltf.userData, ...(await load(movement, VRMAnimationLoaderPlugin)).userData };
  const clip = createVRMAnimationClip(vrmAnimations[0], vrm);
  const mixer = new THREE.AnimationMixer(vrm.scene);
  const action = mixer.clipAction(clip);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const nodes = new Map();
  gltf.scene.traverse((object) => {
    const own = gltf.parser.associations.get(object);
    if (own?.nodes !== undefined && !nodes.has(own.nodes)) nodes.set(own.nodes, { object, rotation: [], translation: [], weights: [] });
  });
  const times = Array.from({ length: Math.ceil(clip.duration * FRAMES_PER_SECOND) + 1 }, (_, frame) => Math.min(frame / FRAMES_PER_SECOND, clip.duration));
  for (const time of times) {
    mixer.setTime(time);
    vrm.humanoid.update();
    vrm.expressionManager?.update();
    for (const { object, rotation, translation, weights } of nodes.values()) {
      rotation.push(...object.quaternion.toArray());
      translation.push(...object.position.toArray());
      const influences = (object.isMesh ? object : object.children.find((child) => child.isMesh))?.morphTargetInfluences;
      weights.push(...(influences ?? []));
    }
  }
  return { times, nodes };
}

// The character's file with an animation of what moves.
function withKeys(character, { times, nodes }) {
  const { json, chunk } = splitFile(character);
  const parts = [chunk];
  let length = chunk.length;
  const add = (numbers, type, more = {}) => {
    const bytes = Buffer.from(new Float32Array(numbers).buffer);
    json.bufferViews.push({ buffer: 0, byteOffset: length, byteLength: bytes.length });
    const components = { SCALAR: 1, VEC3: 3, VEC4: 4 }[type];
    json.accessors.push({ bufferView: json.bufferViews.length - 1, componentType: 5126, type, count: numbers.length / components, ...more });
    parts.push(bytes);
    length += bytes.length;
    return json.accessors.length - 1;
  };
  const input = add(times, 'SCALAR', { min: [times[0]], max: [times.at(-1)] });
  const animation = { name: 'dance', samplers: [], channels: [] };
  for (const [node, keys] of [...nodes].sort(([a], [b]) => a - b)) {
    for (const [target, type] of [['rotation', 'VEC4'], ['translation', 'VEC3'], ['weights', 'SCALAR']]) {
      const numbers = keys[target];
      const width = numbers.length / times.length;
      if (!numbers.some((number, i) => Math.abs(number - numbers[i % width]) > STILL)) continue;
      animation.samplers.push({ input, output: add(numbers, type), interpolation: 'LINEAR' });
      animation.channels.push({ sampler: animation.samplers.length - 1, target: { node, path: target } });
    }
  }
  json.animations = [animation];
  json.buffers[0].byteLength = length;
  return Buffer.from(buildGlb({ json, bytes: Buffer.concat(parts) }));
}
