// A lobe as triangles and lines: a cone from its near to its far end with a rounded cap, cut at CUT so that it fits the picture.
const ROUND = 40;
function lobeSpan(l) {
  const far = Math.min(lobe.far[l], CUT);
  return [Math.min(lobe.near[l], 0.3 * far), far];
}

// The place at distance r from its feature, so far off its axis, and i of ROUND parts around it.
function lobeSurface(l) {
  const p = three(feature.at, lobe.feature[l]), a = three(lobe.axis, l), u = unit(cross(a, Math.abs(a[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0])), v = cross(a, u);
  return (r, angle, i) => add(p, add(times(a, r * Math.cos(angle)), times(add(times(u, Math.cos(2 * Math.PI * i / ROUND)), times(v, Math.sin(2 * Math.PI * i / ROUND))), r * Math.sin(angle))));
}
function lobeShape(l, c, strong, dense, scene) {
  const p = three(feature.at, lobe.feature[l]), a = three(lobe.axis, l), h = lobe.half[l], [near, far] = lobeSpan(l), on = lobeSurface(l);
  const fill = [...c, (strong ? 0.24 : 0.08) / dense ** 1.5], edge = [...c, strong ? 0.95 : 0.5], rings = Math.max(2, Math.ceil(h / 0.4));
  const quad = (s, q, t, w) => scene.triangles.push({p: [s, q, t], c: fill}, {p: [s, t, w], c: fill});
  const line = (s, q) => scene.lines.push({p: s, q, c: edge});
  for (let i = 0; i < ROUND; i++) {
    if (strong || dense < 2) {
      if (h < Math.PI - 0.02) quad(on(near, h, i), on(far, h, i), on(far, h, i + 1), on(near, h, i + 1));
      for (let k = 0; k < rings; k++) quad(on(far, h * k / rings, i), on(far, h * (k + 1) / rings, i), on(far, h * (k + 1) / rings, i + 1), on(far, h * k / rings, i + 1));
    }
    line(on(far, h, i), on(far, h, i + 1));
    if (strong) line(on(near, h, i), on(near, h, i + 1));
    if ((strong || dense < 2) && i % (ROUND / 8) === 0 && h < Math.PI - 0.02) line(on(near, h, i), on(far, h, i));
  }
  line(p, add(p, times(a, far)));
}

const lobesShown = (f) => [...Array(first[f + 1] - first[f]).keys()].map((i) => first[f] + i).filter((l) => state.alone < 0 || state.alone === l);
// The lobes of the shown feature: the one that is alone, or all of them, those that hold the viewpoint strongest. Many are fainter, and only those are filled.
function lobeScene() {
  const scene = {triangles: [], lines: []}, f = shown();
  if (f < 0) return scene;
  const v = viewpoint(), many = first[f + 1] - first[f], dense = state.alone < 0 ? Math.max(1, many / 4) : 1;
  for (const l of lobesShown(f)) lobeShape(l, lobeColour(l), many < 2 || state.alone === l || holds(l, v), dense, scene);
  return scene;
}
const lobeColour = (l) => { const f = lobe.feature[l], looks = [...new Set(lobe.look.subarray(first[f], first[f + 1]))]; return rgb(PALETTE[looks.indexOf(lobe.look[l]) % PALETTE.length]); };

// The sides of edges as strokes: each [from, to, unit vector beside it], along its edge and towards its side.
const LONG = 0.018 * RADIUS;
function sideStrokes() {
  const rows = [];
  for (let f = 0; f < COUNT; f++) {
    if (!isSide(f) || !state.sides) continue;
    const p = three(feature.at, f), on = bright(f), c = on ? [...colours[feature.type[f]], 1] : [0.5, 0.52, 0.55, 0.55];
    const along = three(strokes, 2 * sideAt[f]), across = three(strokes, 2 * sideAt[f] + 1);
    rows.push({p: add(p, times(along, -LONG)), q: add(p, times(along, LONG)), beside: across, c, on}, {p, q: add(p, times(across, 1.2 * LONG)), beside: along, c, on});
  }
  return rows.sort((a, b) => a.on - b.on);
}

// The features as points for whoever draws them: {p, c, size, on}; of the sides of edges only the one that is shown.
const SIZE = Math.max(6.6, Math.min(10, 260 / Math.sqrt(COUNT || 1)));
function points() {
  const rows = [];
  for (let f = 0; f < COUNT; f++) {
    if (isSide(f) && f !== shown()) continue;
    const on = bright(f) || f === shown(), c = colours[feature.type[f]];
    rows.push({p: three(feature.at, f), c: on ? [...c, 1] : [0.5, 0.52, 0.55, 0.55], size: f === shown() ? SIZE + 8 : on ? SIZE : 0.55 * SIZE, on: on || f === shown(), chosen: f === shown()});
  }
  return rows.sort((a, b) => a.on - b.on || a.size - b.size);
}
