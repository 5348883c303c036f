// A headless Chromium with software OpenGL, and the server of the pages, the packages and the files.
import { existsSync, readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';

const SCRIPT = 'text/javascript';
const TYPES = { '.html': 'text/html', '.js': SCRIPT, '.mjs': SCRIPT, '.wasm': 'application/wasm' };
const LIMIT = 300_000;

export const chromiumPath = () =>
  [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome']
    .find(p => p && existsSync(p));

// A browser whose `show` runs a module of this folder for one export, and returns what it found.
export async function openBrowser(playwright, { modules, files }) {
  const folders = { modules, files };
  const server = createServer((request, response) => {
    const [, first, ...rest] = decodeURIComponent(new URL(request.url, 'http://localhost').pathname).split('/');
    const below = path.normalize(`/${rest.join('/')}`);
    const place = folders[first] ? path.join(folders[first], below) : path.join(import.meta.dirname, first);
    if (!existsSync(place)) return response.writeHead(404).end();
    response.writeHead(200, { 'content-type': TYPES[path.extname(place)] ?? 'application/octet-stream' });
    response.end(readFileSync(place));
  });
  await new Promise(done => server.listen(0, '127.0.0.1', done));
  const browser = await playwright.chromium.launch({
    executablePath: chromiumPath(),
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
  const show = async (engine, folder, surfaces) => {
    const page = await browser.newPage();
    try {
      const place = `/files/${folder}/${engine}`;
      const query = new URLSearchParams({ engine, folder: place, surfaces: JSON.stringify(surfaces) });
      await page.goto(`http://127.0.0.1:${server.address().port}/page.html?${query}`);
      await page.waitForFunction(() => window.found, null, { timeout: LIMIT });
      return await page.evaluate(() => window.found);
    } catch (error) {
      return { error: error.message.split('\n')[0] };
    } finally {
      await page.close();
    }
  };
  return { show, close: async () => { await browser.close(); server.close(); } };
}
