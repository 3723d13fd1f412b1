// The image with its overlay: outlines, appearances, circles and squares. Marks keep their size on the screen.
const W = doc.camera.width || 640, H = doc.camera.height || 480;
const IMAGE = address(doc.assets.image);
const canvasSvg = svg('svg', {viewBox: `-0.5 -0.5 ${W} ${H}`, role: 'group', 'aria-label': 'The image with what was detected and what was expected. Arrow keys go from mark to mark.'});
// Names stand above the dots of a photo.
const over = svg('svg', {viewBox: canvasSvg.getAttribute('viewBox'), class: 'over', 'aria-hidden': 'true'});
let marks = [], focusable = 0;

function mark(uv, parts, tell, key) {
  const g = svg('g', {class: 'mark', tabindex: -1, role: 'img', 'aria-label': tell.join(' '), 'data-key': key.join(' ')}, parts, svg('circle', {class: 'halo', r: 11}));
  const choose = () => { state.chosen = {key, tell}; changed('chosen'); };
  g.addEventListener('pointerenter', choose);
  g.addEventListener('focus', choose);
  g.addEventListener('click', choose);
  marks.push({g, uv});
  return g;
}

const featureTell = (h, f, letter) => [`${f.id}`, `of ${called(h.id)}, ${named(f.type)}, case ${letter}.`, reason(h, f)];
function featureMark({h, f, expected, detected, letter}) {
  if (!letter || !state.layers.has(expected ? 'expected' : 'hidden')) return null;
  const g = mark(f.uv, glyph(expected, detected, colour(h.id)), featureTell(h, f, letter), [h.id, f.id]);
  g.setAttribute('data-case', letter);
  return g;
}

function appearanceTell(a) {
  const cause = claimant(a.id), raw = state.shown.causes ? state.shown.causes[a.id] || doc.causes_else : null;
  const because = cause ? `Explained by ${cause.f ? cause.f.id : 'a feature'} of ${called(cause.h.id)}.`
    : raw === 'noise' ? 'Noise in this world: no object explains it.' : raw ? `Explained by ${raw}.` : 'Nothing here explains it.';
  const score = a.score != null ? `, score ${fixed(a.score, 2)}` : '';
  return [`${a.id}`, `${named(a.type)}, found by ${a.detector || 'a detector'}${score}.`, because];
}
const appearanceMark = (a) => mark(a.uv, [svg('circle', {r: 5, fill: 'transparent'}), ...sign(a.type)], appearanceTell(a), [a.id]);

function outline(h, faint) {
  const d = list(h.outline).map((ring) => 'M' + ring.map((p) => p.map(Number).join(',')).join('L') + 'Z').join('');
  const line = (extra) => svg('path', {d, fill: 'none', 'stroke-linejoin': 'round', 'vector-effect': 'non-scaling-stroke', ...extra});
  return svg('g', {class: 'outline'}, line({stroke: '#14171a', 'stroke-opacity': 0.45, 'stroke-width': 4.5}), line({stroke: colour(h.id), 'stroke-width': 2.2, 'stroke-dasharray': faint ? '5 4' : null}));
}

// Names go above the outlines, moved down until they are clear of each other.
function names(shown, k) {
  const placed = [];
  return shown.map((h) => {
    const points = list(h.outline).flat(), text = `${label(h.id)} ${h.id}${crowded && h.status === 'accepted' && h.probability != null ? ' ' + chance(h.probability) : ''}`, half = text.length * 4.3 * k;
    if (!points.length) return null;
    const us = points.map((p) => p[0]), u = Math.max(half + 4, Math.min(W - half - 4, (Math.min(...us) + Math.max(...us)) / 2));
    let v = Math.max(16 * k, Math.min(...points.map((p) => p[1])) - 16 * k);
    while (placed.some((q) => Math.abs(q.u - u) < q.half + half && Math.abs(q.v - v) < 17 * k)) v += (v > 34 * k ? -17 : 40) * k;
    placed.push({u, v, half});
    return svg('text', {class: 'name', 'text-anchor': 'middle', transform: `translate(${u} ${v}) scale(${k})`}, text);
  });
}

const pixel = () => W / (canvasSvg.getBoundingClientRect().width || W);

