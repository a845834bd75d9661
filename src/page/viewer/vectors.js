// Vectors, matrices of 4 × 4 column by column, quaternions (x, y, z, w), and boxes.
const NAMES = ["x", "y", "z"];
const plus = (a, b) => a.map((x, i) => x + b[i]);
const minus = (a, b) => a.map((x, i) => x - b[i]);
const times = (a, s) => a.map(x => x * s);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const crossed = (a, b) => [0, 1, 2].map(i => a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]);
const lengthOf = a => Math.hypot(...a);
const unitOf = a => times(a, 1 / (lengthOf(a) || 1));
const product = (a, b) => Array.from({ length: 16 }, (_, n) => [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + n % 4] * b[4 * Math.floor(n / 4) + k], 0));

function turned([x, y, z, w], [a, b, c]) {
  const t = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * t[0] + y * t[2] - z * t[1], b + w * t[1] + z * t[0] - x * t[2], c + w * t[2] + x * t[1] - y * t[0]];
}

/** The twelve edges of a box, as pairs of ends. */
function edges([low, high]) {
  const corner = n => [0, 1, 2].map(axis => n >> axis & 1 ? high[axis] : low[axis]);
  return [0, 1, 2, 3, 4, 5, 6, 7].flatMap(n => [0, 1, 2].filter(axis => !(n >> axis & 1)).flatMap(axis => [...corner(n), ...corner(n | 1 << axis)]));
}
