// The light of a sky for three.js, written by lobe {{version}}. The folder holds what it loads; README.md says what.
//
//   import { addSky } from './sky.mjs';
//   await addSky(scene);
import * as THREE from 'three';
import { read } from 'three/addons/libs/ktx-parse.module.js';
import { HDRLoader } from 'three/addons/loaders/HDRLoader.js';

// Radiance, nine colors, as a LightProbe has them.
export const coefficients = [
    {{coefficients}}
];

// Suns: the direction towards each, the irradiance of a surface that faces it, the diameter of its disc in degrees.
export const suns = {{suns}};

// Makes `scene.environment` the prefiltered chain, adds a light for each sun, and shows the sky behind the scene.
export async function addSky(scene, { background = true } = {}) {
  if (Number(THREE.REVISION) < 187) throw new Error('sky.mjs needs three.js 0.187 or later, which reads prefiltered cubes');
  scene.environment = await loadChain(new URL('./specular.ktx2', import.meta.url).href);
  for (const sun of suns) scene.add(sunLight(sun));
  if (background) {
    scene.background = await new HDRLoader().loadAsync(new URL('./sky.hdr', import.meta.url).href);
    scene.background.mapping = THREE.EquirectangularReflectionMapping;
  }
}

// The same light without its suns, for materials that no environment lights. Not to be used beside addSky.
export function lightProbe() {
  return new THREE.LightProbe(new THREE.SphericalHarmonics3().fromArray(coefficients));
}

function sunLight({ direction, irradiance }) {
  const intensity = Math.max(...irradiance);
  const light = new THREE.DirectionalLight(new THREE.Color(...irradiance.map(c => c / intensity)), intensity);
  light.position.set(...direction);
  return light;
}

// The chain in the place of the one that three.js filters from a panorama when it starts.
async function loadChain(url) {
  const file = read(new Uint8Array(await (await fetch(url)).arrayBuffer()));
  const size = file.pixelWidth;
  const halves = 4;
  const faces = Array.from({ length: 6 }, (_, face) => ({
    width: size,
    height: size,
    mipmaps: file.levels.map(({ levelData }, level) => {
      const width = size >> level;
      const length = halves * width * width;
      const bytes = levelData.slice(2 * length * face, 2 * length * (face + 1));
      return { data: new Uint16Array(bytes.buffer), width, height: width };
    }),
  }));
  const chain = new THREE.CompressedCubeTexture(faces, THREE.RGBAFormat, THREE.HalfFloatType);
  chain.mapping = THREE.CubeReflectionMapping;
  chain.minFilter = THREE.LinearMipmapLinearFilter;
  chain.magFilter = THREE.LinearFilter;
  chain.generateMipmaps = false;
  chain.isPMREMTexture = true;
  chain.needsUpdate = true;
  return chain;
}
