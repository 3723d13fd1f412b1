// What the lines, colours and signs of the picture mean: those that it has as it is shown.
const sample = (how, inner) => svg('svg', {viewBox: '0 -5 26 10', width: 26, height: 10, 'aria-hidden': 'true'}, line('M1 0H25', MUTED, inner, how)[1]);
function drawKey() {
  const on = (l) => state.layers.has(l), shown = standing(state.shown), some = (how) => shown.some((h) => runs(h).some((run) => unseen(h, run) === (how === 'unseen')));
  const entry = (sign, ...text) => el('li', null, sign, ...text), signs = on('marks') && (on('appearances') || crowded);
  put('signs-key', shown.map((h) => entry(swatch(colour(h.id)), `${label(h.id)} ${h.id}`)),
    on('outlines') && some('seen') ? entry(sample('seen'), 'edge') : null,
    on('unseen') && some('unseen') ? entry(sample('unseen'), 'edge hidden behind another object, or by its own') : null,
    on('missed') && shown.some((h) => missedOf(h).length) ? entry(icon(svg('path', {d: 'M-7 3L3 -7M-7 7L7 -7M-3 7L7 -3', stroke: MUTED, 'stroke-width': 1.6})), 'hatched: less than a third found of what was when it was learned') : null,
    on('ground') && laid() ? [entry(gridSign(), gridTold()), ...(shown.some(stands) ? [entry(icon(footForm()), 'foot of what stands there')] : [])] : null,
    hypotheses.some((h) => h.status !== 'accepted') ? entry(sample('hint'), 'not accepted, pointed at in the list') : null,
    on('marks') ? entry(icon(svg('circle', {r: 8, fill: 'none', stroke: 'currentColor', 'stroke-width': 2})), 'chosen mark') : null,
    signs ? kinds.map((k) => entry(crowded ? dotIcon(k === SIDE ? 'sides' : 'appearances') : icon(sign(k)[1]), words(k), crowded ? tag('id', ` ${appearances.filter((a) => plain(a.type) === k).length}`) : null)) : null);
}
function startKey() {
  watchers.push((what) => { if (what !== 'chosen') drawKey(); });
}
