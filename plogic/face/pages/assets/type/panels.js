// Words around the picture: the head, the tree of parts with counts and dv, the legend, the limits.
const MANY = 12;
const DIGITS = COMMON > 0.98 && COMMON < 1 ? 5 : 3, dvText = (t) => t.dv.toFixed(DIGITS);
const same = (a, b) => Boolean(a && b) && a.part === b.part && a.type === b.type;
function choose(only) {
  state.only = same(state.only, only) ? null : only;
  for (const b of at('tree').querySelectorAll('button[aria-pressed]')) b.setAttribute('aria-pressed', String(Boolean(state.only) && b.dataset.key === keyOf(state.only)));
  changed('only');
}
const keyOf = (only) => `${only.part} ${only.type}`;
const row = (only, cls, ...cells) => button('', () => choose(only), {class: cls, 'aria-pressed': 'false', 'data-key': keyOf(only)}).appendChild(tag(null, cells[0])).parentNode;

function treeRow(only, cls, name, count, dv) {
  const b = row(only, cls, name);
  b.append(tag(null, String(count)), tag(null, dv));
  b.setAttribute('title', cls === 'part' ? 'features of this part and of its parts' : 'features of this type in this part');
  return b;
}

function total(part) {
  return PARTS.reduce((sum, p, i) => (within(i, part) ? sum + p.counts.reduce((s, [, n]) => s + n, 0) : sum), 0);
}
function branch(i) {
  const part = PARTS[i], n = total(i), kinds = part.counts.slice().sort(([a, m], [b, k]) => TYPES[b].dv - TYPES[a].dv || k - m);
  const under = PARTS.map((p, k) => k).filter((k) => PARTS[k].under === i);
  const inside = PARTS.flatMap((p, k) => (within(k, i) ? p.counts.map(([t]) => TYPES[t].dv) : []));
  const dvs = inside.length ? [Math.min(...inside), Math.max(...inside)].map((dv) => dv.toFixed(DIGITS - 1)) : [];
  const leaf = ([t, k]) => el('li', null, treeRow({part: i, type: t}, 'kind', [swatch(css(colours[t])), named(t)], k, 'dv ' + dvText(TYPES[t])));
  const list = el('ul', null, kinds.slice(0, MANY).map(leaf));
  if (kinds.length > MANY) {
    const more = el('li', null, button(`Show all ${kinds.length} feature types`, () => {
      more.replaceWith(...kinds.slice(MANY).map(leaf));
      list.children[MANY].querySelector('button').focus();
    }, {class: 'more'}));
    list.append(more);
  }
  return el('li', null, treeRow({part: i, type: null}, 'part', part.name, n, dvs.length ? (dvs[0] === dvs[1] ? 'dv ' + dvs[0] : dvs.join('\u2013')) : ''), kinds.length ? list : null, under.length ? el('ul', null, under.map(branch)) : null);
}

function drawLegend() {
  if (!TYPES.length) return;
  const strip = el('canvas', {width: 256, height: 1, 'aria-hidden': 'true'}), g = strip.getContext('2d');
  for (let i = 0; i < 256; i++) { g.fillStyle = css(ramp(i / 255)); g.fillRect(i, 0, 1, 1); }
  const ends = RARE > COMMON ? [`${COMMON.toFixed(DIGITS)} common`, `${RARE.toFixed(DIGITS)} rare`] : ['', `${RARE.toFixed(DIGITS)}, of every type here`];
  put('legend', tag(null, 'Colour: dv'), strip, tag('ends', ends.map((e) => tag(null, e))),
    ...[['Grey point', 'not lit: of another part or type, or not seen from here'], ['Ringed point', 'the feature that is shown'], ['Cone', 'a lobe, from where that feature is seen: coloured as what it looks like is in the list of its lobes, strong where it holds the viewpoint']].flatMap((row) => row.map((text) => tag(null, text))),
    ...(SIDES ? [tag(null, 'T-shaped mark'), tag(null, 'the side of an edge: a stroke along the edge, a tick towards the side')] : []));
}

function drawStands() {
  put('standing-key', doc.stands.said);
  put('stands', doc.stands.faces.map(({said, picture}) => el('figure', null, el('img', {src: address(picture), alt: said}), el('figcaption', null, said))));
}

function startPanels() {
  const all = total(0), made = doc.type.detector ? `learned with ${doc.type.detector}` : all ? 'written by hand' : 'its features are still to be written or learned';
  head(`an object type of the knowledge base \u201c${doc.kb.name}\u201d`, doc.type.name,
    doc.lines.length ? doc.lines.map((l) => l.charAt(0).toUpperCase() + l.slice(1) + '. ') : `${plural(all, 'feature')} of ${plural(TYPES.length, 'type')}, ${plural(PARTS.length - 1, 'part')}, ${plural(doc.lobes.of, 'lobe')}; ${made}.`);
  put('tree', el('ul', null, PARTS.map((p, i) => i).filter((i) => PARTS[i].under == null).map(branch)));
  drawLegend();
  drawStands();
  const notes = [`A feature is seen from here where one of its lobes holds the viewpoint; ranges hold for a focal length of ${round(doc.kb.f_ref)} px. Whether the surface hides it is another matter, and is counted only where the mesh is small.`,
    `Lobes are drawn up to ${metres(CUT)}, and begin no farther than 30 % of that, so that they fit the picture; their whole ranges stand in the list.`,
    doc.features.of < all ? 'A compound feature is one point, and its parts are counted in the tree only.' : null, ...doc.notes];
  put('notes', notes.filter(Boolean).map((n) => el('li', null, n)));
  foot(`the knowledge base ${doc.kb.name}`, doc.kb.digest);
}
