// What stands in space, in the camera's frame: triangles, lines and points for whoever draws them. 
const place = (T, p) => [0, 1, 2].map((i) => T[i][0] * p[0] + T[i][1] * p[1] + T[i][2] * p[2] + T[i][3]);
// A world that is the camera's own frame knows no up; the plane that things stand on does. A camera that looks straight down has its up as what is ahead.
const GROUNDED = list(doc.camera.T_world_camera).flat().some((x, i) => x !== (i % 5 ? 0 : 1));
const UP = GROUNDED ? unit(doc.camera.T_world_camera[2].slice(0, 3)) : plane ? plane.normal : [0, -1, 0], AHEAD = Math.abs(UP[2]) > 0.99 ? [0, -1, 0] : [0, 0, 1];
const shape = {lines: true, features: true, picture: true, texture: true, plane: true, grid: null, feet: false}, MOST_CREASES = 400;

// The edges where two facets meet at an angle, from a mesh whose vertices may be doubled along texture seams.
function creases(points, facets) {
  const edges = new Map(), key = (p) => p.map((c) => c.toFixed(6)).join();
  for (const f of facets) {
    const [a, b, c] = f.map((i) => points[i]), n = unit(cross(sub(b, a), sub(c, a)));
    for (const [p, q] of [[a, b], [b, c], [c, a]]) {
      const k = [key(p), key(q)].sort().join('|');
      if (edges.has(k)) edges.get(k).normals.push(n); else edges.set(k, {p, q, normals: [n]});
    }
  }
  return [...edges.values()].filter((e) => e.normals.length === 1 || e.normals.some((n) => dot(n, e.normals[0]) < 0.94)).map((e) => [e.p, e.q]);
}

// Of a scanned surface nearly every edge is a crease, so that they say nothing.
const few = (edges) => (edges.length > MOST_CREASES ? [] : edges);
const posed = new Map();
// Of what has no mesh the features are the body: its own, or those of its type where none were kept.
function featurePoints(h) {
  const own = list(h.features).map((f) => f.at).filter(Boolean), type = (doc.types || {})[h.type] || {};
  return own.length ? own : list(type.features).map((row) => place(h.T_camera_object, row.slice(2)));
}
function solid(h) {
  const mesh = (doc.assets.meshes || {})[h.type];
  if (!posed.has(h.id) && mesh) {
    const points = mesh.vertices.map((p) => place(h.T_camera_object, p));
    posed.set(h.id, {points, facets: mesh.triangles, creases: few(creases(points, mesh.triangles))});
  }
  if (!posed.has(h.id)) posed.set(h.id, {points: featurePoints(h), facets: [], creases: []});
  return posed.get(h.id);
}

const least = (xs) => xs.reduce((m, x) => Math.min(m, x), Infinity), most = (xs) => xs.reduce((m, x) => Math.max(m, x), -Infinity);
// How far from the camera its picture is drawn: before all that stands there.
function frameDepth(points) {
  const deep = least(points.map((p) => p[2]));
  return deep > 0 && deep < Infinity ? deep * 0.42 : 1;
}
function frustum(depth) {
  const K = doc.camera.K || [[W, 0, W / 2], [0, W, H / 2]];
  return [[-0.5, -0.5], [W - 0.5, -0.5], [W - 0.5, H - 0.5], [-0.5, H - 0.5]].map(([u, v]) => [(u - K[0][2]) / K[0][0] * depth, (v - K[1][2]) / K[1][1] * depth, depth]);
}

// The floor under everything: a grid of round steps that fades out, drawn only where the world's up is known and no plane that things stand on.
function floor(points, ink, lines) {
  const low = least(points.map((p) => dot(p, UP))), middle = points.reduce(add, [0, 0, 0]).map((c) => c / points.length);
  const centre = add(middle, times(UP, low - dot(middle, UP))), x = unit(cross(UP, AHEAD)), y = cross(UP, x);
  const size = 1.6 * most(points.map((p) => norm(sub(p, middle)))), raw = size / 5, ten = 10 ** Math.floor(Math.log10(raw)), step = ten * (raw / ten > 5 ? 10 : raw / ten > 2 ? 5 : 2);
  const n = Math.ceil(size / step);
  shape.grid = `floor, a square is ${metric(step)}`;
  for (let i = -n; i <= n; i++) for (const [a, b] of [[x, y], [y, x]]) for (let j = -n; j < n; j++) {
    const p = (k) => add(centre, add(times(a, i * step), times(b, k * step))), fade = 0.42 * Math.max(0, 1 - Math.hypot(i, j + 0.5) / n);
    if (fade > 0.02) lines.push({p: p(j), q: p(j + 1), c: [...ink, fade]});
  }
}

// All that is to be drawn of the shown world: {triangles, painted, lines, points, picture}; painted are [surface, pose].
function build(theme) {
  const shown = standing(state.shown), scene = {triangles: [], painted: [], lines: [], points: [], picture: null};
  const all = shown.flatMap((h) => solid(h).points);
  Object.assign(shape, {grid: null, feet: false});
  if (laid() && shape.plane) gridInSpace(shown, theme.ink, scene.lines);
  if (!laid() && GROUNDED && all.length) floor(all, theme.ink, scene.lines);
  for (const h of shown) {
    const s = solid(h), c = rgb(colour(h.id)), wall = mix(c, [1, 1, 1], 0.5);
    const painted = paintOf(h);
    if (painted) scene.painted.push([painted, h.T_camera_object]);
    else for (const f of s.facets) scene.triangles.push({p: f.map((i) => s.points[i]), c: [...wall, h.opaque === false ? 0.35 : 1]});
    for (const [p, q] of painted ? [] : s.creases) scene.lines.push({p, q, c: [...mix(c, [0, 0, 0], 0.55), 1]});
    for (const f of list(h.features)) sight(h, f, c, scene, theme);
    if (!s.facets.length && !list(h.features).length) for (const p of s.points) scene.points.push({p, c: [...c, 1], kind: 3, size: 9});
  }
  const corners = frustum(frameDepth(all));
  corners.forEach((p, i) => scene.lines.push({p: [0, 0, 0], q: p, c: [...theme.ink, 0.75]}, {p, q: corners[(i + 1) % 4], c: [...theme.ink, 0.75]}));
  if (IMAGE && shape.picture) scene.picture = corners;
  return scene;
}

function sight(h, f, c, scene, theme) {
  const k = caseOf(h, f), chosen = state.chosen && state.chosen.key.join(' ') === h.id + ' ' + f.id;
  if (!k.letter || !f.at || f.stands_for > 1) return;
  const paint = chosen ? theme.ink : mix(c, [0, 0, 0], 0.25);
  if (shape.lines && ((k.expected && !isSide(f)) || chosen)) scene.lines.push({p: [0, 0, 0], q: f.at, c: [...paint, chosen ? 1 : k.detected ? 0.42 : 0.16]});
  if (shape.features) scene.points.push({p: f.at, c: [...paint, 1], kind: (k.expected ? 0 : 2) + (k.detected ? 0 : 1), size: chosen ? 15 : isSide(f) ? 5 : k.expected || k.detected ? 9 : 6});
}
const shade = (p, z) => 0.72 + 0.28 * Math.abs(dot(unit(cross(sub(p[1], p[0]), sub(p[2], p[0]))), unit(add(z, times(UP, 0.7)))));
