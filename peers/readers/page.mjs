// Loads a cube map or a model in an engine, by the engine's own loader, and leaves what it found in window.found.
import { FACES, PROBES } from '/cube.mjs';

const query = new URLSearchParams(location.search);
const file = query.get('file');
const canvas = document.getElementById('canvas');

// What the loaders say instead of throwing.
const said = [];
for (const kind of ['warn', 'error']) console[kind] = (...words) => said.push(words.join(' '));

const script = url => new Promise((done, failed) => {
  document.head.append(Object.assign(document.createElement('script'), { src: url, onload: done, onerror: failed }));
});

// The colors of a texture's level 0 in the directions of the probes: by our shader, whatever the engine has made of it.
function probe(gl, texture) {
  const program = gl.createProgram();
  for (const [type, text] of [
    [gl.VERTEX_SHADER, 'void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4. - 1., 0, 1); }'],
    [gl.FRAGMENT_SHADER, 'uniform samplerCube map; uniform vec3 d; out vec4 color; void main() { color = textureLod(map, d, 0.); }'],
  ]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, `#version 300 es\nprecision highp float; precision highp samplerCube;\n${text}`);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.bindVertexArray(null);
  for (const state of [gl.BLEND, gl.CULL_FACE, gl.DEPTH_TEST, gl.SCISSOR_TEST]) gl.disable(state);
  gl.colorMask(true, true, true, true);
  gl.getExtension('EXT_color_buffer_float');
  gl.activeTexture(gl.TEXTURE1);
  const target = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, target);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, 1, 1);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.viewport(0, 0, 1, 1);
  while (gl.getError());
  gl.activeTexture(gl.TEXTURE0);
  gl.bindSampler(0, null);
  gl.bindTexture(gl.TEXTURE_CUBE_MAP, texture);
  if (gl.getError()) throw new Error('it is no cube map');
  gl.uniform1i(gl.getUniformLocation(program, 'map'), 0);
  return PROBES.map(({ direction }) => {
    gl.uniform3fv(gl.getUniformLocation(program, 'd'), direction);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const color = new Float32Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, color);
    return [...color.slice(0, 3)];
  });
}

async function three() {
  const THREE = await import('three');
  const renderer = new THREE.WebGLRenderer({ canvas });
  const ending = file.split('.').pop();
  let map;
  if (ending === 'hdr') {
    const { HDRCubeTextureLoader } = await import('three/addons/loaders/HDRCubeTextureLoader.js');
    map = await new Promise((done, failed) => {
      new HDRCubeTextureLoader().load(FACES.map(face => file.replace('%', face)), done, undefined, failed);
    });
  } else if (ending === 'ktx2') {
    const { KTX2Loader } = await import('three/addons/loaders/KTX2Loader.js');
    map = await new KTX2Loader().detectSupport(renderer).loadAsync(file);
  } else {
    const { DDSLoader } = await import('three/addons/loaders/DDSLoader.js');
    map = await new DDSLoader().loadAsync(file);
    map.mapping = THREE.CubeReflectionMapping;
  }
  // Draw something with it, so that it is uploaded as a user's material would have it.
  const material = new THREE.ShaderMaterial({
    uniforms: { map: { value: map } },
    vertexShader: 'void main() { gl_Position = vec4(position, 1.); }',
    fragmentShader: 'uniform samplerCube map; void main() { gl_FragColor = textureCube(map, vec3(1.)); }',
  });
  renderer.render(new THREE.Scene().add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material)), new THREE.Camera());
  if (map.isDataTexture) throw new Error('it becomes a texture of one face');
  return probe(renderer.getContext(), renderer.properties.get(map).__webglTexture);
}

async function babylon() {
  await script('/modules/babylonjs/babylon.js');
  const engine = new BABYLON.Engine(canvas, false);
  const scene = new BABYLON.Scene(engine);
  const map = await new Promise((done, failed) => {
    const texture = new BABYLON.CubeTexture(file, scene, null, false, null, () => done(texture),
      (message, error) => failed(error ?? new Error(message)), undefined, true);
  });
  return probe(engine._gl, map.getInternalTexture()._hardwareTexture.underlyingResource);
}

async function playcanvas() {
  const pc = await import('/modules/playcanvas/build/playcanvas.mjs');
  const app = new pc.Application(canvas, { graphicsDeviceOptions: { deviceTypes: ['webgl2'] } });
  const asset = new pc.Asset('map', 'texture', { url: file });
  await new Promise((done, failed) => {
    asset.on('load', done);
    asset.on('error', failed);
    app.assets.add(asset);
    app.assets.load(asset);
  });
  asset.resource.upload();
  return probe(app.graphicsDevice.gl, asset.resource.impl._glTexture);
}

async function filament() {
  // Filament does not tell its textures: remember the cubes that it makes.
  const cubes = [];
  const make = WebGL2RenderingContext.prototype.texStorage2D;
  WebGL2RenderingContext.prototype.texStorage2D = function (target, levels, format, width, height) {
    make.call(this, target, levels, format, width, height);
    if (target === this.TEXTURE_CUBE_MAP) cubes.push({ gl: this, texture: this.getParameter(this.TEXTURE_BINDING_CUBE_MAP), width });
  };
  await script('/modules/filament/filament.js');
  await new Promise(done => Filament.init([file], done));
  const engine = Filament.Engine.create(canvas);
  const map = file.endsWith('.ktx2') ? engine.createTextureFromKtx2(file, {}) : engine.createTextureFromKtx1(file, {});
  if (!map) throw new Error('no texture');
  engine.execute();
  // Its own black cube of one texel is made at the same time.
  const { gl, texture } = cubes.find(({ width }) => width > 1) ?? {};
  if (!texture) throw new Error('it is no cube map');
  gl.bindTexture(gl.TEXTURE_CUBE_MAP, texture);
  gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MIN_FILTER, gl.NEAREST_MIPMAP_NEAREST);
  return probe(gl, texture);
}

// Every attribute of every mesh of a model: number of items, sum of all numbers.
async function model() {
  const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
  const { scene } = await new GLTFLoader().loadAsync(file);
  const found = {};
  scene.traverse(({ geometry }) => {
    for (const [name, attribute] of Object.entries(geometry?.attributes ?? {})) {
      found[name] ??= { count: 0, sum: 0 };
      found[name].count += attribute.count;
      for (let i = 0; i < attribute.count; i++) {
        for (let c = 0; c < attribute.itemSize; c++) found[name].sum += attribute.getComponent(i, c);
      }
    }
  });
  return found;
}

const late = new Promise((_, failed) => setTimeout(() => failed(new Error('no answer')), 60_000));
const engines = { three, babylon, playcanvas, filament, model };
try {
  window.found = { result: await Promise.race([engines[query.get('engine')](), late]), said };
} catch (error) {
  window.found = { error: String(error?.message ?? error), said };
}
