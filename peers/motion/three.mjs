// Poses of a glTF file by three.js: its own GLTFLoader and AnimationMixer.
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

// What the loader expects of a browser, although it is given bytes and no pictures.
globalThis.self ??= globalThis;
globalThis.ProgressEvent ??= class extends Event {};

// A module of a package that the script got.
export function importFrom(modules, name) {
  return import(pathToFileURL(path.join(modules, name)));
}

// The JSON of a file and, of a .glb, its chunk of bytes, padded to four.
export function splitFile(file) {
  const bytes = readFileSync(file);
  if (bytes.toString('latin1', 0, 4) !== 'glTF') return { json: JSON.parse(bytes.toString('utf8')) };
  const length = bytes.readUInt32LE(12);
  return { json: JSON.parse(bytes.toString('utf8', 20, 20 + length)), chunk: bytes.subarray(28 + length) };
}

// The JSON and the one buffer of a file, without materials and pictures, which node cannot decode.
export function plainFile(file) {
  const { json, chunk } = splitFile(file);
  const buffers = (json.buffers ?? []).map((buffer) => {
    if (buffer.uri === undefined) return chunk.subarray(0, buffer.byteLength);
    if (buffer.uri.startsWith('data:')) return Buffer.from(buffer.uri.slice(buffer.uri.indexOf(',') + 1), 'base64');
    return readFileSync(path.join(path.dirname(file), decodeURIComponent(buffer.uri)));
  });
  const starts = [];
  let all = Buffer.alloc(0);
  for (const buffer of buffers) {
    starts.push(all.length);
    all = Buffer.concat([all, buffer, Buffer.alloc((4 - (buffer.length % 4)) % 4)]);
  }
  for (const view of json.bufferViews ?? []) {
    view.byteOffset = (view.byteOffset ?? 0) + starts[view.buffer];
    view.buffer = 0;
  }
  json.buffers = [{ byteLength: all.length }];
  for (const mesh of json.meshes ?? []) for (const primitive of mesh.primitives) delete primitive.material;
  for (const member of ['materials', 'textures', 'images', 'samplers', 'extensionsRequired']) delete json[member];
  return { json, bytes: all };
}

export function buildGlb({ json, bytes }) {
  let text = Buffer.from(JSON.stringify(json));
  text = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, ' ')]);
  const header = Buffer.alloc(20);
  header.write('glTF', 0, 'latin1');
  header.writeUInt32LE(2, 4);
  header.writeUInt32LE(28 + text.length + bytes.length, 8);
  header.writeUInt32LE(text.length, 12);
  header.write('JSON', 16, 'latin1');
  const second = Buffer.alloc(8);
  second.writeUInt32LE(bytes.length, 0);
  second.write('BIN\0', 4, 'latin1');
  const whole = Buffer.concat([header, text, second, bytes]);
  return whole.buffer.slice(whole.byteOffset, whole.byteOffset + whole.length);
}

// The file as three.js has it, with what is needed to ask for poses.
export async function openWithThree(file, modules) {
  const THREE = await importFrom(modules, 'three/build/three.module.js');
  const { GLTFLoader } = await importFrom(modules, 'three/examples/jsm/loaders/GLTFLoader.js');
  const plain = plainFile(file);
  const gltf = await new Promise((done, failed) => new GLTFLoader().parse(buildGlb(plain), '', done, failed));
  // three.js scales by a quaternion whose length is not one, such as one of three digits; Lobe makes it a rotation.
  for (const track of gltf.animations.flatMap((clip) => clip.tracks)) {
    if (!(track instanceof THREE.QuaternionKeyframeTrack)) continue;
    const { values } = track;
    // A key of a spline has tangents before and behind its value.
    const [first, step] = track.createInterpolant.isInterpolantFactoryMethodGLTFCubicSpline ? [4, 12] : [0, 4];
    for (let k = first; k < values.length; k += step) new THREE.Quaternion().fromArray(values, k).normalize().toArray(values, k);
  }
  const animations = (plain.json.animations ?? []).map((animation, index) => animation.name ?? String(index));
  // A mesh of several primitives is a group of meshes, and the group is the node.
  const meshes = new Map();
  gltf.scene.traverse((object) => {
    const own = gltf.parser.associations.get(object);
    if (!object.isMesh || own === undefined) return;
    const node = own.nodes ?? gltf.parser.associations.get(object.parent)?.nodes;
    meshes.set(`${node} ${own.meshes} ${own.primitives ?? 0}`, object);
  });
  return { THREE, gltf, animations, meshes, json: plain.json };
}

// Moves everything to a time of an animation.
export function poseAt({ THREE, gltf }, animation, time) {
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const action = mixer.clipAction(gltf.animations[animation]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  mixer.setTime(time);
  gltf.scene.updateMatrixWorld(true);
}

// Position and normal of a vertex. Positions are three.js's own. Its normals are made in shaders, by the blended matrix itself;
// here they are made by the inverse transpose of three.js's matrices, and `shaded` is the other way.
export function vertexOf({ THREE }, mesh, vertex) {
  const { position, normal, weights_1: second } = mesh.geometry.attributes;
  const matrix = mesh.isSkinnedMesh ? blended(THREE, mesh, vertex) : mesh.matrixWorld;
  const place = new THREE.Vector3();
  if (second === undefined) {
    mesh.getVertexPosition(vertex, place);
    place.applyMatrix4(mesh.matrixWorld);
  } else {
    // three.js takes four weights of a vertex and no more.
    place.fromBufferAttribute(position, vertex).applyMatrix4(matrix);
  }
  if (normal === undefined) return { place };
  const turned = new THREE.Vector3().fromBufferAttribute(normal, vertex);
  const morphs = mesh.geometry.morphAttributes.normal ?? [];
  // Where a target has no normals, the loader gives the mesh's own, which would be added to themselves.
  const adds = (morph) => morph !== normal;
  morphs.forEach((morph, k) => adds(morph) && turned.addScaledVector(new THREE.Vector3().fromBufferAttribute(morph, vertex), mesh.morphTargetInfluences[k]));
  const shaded = turned.clone().transformDirection(matrix);
  turned.applyMatrix3(new THREE.Matrix3().getNormalMatrix(matrix)).normalize();
  return { place, normal: turned, shaded };
}

// The joints of a vertex with weights. The loader divides those of the first set by their sum, which is undone where there is a
// second set: all together are one.
function weightsOf(mesh, vertex) {
  const { skinIndex, skinWeight, joints_1: joints, weights_1: weights } = mesh.geometry.attributes;
  const set = (joints, weights) => [0, 1, 2, 3].map((k) => [joints.getComponent(vertex, k), weights.getComponent(vertex, k)]);
  const first = set(skinIndex, skinWeight);
  if (weights === undefined) return first;
  const second = set(joints, weights);
  const rest = 1 - second.reduce((sum, [, weight]) => sum + weight, 0);
  return [...first.map(([joint, weight]) => [joint, weight * rest]), ...second];
}

function blended(THREE, mesh, vertex) {
  const sum = new THREE.Matrix4().set(...Array(16).fill(0));
  for (const [joint, weight] of weightsOf(mesh, vertex)) {
    if (weight === 0) continue;
    const matrix = mesh.skeleton.bones[joint].matrixWorld.clone().multiply(mesh.skeleton.boneInverses[joint]);
    sum.elements.forEach((_, i) => (sum.elements[i] += weight * matrix.elements[i]));
  }
  return sum;
}
