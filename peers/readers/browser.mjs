// A headless Chromium with software OpenGL, and the server of the page and the files.
import { existsSync, readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm' };

export const chromiumPath = () =>
  [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(p => p && existsSync(p));

export async function openBrowser(playwright, { modules, files }) {
  const server = createServer((request, response) => {
    const name = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    const [folder, rest] = name.startsWith('/modules/') ? [modules, name.slice(9)]
      : name.startsWith('/files/') ? [files, name.slice(7)] : [import.meta.dirname, name.slice(1)];
    const place = path.join(folder, path.normalize(`/${rest}`));
    if (!existsSync(place)) return response.writeHead(404).end();
    response.writeHead(200, { 'content-type': TYPES[path.extname(place)] ?? 'application/octet-stream' });
    response.end(readFileSync(place));
  });
  await new Promise(done => server.listen(0, '127.0.0.1', done));
  const browser = await playwright.chromium.launch({
    executablePath: chromiumPath(),
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
  const load = async (engine, file) => {
    const page = await browser.newPage();
    try {
      await page.goto(`http://127.0.0.1:${server.address().port}/page.html?engine=${engine}&file=/files/${encodeURIComponent(file)}`);
      await page.waitForFunction(() => window.found, null, { timeout: 90_000 });
      return await page.evaluate(() => window.found);
    } catch (error) {
      return { error: error.message.split('\n')[0], said: [] };
    } finally {
      await page.close();
    }
  };
  return { load, close: async () => { await browser.close(); server.close(); } };
}
