#!/usr/bin/env node
// Opens the page of the viewer in headless Chromium through WebGL 2, looks into its rooms, and fails on an error on the console and
// where a room shows no picture.
//
//   node check.mjs FOLDER PICTURES
//
// FOLDER has the page, PICTURES takes a screenshot of each room. playwright-core is fetched into the cache of the user once.
import { execFileSync } from 'node:child_process';
import { createServer } from 'node:http';
import { existsSync, mkdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { homedir } from 'node:os';
import path from 'node:path';

const DRIVER = 'playwright-core@1.65.1';
const [folder, pictures] = process.argv.slice(2).map(name => path.resolve(name));
const cache = path.join(process.env.XDG_CACHE_HOME ?? path.join(homedir(), '.cache'), 'lobe-web');
const modules = path.join(cache, 'node_modules');
if (!existsSync(path.join(modules, 'playwright-core'))) {
  mkdirSync(cache, { recursive: true });
  execFileSync('npm', ['install', '--prefix', cache, '--ignore-scripts', '--no-audit', '--no-fund', '--no-save', '--no-package-lock', DRIVER],
    { stdio: ['ignore', 'ignore', 'inherit'] });
}
const { chromium } = createRequire(path.join(modules, '/'))('playwright-core');
const executablePath = process.env.CHROMIUM ?? ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm', '.glb': 'model/gltf-binary' };
// What a room draws first: reading a scene of fifty thousand vertices and a sky, in a page that emulates a device.
const PATIENCE = 120_000;

// Right of the panel and between the bars, where rooms have their pictures.
const PICTURE = { left: 330, top: 70, right: 1270, bottom: 740 };
// Colors of the least picture: words on a panel have some tens, the shades of their edges.
const FEWEST_COLORS = 400;

const server = createServer((request, response) => {
  const file = path.join(folder, path.normalize(new URL(request.url, 'http://page').pathname).replace(/\/$/, '/index.html'));
  if (!file.startsWith(folder) || !existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.writeHead(200, { 'Content-Type': TYPES[path.extname(file)] ?? 'application/octet-stream' }).end(readFileSync(file));
});
await new Promise(resolve => server.listen(0, '127.0.0.1', resolve));

const browser = await chromium.launch({
  executablePath,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
});
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
const faults = [], shots = [];
page.on('pageerror', error => faults.push(String(error)));
page.on('console', message => {
  console.log(`${message.type()}: ${message.text()}`);
  if (message.type() === 'error') faults.push(message.text());
});
// Counts the colors of the part of a screenshot that has the picture of a room.
const reader = await browser.newPage();
const colors = shot => reader.evaluate(async ([png, { left, top, right, bottom }]) => {
  const bytes = Uint8Array.from(atob(png), letter => letter.charCodeAt(0));
  const picture = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
  const canvas = new OffscreenCanvas(picture.width, picture.height).getContext('2d');
  canvas.drawImage(picture, 0, 0);
  const texels = new Uint32Array(canvas.getImageData(left, top, right - left, bottom - top).data.buffer);
  return new Set(texels).size;
}, [shot.toString('base64'), PICTURE]);
mkdirSync(pictures, { recursive: true });
try {
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await page.waitForFunction(() => document.getElementById('message') === null, null, { timeout: PATIENCE });
  await page.waitForTimeout(4000);
  // The room of motion only says that a page with one thread has none.
  for (const [key, room, fewest] of [['1', 'scene', FEWEST_COLORS], ['2', 'sky', FEWEST_COLORS], ['3', 'functions', FEWEST_COLORS], ['4', 'motion', 2]]) {
    await page.locator('#lobe').focus();
    await page.keyboard.press(`Control+${key}`);
    await page.waitForTimeout(3000);
    const shot = await page.screenshot({ path: path.join(pictures, `${room}.png`), timeout: PATIENCE });
    const found = await colors(shot);
    console.log(`room ${room}: ${found} colors`);
    if (found < fewest) faults.push(`room ${room} shows no picture: expected ${fewest} colors at least, found ${found}`);
    shots.push(shot);
  }
  // Another light path is another picture: the scene is lit by its transfer.
  await page.keyboard.press('Control+1');
  for (const mode of ['1', '3']) {
    await page.keyboard.press(mode);
    await page.waitForTimeout(3000);
    shots.push(await page.screenshot({ path: path.join(pictures, `scene-${mode}.png`), timeout: PATIENCE }));
  }
  // The last one is the first room as it was.
  const seen = shots.slice(0, -1);
  if (seen.some((shot, k) => seen.slice(k + 1).some(other => shot.equals(other)))) faults.push('two rooms or modes look alike');
} finally {
  await browser.close();
  server.close();
}
if (faults.length > 0) {
  console.error(`the page has ${faults.length} faults, first: ${faults[0]}`);
  process.exit(1);
}
