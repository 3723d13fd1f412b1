// What is seen from the eye, how it moves, which feature is pointed at; the buttons and the slider of distance.
function paint(ratio, wide) {
  painter(isDark() ? [0.62, 0.63, 0.65] : [0.8, 0.79, 0.76], ratio * Math.sqrt(eye.zoom) * Math.min(1, 0.5 + wide / 1400));
  drawMap();
  Object.assign(stage.dataset, {yaw: eye.yaw.toFixed(6), pitch: eye.pitch.toFixed(6), distance: eye.distance.toPrecision(9), zoom: eye.zoom.toFixed(3), seen: state.seen});
}
// The viewpoint has moved: who is seen from it? Rays are shot only where there are few.
const RAYS = 60000;
function moved() {
  state.seen = look(viewpoint(), state.lit);
  const some = state.only ? feature.names.filter((_, f) => chosen(f) && state.lit[f]).length : 0, of = state.only ? feature.names.filter((_, f) => chosen(f)).length : 0;
  const open = surface && state.seen * surface.triangles.length / 3 <= RAYS ? feature.names.filter((_, f) => state.lit[f] && !hidden(three(feature.at, f))).length : null;
  put('here', tag(null, 'Seen from here: ', el('b', null, `${state.seen} of ${COUNT}`), ` features, from ${metres(eye.distance)}`, open == null || open === state.seen ? null : `; the surface hides ${state.seen - open} of them`, state.only ? `; of the chosen ones ${some} of ${of}` : ''), bar(state.seen / (COUNT || 1)));
  redraw();
}
function turn(yaw, pitch) {
  eye.yaw += yaw;
  eye.pitch = Math.max(-1.55, Math.min(1.55, eye.pitch + pitch));
  changed('eye');
}
function zoom(factor) {
  eye.zoom = Math.max(0.4, Math.min(12, eye.zoom * factor));
  redraw();
}
const fromSlider = (k) => FAR.low * (FAR.high / FAR.low) ** (k / 1000), toSlider = (d) => Math.round(1000 * Math.log(d / FAR.low) / Math.log(FAR.high / FAR.low));
function goTo(yaw, pitch) {
  Object.assign(eye, {yaw, pitch, zoom: 1});
  changed('eye');
}

// The nearest feature within reach of the pointer that is drawn and not hidden; -1 for none.
function under(event) {
  const box = stage.getBoundingClientRect(), m = clipMatrix(box.width / box.height), near = [];
  for (let f = 0; f < COUNT; f++) {
    if (!drawn(f)) continue;
    const s = project(m, three(feature.at, f), box.width, box.height), far = s ? Math.hypot(s[0] - (event.clientX - box.left), s[1] - (event.clientY - box.top)) : Infinity;
    if (far < 10) near.push({f, far: far + (bright(f) ? 0 : 4)});
  }
  const found = near.sort((a, b) => a.far - b.far).slice(0, 8).find((q) => !state.surface || !hidden(three(feature.at, q.f)));
  return found ? found.f : -1;
}
function point(event) {
  const f = under(event);
  stage.classList.toggle('over', f >= 0);
  if (f === state.pointed || state.pinned >= 0) return;
  Object.assign(state, {pointed: f, alone: -1});
  changed('chosen');
}

function leave() {
  if (state.pointed < 0) return;
  state.pointed = -1;
  changed('chosen');
}

function startDistance() {
  const slider = el('input', {type: 'range', min: 0, max: 1000, step: 1, id: 'far', value: toSlider(eye.distance)}), told = el('output', {for: 'far'});
  const tell = () => { told.textContent = metres(eye.distance); slider.setAttribute('aria-valuetext', told.textContent); };
  slider.addEventListener('input', () => { eye.distance = fromSlider(Number(slider.value)); tell(); changed('eye'); });
  tell();
  put('distance', el('label', {for: 'far'}, 'Viewpoint\u2019s distance'), slider, told);
}
function startStage() {
  const look = (text, ...angles) => button(text, () => goTo(...angles)), home = () => goTo(...bestView(0.15, 0.7));
  const label = 'The surface with its features. Arrow keys turn it, plus and minus zoom, n and p go from feature to feature, Escape lets go, Home resets.';
  mountStage({label, webgl: webglPainter, flat: flatPainter, paint, turn, zoom, point, tap: (e) => pin(under(e)), leave, keys: {Home: home, n: () => walk(1), p: () => walk(-1), Escape: () => pin(-1)}});
  put('stage-bar', toggle('here', false, 'Only what is seen from here', (on) => { state.here = on; redraw(); }), toggle('surface', true, 'Surface', (on) => { state.surface = on; redraw(); }),
    SIDES ? toggle('sides', true, 'Sides of edges', (on) => { state.sides = on; redraw(); }) : null,
    button('Best view', () => goTo(...bestView(-1.6, 1.6)), {'data-view': 'best'}), look('Front', 0, 0), look('Side', Math.PI / 2, 0), look('Back', Math.PI, 0), look('Top', 0, 1.55));
  put('stage-hint', 'Drag or press the arrow keys to turn: the eye is the viewpoint. Click, then use the wheel to zoom; + and \u2212 do the same. The lens keeps the object as large as it is, however far the viewpoint.');
  startDistance();
  watchers.push((what) => (what === 'chosen' ? redraw() : moved()));
  home();
}
startPanels();
startFeature();
startMap();
startStage();
