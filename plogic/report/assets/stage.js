// The canvas that turns: by drag, by keyboard, by wheel, by its buttons.
let stage = null, painter = null, waiting = false;

function theme() {
  const dark = matchMedia('(prefers-color-scheme: dark)').matches;
  return {ink: dark ? [0.9, 0.89, 0.87] : [0.12, 0.13, 0.15]};
}
function redraw() {
  if (!waiting) requestAnimationFrame(() => { waiting = false; paint(); });
  waiting = true;
}
function paint() {
  const ratio = Math.min(2, devicePixelRatio || 1), box = stage.getBoundingClientRect();
  const w = Math.max(1, Math.round(box.width * ratio)), h = Math.max(1, Math.round(box.height * ratio));
  if (stage.width !== w || stage.height !== h) Object.assign(stage, {width: w, height: h});
  painter(build(theme()), ratio * Math.min(1, 0.45 + box.width / 1200));
  stage.dataset.yaw = eye.yaw.toFixed(3);
  stage.dataset.distance = eye.distance.toFixed(3);
}
function turn(yaw, pitch) {
  eye.yaw += yaw;
  eye.pitch = Math.max(-0.3, Math.min(1.5, eye.pitch + pitch));
  redraw();
}
function zoom(factor) {
  eye.distance = Math.max(eye.far * 0.4, Math.min(eye.far * 8, eye.distance * factor));
  redraw();
}

function listen(canvas) {
  let from = null;
  canvas.addEventListener('pointerdown', (e) => { from = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener('pointermove', (e) => {
    if (!from) return;
    turn((e.clientX - from[0]) * -0.008, (e.clientY - from[1]) * 0.006);
    from = [e.clientX, e.clientY];
  });
  for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { from = null; });
  canvas.addEventListener('wheel', (e) => {
    if (document.activeElement !== canvas && !e.ctrlKey) return;
    e.preventDefault();
    zoom(Math.exp(Math.max(-0.3, Math.min(0.3, e.deltaY * 0.0012))));
  }, {passive: false});
  canvas.addEventListener('keydown', (e) => {
    const act = {ArrowLeft: () => turn(0.12, 0), ArrowRight: () => turn(-0.12, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1),
      '+': () => zoom(0.88), '=': () => zoom(0.88), '-': () => zoom(1.14), Home: () => { resetEye(); redraw(); }}[e.key];
    if (act && !e.ctrlKey && !e.metaKey) { e.preventDefault(); act(); }
  });
}

function mount(tryGl) {
  stage = el('canvas', {tabindex: 0, role: 'img', 'aria-label': 'The posed objects, their features, the camera and its lines of sight, seen from beside. Arrow keys turn it, plus and minus zoom, Home resets.'});
  painter = (tryGl && webglPainter(stage, redraw)) || null;
  if (!painter && tryGl) return mount(false);
  painter = painter || flatPainter(stage);
  stage.dataset.painter = tryGl ? 'webgl' : 'canvas';
  stage.addEventListener('webglcontextlost', () => { mount(false); redraw(); });
  listen(stage);
  put('stage', stage);
}

function startStage() {
  resetEye();
  mount(true);
  const view = (text, ...angles) => button(text, () => { resetEye(...angles); redraw(); });
  put('stage-bar', view('Side'), view('Camera', 0, 0.2), view('Top', 0, 1.5), view('Back', 2.6, 0.35),
    [['lines', 'Lines of sight'], ['features', 'Features'], ['picture', 'Image']].map(([k, text]) => toggle(k, true, text, (on) => { shape[k] = on; redraw(); })));
  put('stage-hint', 'Drag or press the arrow keys to turn. Click it, then use the wheel to zoom; + and \u2212 do the same.');
  new ResizeObserver(redraw).observe(stage.parentNode);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  watchers.push(redraw);
}
startPicture();
startPanels();
startStage();
changed('world');
