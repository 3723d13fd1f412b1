// Everything that is words and numbers.
const listed = (b) => el('li', {class: 'fold'}, b);
const across = (n) => (b) => el('tr', null, el('td', {colspan: n, class: 'fold'}, b));
const boxed = (b) => el('div', null, b);
const none = (text) => el('p', {class: 'none'}, text);
const present = (world) => (world.present.length ? world.present.map(who) : [tag(null, 'Nothing that the knowledge base knows')]);

function show(world) {
  state.shown = world;
  state.chosen = null;
  changed('world');
}

function worldRow(world, i) {
  const b = button('', () => show(world), {'aria-pressed': String(state.shown === world), 'data-world': i});
  b.append(tag('p', chance(world.probability)), tag(null, present(world)), bar(world.probability));
  return el('li', null, b);
}

function drawWorlds() {
  const [low = 0, high = 0] = list(doc.unlisted_mass);
  const mass = high - low < 0.0005 ? chance(high) : `${chance(low)} to ${chance(high)}`;
  const rest = high > 0 ? el('li', {class: 'rest'}, tag(null, (high < 0.0005 ? '' : '\u2264') + chance(high)), el('span', {title: mass}, 'not listed'), bar(high)) : null;
  const active = document.activeElement && document.activeElement.dataset.world;
  put('world-list', [...fold(worlds.map(worldRow), 8, 'worlds', listed), rest].filter(Boolean));
  if (active != null) at('world-list').querySelector(`[data-world="${Number(active)}"]`).focus();
  drawCauses();
}

// How many appearances each object explains in the shown world, as one stacked bar with its key.
function drawCauses() {
  const world = state.shown, causes = appearances.map((a) => claimant(a.id)).filter(Boolean);
  const rows = world.present.map((id) => [who(id), causes.filter((c) => c.h.id === id).length, colour(id)]);
  const explained = causes.length, left = appearances.length - explained;
  if (world.alone) return put('world', el('p', null, world.title), button('Back to the worlds', () => { show(world.before); (at('world-list').querySelector('[aria-pressed=true]') || at('worlds')).focus(); }, {'data-back': ''}));
  if (!world.causes) return put('world', el('p', null, world.title));
  const stack = el('div', {class: 'stack', 'aria-hidden': 'true'}, [...rows, [null, left, 'transparent']].map(([, n, c]) => {
    const i = el('i');
    i.style.flexGrow = n;
    i.style.background = c;
    return i;
  }));
  put('world', el('p', null, `${explained} of ${plural(appearances.length, 'appearance')} explained`), stack,
    el('ul', {class: 'key'}, rows.map(([w, n]) => el('li', null, w, tag(null, String(n)))), el('li', null, tag(null, swatch('var(--line)'), 'noise'), tag(null, String(left)))));
}

const sentence = (s) => (/^[a-z]+\d/.test(s) ? String(s) : String(s).charAt(0).toUpperCase() + String(s).slice(1)).replace(/\.?$/, '.');
const cellSums = (h) => Object.values(h.support || {}).map(numbers).reduce((sum, row) => sum.map((n, i) => n + row[i]), [0, 0, 0, 0]);
const EVENT = {rank: 'Ranked', accept: 'Accepted', reject: 'Rejected', release: 'Released', reconsider: 'Reconsidered', smooth: 'Smoothed', stable: 'Stable',
  deepen: 'Looked deeper', move: 'Moved', support: 'Supported', deadline: 'Out of time', recall: 'Remembered', search: 'Searched', 'no search': 'No search'};