function drawPicture() {
  const shown = standing(state.shown), on = (l) => state.layers.has(l);
  marks = [];
  const rows = shown.flatMap((h) => list(h.features).map((f) => ({h, f, ...caseOf(h, f)})));
  const order = (wanted) => crowded ? [] : rows.filter((r) => r.expected === wanted).map(featureMark);
  fill(canvasSvg,
    IMAGE ? svg('image', {href: IMAGE, x: -0.5, y: -0.5, width: W, height: H, preserveAspectRatio: 'none'}) : svg('rect', {x: -0.5, y: -0.5, width: W, height: H, fill: '#c9c7c0'}),
    on('outlines') ? shown.map((h) => outline(h)) : [], svg('g', {id: 'squares'}, order(false)), svg('g', {id: 'circles'}, order(true)),
    svg('g', {id: 'signs'}, on('appearances') && !crowded ? appearances.map(appearanceMark) : []),
    svg('g', {id: 'hint'}), svg('g', {id: 'names'}, on('labels') ? names(shown, pixel()) : []));
  if (crowded) over.replaceChildren(canvasSvg.lastChild);
  focusable = Math.min(focusable, Math.max(0, marks.length - 1));
  if (marks.length) marks[focusable].g.setAttribute('tabindex', 0);
  resizeMarks();
  if (crowded) gatherDots(rows);
  paintDots();
  showChosen();
  countCases(rows);
}

// The outline of a hypothesis that is not shown, while a reader points at its row.
function hint(id) {
  const h = byId.get(id), layer = canvasSvg.querySelector('#hint');
  if (layer) fill(layer, h ? [outline(h, true), names([h], pixel())] : []);
}

function resizeMarks() {
  paintDots();
  const k = pixel(), small = k * (innerWidth < 560 ? 0.72 : 1);
  for (const m of marks) m.g.setAttribute('transform', `translate(${Number(m.uv[0])} ${Number(m.uv[1])}) scale(${small})`);
  const layer = at('picture').querySelector('#names');
  if (layer && state.layers.has('labels')) fill(layer, names(standing(state.shown), k));
}

function showChosen() {
  const c = state.chosen, key = c && c.key.join(' ');
  marks.forEach((m) => m.g.classList.toggle('on', m.g.dataset.key === key));
  if (c) put('about', el('b', null, c.tell[0]), ' ', c.tell.slice(1).join(' '));
  else put('about', tag('id', 'Point at a mark, or walk through them with the arrow keys, to read what it is and why.'));
}

const CASES = [['A', 1, 1, 'Found', 'expected, detected'], ['B', 0, 0, 'Rightly unseen', 'neither'],
  ['C', 1, 0, 'Missed', 'expected, not detected'], ['D', 0, 1, 'Unexpected', 'detected, not expected']];
function countCases(rows) {
  put('cases', CASES.map(([letter, expected, detected, name, means]) => {
    const mine = rows.filter((r) => r.letter === letter), sides = expected ? mine.filter((r) => isSide(r.f)).length : 0;
    return el('div', {'data-case': letter}, crowded ? dotIcon(letter) : icon(glyph(expected, detected, MUTED)), el('dt', null, tag('id', letter), ' ' + name),
      el('dd', null, String(mine.reduce((n, r) => n + (r.f.stands_for ?? 1), 0))),
      el('small', null, means, sides ? el('span', {class: 'sides', 'data-sides': letter}, sideIcon(detected ? Math.PI / 2 : null), plural(sides, SIDE, 'sides of edges')) : null));
  }));
}

// One mark on or back, by an arrow key; 0 for any other key.
function stepOf(event, possible) {
  const step = possible && {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key] || 0;
  if (step) event.preventDefault();
  return step;
}
function walk(event) {
  const here = marks.findIndex((m) => m.g === event.target), step = stepOf(event, here >= 0);
  if (!step) return;
  marks[here].g.setAttribute('tabindex', -1);
  focusable = (here + step + marks.length) % marks.length;
  marks[focusable].g.setAttribute('tabindex', 0);
  marks[focusable].g.focus();
}

const icon = (...parts) => svg('svg', {viewBox: '-10 -10 20 20', width: 20, height: 20, 'aria-hidden': 'true'}, parts);
const LAYERS = [['appearances', 'Appearances'], ['expected', 'Expected', true], ['hidden', 'Not expected', false], ['outlines', 'Outlines'], ['labels', 'Names']];
const layer = (name, shown, text) => toggle(name, shown, text, (on) => { state.layers[on ? 'add' : 'delete'](name); changed('layers'); });
function startPicture() {
  put('picture', canvasSvg);
  startDots();
  if (crowded) put('layers', [...DOTS.map(([name, text, on]) => layer(name, on, [dotIcon(name), text])), ...LAYERS.slice(3).map(([name, text]) => layer(name, true, [text]))]);
  else put('layers', LAYERS.map(([name, text, form]) => layer(name, true, [form == null ? null : icon(glyph(form, true, MUTED)), text])));
  put('signs-key', kinds.map((k) => el('li', null, crowded ? dotIcon(k === SIDE ? 'sides' : 'appearances') : icon(sign(k)), words(k), crowded ? tag('id', ` ${appearances.filter((a) => plain(a.type) === k).length}`) : null)));
  canvasSvg.addEventListener('keydown', walk);
  new ResizeObserver(resizeMarks).observe(canvasSvg);
  watchers.push((what) => (what === 'chosen' ? showChosen() : drawPicture()));
}
