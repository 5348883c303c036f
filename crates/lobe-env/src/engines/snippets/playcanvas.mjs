// The light of a sky for PlayCanvas, written by lobe {{version}}. The folder holds what it loads; README.md says what.
//
//   import { addSky } from './sky.mjs';
//   await addSky(pc, app);

// What a white surface sends back, nine colors in the order of `material.ambientSH`. They are exact where the atlas
// that the engine makes has eight bits: material.ambientSH = new Float32Array(coefficients).
export const coefficients = [
    {{coefficients}}
];

// Suns: the direction towards each, the irradiance of a surface that faces it, the diameter of its disc in degrees.
export const suns = {{suns}};

const here = name => new URL(name, import.meta.url).href;

// Makes the atlas of the scene from the cube, adds a light for each sun, and shows the sky behind the scene.
export async function addSky(pc, app, { background = true } = {}) {
  const light = await load(pc, app, 'light.dds');
  const source = pc.EnvLighting.generateLightingSource(light);
  app.scene.envAtlas = pc.EnvLighting.generateAtlas(source);
  for (const sun of suns) addSun(pc, app, sun);
  if (background) app.scene.skybox = await load(pc, app, 'sky.dds');
}

function load(pc, app, name) {
  const asset = new pc.Asset(name, 'texture', { url: here(name) }, { mipmaps: false });
  return new Promise((done, failed) => {
    asset.once('load', () => done(asset.resource));
    asset.once('error', failed);
    app.assets.add(asset);
    app.assets.load(asset);
  });
}

function addSun(pc, app, { direction, irradiance }) {
  // A light of intensity 1 makes a white surface that faces it 1. Its color is that of a display; below 1, so would be
  // the intensity.
  const overPi = irradiance.map(c => c / Math.PI);
  const intensity = Math.max(1, ...overPi);
  const color = new pc.Color(...overPi.map(c => (c / intensity) ** (1 / 2.2)));
  const sun = new pc.Entity('sun');
  sun.addComponent('light', { type: 'directional', intensity, color });
  // It shines along its negative y axis.
  sun.setRotation(new pc.Quat().setFromDirections(pc.Vec3.UP, new pc.Vec3(...direction)));
  app.root.addChild(sun);
}