// Of a learned type: how many of the features that it expects by itself were found when it was learned.
function usual(h) {
  const some = list(h.features).filter((f) => f.learned_rate != null && !(f.stands_for !== undefined && f.stands_for !== 1) && f.in_image && f.in_lobe && !(f.self_hidden && h.opaque !== false));
  return some.length ? ` When its type was learned, ${Math.round(some.reduce((sum, f) => sum + f.learned_rate, 0))} of these were found from there: most visual words come and go from picture to picture.` : '';
}
function card(h, number) {
  const look = () => {
    if (state.shown.alone === h.id) return show(state.shown.before);
    show({present: [h.id], causes: null, alone: h.id, before: state.shown.before || state.shown, title: `Only ${called(h.id)} is shown, as it was tried.${h.status === 'rejected' ? ' It is in no world.' : ''}`});
    at('view').scrollIntoView({block: 'start'});
  };
  const [a, c, , d] = cellSums(h), box = el('div', {class: 'why'}, el('p', {class: 'top'}, who(h.id), number), el('p', null, `By itself: of ${plural(a + c, 'expected feature')} ${a} found, ${c} missed${d ? `; ${d} more found that it does not expect` : ''}.${usual(h)}`),
    h.why ? el('p', null, sentence(h.why)) : null, list(h.apart).map((t) => el('p', null, t)), h.status === 'accepted' ? null : button('Show it alone', look, {'data-alone': h.id, 'aria-pressed': 'false', 'aria-label': `Show ${called(h.id)} alone`}));
  if (h.status !== 'accepted') for (const [event, id] of [['pointerenter', h.id], ['pointerleave', null], ['focusin', h.id], ['focusout', null]]) box.addEventListener(event, () => hint(id));
  return box;
}
function drawHypotheses() {
  const number = (h) => tag('p', chance(h.probability));
  const yes = hypotheses.filter((h) => h.status === 'accepted'), no = hypotheses.filter((h) => h.status !== 'accepted');
  put('believed', yes.length ? yes.map((h) => card(h, number(h))) : none('None was accepted.'));
  put('rejected', no.length ? fold(no.map((h) => card(h, tag('p id', h.status === 'rival' ? `rival, ${chance(h.probability)}` : 'rejected'))), 4, 'that were not accepted', boxed) : none('Nothing was tried in vain.'));
  const once = (r, i, all) => r.probability >= 0.0005 && !(/^(non|mutually)_/.test(r.relation) && all.slice(0, i).some((q) => q.relation === r.relation && q.args[0] === r.args[1] && q.args[1] === r.args[0]));
  const related = list(doc.relations).filter(once);
  put('relations', related.length ? fold(related.map((r) => el('div', {class: 'why'}, el('p', {class: 'top'},
    tag(null, who(r.args[0]), tag('id', words(r.relation) + ' '), r.args.slice(1).map(who)), tag('p', chance(r.probability))))), 6, 'relations', boxed) : none('No two objects to relate.'),
    ...list(doc.doubts).map((d) => el('p', null, `Doubtful: ${d.expected}, but ${d.found}. ${sentence(d.why)}`)));
}

// The planes that things may stand on, likeliest first, who stands there, who on whom, and who on nothing known.
function drawStanding() {
  const told = (p) => p >= 0.0005, planes = list(doc.support_planes), chances = planes.map((s) => s.probability), other = 1 - chances.reduce((a, b) => a + b, 0);
  const on = (name) => hypotheses.map((h) => [h.id, list(h.stances).filter((s) => s.on === name).reduce((sum, s) => sum + s.probability, 0)]);
  const group = (title, p, who_stands) => el('div', {class: 'why'}, el('p', {class: 'top'}, tag(null, title), p == null ? null : tag('p', chance(p))),
    el('ul', {class: 'key'}, who_stands.filter(([, q]) => told(q)).map(([id, q]) => el('li', null, who(id), tag(null, chance(q))))));
  const place = ({normal, offset}) => `${fixed(-offset, 2)} m below the camera, at ${fixed(Math.asin(Math.min(1, Math.abs(normal[2]))) * 180 / Math.PI, 0)}\u00b0 to its line of sight`;
  const some = (title, rows) => (rows.some(([, q]) => told(q)) ? group(title, null, rows) : []);
  if (planes.length) put('standing', el('h3', null, 'What they stand on'), el('div', null,
    planes.filter((s) => told(s.probability)).sort((a, b) => b.probability - a.probability).map((s) => group([`Plane ${s.name} `, tag('id', place(s.plane))], s.probability, on(s.name))),
    told(other) ? group('Another plane, or none', other, []) : [],
    hypotheses.map((h) => some(['On ', who(h.id)], on(h.id))), some('Free: on nothing known', hypotheses.map((h) => [h.id, h.free]))));
}

const numbers = (row) => [row.expected_detected, row.expected_missed, row.hidden_missed, row.hidden_detected].map((n) => n || 0);
function evBar(x) {
  if (x == null) return null;
  return svg('svg', {class: 'ev', width: 64, height: 10, viewBox: '-32 -5 64 10', 'aria-hidden': 'true'}, svg('rect', {x: -32, y: -3, width: 64, height: 6, rx: 3, fill: 'var(--fill)'}),
    svg('rect', {x: Math.min(0, 32 * x), y: -3, width: Math.abs(32 * x), height: 6, fill: x < 0 ? 'var(--bad)' : 'var(--mark)'}), svg('path', {d: 'M0,-5V5', stroke: 'var(--soft)'}));
}
function table(caption, heads, rows, names = 1) {
  const head = heads.map((h, i) => el('th', {scope: 'col', class: i >= names ? 'n' : null}, ...String(h).split('\n').flatMap((t, k) => (k ? [el('br'), t] : [t]))));
  return el('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': caption}, el('table', null, el('caption', null, tag(null, caption)), el('thead', null, el('tr', null, head)), rows));
}

