// The light of a sky for Babylon.js, written by lobe {{version}}. The folder holds what it loads; README.md says what.
// For left-handed scenes, the default of Babylon.js, into which its loader turns glTF.
//
//   import { addSky } from './sky.mjs';
//   await addSky(BABYLON, scene);

// What a white surface sends back, nine colors, as SphericalHarmonics has them; the .env holds the same.
export const coefficients = [
    {{coefficients}}
];

// Suns: the direction towards each, the irradiance of a surface that faces it, the diameter of its disc in degrees.
export const suns = {{suns}};

// Makes `scene.environmentTexture` the prefiltered environment, adds a light for each sun, and shows the sky behind the
// scene in a box of this many units.
export async function addSky(BABYLON, scene, { background = true, size = 1000 } = {}) {
  const environment = new BABYLON.CubeTexture(new URL('./light.env', import.meta.url).href, scene);
  scene.environmentTexture = environment;
  for (const sun of suns) addSun(BABYLON, scene, sun);
  if (background) {
    // Faces of this many texels, as linear light, neither filtered nor with harmonics of their own.
    const sky = new BABYLON.HDRCubeTexture(new URL('./sky.hdr', import.meta.url).href, scene, 512, false, false, false, false);
    // The last word leaves the environment as it is.
    scene.createDefaultSkybox(sky, true, size, 0, false);
  }
  await new Promise((done, failed) => BABYLON.Texture.WhenAllReady([environment], done, failed));
}

function addSun(BABYLON, scene, { direction, irradiance }) {
  const light = new BABYLON.DirectionalLight('sun', new BABYLON.Vector3(...direction).negate(), scene);
  light.intensity = Math.max(...irradiance);
  light.diffuse = new BABYLON.Color3(...irradiance.map(c => c / light.intensity));
  light.specular = light.diffuse;
}
