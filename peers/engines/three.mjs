// A ball in three.js, seen from each direction, lit by what the exported program does.
import * as THREE from 'three';

// The material of a surface: matte without a mirror of its skin, or metal.
const material = ({ roughness }) => roughness === null
  ? new THREE.MeshPhysicalMaterial({ roughness: 1, metalness: 0, specularIntensity: 0 })
  : new THREE.MeshStandardMaterial({ roughness, metalness: 1 });

export async function show({ program, canvas, surfaces, directions, skyDirections }) {
  const renderer = new THREE.WebGLRenderer({ canvas });
  renderer.toneMapping = THREE.NoToneMapping;
  const target = new THREE.WebGLRenderTarget(9, 9, { type: THREE.FloatType });
  const ball = new THREE.SphereGeometry(1, 256, 128);
  const look = (scene, d) => {
    const camera = new THREE.OrthographicCamera(-0.01, 0.01, 0.01, -0.01, 0.1, 10);
    camera.up.set(0, Math.abs(d[1]) > 0.9 ? 0 : 1, Math.abs(d[1]) > 0.9 ? 1 : 0);
    camera.position.set(...d).multiplyScalar(3);
    camera.lookAt(0, 0, 0);
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    const pixels = new Float32Array(4 * 81);
    renderer.readRenderTargetPixels(target, 0, 0, 9, 9, pixels);
    return [...pixels.slice(160, 163)];
  };
  const scene = new THREE.Scene();
  await program.addSky(scene);
  const mesh = new THREE.Mesh(ball);
  scene.add(mesh);
  const values = {};
  for (const surface of surfaces) {
    mesh.material = material(surface);
    values[surface.name] = directions.map(d => look(scene, d));
  }
  // The sky alone, looked at from its middle, and the probe on a surface without an environment.
  scene.remove(mesh);
  values.sky = skyDirections.map(d => {
    const camera = new THREE.PerspectiveCamera(1, 1, 0.1, 10);
    camera.up.set(0, Math.abs(d[1]) > 0.9 ? 0 : 1, Math.abs(d[1]) > 0.9 ? 1 : 0);
    camera.lookAt(...d);
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    const pixels = new Float32Array(4 * 81);
    renderer.readRenderTargetPixels(target, 0, 0, 9, 9, pixels);
    return [...pixels.slice(160, 163)];
  });
  if (program.suns.length) return { version: THREE.REVISION, values };
  const plain = new THREE.Scene();
  plain.add(program.lightProbe(), new THREE.Mesh(ball, new THREE.MeshLambertMaterial()));
  values.numbers = directions.map(d => look(plain, d));
  return { version: THREE.REVISION, values };
}
