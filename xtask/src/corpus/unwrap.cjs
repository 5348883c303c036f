// Writes what is wrapped as a data URI in modules such as sky.exr.js beside them: node unwrap.cjs FOLDER
const { readdirSync, readFileSync, writeFileSync } = require('fs');
const { join } = require('path');
for (const entry of readdirSync(process.argv[2], { recursive: true })) {
  if (!/\.(glb|exr|hdr)\.js$/.test(entry)) continue;
  const path = join(process.argv[2], entry);
  const data = readFileSync(path, 'latin1').match(/base64,([A-Za-z0-9+/=]+)/);
  if (data) writeFileSync(path.slice(0, -'.js'.length), Buffer.from(data[1], 'base64'));
}
