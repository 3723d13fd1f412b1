// How this page's eye moves, and the buttons under the canvas.
function turn(yaw, pitch) {
  eye.yaw += yaw;
  eye.pitch = Math.max(-0.3, Math.min(1.5, eye.pitch + pitch));
  redraw();
}
function zoom(factor) {
  eye.zoom = Math.max(0.25, Math.min(Math.max(4, eye.fit / (1.4 * eye.near)), eye.zoom * factor));
  redraw();
}
function paint(ratio, wide) {
  refit(stage.width / stage.height);
  painter(build({ink: isDark() ? [0.9, 0.89, 0.87] : [0.12, 0.13, 0.15]}), ratio * Math.min(1, 0.45 + wide / 1200));
  Object.assign(stage.dataset, {yaw: eye.yaw.toFixed(3), painted: standing(state.shown).filter(paintOf).length, distance: distance().toPrecision(6)});
  if (keyed !== shape.grid + shape.feet) drawStageKey();
}

// What the lines and marks in space mean.
let keyed;
function drawStageKey() {
  keyed = shape.grid + shape.feet;
  const ray = (alpha) => svg('svg', {viewBox: '0 -5 26 10', width: 26, height: 10, 'aria-hidden': 'true'}, svg('line', {x1: 1, x2: 25, stroke: 'currentColor', 'stroke-width': 2, 'stroke-opacity': alpha}));
  const dot = (round, full) => icon(svg(round ? 'circle' : 'rect', {...(round ? {r: 5} : {x: -4.5, y: -4.5, width: 9, height: 9}), fill: full ? MUTED : 'none', stroke: MUTED, 'stroke-width': 2}));
  const marks = shape.features ? [[dot(true, true), 'found'], [dot(true, false), 'missed'], [dot(false, true), 'unexpected'], [dot(false, false), 'rightly unseen']] : [], rays = shape.lines ? [[ray(0.8), 'line of sight to what is found'], [ray(0.3), 'to what is missed']] : [];
  put('stage-key', [...marks, ...rays, [ray(1), IMAGE && shape.picture ? 'the camera with its image' : 'the camera'], ...(shape.grid ? [[gridSign(), shape.grid]] : []), ...(shape.feet ? [[icon(svg('path', {d: 'M-8 1L1 -5L8 -1L-1 5Z', fill: 'none', stroke: 'currentColor', 'stroke-width': 1.6})), 'foot of what stands there']] : [])].map(([sign, text]) => el('li', null, sign, text)));
}

function startStage() {
  const goTo = (...angles) => { lookFrom(...angles); redraw(); }, look = (text, ...angles) => button(text, () => goTo(...angles));
  const label = 'The posed objects, their features, the camera and its lines of sight, seen from beside. Arrow keys turn it, plus and minus zoom, Home resets.';
  if (BUSY) shape.lines = shape.features = false;
  lookFrom();
  mountStage({label, webgl: webglPainter, flat: flatPainter, paint, turn, zoom, keys: {Home: () => goTo()}});
  put('stage-bar', look('Side'), look('Camera', 0, 0.2), look('Top', 0, 1.5), look('Back', 2.6, 0.35), button('Close', () => goTo(0.95, 0.42, true), {'data-view': 'close'}),
    [['lines', 'Lines of sight'], ['features', 'Features'], ...(IMAGE ? [['picture', 'Image']] : []), ...(ground ? [['plane', 'Support plane']] : []), ...(paints.size ? [['texture', 'Texture']] : [])].map(([k, text]) => toggle(k, shape[k], text, (on) => { shape[k] = on; drawStageKey(); redraw(); })));
  put('stage-hint', 'Drag or press the arrow keys to turn. Click it, then use the wheel to zoom; + and \u2212 do the same.');
  watchers.push((what) => { if (what === 'world') follows(); redraw(); });
  drawStageKey();
}
startPicture();
startKey();
startPanels();
startStage();
startPaints();
changed('world');
