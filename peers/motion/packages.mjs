// The packages of package.json, in a folder of the user's cache, or where LOBE_MOTION says.
import { execFileSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readFileSync } from 'node:fs';
import { homedir } from 'node:os';
import path from 'node:path';

export const cache = process.env.LOBE_MOTION ?? path.join(process.env.XDG_CACHE_HOME ?? path.join(homedir(), '.cache'), 'lobe-motion');

// Gets the packages of package.json into the cache.
export function getPackages() {
  mkdirSync(cache, { recursive: true });
  const wanted = path.join(import.meta.dirname, 'package.json');
  const there = path.join(cache, 'package.json');
  if (!existsSync(there) || readFileSync(there, 'utf8') !== readFileSync(wanted, 'utf8')) {
    const all = Object.entries(JSON.parse(readFileSync(wanted)).dependencies).map(([name, version]) => `${name}@${version}`);
    const options = ['--ignore-scripts', '--no-audit', '--no-fund', '--no-save', '--no-package-lock'];
    execFileSync('npm', ['install', '--prefix', cache, ...options, ...all], { stdio: ['ignore', 'ignore', 'inherit'] });
    copyFileSync(wanted, there);
  }
  return path.join(cache, 'node_modules');
}
