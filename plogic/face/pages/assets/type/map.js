// The sphere of viewpoints at the eye's distance, laid flat: how many features are seen from each direction.
const WIDE = 48, HIGH = 24, cells = new Uint16Array(WIDE * HIGH);
const cellAngles = (i) => [((i % WIDE) + 0.5) / WIDE * 2 * Math.PI - Math.PI, Math.PI / 2 - (Math.floor(i / WIDE) + 0.5) / HIGH * Math.PI];
let sphere = null, measured = NaN, soon = null;

function measure() {
  if (measured === eye.distance) return;
  measured = eye.distance;
  const lit = new Uint8Array(COUNT);
  for (let i = 0; i < cells.length; i++) cells[i] = look(viewpoint(...cellAngles(i)), lit);
}
// The direction from which most is seen, among those from so far below to so far above.
function bestView(low, high) {
  measure();
  let best = -1;
  cells.forEach((n, i) => { const pitch = cellAngles(i)[1]; if (pitch >= low && pitch <= high && (best < 0 || n > cells[best])) best = i; });
  return cellAngles(best);
}

function drawMap() {
  const {ratio: k, w, h} = fit(sphere);
  if (measured !== eye.distance && !soon) soon = setTimeout(() => { soon = null; measure(); drawMap(); }, 120);
  const most = cells.reduce((a, b) => Math.max(a, b), 0), least = cells.reduce((a, b) => Math.min(a, b), most), small = el('canvas', {width: WIDE, height: HIGH}), s = small.getContext('2d'), g = sphere.getContext('2d');
  cells.forEach((n, i) => { s.fillStyle = css(mix([0.1, 0.13, 0.2], [0.98, 0.95, 0.86], most ? n / most : 0)); s.fillRect(i % WIDE, Math.floor(i / WIDE), 1, 1); });
  g.imageSmoothingEnabled = true;
  g.drawImage(small, 0, 0, w, h);
  const turn = eye.yaw / (2 * Math.PI) + 0.5, x = (turn - Math.floor(turn)) * w, y = (0.5 - eye.pitch / Math.PI) * h;
  for (const [c, wide] of [['#14171a', 5], ['#e69f00', 2.5]]) { g.beginPath(); g.arc(x, y, 6 * k, 0, 7); g.strokeStyle = c; g.lineWidth = wide * k; g.stroke(); }
  put('map-key', `Left to right all around, the front (\u2212y) in the middle; top to bottom from above to below. From ${metres(measured)}: ${least} to ${most} features.`);
}

function startMap() {
  sphere = el('canvas', {role: 'img', 'aria-label': 'How many features are seen from each direction. The 3D view turns with the arrow keys.'});
  put('map', sphere);
  let down = false;
  const go = (e) => { const b = sphere.getBoundingClientRect(); eye.yaw = ((e.clientX - b.left) / b.width - 0.5) * 2 * Math.PI; turn(0, (0.5 - (e.clientY - b.top) / b.height) * Math.PI - eye.pitch); };
  sphere.addEventListener('pointerdown', (e) => { down = true; sphere.setPointerCapture(e.pointerId); go(e); });
  sphere.addEventListener('pointermove', (e) => { if (down) go(e); });
  for (const end of ['pointerup', 'pointercancel']) sphere.addEventListener(end, () => { down = false; });
}
