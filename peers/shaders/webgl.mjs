// Runs the programs of a folder's programs.json in WebGL 2, in a headless Chromium, and prints their numbers as JSON.
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { homedir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { openBrowser } from '../browser.mjs';

const caches = process.env.XDG_CACHE_HOME ?? path.join(homedir(), '.cache');
const packages = [process.env.LOBE_READERS, path.join(caches, 'lobe-readers'), path.join(caches, 'lobe-engines')];
const modules = packages.filter(Boolean).map(p => path.join(p, 'node_modules')).find(existsSync);
if (!modules) throw new Error('no packages; run peers/readers/readers.mjs, which fetches them');
const playwright = createRequire(path.join(modules, 'x.js'))('playwright-core');
const page = path.dirname(fileURLToPath(import.meta.url));
const browser = await openBrowser(playwright, { page, modules, files: process.argv[2] }, 300000);
const found = await browser.found({});
await browser.close();
if (found.error) throw new Error(found.error);
console.log(JSON.stringify(found.numbers));
