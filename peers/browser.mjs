// A headless Chromium with software OpenGL, and the server of a folder's page, of packages and of files.
import { existsSync, readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';

const SCRIPT = 'text/javascript';
const TYPES = { '.html': 'text/html', '.js': SCRIPT, '.mjs': SCRIPT, '.wasm': 'application/wasm' };

export const chromiumPath = () =>
  [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome']
    .find(p => p && existsSync(p));

// A browser whose `found` opens page.html of the folder with a query, and returns what the page left in window.found.
export async function openBrowser(playwright, { page: folder, modules, files }, timeout) {
  const folders = { modules, files };
  const server = createServer((request, response) => {
    const [, first, ...rest] = decodeURIComponent(new URL(request.url, 'http://localhost').pathname).split('/');
    const below = path.normalize(`/${rest.join('/')}`);
    const place = folders[first] ? path.join(folders[first], below) : path.join(folder, first);
    if (!existsSync(place)) return response.writeHead(404).end();
    response.writeHead(200, { 'content-type': TYPES[path.extname(place)] ?? 'application/octet-stream' });
    response.end(readFileSync(place));
  });
  await new Promise(done => server.listen(0, '127.0.0.1', done));
  const browser = await playwright.chromium.launch({
    executablePath: chromiumPath(),
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
  const found = async query => {
    const page = await browser.newPage();
    try {
      await page.goto(`http://127.0.0.1:${server.address().port}/page.html?${new URLSearchParams(query)}`);
      await page.waitForFunction(() => window.found, null, { timeout });
      return await page.evaluate(() => window.found);
    } catch (error) {
      return { error: error.message.split('\n')[0] };
    } finally {
      await page.close();
    }
  };
  return { found, close: async () => { await browser.close(); server.close(); } };
}
