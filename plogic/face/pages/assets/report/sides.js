// Sides of edges: of SIFT's appearances those that have an angle and no scale. A feature is one as its match or else its type tells.
const sideAngles = new Map(appearances.filter((a) => a.detector === 'sift' && a.angle != null && a.scale == null).map((a) => [a.id, Number(a.angle)]));
const sideTypes = new Set([...sideAngles.keys()].map((id) => appearanceById.get(id).type));
const angleOf = (mark) => sideAngles.get(mark.a ? mark.a.id : mark.f.match);
const isSide = (f) => (f.match != null ? sideAngles.has(f.match) : sideTypes.has(f.type));
const named = (type) => words(type) + (sideTypes.has(type) ? `, the ${SIDE}` : '');

// What all of them are called where words are one.
const SIDE = 'side of an edge';
// A stroke along the edge and a tick across it, towards the side; a cross where it was missed, so that nobody knows its angle.
function sideStrokes(angle, r) {
  const n = [1.8 * r * Math.cos(angle), 1.8 * r * Math.sin(angle)], [x, y] = [-0.9 * n[1], 0.9 * n[0]];
  return angle == null ? [[-0.75 * r, -0.75 * r, 0.75 * r, 0.75 * r], [-0.75 * r, 0.75 * r, 0.75 * r, -0.75 * r]] : [[-x, -y, x, y], [0, 0, ...n]];
}
const sideIcon = (angle) => icon(sideStrokes(angle, 3.6).map(([x1, y1, x2, y2]) => svg('line', {x1, y1, x2, y2, stroke: MUTED, 'stroke-width': angle == null ? 1.6 : 2})));
