// What the page knows: the document, its arrays unpacked, and which lobes hold a viewpoint (§2.7). No drawing here.
const doc = JSON.parse(document.getElementById('type').textContent);
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const floats = (text) => new Float32Array(bytes(text || '')), shorts = (text) => new Uint16Array(bytes(text || ''));
const TYPES = doc.types.map(([name, here, all, dv, hit, sigma]) => ({name, here, all, dv, hit, sigma})), PARTS = doc.parts, LOOKS = doc.lobes.looks;
const feature = {names: doc.features.names, type: shorts(doc.features.type), part: shorts(doc.features.part), at: floats(doc.features.at), sigma: doc.features.sigma ? floats(doc.features.sigma) : null};
const lobe = {look: shorts(doc.lobes.look), feature: shorts(doc.lobes.feature), axis: floats(doc.lobes.axis), half: floats(doc.lobes.half_angle), near: floats(doc.lobes.r_min), far: floats(doc.lobes.r_max), hit: doc.lobes.hit ? floats(doc.lobes.hit) : null};
const COUNT = feature.names.length, LOBES = lobe.look.length, cosine = Float64Array.from(lobe.half, Math.cos);
const surface = doc.surface && {vertices: floats(doc.surface.vertices), triangles: shorts(doc.surface.triangles), uv: doc.surface.uv ? floats(doc.surface.uv) : null};
const PICTURE = (() => {
  const i = doc.surface && doc.surface.picture;
  return i && /^image\/(png|jpeg)$/.test(i.media_type) && /^[A-Za-z0-9+/=]+$/.test(i.base64) ? `data:${i.media_type};base64,${i.base64}` : null;
})();

const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]], add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]], times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2], cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => times(a, 1 / (Math.hypot(...a) || 1)), mix = (a, b, t) => add(times(a, 1 - t), times(b, t));
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
const RAMP = ['#4a5fb5', '#2a9db0', '#6cc36a', '#f5d33f'].map((hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255));
const surprise = (dv) => -Math.log(Math.max(1e-6, 1 - dv)), DVS = TYPES.map((t) => t.dv), [COMMON, RARE] = [Math.min(...DVS), Math.max(...DVS)];
const ramp = (t) => { const k = Math.max(0, Math.min(2.999, 3 * t)), i = Math.floor(k); return mix(RAMP[i], RAMP[i + 1], k - i); };
const warmth = (dv) => (RARE > COMMON ? (surprise(dv) - surprise(COMMON)) / (surprise(RARE) - surprise(COMMON)) : 1);
const colours = TYPES.map((t) => ramp(warmth(t.dv)));
const css = (c, a = 1) => `rgba(${c.slice(0, 3).map((v) => Math.round(255 * Math.min(1, v))).join()},${a})`;
const PALETTE = ['#E69F00', '#56B4E9', '#009E73', '#CC79A7', '#F0E442', '#D55E00', '#0072B2'].map((hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255));

// What is shown: `pinned` stays until it is let go, `pointed` while the pointer is on it; `alone` is one lobe of it; `only` a part or a type.
const state = {pinned: -1, pointed: -1, alone: -1, only: null, here: false, surface: true, lit: new Uint8Array(COUNT), seen: 0};
const shown = () => (state.pinned >= 0 ? state.pinned : state.pointed);
const within = (part, top) => part === top || (PARTS[part].under != null && within(PARTS[part].under, top));
const chosen = (f) => !state.only || ((state.only.part == null || within(feature.part[f], state.only.part)) && (state.only.type == null || feature.type[f] === state.only.type));
const bright = (f) => chosen(f) && (!state.here || state.lit[f] === 1);
const watchers = [];
const changed = (what) => watchers.forEach((w) => w(what));
