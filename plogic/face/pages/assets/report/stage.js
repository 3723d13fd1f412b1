// How this page's eye moves, and the buttons under the canvas.
function turn(yaw, pitch) {
  eye.yaw += yaw;
  eye.pitch = Math.max(-0.3, Math.min(1.5, eye.pitch + pitch));
  redraw();
}
function zoom(factor) {
  eye.distance = Math.max(eye.far * 0.4, Math.min(eye.far * 8, eye.distance / factor));
  redraw();
}
function paint(ratio, wide) {
  painter(build({ink: isDark() ? [0.9, 0.89, 0.87] : [0.12, 0.13, 0.15]}), ratio * Math.min(1, 0.45 + wide / 1200));
  Object.assign(stage.dataset, {yaw: eye.yaw.toFixed(3), distance: eye.distance.toFixed(3)});
}

function startStage() {
  const goTo = (...angles) => { resetEye(...angles); redraw(); }, look = (text, ...angles) => button(text, () => goTo(...angles));
  const label = 'The posed objects, their features, the camera and its lines of sight, seen from beside. Arrow keys turn it, plus and minus zoom, Home resets.';
  resetEye();
  mountStage({label, webgl: webglPainter, flat: flatPainter, paint, turn, zoom, keys: {Home: () => goTo()}});
  put('stage-bar', look('Side'), look('Camera', 0, 0.2), look('Top', 0, 1.5), look('Back', 2.6, 0.35),
    [['lines', 'Lines of sight'], ['features', 'Features'], ['picture', 'Image']].map(([k, text]) => toggle(k, true, text, (on) => { shape[k] = on; redraw(); })));
  put('stage-hint', 'Drag or press the arrow keys to turn. Click it, then use the wheel to zoom; + and \u2212 do the same.');
  watchers.push(redraw);
}
startPicture();
startPanels();
startStage();
changed('world');
