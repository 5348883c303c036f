// Packages of npm and of PyPI that a harness needs, in a folder of the user's cache.
import { execFileSync, spawnSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readFileSync, rmSync } from 'node:fs';
import { homedir } from 'node:os';
import path from 'node:path';

// The folder of a harness: where its variable says, or in the user's cache.
export function cacheOf(name) {
  const caches = process.env.XDG_CACHE_HOME ?? path.join(homedir(), '.cache');
  return process.env[name.toUpperCase().replaceAll('-', '_')] ?? path.join(caches, name);
}

// Installs what the package.json of a folder lists, once for each contents of it; gives the folder of modules.
export function getPackages(folder, cache) {
  mkdirSync(cache, { recursive: true });
  const wanted = path.join(folder, 'package.json');
  const there = path.join(cache, 'package.json');
  if (!existsSync(there) || readFileSync(there, 'utf8') !== readFileSync(wanted, 'utf8')) {
    const { dependencies } = JSON.parse(readFileSync(wanted));
    const all = Object.entries(dependencies).map(([name, version]) => `${name}@${version}`);
    const options = ['--ignore-scripts', '--no-audit', '--no-fund', '--no-save', '--no-package-lock'];
    execFileSync('npm', ['install', '--prefix', cache, ...options, ...all], { stdio: ['ignore', 'ignore', 'inherit'] });
    copyFileSync(wanted, there);
  }
  return path.join(cache, 'node_modules');
}

// Python with packages of PyPI, in an environment of its own; null where pip does not find them.
export function getPython(cache, ...packages) {
  const place = path.join(cache, packages.join('+'));
  const python = path.join(place, 'bin', 'python');
  if (!existsSync(python)) {
    execFileSync('python3', ['-m', 'venv', place]);
    const install = ['-m', 'pip', 'install', '--quiet', ...packages];
    if (spawnSync(python, install, { stdio: ['ignore', 'ignore', 'inherit'] }).status !== 0) {
      rmSync(place, { recursive: true });
      return null;
    }
  }
  return python;
}

// The version of Blender that harnesses run.
export const BLENDER = 'bpy==5.0.1';
