// The image with its overlay: outlines, appearances, circles and squares. Marks keep their size on the screen.
const W = doc.camera.width || 640, H = doc.camera.height || 480;
const IMAGE = address(doc.assets.image);
const canvasSvg = svg('svg', {viewBox: `-0.5 -0.5 ${W} ${H}`, role: 'application', 'aria-label': 'The image with what was detected and what was expected. Arrow keys go from mark to mark.'});
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

// Names go above the outlines, moved until they are clear of each other.
function names(shown, k) {
  const placed = [];
  return shown.map((h) => {
    const points = runs(h).flatMap(ends), after = ` ${h.id}${crowded && h.status === 'accepted' && h.probability != null ? ' ' + chance(h.probability) : ''}`;
    const room = Math.max(3, Math.floor((W / k - 8) / 8.6) - after.length), name = label(h.id), text = (name.length > room ? name.slice(0, room - 1) + '\u2026' : name) + after, half = text.length * 4.3 * k;
    if (!points.length) return null;
    const us = points.map((p) => p[0]), u = Math.max(half + 4, Math.min(W - half - 4, (Math.min(...us) + Math.max(...us)) / 2));
    const first = Math.max(16 * k, Math.min(...points.map((p) => p[1])) - 16 * k), clear = (v) => !placed.some((q) => Math.abs(q.u - u) < q.half + half && Math.abs(q.v - v) < 16.9 * k);
    const rows = shown.flatMap((_, i) => [first - 17 * i * k, first + 17 * i * k]).filter((v) => v >= 16 * k), v = rows.find(clear) ?? first;
    placed.push({u, v, half});
    return svg('text', {class: 'name', 'text-anchor': 'middle', transform: `translate(${u} ${v}) scale(${k})`}, text);
  });
}

const pixel = () => W / (canvasSvg.getBoundingClientRect().width || W);

function drawPicture() {
  const shown = standing(state.shown), on = (l) => state.layers.has(l);
  marks = [];
  const rows = shown.flatMap((h) => list(h.features).map((f) => ({h, f, ...caseOf(h, f)})));
  const full = on('marks') && !crowded, order = (wanted) => (full ? rows.filter((r) => r.expected === wanted).map(featureMark) : []);
  fill(canvasSvg,
    IMAGE ? svg('image', {href: IMAGE, x: -0.5, y: -0.5, width: W, height: H, preserveAspectRatio: 'none'}) : svg('rect', {x: -0.5, y: -0.5, width: W, height: H, fill: '#83868a'}),
    on('ground') && laid() ? gridDrawn(shown) : [], on('missed') ? shown.map(hatch) : [], on('unseen') ? shown.map((h) => edgesOf(h, 'unseen')) : [], on('outlines') ? shown.map((h) => edgesOf(h, 'outline')) : [], on('ground') && laid() ? feetDrawn(shown) : [], svg('g', {id: 'squares'}, order(false)), svg('g', {id: 'circles'}, order(true)),
    svg('g', {id: 'signs'}, full && on('appearances') ? appearances.map(appearanceMark) : []),
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
  const h = byId.get(id), layer = canvasSvg.querySelector('#hint'), shown = standing(state.shown);
  if (layer) fill(layer, h && !shown.includes(h) ? [hinted(h), names([...shown, h], pixel()).slice(-1)] : []);
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
  else put('about', state.shown.alone ? state.shown.title + ' ' : null, tag('id', state.layers.has('marks') ? 'Point at a mark, or walk through them with the arrow keys, to read what it is and why.'
    : `${plural(BUSY, 'mark')} are left out, so that the objects are seen. \u201cMarks\u201d draws them.`));
}

const CASES = [['A', 1, 1, 'Found', 'expected, detected'], ['B', 0, 0, 'Rightly unseen', 'neither'],
  ['C', 1, 0, 'Missed', 'expected, not detected'], ['D', 0, 1, 'Unexpected', 'detected, not expected']];
// Of a hypothesis whose features were not kept the counts are those of its trial.
function countCases(rows) {
  const [a, c, b, d] = rows.length || !state.shown.alone ? [] : cellSums(byId.get(state.shown.alone)), triedAlone = a == null ? null : {A: a, B: b, C: c, D: d};
  put('cases', CASES.map(([letter, expected, detected, name, means]) => {
    const mine = rows.filter((r) => r.letter === letter), of = triedAlone ? triedAlone[letter] : mine.reduce((n, r) => n + (r.f.stands_for ?? 1), 0), sides = expected ? mine.filter((r) => isSide(r.f)).length : 0;
    return el('div', {'data-case': letter}, crowded ? dotIcon(letter) : icon(glyph(expected, detected, MUTED)), el('dt', null, tag('id', letter), ' ' + name),
      el('dd', null, String(of)),
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
const LAYERS = [['appearances', 'Appearances'], ['expected', 'Expected', true], ['hidden', 'Not expected', false]], PLAIN_LAYERS = [...(Object.keys(missed).length ? [['missed', 'Where features are missed']] : []), ['outlines', 'Edges'], ['unseen', 'Hidden edges'], ...(ground ? [['ground', 'Support plane']] : []), ['labels', 'Names']];
const layer = (name, text) => toggle(name, state.layers.has(name), text, (on) => { state.layers[on ? 'add' : 'delete'](name); changed('layers'); });
// So many marks, or any of a learned type, which has hundreds on a few pixels, cover what they are about: they are drawn when asked for.
const MANY = 200;
const BUSY = (() => {
  const rows = standing(worlds[0]).flatMap((h) => list(h.features).map((f) => [f, caseOf(h, f).letter]));
  const n = crowded ? rows.filter(([f, letter]) => 'ACD'.includes(letter || '-') && !(f.stands_for > 1)).length : appearances.length + rows.filter(([, letter]) => letter).length;
  return n > MANY || rows.some(([f]) => f.learned_rate != null) ? n : 0;
})();
function startPicture() {
  put('picture', canvasSvg);
  startDots();
  if (BUSY) state.layers.delete('marks');
  const kinds = crowded ? DOTS.map(([name, text]) => layer(name, [dotIcon(name), text])) : LAYERS.map(([name, text, form]) => layer(name, [form == null ? null : icon(glyph(form, true, MUTED)), text]));
  const show = () => kinds.forEach((k) => { k.hidden = !state.layers.has('marks'); });
  put('layers', BUSY ? layer('marks', ['Marks', tag('id', String(BUSY))]) : null, kinds, PLAIN_LAYERS.map(([name, text]) => layer(name, [text])));
  show();
  canvasSvg.addEventListener('keydown', walk);
  new ResizeObserver(resizeMarks).observe(canvasSvg);
  watchers.push((what) => { show(); if (what === 'chosen') showChosen(); else drawPicture(); });
}
