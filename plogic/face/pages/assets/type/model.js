// What the page knows: the document, its arrays unpacked, and which lobes hold a viewpoint (§2.7). No drawing here.
const doc = read;
const TYPES = doc.types.map(([name, here, all, dv, hit, sigma]) => ({name, here, all, dv, hit, sigma})), PARTS = doc.parts, LOOKS = doc.lobes.looks;
const feature = {names: doc.features.names, type: shorts(doc.features.type), part: shorts(doc.features.part), at: floats(doc.features.at), sigma: doc.features.sigma ? floats(doc.features.sigma) : null};
const lobe = {look: shorts(doc.lobes.look), feature: shorts(doc.lobes.feature), axis: floats(doc.lobes.axis), half: floats(doc.lobes.half_angle), near: floats(doc.lobes.r_min), far: floats(doc.lobes.r_max), hit: doc.lobes.hit ? floats(doc.lobes.hit) : null};
const COUNT = feature.names.length, LOBES = lobe.look.length, cosine = Float64Array.from(lobe.half, Math.cos);
const surface = doc.surface && {vertices: floats(doc.surface.vertices), triangles: shorts(doc.surface.triangles), uv: doc.surface.uv ? floats(doc.surface.uv) : null};
const PICTURE = doc.surface && address(doc.surface.picture);
// Sides of edges: the place of each among the strokes, -1 of a keypoint.
const sideAt = new Int32Array(COUNT).fill(-1), strokes = doc.features.sides ? floats(doc.features.sides.strokes) : [], SIDES = strokes.length / 6;
if (SIDES) shorts(doc.features.sides.feature).forEach((f, i) => { sideAt[f] = i; });
const isSide = (f) => sideAt[f] >= 0, sideTypes = new Set([...feature.type].filter((_, f) => isSide(f)));
const named = (t) => words(TYPES[t].name) + (sideTypes.has(t) ? ', the side of an edge' : '');
const three = (array, i) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];

// The lobes of each feature: from first[f] up to first[f + 1].
const first = new Uint32Array(COUNT + 1);
for (let l = 0; l < LOBES; l++) first[lobe.feature[l] + 1] += 1;
for (let f = 0; f < COUNT; f++) first[f + 1] += first[f];

const GRAIN = 1e-6;
function holds(l, v) {
  const f = 3 * lobe.feature[l], x = v[0] - feature.at[f], y = v[1] - feature.at[f + 1], z = v[2] - feature.at[f + 2], d = Math.sqrt(x * x + y * y + z * z);
  return d >= lobe.near[l] * (1 - GRAIN) && d <= lobe.far[l] * (1 + GRAIN) && d > 0 && x * lobe.axis[3 * l] + y * lobe.axis[3 * l + 1] + z * lobe.axis[3 * l + 2] >= (cosine[l] - GRAIN) * d;
}
// Marks in `lit` the features one of whose lobes holds v; returns how many.
function look(v, lit) {
  let n = 0;
  for (let f = 0; f < COUNT; f++) {
    let l = first[f];
    while (l < first[f + 1] && !holds(l, v)) l += 1;
    lit[f] = l < first[f + 1] ? 1 : 0;
    n += lit[f];
  }
  return n;
}

// The middle of what is drawn and how far from it anything is.
const [CENTRE, RADIUS] = (() => {
  const all = surface ? surface.vertices : feature.at, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < all.length; i++) { low[i % 3] = Math.min(low[i % 3], all[i]); high[i % 3] = Math.max(high[i % 3], all[i]); }
  const middle = all.length ? times(add(low, high), 0.5) : [0, 0, 0];
  let far = 0;
  for (const list of [all, feature.at]) for (let i = 0; i < list.length; i += 3) far = Math.max(far, Math.hypot(list[i] - middle[0], list[i + 1] - middle[1], list[i + 2] - middle[2]));
  return [middle, far || 1];
})();
const CUT = 0.62 * RADIUS;

// dv as a colour: equal steps of -log(1 - dv), from the commonest type here to the rarest.
const RAMP = ['#4a5fb5', '#2a9db0', '#6cc36a', '#f5d33f'].map(rgb);
const surprise = (dv) => -Math.log(Math.max(1e-6, 1 - dv)), DVS = TYPES.map((t) => t.dv), [COMMON, RARE] = [Math.min(...DVS), Math.max(...DVS)];
const ramp = (t) => { const k = Math.max(0, Math.min(2.999, 3 * t)), i = Math.floor(k); return mix(RAMP[i], RAMP[i + 1], k - i); };
const warmth = (dv) => (RARE > COMMON ? (surprise(dv) - surprise(COMMON)) / (surprise(RARE) - surprise(COMMON)) : 1);
const colours = TYPES.map((t) => ramp(warmth(t.dv)));

// What is shown: `pinned` stays until it is let go, `pointed` while the pointer is on it; `alone` is one lobe of it; `only` a part or a type.
const state = {pinned: -1, pointed: -1, alone: -1, only: null, here: false, surface: true, sides: true, lit: new Uint8Array(COUNT), seen: 0};
const shown = () => (state.pinned >= 0 ? state.pinned : state.pointed);
const within = (part, top) => part === top || (PARTS[part].under != null && within(PARTS[part].under, top));
const chosen = (f) => !state.only || ((state.only.part == null || within(feature.part[f], state.only.part)) && (state.only.type == null || feature.type[f] === state.only.type));
const drawn = (f) => state.sides || !isSide(f);
const bright = (f) => drawn(f) && chosen(f) && (!state.here || state.lit[f] === 1);

const round = (x, n = 3) => Number(x.toPrecision(n)).toString();
const metres = (x, n = 3) => (x === 0 ? '0' : x < 0.001 ? round(x * 1e3, 2) + ' mm' : x < 0.1 ? round(x * 1e2, 2) + ' cm' : x < 1e5 ? round(x, n) + ' m' : x.toExponential(1) + ' m');
const degrees = (x) => Math.round(x * 180 / Math.PI) + '\u00b0';
