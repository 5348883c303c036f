// The light of the test, what surfaces make of it, and the comparison with what an engine shows.
//
// Directions are those of glTF. The light has nine coefficients that all differ in each channel, so that no exchange of
// axes, no sign and no factor of a band leaves it as it is.

// Coefficients without the Condon-Shortley phase, in Lobe's frame: the constant band by color, the others by a sequence
// with a fixed start, none of them near zero.
function coefficients() {
  let state = 20261130;
  const uniform = () => (state = (1103515245 * state + 12345) % 2147483648) / 2147483648;
  const signed = (least, most) => (uniform() < 0.5 ? -1 : 1) * (least + (most - least) * uniform());
  const ranges = [...Array(3).fill([0.15, 0.6]), ...Array(5).fill([0.08, 0.38])];
  const rest = ranges.map(range => [0, 1, 2].map(() => signed(...range)));
  const mean = [1, 0.8, 0.6].map(c => c / basis([0, 0, 1])[0]);
  // No light below 0: the other bands are as strong as that allows.
  for (let scale = 1; ; scale *= 0.95) {
    const all = [mean, ...rest.map(color => color.map(c => scale * c))];
    if (sphere(4000).every(s => radiance(all, s).every(c => c >= 0.01))) return all;
  }
}

function sphere(count) {
  const golden = Math.PI * (3 - Math.sqrt(5));
  return Array.from({ length: count }, (_, k) => {
    const z = 1 - (2 * k + 1) / count, r = Math.sqrt(1 - z * z);
    return [r * Math.cos(golden * k), r * Math.sin(golden * k), z];
  });
}

function basis([x, y, z]) {
  const k = [Math.sqrt(1 / Math.PI) / 2, Math.sqrt(3 / Math.PI) / 2, Math.sqrt(15 / Math.PI) / 2];
  const zonal = Math.sqrt(5 / Math.PI) / 4 * (3 * z * z - 1);
  return [
    k[0], k[1] * y, k[1] * z, k[1] * x, k[2] * x * y, k[2] * y * z, zonal, k[2] * x * z, k[2] / 2 * (x * x - y * y),
  ];
}

// The sum of bands, each multiplied by a gain, at a direction of Lobe's frame.
function radiance(light, s, [g1, g2] = [1, 1]) {
  const gains = [1, g1, g1, g1, g2, g2, g2, g2, g2];
  const values = basis(s);
  return [0, 1, 2].map(c => light.reduce((sum, color, i) => sum + gains[i] * color[c] * values[i], 0));
}

export const LIGHT = coefficients();

// The light as Lobe keeps it, with the phase.
export const shJson = () => {
  const signs = [1, -1, 1, -1, 1, -1, 1, -1, 1];
  const numbers = LIGHT.map((color, i) => color.map(c => signs[i] * c));
  return JSON.stringify({ format: 'lobe-sh', version: 1, order: 3, quantity: 'radiance', coefficients: numbers });
};

const toLobe = ([x, y, z]) => [x, -z, y];
const unit = v => v.map(c => c / Math.hypot(...v));

// Six axes and eight diagonals: over either, bands 1 and 2 have a mean of zero.
export const DIRECTIONS = [
  [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1],
  ...[1, -1].flatMap(x => [1, -1].flatMap(y => [1, -1].map(z => unit([x, y, z])))),
];

// Others, of the sky: a direction that ends in a corner of the box on which an engine draws it has no texel of its own.
export const SKY_DIRECTIONS = sphere(14);

// A sun beside that light, for a run of its own; in Lobe's frame for the file.
const SUN = { direction: unit([0.48, 0.6, -0.64]), irradiance: [1.2, 0.9, 0.5], diameter: 1 };
export const sunJson = () => JSON.stringify({ ...SUN, direction: toLobe(SUN.direction) });

// The share of the first two bands that the cosine lobe lets through.
export const COSINE = [2 / 3, 1 / 4];

