// Vectors, colours as [red, green, blue] from 0 to 1, and the projection of an eye onto a canvas.
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]], add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]], times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2], cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.sqrt(dot(a, a)), unit = (a) => times(a, 1 / (norm(a) || 1)), mix = (a, b, t) => add(times(a, 1 - t), times(b, t));

const PALETTE = ['#E69F00', '#56B4E9', '#009E73', '#CC79A7', '#F0E442', '#D55E00', '#0072B2'];
const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
const css = (c, a = 1) => `rgba(${c.slice(0, 3).map((v) => Math.round(255 * Math.min(1, v))).join()},${a})`;

// Column-major clip_from_scene of an eye with these axes, lens and reach; it looks along -z.
function clip({x, y, z, at: o}, [fx, fy], near, far) {
  const a = (far + near) / (near - far), b = 2 * far * near / (near - far), depth = [...z, -dot(z, o)];
  const rows = [[...times(x, fx), -fx * dot(x, o)], [...times(y, fy), -fy * dot(y, o)], [a * depth[0], a * depth[1], a * depth[2], a * depth[3] + b], depth.map((v) => -v)];
  return [0, 1, 2, 3].flatMap((j) => rows.map((r) => r[j]));
}
// Where a point stands on a canvas of w by h, and how deep; null nearer than the eye reaches.
function project(m, p, w, h) {
  const [x, y, z, d] = [0, 1, 2, 3].map((i) => m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i]);
  return d > 0 && z > -d ? [(x / d + 1) * w / 2, (1 - y / d) * h / 2, d] : null;
}
