// A photo's marks: thousands, so they are dots on one canvas over the picture, by case; pointing finds the nearest.
const crowded = appearances.length > 500 || hypotheses.some((h) => list(h.features).some((f) => f.stands_for > 1));
const sheet = el('canvas', {class: 'dots', tabindex: 0, role: 'img', 'aria-label': 'What was expected and detected, as dots. Arrow keys go from dot to dot.'});
const DOTS = [['A', 'Found', true], ['C', 'Missed', true], ['D', 'Unexpected', true], ['B', 'Hidden', false], ['appearances', 'All that was detected', false]];
const SIDES = ['sides', 'Sides of edges', true];
const NEAR = 9;
let dots = [], at_dot = -1;

function gatherDots(features) {
  const on = (name) => state.layers.has(name), told = features.filter(([, f]) => !(f.stands_for > 1));
  const seen = on('appearances') ? appearances.map((a) => ({uv: a.uv, letter: '', a, side: sideAngles.has(a.id), angle: sideAngles.get(a.id)})) : [];
  const rows = told.map(([h, f]) => ({uv: f.uv, h, f, letter: caseOf(h, f, state.shown).letter, side: isSide(f), angle: sideAngles.get(f.match)})).filter((d) => d.letter && on(d.letter));
  dots = [...seen, ...['B', 'D', 'C', 'A'].flatMap((letter) => rows.filter((d) => d.letter === letter))].filter((d) => on('sides') || !d.side);
  at_dot = -1;
}

// A side that is expected, or only seen, is strokes; any other case is a square as a keypoint's is.
const stroked = (d) => d.side && d.letter !== 'B' && d.letter !== 'D';
function dotPath(g, d, k) {
  const [u, v] = [(Number(d.uv[0]) + 0.5) * k, (Number(d.uv[1]) + 0.5) * k], r = (!d.letter ? 1.3 : stroked(d) ? 2.4 : 2.9) * (devicePixelRatio || 1);
  g.beginPath();
  if (stroked(d)) for (const [a, b, c, e] of sideStrokes(d.angle, r)) { g.moveTo(u + a, v + b); g.lineTo(u + c, v + e); }
  else if (d.letter === 'A' || d.letter === 'C' || !d.letter) g.arc(u, v, r, 0, 7);
  else g.rect(u - 0.85 * r, v - 0.85 * r, 1.7 * r, 1.7 * r);
}

function paintDots() {
  const wide = canvasSvg.getBoundingClientRect().width * (devicePixelRatio || 1);
  if (!crowded || !wide) return;
  sheet.width = Math.round(wide);
  sheet.height = Math.round(wide * H / W);
  const g = sheet.getContext('2d'), k = sheet.width / W, px = devicePixelRatio || 1;
  for (const d of dots) {
    dotPath(g, d, k);
    const c = d.h ? colour(d.h.id) : '#fff';
    const open = stroked(d), wide = open && d.letter === 'A' ? 1.6 : 1.2;
    if (!open && (d.letter === 'A' || !d.letter)) { g.fillStyle = c; g.globalAlpha = d.letter ? 1 : 0.6; g.fill(); }
    g.globalAlpha = d.letter === 'B' ? 0.6 : d.letter ? 1 : 0.35;
    g.strokeStyle = '#14171a';
    g.lineWidth = (open && d.letter ? wide + 1.4 : d.letter === 'A' || !d.letter ? 1 : 3) * px;
    g.stroke();
    if (open || (d.letter && d.letter !== 'A')) { g.strokeStyle = c; g.lineWidth = (d.letter ? wide : 0.8) * px; g.stroke(); }
    g.globalAlpha = 1;
  }
  if (dots[at_dot]) { g.beginPath(); g.arc((Number(dots[at_dot].uv[0]) + 0.5) * k, (Number(dots[at_dot].uv[1]) + 0.5) * k, 9 * px, 0, 7); g.strokeStyle = '#fff'; g.lineWidth = 2 * px; g.stroke(); }
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
  const step = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key];
  if (!step || !dots.length) return;
  event.preventDefault();
  chooseDot((Math.max(at_dot, step > 0 ? -1 : 0) + step + dots.length) % dots.length);
}

function startDots() {
  if (!crowded) return;
  state.layers = new Set(['A', 'C', 'D', 'sides', 'outlines', 'labels']);
  at('picture').append(sheet, over);
  sheet.addEventListener('pointermove', pointDot);
  sheet.addEventListener('click', pointDot);
  sheet.addEventListener('keydown', walkDots);
}

// A dot for the key and the switches.
const keyIcon = (kind) => (kind === 'side of an edge' ? sideIcon(Math.PI / 2) : dotIcon('appearances'));
const dotIcon = (letter) => letter === 'sides' ? sideIcon(Math.PI / 2) : icon(letter === 'A' || letter === 'C' ? svg('circle', {r: 4, fill: letter === 'A' ? '#9aa0a6' : 'none', stroke: '#9aa0a6', 'stroke-width': 2})
  : letter === 'appearances' ? svg('circle', {r: 1.8, fill: '#9aa0a6'}) : svg('rect', {x: -3.6, y: -3.6, width: 7.2, height: 7.2, fill: 'none', stroke: '#9aa0a6', 'stroke-width': 2, 'stroke-opacity': letter === 'B' ? 0.5 : 1}));