const falling = (names, by = {}) => names.sort((a, b) => by[b] - by[a] || (a < b ? -1 : 1));
function supportRows(h) {
  const types = falling(Object.keys(h.support || {}), doc.measures.dv), rowspan = Math.max(1, types.length);
  const wide = (text, extra, cls) => el('td', {rowspan, class: cls}, text, extra);
  const tail = [wide(fixed(h.ev, 2)), wide(fixed(h.p_ev, 2)), wide(fixed(h.ev_reconsidered, 2), evBar(h.ev_reconsidered), 'strong')];
  return (types.length ? types : [null]).map((type, i) => el('tr', {class: i ? null : 'first'}, i ? null : el('th', {scope: 'rowgroup', rowspan}, who(h.id), el('br'), tag('id', h.status)),
    el('th', {scope: 'row'}, type == null ? '\u2013' : words(type)), numbers((h.support || {})[type] || {}).map((n, j) => el('td', {class: n ? (j % 2 ? 'c' : null) : 'zero'}, String(n))), i ? null : tail));
}
const measured = (name, ...values) => el('tr', null, el('th', {scope: 'row'}, name), values.map((x) => el('td', null, fixed(x, 3))));
function drawMeasures() {
  const heads = ['Hypothesis', 'Feature type', 'A  expected,\ndetected', 'C  expected,\nmissed', 'B  not expected,\nnot detected', 'D  not expected,\ndetected', 'ev', 'P(ev)', 'ev\nreconsidered'];
  put('support', hypotheses.length ? table('Support for each hypothesis', heads, fold(hypotheses.map((h) => el('tbody', null, supportRows(h))), 6, 'hypotheses', (b) => el('tbody', null, across(9)(b))), 2) : none('No hypothesis was made.'));
  const {dv = {}, p_dv: pdv = {}, rank = {}} = doc.measures, types = falling(Object.keys(dv), dv), ranked = falling(Object.keys(rank), rank);
  put('types', types.length ? table('How distinctive a feature type is', ['Feature type', 'dv', 'P(dv)'], el('tbody', null, fold(types.map((t) => measured(words(t), dv[t], pdv[t])), 14, 'feature types', across(3)))) : []);
  put('ranks', ranked.length ? table('What drew attention first', ['Object type', 'rank'], el('tbody', null, ranked.map((t) => measured(t, rank[t])))) : []);
}

function drawTrace() {
  put('steps', fold(list(doc.trace).map((s) => el('li', null, tag('n', String(s.step)), tag('event ' + (Object.hasOwn(EVENT, s.event) ? s.event : ''), Object.hasOwn(EVENT, s.event) ? EVENT[s.event] : String(s.event)),
    tag('subject', s.hypothesis != null ? who(s.hypothesis) : s.type != null ? String(s.type) : ''), tag('text', String(s.why || '')), tag('num', s.ev == null ? '' : fixed(s.ev, 2)))), 40, 'steps', listed));
  at('trace').hidden = !list(doc.trace).length;
}

function drawHead() {
  put('cautions', list(block('caveats')).map((text) => el('p', {class: 'hint'}, sentence(text))));
  const best = worlds[0], explained = appearances.filter((a) => claimant(a.id, best)).length;
  const text = and(best.present.map(label)) || 'Nothing known is in view';
  const mode = doc.reading === 'posterior' ? 'Posterior reading' : `Score reading, mode ${doc.reconsider || 'to_B'}`;
  head(`what one picture shows, by the knowledge base \u201c${doc.kb.name || ''}\u201d`, /^[a-z]{2,} /.test(text) ? text.charAt(0).toUpperCase() + text.slice(1) : text,
    `The most probable of ${plural(worlds.length, 'world')} has probability ${chance(best.probability)} and explains ${explained} of ${plural(appearances.length, 'appearance')}. ${mode}.${doc.unfinished ? ' Unfinished: more time may change all of this.' : ''}`);
  foot(`${doc.format || 'an interpretation'} and the knowledge base ${doc.kb.name || ''}`, doc.kb.digest);
}

function startPanels() {
  drawHead();
  drawHypotheses();
  drawStanding();
  drawMeasures();
  drawTrace();
  watchers.push((what) => {
    if (what !== 'world') return;
    drawWorlds();
    for (const b of at('rejected').querySelectorAll('[data-alone]')) b.setAttribute('aria-pressed', String(b.dataset.alone === state.shown.alone));
  });
}
