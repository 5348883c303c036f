// A ball in PlayCanvas, seen from each direction, lit by what the exported program does.

export async function show({ program, canvas, surfaces, directions, skyDirections }) {
  const pc = await import('/modules/playcanvas/build/playcanvas.mjs');
  const app = new pc.Application(canvas, { graphicsDeviceOptions: { deviceTypes: ['webgl2'], antialias: false } });
  app.start();
  app.autoRender = false;
  app.scene.ambientLight = new pc.Color(0, 0, 0);
  await program.addSky(pc, app);
  const device = app.graphicsDevice;
  const texture = new pc.Texture(device, {
    width: 9, height: 9, format: pc.PIXELFORMAT_RGBA32F, mipmaps: false,
    minFilter: pc.FILTER_NEAREST, magFilter: pc.FILTER_NEAREST,
  });
  const target = new pc.RenderTarget({ colorBuffer: texture, depth: true });
  const looks = async (settings, all, seen) => {
    const camera = new pc.Entity();
    camera.addComponent('camera', {
      nearClip: 0.1, farClip: 10, clearColor: new pc.Color(0, 0, 0, 1), renderTarget: target,
      toneMapping: pc.TONEMAP_NONE, gammaCorrection: pc.GAMMA_NONE, ...settings,
    });
    app.root.addChild(camera);
    const found = [];
    for (const d of all) {
      seen(camera, d, Math.abs(d[1]) > 0.9 ? new pc.Vec3(0, 0, 1) : pc.Vec3.UP);
      app.update(0.016);
      app.fire('prerender');
      app.render();
      found.push([...(await texture.read(0, 0, 9, 9, { renderTarget: target })).slice(160, 163)]);
    }
    camera.destroy();
    return found;
  };
  const ball = async prepare => {
    const sphere = new pc.SphereGeometry({ radius: 1, latitudeBands: 250, longitudeBands: 250 });
    const mesh = pc.Mesh.fromGeometry(device, sphere);
    const material = new pc.StandardMaterial();
    material.diffuse = new pc.Color(1, 1, 1);
    material.useMetalness = true;
    material.useTonemap = false;
    prepare(material);
    material.update();
    const entity = new pc.Entity();
    entity.addComponent('render', { meshInstances: [new pc.MeshInstance(mesh, material)] });
    app.root.addChild(entity);
    const flat = { projection: pc.PROJECTION_ORTHOGRAPHIC, orthoHeight: 0.01 };
    const found = await looks(flat, directions, (camera, d, up) => {
      camera.setPosition(3 * d[0], 3 * d[1], 3 * d[2]);
      camera.lookAt(pc.Vec3.ZERO, up);
    });
    entity.destroy();
    return found;
  };
  const matte = material => { Object.assign(material, { useMetalness: false, specular: new pc.Color(0, 0, 0) }); };
  const values = {};
  for (const { name, roughness } of surfaces) {
    if (roughness === null) values[name] = await ball(matte);
    else values[name] = await ball(material => { material.metalness = 1; material.gloss = 1 - roughness; });
  }
  values.numbers = await ball(material => {
    matte(material);
    material.ambientSH = new Float32Array(program.coefficients);
  });
  values.sky = await looks({ fov: 1, farClip: 1000 }, skyDirections, (camera, d, up) => {
    camera.setPosition(0, 0, 0);
    camera.lookAt(new pc.Vec3(...d), up);
  });
  return { version: pc.version, values };
}
