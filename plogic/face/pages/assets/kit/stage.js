// The canvas that turns: by drag, by keys, by wheel. What it shows and how its eye moves is the page's, its view:
// {label, webgl(canvas), flat(canvas), paint(ratio, wide), turn(yaw, pitch), zoom(factor), keys}, and point(event), tap(event), leave() where it can be pointed at.
// webgl and flat make the painter that the page's paint calls; webgl gives null where there is no such thing.
let stage = null, painter = null, waiting = false, view = null;

const isDark = () => matchMedia('(prefers-color-scheme: dark)').matches;
// Gives a canvas the pixels that it has on the screen.
function fit(canvas) {
  const ratio = Math.min(2, devicePixelRatio || 1), box = canvas.getBoundingClientRect();
  const w = Math.max(1, Math.round(box.width * ratio)), h = Math.max(1, Math.round(box.height * ratio));
  if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, {width: w, height: h});
  return {ratio, w, h, wide: box.width};
}
function redraw() {
  if (!waiting) requestAnimationFrame(() => { const {ratio, wide} = fit(stage); waiting = false; view.paint(ratio, wide); });
  waiting = true;
}

function follow(canvas) {
  let from = null, far = 0;
  canvas.addEventListener('pointerdown', (e) => { from = [e.clientX, e.clientY]; far = 0; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener('pointermove', (e) => {
    if (!from) return view.point && view.point(e);
    const [x, y] = [e.clientX - from[0], e.clientY - from[1]];
    far += Math.abs(x) + Math.abs(y);
    view.turn(x * -0.008, y * 0.008);
    from = [e.clientX, e.clientY];
  });
  canvas.addEventListener('pointerup', (e) => { if (from && far < 4 && view.tap) view.tap(e); from = null; });
  canvas.addEventListener('pointercancel', () => { from = null; });
  canvas.addEventListener('pointerleave', () => view.leave && view.leave());
}
function listen(canvas) {
  follow(canvas);
  canvas.addEventListener('wheel', (e) => {
    if (document.activeElement !== canvas && !e.ctrlKey) return;
    e.preventDefault();
    view.zoom(Math.exp(Math.max(-0.3, Math.min(0.3, e.deltaY * -0.0012))));
  }, {passive: false});
  // The arrows move the eye, not what it sees.
  const keys = {ArrowLeft: () => view.turn(-0.12, 0), ArrowRight: () => view.turn(0.12, 0), ArrowUp: () => view.turn(0, 0.1), ArrowDown: () => view.turn(0, -0.1),
    '+': () => view.zoom(1.14), '=': () => view.zoom(1.14), '-': () => view.zoom(0.88), ...view.keys};
  canvas.addEventListener('keydown', (e) => {
    if (Object.hasOwn(keys, e.key) && !e.ctrlKey && !e.metaKey && !e.altKey) { e.preventDefault(); keys[e.key](); }
  });
}

function mount(tryGl) {
  stage = el('canvas', {tabindex: 0, role: 'application', 'aria-label': view.label});
  painter = (tryGl && view.webgl(stage)) || null;
  if (!painter && tryGl) return mount(false);
  painter = painter || view.flat(stage);
  stage.dataset.painter = tryGl ? 'webgl' : 'canvas';
  stage.addEventListener('webglcontextlost', () => { mount(false); redraw(); });
  listen(stage);
  put('stage', stage);
}
function mountStage(its) {
  view = its;
  mount(true);
  new ResizeObserver(redraw).observe(stage.parentNode);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
}
