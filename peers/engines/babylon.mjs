// A ball in Babylon.js, seen from each direction, lit by what the exported program does.

const script = url => new Promise((done, failed) =>
  document.head.append(Object.assign(document.createElement('script'), { src: url, onload: done, onerror: failed })));

// Where its loader of glTF puts things into a left-handed scene.
const place = ([x, y, z]) => [-x, y, z];

export async function show({ program, canvas, surfaces, directions, skyDirections }) {
  await script('/modules/babylonjs/babylon.js');
  const B = BABYLON;
  const engine = new B.Engine(canvas, false);
  const vector = v => new B.Vector3(...v);
  const values = {};
  // Renders what a camera sees of a scene for each direction, in linear light.
  const looks = async (scene, setUp, all, seen) => {
    const camera = new B.FreeCamera('camera', B.Vector3.Zero(), scene);
    setUp(camera);
    const floats = { type: B.Constants.TEXTURETYPE_FLOAT, generateMipMaps: false };
    const target = new B.RenderTargetTexture('target', 9, scene, floats);
    target.renderList = null;
    target.activeCamera = camera;
    scene.customRenderTargets.push(target);
    await scene.whenReadyAsync();
    const found = [];
    for (const d of all) {
      camera.upVector = Math.abs(d[1]) > 0.9 ? vector([0, 0, 1]) : B.Vector3.Up();
      seen(camera, vector(place(d)));
      for (let k = 0; k < 3; k++) scene.render();
      found.push([...(await target.readPixels()).slice(160, 163)]);
    }
    scene.customRenderTargets.length = 0;
    camera.dispose();
    return found;
  };
  const newScene = async () => {
    const scene = new B.Scene(engine);
    scene.clearColor = new B.Color4(0, 0, 0, 1);
    // Colors stay linear in what is read back.
    scene.imageProcessingConfiguration.applyByPostProcess = true;
    await program.addSky(B, scene);
    return scene;
  };
  const aside = (camera, d) => { camera.position = d.scale(3); camera.setTarget(B.Vector3.Zero()); };
  for (const { name, roughness } of surfaces) {
    const scene = await newScene();
    const material = new B.PBRMaterial('material', scene);
    material.metallic = roughness === null ? 0 : 1;
    material.roughness = roughness ?? 1;
    material.metallicF0Factor = material.metallic;
    material.albedoColor = B.Color3.White();
    B.MeshBuilder.CreateSphere('ball', { diameter: 2, segments: 128 }, scene).material = material;
    values[name] = await looks(scene, camera => {
      camera.mode = B.Camera.ORTHOGRAPHIC_CAMERA;
      [camera.orthoLeft, camera.orthoRight, camera.orthoBottom, camera.orthoTop] = [-0.01, 0.01, -0.01, 0.01];
      [camera.minZ, camera.maxZ] = [0.1, 10];
    }, directions, aside);
    scene.dispose();
  }
  const scene = await newScene();
  const narrow = camera => { camera.fov = 0.02; camera.maxZ = 5000; };
  values.sky = await looks(scene, narrow, skyDirections, (camera, d) => camera.setTarget(d));
  scene.dispose();
  return { version: B.Engine.Version, values };
}
