// A photo's marks: thousands, so they are dots on one canvas over the picture, by case; pointing finds the nearest.
const crowded = appearances.length > 500 || hypotheses.some((h) => list(h.features).some((f) => f.stands_for > 1));
const sheet = el('canvas', {class: 'dots', tabindex: 0, role: 'application', 'aria-describedby': 'about', 'aria-label': 'What was expected and detected, as dots. Arrow keys go from dot to dot.'});
const DOTS = [['A', 'Found', true], ['C', 'Missed', true], ['D', 'Unexpected', true], ['B', 'Rightly unseen', false], ['appearances', 'All that was detected', false],
  ...(sideTypes.size ? [['sides', 'Sides of edges', true]] : [])];
const NEAR = 9;
let dots = [], at_dot = -1;

function gatherDots(features) {
  const on = (name) => state.layers.has(name);
  if (!on('marks')) features = [];
  const seen = on('marks') && on('appearances') ? appearances.map((a) => ({uv: a.uv, letter: '', a, side: sideAngles.has(a.id)})) : [];
  const rows = features.filter((r) => on(r.letter) && !(r.f.stands_for > 1)).map((r) => ({...r, uv: r.f.uv, side: isSide(r.f)}));
  dots = [...seen, ...['B', 'D', 'C', 'A'].flatMap((letter) => rows.filter((d) => d.letter === letter))].filter((d) => on('sides') || !d.side);
  at_dot = -1;
}

// A side that is expected, or only seen, is strokes; any other case is a square as a keypoint's is.
const stroked = (d) => d.side && d.letter !== 'B' && d.letter !== 'D';
const spot = (d, k) => d.uv.map((x) => (Number(x) + 0.5) * k);
function dotPath(g, d, k) {
  const [u, v] = spot(d, k), r = (!d.letter ? 1.3 : stroked(d) ? 2.4 : 2.9) * (devicePixelRatio || 1);
  g.beginPath();
  if (stroked(d)) for (const [a, b, c, e] of sideStrokes(angleOf(d), r)) { g.moveTo(u + a, v + b); g.lineTo(u + c, v + e); }
  else if (d.letter === 'A' || d.letter === 'C' || !d.letter) g.arc(u, v, r, 0, 7);
  else g.rect(u - 0.85 * r, v - 0.85 * r, 1.7 * r, 1.7 * r);
}

// How opaque a mark's inside is, how wide its casing and its line are, and how opaque both; '' is what was detected.
const FORMS = {A: [1, 1, 0, 1], C: [0, 3, 1.4, 1], D: [0, 3, 1.4, 1], B: [0, 3, 1.4, 0.6], '': [0.6, 1, 0, 0.35]}, STROKES = {A: [0, 3, 1.6, 1], C: [0, 2.6, 1.2, 1], '': [0, 1, 0.8, 0.35]};
function paintDots() {
  const wide = canvasSvg.getBoundingClientRect().width * (devicePixelRatio || 1);
  if (!crowded || !wide) return;
  sheet.width = Math.round(wide);
  sheet.height = Math.round(wide * H / W);
  const g = sheet.getContext('2d'), k = sheet.width / W, px = devicePixelRatio || 1;
  const stroke = (paint, width) => { g.strokeStyle = paint; g.lineWidth = width * px; g.stroke(); };
  for (const d of dots) {
    dotPath(g, d, k);
    const c = d.h ? colour(d.h.id) : '#fff', [inside, casing, line, alpha] = (stroked(d) ? STROKES : FORMS)[d.letter];
    if (inside) { g.fillStyle = c; g.globalAlpha = inside; g.fill(); }
    g.globalAlpha = alpha;
    for (const [paint, width] of [['#14171a', casing], [c, line]]) if (width) stroke(paint, width);
    g.globalAlpha = 1;
  }
  if (dots[at_dot]) { g.beginPath(); g.arc(...spot(dots[at_dot], k), 9 * px, 0, 7); stroke('#fff', 2); }
}

function chooseDot(i) {
  if (i === at_dot) return;
  at_dot = i;
  const d = dots[i];
  state.chosen = !d ? null : {key: d.h ? [d.h.id, d.f.id] : [d.a.id], tell: d.h ? featureTell(d.h, d.f, d.letter) : appearanceTell(d.a)};
  paintDots();
  changed('chosen');
}

function pointDot(event) {
  const box = sheet.getBoundingClientRect(), k = W / box.width, u = (event.clientX - box.left) * k - 0.5, v = (event.clientY - box.top) * k - 0.5;
  const far = dots.map((d) => Math.hypot(d.uv[0] - u, d.uv[1] - v)), best = far.reduce((m, x, i) => (x <= far[m] ? i : m), 0);
  if (far[best] < NEAR * k) chooseDot(best);
}

function walkDots(event) {
  const step = stepOf(event, dots.length > 0);
  if (step) chooseDot((Math.max(at_dot, step > 0 ? -1 : 0) + step + dots.length) % dots.length);
}

function startDots() {
  if (!crowded) return;
  state.layers = new Set(['marks', ...DOTS.filter(([, , shown]) => shown).map(([name]) => name), 'sides', 'missed', 'outlines', 'unseen', 'ground', 'labels']);
  at('picture').append(sheet, over);
  sheet.addEventListener('pointermove', pointDot);
  sheet.addEventListener('click', pointDot);
  sheet.addEventListener('keydown', walkDots);
}

// A dot for the key and the switches.
function dotIcon(letter) {
  if (letter === 'sides') return sideIcon(Math.PI / 2);
  const line = {fill: letter === 'A' ? MUTED : 'none', stroke: MUTED, 'stroke-width': 2, 'stroke-opacity': letter === 'B' ? 0.5 : 1};
  return icon(letter === 'appearances' ? svg('circle', {r: 1.8, fill: MUTED}) : letter === 'A' || letter === 'C' ? svg('circle', {r: 4, ...line})
    : svg('rect', {x: -3.6, y: -3.6, width: 7.2, height: 7.2, ...line}));
}
