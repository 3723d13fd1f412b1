// The edges of a hypothesis in the picture: outline and creases, in runs that the shown world hides or not.
// A run is [whether it is a crease, whether its own object hides it, who else may hide it, u, v, u, v, ...].
const edges = block('edges');
const runs = (h) => (Object.hasOwn(edges, h.id) ? edges[h.id] : []);
const unseen = (h, [, own, by]) => Boolean(own && h.opaque !== false) || by.some((g) => hides(g, h));
const pathOf = (some) => some.map((run) => 'M' + run.slice(3).join(' ')).join('');
const ends = (run) => run.slice(3).reduce((points, x, i) => (i % 2 ? (points[points.length - 1].push(x), points) : [...points, [x]]), []);

const DASHES = {seen: null, unseen: '6 4.5', hint: '0.1 5'};
function line(d, c, inner, how) {
  const dashed = {'stroke-dasharray': DASHES[how], 'stroke-linecap': how === 'hint' ? 'round' : null}, wide = inner ? 1.3 : how === 'unseen' ? 1.8 : 2.2;
  const one = (extra) => svg('path', {d, fill: 'none', 'stroke-linejoin': 'round', 'vector-effect': 'non-scaling-stroke', ...dashed, ...extra});
  return [one({stroke: '#14171a', 'stroke-opacity': 0.45, 'stroke-width': wide * 2 + (how === 'hint' ? 1 : 0)}), one({stroke: c, 'stroke-width': how === 'hint' ? 3 : wide})];
}
// The seen ones, 'outline', or the others, 'unseen'.
function edgesOf(h, how) {
  const mine = runs(h).filter((run) => unseen(h, run) === (how === 'unseen'));
  return mine.length ? svg('g', {class: how === 'unseen' ? 'unseen' : 'outline'}, [1, 0].map((inner) => mine.filter((run) => run[0] === inner))
    .map((some, i) => (some.length ? line(pathOf(some), colour(h.id), i === 0, how === 'unseen' ? how : 'seen') : []))) : null;
}
// Where few features are found of what was in learning: rings by hypothesis, of the world of those that are accepted. Beside other hiders others are missed.
const missed = block('missed');
const missedOf = (h) => (Object.hasOwn(missed, h.id) && list(h.features).every((f) => list(f.hidden_by).every((g) => (byId.get(g) || {}).status !== 'accepted' || state.shown.present.includes(g))) ? missed[h.id] : []);
function hatch(h) {
  const rings = missedOf(h), name = 'hatch-' + hypotheses.indexOf(h), c = colour(h.id);
  const lines = (extra) => svg('path', {d: 'M-1,1L1,-1M0,5L5,0M4,6L6,4', fill: 'none', ...extra});
  return rings.length ? svg('g', {class: 'missed'}, svg('pattern', {id: name, width: 5, height: 5, patternUnits: 'userSpaceOnUse'}, lines({stroke: '#14171a', 'stroke-width': 1.7}), lines({stroke: c, 'stroke-width': 0.9})),
    svg('path', {d: rings.map((r) => 'M' + r.join(' ') + 'Z').join(''), fill: `url(#${name})`, 'fill-rule': 'evenodd'})) : null;
}
const hinted = (h) => svg('g', {class: 'outline'}, line(pathOf(runs(h).filter((run) => !run[0])), colour(h.id), false, 'hint'));
