// A cube map whose texels say where they are: 2 (face + 1), 4 (column + 1/2)/N, 4 (row + 1/2)/N.
export const N = 16;
export const FACES = ['px', 'nx', 'py', 'ny', 'pz', 'nz'];

export const texel = (face, x, y) => [2 * (face + 1), 4 * (x + 0.5) / N, 4 * (y + 0.5) / N];

// The direction of a point of a face, s and t from -1 to 1, by OpenGL's table of cube maps.
const TOWARDS = [
  (s, t) => [1, -t, -s], (s, t) => [-1, -t, s], (s, t) => [s, 1, t],
  (s, t) => [s, -1, -t], (s, t) => [s, -t, 1], (s, t) => [-s, -t, -1],
];

// Three texels of each face, none the mirror image of another: place, direction, expected color.
export const PROBES = FACES.flatMap((_, face) => [[8, 8], [3, 5], [12, 2]].map(([x, y]) => ({
  direction: TOWARDS[face](2 * (x + 0.5) / N - 1, 2 * (y + 0.5) / N - 1),
  expected: texel(face, x, y),
})));

// The largest difference of the colors found at the probes, relative to 4.
export const difference = found => Math.max(...PROBES.flatMap(({ expected }, k) =>
  expected.map((value, c) => Math.abs(value - found[k][c]) / 4)));

// A face as the bytes of a .pfm picture, whose rows go upwards.
export function pfm(face) {
  const numbers = new Float32Array(3 * N * N);
  for (let y = 0; y < N; y++) for (let x = 0; x < N; x++) numbers.set(texel(face, x, y), 3 * ((N - 1 - y) * N + x));
  return Buffer.concat([Buffer.from(`PF\n${N} ${N}\n-1.0\n`), Buffer.from(numbers.buffer)]);
}
