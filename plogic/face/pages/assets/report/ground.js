// The likeliest plane that things stand on, null where none is likely: a grid where no object covers it, and feet.
const ground = block('ground'), plane = ground && list(doc.support_planes).find((s) => s.name === ground.name).plane;
// Whether the shown world has it, and which of its objects stand there.
const laid = () => Boolean(ground) && [undefined, ground.name].includes(state.shown.support);
const stands = (h) => laid() && Object.hasOwn(ground.feet, h.id) && (!state.shown.stances || String(state.shown.stances[h.id]).startsWith(ground.name + '/'));
const gridTold = () => `plane ${ground.name} that things stand on, a square is ${metric(ground.step)}`;
const gridSign = () => icon(svg('path', {d: 'M-8 -3H8M-8 3H8M-3 -8V8M3 -8V8', stroke: 'currentColor', 'stroke-opacity': 0.5}));
const footForm = (extra) => svg('path', {d: 'M-8 0A8 3.6 0 1 1 8 0A8 3.6 0 1 1 -8 0M-4.5 0H4.5M0 -2V2', fill: 'none', 'vector-effect': 'non-scaling-stroke', ...extra});
const CASING = {stroke: '#14171a', 'stroke-opacity': 0.6, 'stroke-width': 3.6};

function gridDrawn(shown) {
  const box = {x: -0.5, y: -0.5, width: W, height: H}, d = ground.drawn.map((l) => 'M' + l.join(' ')).join('');
  const stroke = (extra) => svg('path', {d, fill: 'none', 'vector-effect': 'non-scaling-stroke', ...extra});
  return [svg('mask', {id: 'bare', maskUnits: 'userSpaceOnUse', ...box}, svg('rect', {...box, fill: '#fff'}), shown.map((h) => svg('path', {d: list(h.outline).map((r) => 'M' + r.join(' ') + 'Z').join(''), 'fill-rule': 'evenodd'}))),
    svg('g', {class: 'ground', mask: 'url(#bare)'}, stroke({...CASING, 'stroke-opacity': 0.25, 'stroke-width': 2.4}), stroke({stroke: '#ebebeb', 'stroke-opacity': 0.6}))];
}
const feetDrawn = (shown) => svg('g', {class: 'feet'}, shown.filter(stands)
  .map((h) => svg('g', {transform: `translate(${ground.feet[h.id].join(' ')}) scale(${W / 640})`}, footForm(CASING), footForm({stroke: colour(h.id), 'stroke-width': 1.6}))));

// The outline of an object dropped onto the plane: the hull of its points there.
const footprints = new Map();
function footprint(h) {
  const x = unit(cross(plane.normal, AHEAD)), y = cross(plane.normal, x), turn = (a, b, p) => dot(plane.normal, cross(sub(b, a), sub(p, b)));
  const points = solid(h).points.map((p) => add(p, times(plane.normal, plane.offset - dot(p, plane.normal)))).sort((a, b) => dot(sub(a, b), x) || dot(sub(a, b), y));
  const half = (some) => some.reduce((hull, p) => { while (hull.length > 1 && turn(...hull.slice(-2), p) <= 0) hull.pop(); hull.push(p); return hull; }, []).slice(0, -1);
  if (!footprints.has(h.id)) footprints.set(h.id, [...half(points), ...half(points.reverse())]);
  return footprints.get(h.id);
}
function gridInSpace(shown, ink, lines) {
  Object.assign(shape, {grid: gridTold(), feet: shown.some(stands)});
  for (const [p, q] of ground.lines) {
    const n = Math.max(1, Math.round(norm(sub(q, p)) / ground.step));
    for (let i = 0; i < n; i++) lines.push({p: mix(p, q, i / n), q: mix(p, q, (i + 1) / n), c: [...ink, 0.3]});
  }
  for (const h of shown.filter(stands)) footprint(h).forEach((p, i, ring) => lines.push({p, q: ring[(i + 1) % ring.length], c: [...rgb(colour(h.id)), 1]}));
}
