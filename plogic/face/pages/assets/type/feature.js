// The feature that is shown: what it is, how surely it is seen, and its lobes one by one.
const span = (a, b) => { const [x, y] = [a, b].map((d) => metres(d, 2)), [s, t] = [x, y].map((d) => d.split(' ')); return s[1] && s[1] !== t[1] ? `${x} \u2013 ${y}` : `${s[0]}\u2013${y}`; };
const place = (p) => '[' + p.map((x) => round(x + 0)).join(', ') + '] m';
const lobeHit = (l, t) => (lobe.hit ? lobe.hit[l] : t.hit).toFixed(2);
function lobeRow(l, t, v) {
  const held = holds(l, v), b = button('', () => { state.alone = state.alone === l ? -1 : l; changed('chosen'); }, {'aria-pressed': String(state.alone === l), 'data-lobe': l, title: 'Show this lobe alone'});
  b.append(swatch(css(lobeColour(l))), tag(null, words(LOOKS[lobe.look[l]])));
  const cells = [degrees(lobe.half[l]), span(lobe.near[l], lobe.far[l]), lobeHit(l, t), held ? 'yes' : 'no'];
  return el('tr', {class: [held ? null : 'away', state.alone === l ? 'on' : null].filter(Boolean).join(' ') || null}, el('th', {scope: 'row'}, b), cells.map((c) => el('td', null, c)));
}

function lobeTable(f, t) {
  const v = viewpoint(), rows = [];
  for (let l = first[f]; l < first[f + 1]; l++) rows.push(lobeRow(l, t, v));
  if (!rows.length) return el('p', {class: 'none'}, 'It has no lobe, so it is never expected.');
  const heads = ['Looks like', 'angle', 'range', 'hit', 'here'].map((h, i) => el('th', {scope: 'col', class: i ? 'n' : null}, h));
  return el('div', {class: 'scroll lobes', tabindex: 0, role: 'region', 'aria-label': 'Its lobes'}, el('table', null, el('thead', null, el('tr', null, heads)), el('tbody', null, rows)));
}

function drawFeature() {
  const f = shown();
  if (f < 0) return put('about', el('p', {class: 'none'}, 'Point at a feature to see its lobes; click it to keep it, click beside it or press Escape to let it go. The buttons and the keys n and p go through the lit ones.'));
  const t = TYPES[feature.type[f]], names = [], at3 = three(feature.at, f);
  for (let p = feature.part[f]; p != null; p = PARTS[p].under) names.unshift(PARTS[p].name);
  const facts = [['Type', [swatch(css(colours[feature.type[f]])), `${named(feature.type[f])}, dv ${dvText(t)}`]], ['Part', names.join(' / ')], ['Place', place(at3)],
    ['Sigma', feature.sigma ? `${metres(feature.sigma[f])} along one axis` : `${round(t.sigma)} px in an image (the place is exact as written)`],
    ['Hit rate', feature.sigma ? 'measured for each lobe' : `${t.hit.toFixed(2)} of its type`], ['In the KB', `${t.all} of this type, ${t.here} here`]];
  const scroll = document.activeElement && document.activeElement.dataset.lobe;
  put('about', el('p', {class: 'about-name'}, feature.names[f]), el('dl', {class: 'facts'}, facts.map(([k, v]) => [el('dt', null, k), el('dd', null, v)])), lobeTable(f, t));
  const again = scroll != null && at('about').querySelector(`[data-lobe="${Number(scroll)}"]`);
  if (again) again.focus();
}

// Goes to the next lit feature that the surface does not hide.
function walk(step) {
  for (let k = 1, f = state.pinned < 0 && step < 0 ? 0 : state.pinned; k <= COUNT; k++) {
    f = (f + step + COUNT) % COUNT;
    if (bright(f) && !(state.surface && hidden(three(feature.at, f)))) return pin(f);
  }
}
function pin(f) {
  Object.assign(state, {pinned: f, pointed: -1, alone: -1});
  changed('chosen');
}
function startFeature() {
  put('chosen-bar', button('Previous', () => walk(-1), {'data-walk': -1}), button('Next', () => walk(1), {'data-walk': 1}), button('Let go', () => pin(-1)));
  watchers.push((what) => { if (what !== 'only') drawFeature(); });
}
