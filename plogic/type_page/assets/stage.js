// The canvas that turns, and what turns it: drag, keys, wheel, buttons, the slider of distance.
let stage = null, painter = null, waiting = false, slider = null;

function theme() {
  const dark = matchMedia('(prefers-color-scheme: dark)').matches;
  return {wall: dark ? [0.62, 0.63, 0.65] : [0.8, 0.79, 0.76]};
}
function redraw() {
  if (!waiting) requestAnimationFrame(() => { waiting = false; paint(); });
  waiting = true;
}
function paint() {
  const ratio = Math.min(2, devicePixelRatio || 1), box = stage.getBoundingClientRect();
  const w = Math.max(1, Math.round(box.width * ratio)), h = Math.max(1, Math.round(box.height * ratio));
  if (stage.width !== w || stage.height !== h) Object.assign(stage, {width: w, height: h});
  painter(theme(), ratio * Math.sqrt(eye.zoom) * Math.min(1, 0.5 + box.width / 1400));
  drawMap();
  Object.assign(stage.dataset, {yaw: eye.yaw.toFixed(6), pitch: eye.pitch.toFixed(6), distance: eye.distance.toPrecision(9), zoom: eye.zoom.toFixed(3), seen: state.seen});
}
// The viewpoint has moved: who is seen from it? Rays are shot only where there are few.
const RAYS = 60000;
function moved() {
  state.seen = look(viewpoint(), state.lit);
  const some = state.only ? feature.names.filter((_, f) => chosen(f) && state.lit[f]).length : 0, of = state.only ? feature.names.filter((_, f) => chosen(f)).length : 0;
  const open = surface && state.seen * surface.triangles.length / 3 <= RAYS ? feature.names.filter((_, f) => state.lit[f] && !hidden(three(feature.at, f))).length : null;
  put('here', el('span', null, 'Seen from here: ', el('b', null, `${state.seen} of ${COUNT}`), ` features, from ${metres(eye.distance)}`, open == null || open === state.seen ? null : `; the surface hides ${state.seen - open} of them`, state.only ? `; of the chosen ones ${some} of ${of}` : ''), bar(state.seen / (COUNT || 1)));
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

function listen(canvas) {
  let from = null, far = 0;
  canvas.addEventListener('pointerdown', (e) => { from = [e.clientX, e.clientY]; far = 0; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener('pointermove', (e) => {
    if (!from) return point(e);
    far += Math.abs(e.clientX - from[0]) + Math.abs(e.clientY - from[1]);
    turn((e.clientX - from[0]) * -0.008, (e.clientY - from[1]) * 0.008);
    from = [e.clientX, e.clientY];
  });
  canvas.addEventListener('pointerup', (e) => { if (from && far < 4) pin(under(e)); from = null; });
  canvas.addEventListener('pointercancel', () => { from = null; });
  canvas.addEventListener('pointerleave', () => { if (state.pointed >= 0) { state.pointed = -1; changed('chosen'); } });
  canvas.addEventListener('wheel', (e) => {
    if (document.activeElement !== canvas && !e.ctrlKey) return;
    e.preventDefault();
    zoom(Math.exp(Math.max(-0.3, Math.min(0.3, e.deltaY * -0.0012))));
  }, {passive: false});
  canvas.addEventListener('keydown', (e) => {
    const act = {ArrowLeft: () => turn(-0.12, 0), ArrowRight: () => turn(0.12, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1), '+': () => zoom(1.14), '=': () => zoom(1.14), '-': () => zoom(0.88),
      Home: () => goTo(...bestView(0.15, 0.7)), n: () => walk(1), p: () => walk(-1), Escape: () => pin(-1)}[e.key];
    if (act && !e.ctrlKey && !e.metaKey && !e.altKey) { e.preventDefault(); act(); }
  });
}

function mount(tryGl) {
  stage = el('canvas', {tabindex: 0, role: 'img', 'aria-label': 'The surface with its features. Arrow keys turn it, plus and minus zoom, n and p go from feature to feature, Escape lets go, Home resets.'});
  painter = (tryGl && webglPainter(stage, redraw)) || null;
  if (!painter && tryGl) return mount(false);
  painter = painter || flatPainter(stage, redraw);
  stage.dataset.painter = tryGl ? 'webgl' : 'canvas';
  stage.addEventListener('webglcontextlost', () => { mount(false); redraw(); });
  listen(stage);
  put('stage', stage);
}

function startStage() {
  mount(true);
  const view = (text, ...angles) => button(text, () => goTo(...angles));
  put('stage-bar', toggle('here', false, 'Only what is seen from here', (on) => { state.here = on; redraw(); }), toggle('surface', true, 'Surface', (on) => { state.surface = on; redraw(); }),
    button('Best view', () => goTo(...bestView(-1.6, 1.6)), {'data-view': 'best'}), view('Front', 0, 0), view('Side', Math.PI / 2, 0), view('Back', Math.PI, 0), view('Top', 0, 1.55));
  slider = el('input', {type: 'range', min: 0, max: 1000, step: 1, id: 'far', value: toSlider(eye.distance)});
  const told = el('output', {for: 'far'}, metres(eye.distance));
  slider.addEventListener('input', () => { eye.distance = fromSlider(Number(slider.value)); told.textContent = metres(eye.distance); slider.setAttribute('aria-valuetext', told.textContent); changed('eye'); });
  slider.setAttribute('aria-valuetext', told.textContent);
  put('distance', el('label', {for: 'far'}, 'Viewpoint\u2019s distance'), slider, told);
  put('stage-hint', 'Drag or press the arrow keys to turn: the eye is the viewpoint. Click, then use the wheel to zoom; + and \u2212 do the same. The lens keeps the object as large as it is, however far the viewpoint.');
  new ResizeObserver(redraw).observe(stage.parentNode);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  watchers.push((what) => (what === 'chosen' ? redraw() : moved()));
}
startPanels();
startFeature();
startMap();
startStage();
goTo(...bestView(0.15, 0.7));
