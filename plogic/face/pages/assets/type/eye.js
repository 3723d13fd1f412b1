// The eye is the viewpoint: it goes around the object at a distance in metres, and its lens keeps the object's size on the screen.
const FAR = (() => {
  const spans = [];
  for (let l = 0; l < LOBES; l++) spans.push([lobe.near[l], lobe.far[l]]);
  const middles = spans.map(([a, b]) => Math.sqrt(Math.max(a, 1e-3 * b) * b)).sort((a, b) => a - b), least = 1.15 * RADIUS;
  const most = spans.reduce((m, s) => Math.max(m, s[1]), 0) * 1.15 + RADIUS;
  const [low, high] = [least, Math.max(6 * RADIUS, Math.min(most, 300 * RADIUS))];
  return {low, high, start: Math.max(2.4 * RADIUS, Math.min(high, middles.length ? middles[middles.length >> 1] : 0))};
})();
const eye = {yaw: 0.6, pitch: 0.4, distance: FAR.start, zoom: 1};
const towards = (yaw, pitch) => [Math.cos(pitch) * Math.sin(yaw), -Math.cos(pitch) * Math.cos(yaw), Math.sin(pitch)];
const viewpoint = (yaw = eye.yaw, pitch = eye.pitch) => add(CENTRE, times(towards(yaw, pitch), eye.distance));

function eyeAxes() {
  const z = towards(eye.yaw, eye.pitch), x = [Math.cos(eye.yaw), Math.sin(eye.yaw), 0];
  return {x, y: cross(z, x), z, at: viewpoint()};
}
// The clip matrix for a canvas of this aspect.
function clipMatrix(aspect) {
  const d = eye.distance, reach = RADIUS + CUT, lens = 0.8 * eye.zoom * Math.sqrt(d * d - RADIUS * RADIUS) / RADIUS;
  const through = (lens) => clip(eyeAxes(), aspect > 1 ? [lens / aspect, lens] : [lens, lens * aspect], Math.max(d - reach, 0.02 * d), d + reach);
  return through(lens * (eye.zoom > 1 ? 1 : Math.min(1, 0.97 / widest(through(lens)))));
}
// How far from the middle of a canvas of which the edge is at 1 the lobes of the feature that is kept reach.
function widest(m) {
  const f = state.pinned, ends = f < 0 ? [] : lobesShown(f).flatMap((l) => { const on = lobeSurface(l), far = lobeSpan(l)[1]; return [...Array(ROUND / 4).keys()].map((i) => on(far, lobe.half[l], 4 * i)).concat([on(far, 0, 0)]); });
  return ends.map((p) => project(m, p, 2, 2)).reduce((most, s) => (s ? Math.max(most, Math.abs(s[0] - 1), Math.abs(s[1] - 1)) : most), 0);
}

// Whether the surface hides a point from the eye: a ray against every triangle.
function hidden(p) {
  if (!surface) return false;
  const o = viewpoint(), r = sub(p, o), V = surface.vertices, T = surface.triangles, end = 1 - 0.02 * RADIUS / Math.hypot(...r);
  for (let t = 0; t < T.length; t += 3) {
    const a = three(V, T[t]), e = sub(three(V, T[t + 1]), a), g = sub(three(V, T[t + 2]), a), q = cross(r, g), det = dot(e, q);
    if (!det) continue;
    const s = sub(o, a), u = dot(s, q) / det;
    if (u < 0 || u > 1) continue;
    const k = cross(s, e), v = dot(r, k) / det;
    if (v < 0 || u + v > 1) continue;
    const along = dot(g, k) / det;
    if (along > 0 && along < end) return true;
  }
  return false;
}