// The same of the GGX lobe about the reflected view, weighted as prefiltered levels are.
export function ggxGains(roughness) {
  const alpha = roughness ** 2;
  if (alpha < 1e-4) return [1, 1];
  let [w0, w1, w2] = [0, 0, 0];
  lobe(alpha, (d, cos, sin) => {
    const w = d * cos * sin;
    w0 += w; w1 += w * cos; w2 += w * (3 * cos * cos - 1) / 2;
  });
  return [w1 / w0, w2 / w0];
}

// What a white GGX surface seen along its normal reflects by single scattering, with Smith's correlated shadowing.
export function ggxAlbedo(roughness) {
  const alpha = roughness ** 2;
  if (alpha < 1e-4) return 1;
  let sum = 0;
  const step = lobe(alpha, (d, cos, sin) => {
    const lambda = (Math.sqrt(1 + (alpha * sin / cos) ** 2) - 1) / 2;
    sum += d / Math.PI / 4 / (1 + lambda) * 2 * Math.PI * sin;
  });
  return sum * step;
}

// Calls `add` with π D, cosine and sine for angles between normal and light; half of each is the angle of the facet.
function lobe(alpha, add) {
  const count = 20000, step = Math.PI / 2 / count;
  for (let k = 0; k < count; k++) {
    const theta = (k + 0.5) * step, cos2 = Math.cos(theta / 2) ** 2;
    add(alpha ** 2 / (cos2 * (alpha ** 2 - 1) + 1) ** 2, Math.cos(theta), Math.sin(theta));
  }
  return step;
}

// The 48 signed exchanges of axes.
const FRAMES = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]].flatMap(order =>
  Array.from({ length: 8 }, (_, bits) => {
    const signs = [0, 1, 2].map(k => (bits >> k & 1 ? -1 : 1));
    const name = order.map((axis, k) => (signs[k] < 0 ? '-' : '+') + 'xyz'[axis]).join(' ');
    return { name, of: d => order.map((axis, k) => signs[k] * d[axis]) };
  }));
export const IDENTITY = '+x +y +z';

const worst = (found, expected) =>
  Math.max(...found.flatMap((color, i) => color.map((c, k) => Math.abs(c - expected[i][k]))));

// The frame in which an engine shows the light by these gains, the largest difference there, and that of the next best.
export function bestFrame(found, gains, directions = DIRECTIONS) {
  const shown = of => directions.map(d => radiance(LIGHT, toLobe(of(d)), gains));
  const tried = FRAMES.map(({ name, of }) => ({ name, error: worst(found, shown(of)) }));
  const [best, second] = tried.sort((a, b) => a.error - b.error);
  return { ...best, next: second.error };
}

// The largest difference with the sun beside the light on a matte surface.
export function sunError(found, gain = 1) {
  return worst(found, DIRECTIONS.map(d => {
    const cosine = Math.max(d.reduce((sum, c, k) => sum + c * SUN.direction[k], 0), 0);
    return radiance(LIGHT, toLobe(d), COSINE).map((c, k) => c + gain * SUN.irradiance[k] * cosine / Math.PI);
  }));
}

// The level of a chain that explains a rough metal best, up to a factor for all, with levels between two that are read
// together, and what is left unexplained relative to that factor. `roughness` is that of each level, `gains` those of
// the engine from the gains of the level.
export function bestLevel(found, roughness, gains) {
  const mean = values => values.flat().reduce((sum, c) => sum + c, 0) / values.length;
  const scale = mean(found) / mean(DIRECTIONS.map(d => radiance(LIGHT, toLobe(d))));
  const scaled = found.map(color => color.map(c => c / scale));
  const ofLevels = roughness.map(ggxGains);
  const between = level => {
    const k = Math.min(Math.floor(level), ofLevels.length - 2), t = level - k;
    return ofLevels[k].map((g, band) => (1 - t) * g + t * ofLevels[k + 1][band]);
  };
  const error = level => worst(scaled, DIRECTIONS.map(d => radiance(LIGHT, toLobe(d), gains(between(level)))));
  const tried = Array.from({ length: 100 * (roughness.length - 1) + 1 }, (_, k) => k / 100);
  const level = tried.reduce((a, b) => (error(b) < error(a) ? b : a));
  return { level, error: error(level), scale };
}
