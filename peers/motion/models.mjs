// Animated models that nobody here made, from packages of public registries, by the registries' own clients.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

const GRADIO = '6.31.0';
const MINETEST_GLTF = '3.0.1';
const VRSPACE = '0.7.9';

// The files, which are fetched into the cache once.
export function models(cache) {
  return [...ofGradio(cache), ...ofVrspace(cache), ...ofMinetestGltf(cache)];
}

// PyPI: a fox. Model CC0 by PixelMannen, rig and animation CC BY 4.0 by tomkranis, conversion CC BY 4.0 by AsoboStudio and scurest.
function ofGradio(cache) {
  const folder = path.join(cache, `gradio-${GRADIO}`);
  const inside = 'gradio/media_assets/models3d/Fox.gltf';
  if (!existsSync(path.join(folder, inside))) {
    mkdirSync(folder, { recursive: true });
    const python = (...args) => execFileSync('python3', args, { cwd: folder, stdio: ['ignore', 'ignore', 'inherit'] });
    python('-m', 'pip', 'download', '--quiet', '--no-deps', '-d', '.', `gradio==${GRADIO}`);
    python('-c', `import glob, zipfile; zipfile.ZipFile(glob.glob('gradio-*.whl')[0]).extract('${inside}')`);
  }
  return [{ name: 'Fox', file: path.join(folder, inside) }];
}

// npm: a dolphin, Apache-2.0 as the package.
function ofVrspace(cache) {
  const folder = path.join(cache, `vrspace-${VRSPACE}`);
  const inside = 'package/dolphin.glb';
  if (!existsSync(path.join(folder, inside))) {
    mkdirSync(folder, { recursive: true });
    const options = { cwd: folder, stdio: ['ignore', 'ignore', 'inherit'] };
    execFileSync('npm', ['pack', '--silent', `@vrspace/babylonjs@${VRSPACE}`], options);
    execFileSync('tar', ['xzf', `vrspace-babylonjs-${VRSPACE}.tgz`, inside], options);
  }
  return [{ name: 'dolphin', file: path.join(folder, inside) }];
}

// crates.io: the tests of the crate minetest-gltf, MIT.
function ofMinetestGltf(cache) {
  const folder = path.join(cache, `minetest-gltf-${MINETEST_GLTF}`);
  const tests = path.join(folder, 'vendor', 'minetest-gltf', 'tests');
  if (!existsSync(tests)) {
    mkdirSync(path.join(folder, 'src'), { recursive: true });
    const manifest = ['[package]', 'name = "models"', '[dependencies]', `minetest-gltf = "=${MINETEST_GLTF}"`, '[workspace]', ''];
    writeFileSync(path.join(folder, 'Cargo.toml'), manifest.join('\n'));
    writeFileSync(path.join(folder, 'src', 'lib.rs'), '');
    execFileSync('cargo', ['vendor', '--quiet'], { cwd: folder, stdio: ['ignore', 'ignore', 'inherit'] });
  }
  return ['spider_animated', 'minetest_sam', 'simple_skin'].map((name) => ({ name, file: path.join(tests, `${name}.gltf`) }));
}
