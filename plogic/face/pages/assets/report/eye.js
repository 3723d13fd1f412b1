// The eye that orbits: angles in radians, distances in the document's metres. It stands as far off as its target needs to fit the canvas.
const eye = {yaw: 0.95, pitch: 0.42, zoom: 1, close: false, aspect: 1.5, fit: 1, points: [], own: [], centre: [0, 0, 1], middle: [0, 0, 1], far: 1, near: 1};
const MARGIN = 0.92;
const middleOf = (points) => [0, 1, 2].map((i) => { const xs = points.map((p) => p[i]); return (least(xs) + most(xs)) / 2; });
const bodies = (world) => standing(world).flatMap((h) => solid(h).points);
const distance = () => eye.fit / eye.zoom;

function directions() {
  const ahead = unit(sub(AHEAD, times(UP, dot(AHEAD, UP)))), right = cross(ahead, UP), {yaw, pitch} = eye;
  const flat = add(times(ahead, -Math.cos(yaw)), times(right, Math.sin(yaw)));
  const z = unit(add(times(flat, Math.cos(pitch)), times(UP, Math.sin(pitch)))), x = unit(cross(UP, z));
  return {x, y: cross(z, x), z};
}
// Zooming in leads to the objects, not to the empty place between them and the camera.
function eyeAxes() {
  const axes = directions(), towards = mix(eye.middle, eye.centre, Math.min(1, eye.zoom ** -2));
  return {...axes, at: add(towards, times(axes.z, distance()))};
}
function lens(aspect) {
  const f = 1 / Math.tan(0.36) * Math.min(1, aspect / 1.5);
  return [f / aspect, f];
}
const reach = () => [Math.max(distance() * 0.05, distance() - eye.far * 2.1), distance() + eye.far * 6];
// The clip matrix for a canvas of this aspect.
function clipMatrix(aspect) {
  return clip(eyeAxes(), lens(aspect), ...reach());
}
// How far off the eye must be to have all of its target on the canvas.
function fitting() {
  const {x, y, z} = directions(), [fx, fy] = lens(eye.aspect);
  return most(eye.points.map((p) => { const q = sub(p, eye.centre); return dot(z, q) + Math.max(fx * Math.abs(dot(x, q)), fy * Math.abs(dot(y, q))) / MARGIN; })) || 1;
}
function inView(points) {
  const m = clipMatrix(eye.aspect);
  return points.every((p) => { const s = project(m, p, 2, 2); return s && Math.abs(s[0] - 1) <= 1 && Math.abs(s[1] - 1) <= 1; });
}
function target(world) {
  const own = bodies(world), seen = eye.close && own.length ? own : [[0, 0, 0], ...frustum(frameDepth(own)), ...own], centre = middleOf(seen);
  Object.assign(eye, {points: seen, own, centre, middle: own.length ? middleOf(own) : centre});
  eye.far = most(seen.map((p) => norm(sub(p, centre)))) || 1;
  eye.near = most(own.map((p) => norm(sub(p, eye.middle)))) || eye.far / 3;
  eye.fit = Math.max(fitting(), eye.of === world ? eye.fit : 0);
  eye.of = world;
}
// The view of the most probable world is kept while all that is shown is in it; else it is that of what is shown.
function aim() {
  const of = eye.of;
  target(worlds[0]);
  if (bodies(worlds[0]).length && inView(bodies(state.shown))) return;
  eye.of = of;
  target(state.shown);
}
// Nothing leaves the view by itself: another shape of the canvas is filled anew, a turn steps back where it must.
function refit(aspect) {
  const need = Object.assign(eye, {aspect}) && fitting();
  if (eye.shaped !== aspect || need > eye.fit) eye.fit = need;
  eye.shaped = aspect;
}
function follows() {
  if (eye.zoom > 1 && inView(bodies(state.shown))) return;
  eye.zoom = Math.min(1, eye.zoom);
  aim();
}
function lookFrom(yaw = 0.95, pitch = 0.42, close = false) {
  Object.assign(eye, {yaw, pitch, close, zoom: 1, of: null});
  aim();
}
