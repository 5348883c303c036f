// The light of a sky for Filament, written by lobe {{version}}. The folder holds what it loads; README.md says what.
//
//   import { addSky } from './sky.mjs';
//   await addSky(Filament, engine, scene);

// What a white surface sends back, nine colors, as `irradianceSh(3, coefficients)` takes them; the .ktx holds the same.
export const coefficients = [
    {{coefficients}}
];

// Suns: the direction towards each, the irradiance of a surface that faces it, the diameter of its disc in degrees.
export const suns = {{suns}};

const here = name => new URL(name, import.meta.url).href;
const bytes = async name => new Uint8Array(await (await fetch(here(name))).arrayBuffer());

// Makes the indirect light of the scene, adds the brightest sun, as Filament has one directional light, and shows the
// sky behind the scene. Texels are candelas for each square meter: the exposure of the camera makes white of them.
export async function addSky(Filament, engine, scene, { background = true, intensity = 1 } = {}) {
  const chain = engine.createTextureFromKtx1(await bytes('light.ktx'));
  const light = Filament.IndirectLight.Builder()
    .reflections(chain)
    .irradianceSh(3, coefficients)
    .intensity(intensity)
    .build(engine);
  scene.setIndirectLight(light);
  const [sun] = [...suns].sort((a, b) => Math.max(...b.irradiance) - Math.max(...a.irradiance));
  if (sun) scene.addEntity(sunLight(Filament, engine, sun, intensity));
  if (background) {
    const sky = engine.createTextureFromKtx1(await bytes('sky.ktx'));
    scene.setSkybox(Filament.Skybox.Builder().environment(sky).build(engine));
  }
  return light;
}

function sunLight(Filament, engine, { direction, irradiance, diameter }, intensity) {
  const lux = Math.max(...irradiance);
  const sun = Filament.EntityManager.get().create();
  Filament.LightManager.Builder(Filament.LightManager$Type.SUN)
    .color(irradiance.map(c => c / lux))
    .intensity(intensity * lux)
    .direction(direction.map(c => -c))
    .sunAngularRadius(diameter / 2)
    .build(engine, sun);
  return sun;
}
