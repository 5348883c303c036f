// A ball in Filament, seen from each direction, lit by what the exported program does.

const script = url => new Promise((done, failed) =>
  document.head.append(Object.assign(document.createElement('script'), { src: url, onload: done, onerror: failed })));

// Its canvas has eight bits: light of the test is up to twice as bright as white.
const INTENSITY = 0.4;

export async function show({ program, canvas, surfaces, directions, skyDirections }) {
  await script('/modules/gl-matrix/gl-matrix-min.js');
  Object.assign(window, window.glMatrix);
  await script('/modules/filament/filament.js');
  const shine = roughness => (roughness === 0 ? 'mirror' : `rough-${roughness}`);
  const file = ({ roughness }) => `/files/${roughness === null ? 'matte' : shine(roughness)}.glb`;
  await new Promise(done => Filament.init(surfaces.map(file), done));
  canvas.width = canvas.height = 64;
  const engine = Filament.Engine.create(canvas);
  const [swapChain, renderer, view] = [engine.createSwapChain(), engine.createRenderer(), engine.createView()];
  const camera = engine.createCamera(Filament.EntityManager.get().create());
  view.setCamera(camera);
  view.setViewport([0, 0, 64, 64]);
  view.setPostProcessingEnabled(false);
  camera.setExposureDirect(1);
  const gl = engine.ctx ?? canvas.getContext('webgl2');
  // Frames come late: the third that is not black is of this direction.
  const look = async (eye, center, d) => {
    camera.lookAt(eye, center, Math.abs(d[1]) > 0.9 ? [0, 0, 1] : [0, 1, 0]);
    const pixel = new Uint8Array(4);
    for (let k = 0, seen = 0; k < 60 && seen < 3; k++) {
      await new Promise(done => setTimeout(done, 20));
      renderer.render(swapChain, view);
      engine.execute();
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      gl.readPixels(32, 32, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      if (pixel[0] + pixel[1] + pixel[2] > 0) seen++;
    }
    return [...pixel.slice(0, 3)].map(byte => byte / 255 / INTENSITY);
  };
  const scene = engine.createScene();
  view.setScene(scene);
  await program.addSky(Filament, engine, scene, { background: false, intensity: INTENSITY });
  const loader = engine.createAssetLoader();
  camera.setProjection(Filament.Camera$Projection.ORTHO, -0.01, 0.01, -0.01, 0.01, 0.1, 10);
  const values = {};
  for (const surface of surfaces) {
    const asset = loader.createAsset(file(surface));
    await new Promise(done => asset.loadResources(done, null, null, 5));
    scene.addEntities(asset.getEntities());
    values[surface.name] = [];
    for (const d of directions) values[surface.name].push(await look(d.map(c => 3 * c), [0, 0, 0], d));
    scene.removeEntities(asset.getEntities());
  }
  const sky = engine.createScene();
  view.setScene(sky);
  await program.addSky(Filament, engine, sky, { intensity: INTENSITY });
  camera.setProjectionFov(1, 1, 0.1, 100, Filament.Camera$Fov.VERTICAL);
  values.sky = [];
  for (const d of skyDirections) values.sky.push(await look([0, 0, 0], d, d));
  return { version: '1.53.4', values };
}
