// Elements of this page: who is meant, long lists folded, the marks of features and appearances.
const who = (id) => tag('who', swatch(colour(id)), byId.has(id) ? label(id) + ' ' : null, tag('id', String(id)));

// Metres.
const metric = (m) => (m >= 1 ? `${m} m` : m >= 0.01 ? `${Math.round(m * 100)} cm` : `${Math.round(m * 1e4) / 10} mm`);

// Long lists show their first n; a button shows the rest, and what was unfolded stays so.
const unfolded = new Set();
function fold(nodes, n, what, wrap) {
  if (nodes.length <= n + 1 || unfolded.has(what)) return nodes;
  const rest = nodes.slice(n);
  rest.forEach((r) => { r.hidden = true; });
  const more = wrap(button(`Show all ${nodes.length} ${what}`, () => {
    unfolded.add(what);
    rest.forEach((r) => { r.hidden = false; });
    more.remove();
    (rest[0].querySelector('button') || at('worlds')).focus();
  }, {class: 'more'}));
  return [...nodes.slice(0, n), more, ...rest];
}

// The mark of a feature, centred on 0,0: a circle where it is expected, else a square; filled if detected, else dashed.
function glyph(expected, detected, c) {
  const faint = !expected && !detected, half = faint ? 4.2 : 5.8;
  const form = (extra) => (expected ? svg('circle', {r: 7, ...extra}) : svg('rect', {x: -half, y: -half, width: 2 * half, height: 2 * half, ...extra}));
  return [form({fill: detected ? c : 'none', 'fill-opacity': 0.4, stroke: '#14171a', 'stroke-opacity': faint ? 0.35 : 0.75, 'stroke-width': faint ? 2.8 : 3.8}),
    form({fill: 'none', stroke: c, 'stroke-width': faint ? 1.4 : 2.2, 'stroke-dasharray': detected ? null : faint ? '2.6 2' : '4.2 3'})];
}

// The mark of an appearance: a small sign that looks like its type where we know the type.
const SIGNS = {
  patch: 'M-3,-3H3V3H-3Z', corner: 'M-3,3V-3H3', apex: 'M-3.4,3L0,-3L3.4,3', l_junction: 'M-2.5,-3V3H3', y_junction: 'M0,3.6V0L-3,-3M0,0L3,-3',
  arrow_junction: 'M0,3.6V-3.4M-3,0L0,-3.4L3,0', t_junction: 'M-3.4,-3H3.4M0,-3V3.4', x_junction: 'M-3,-3L3,3M3,-3L-3,3', multi_junction: 'M-3.4,0H3.4M0,-3.4V3.4M-2.4,-2.4L2.4,2.4',
};
const OTHER = ['M0,-3.6L3.6,0L0,3.6L-3.6,0Z', 'M0,-3.4L3.2,2.6H-3.2Z', 'M0,3.4L3.2,-2.6H-3.2Z', 'M-3,-3H3L-3,3H3Z', 'M-3.4,-1.4H3.4M-3.4,2H3.4', 'M-2,-3.4V3.4M2,-3.4V3.4M-2,0H2', 'M-3,-3H3L-3,3H3', 'M-3.4,-3L-1.4,3L0,-1.4L1.4,3L3.4,-3'];
// Once every sign is used, they are used again in the next colour.
const TINTS = ['#fff', '#ffe27a', '#9be7ff', '#ffb3d1'];
// Visual words are hundreds of types; for a reader they are one.
const plain = (type) => (sideTypes.has(type) ? SIDE : String(type).replace(/^(sift|orb)_w\d+$/, '$1 keypoint'));
const kinds = [...new Set(appearances.map((a) => plain(a.type)))].sort();
const strange = kinds.filter((k) => !Object.hasOwn(SIGNS, k));
function sign(type) {
  const known = Object.hasOwn(SIGNS, type), number = Math.max(0, strange.indexOf(plain(type)));
  const d = known ? SIGNS[type] : OTHER[number % OTHER.length], tint = known ? TINTS[0] : TINTS[Math.floor(number / OTHER.length) % TINTS.length];
  return [svg('path', {d, fill: 'none', stroke: '#14171a', 'stroke-width': 3.2, 'stroke-opacity': 0.7}), svg('path', {d, fill: 'none', stroke: tint, 'stroke-width': 1.5})];
}
