// Drawing without WebGL: everything sorted from far to near onto a plain canvas; a textured triangle in the one colour of its middle.
function flatPainter(canvas, redraw) {
  const ctx = canvas.getContext('2d'), count = surface ? surface.triangles.length / 3 : 0;
  let paint = null;
  if (PICTURE && surface.uv) {
    const image = new Image();
    image.onload = () => { paint = middles(image); redraw(); };
    image.src = PICTURE;
  }
  const normals = Array.from({length: count}, (_, t) => { const [a, b, c] = corners(t); return unit(cross(sub(b, a), sub(c, a))); });
  return (theme, ratio) => {
    const w = canvas.width, h = canvas.height, m = clipMatrix(w / h), scene = lobeScene(), items = [], light = unit(add(eyeAxes().z, [0.15, 0.1, 0.55]));
    const push = (at3, bias, draw) => { const s = at3.map((p) => project(m, p, w, h)); if (s.every(Boolean)) items.push({depth: s.reduce((sum, q) => sum + q[2], 0) / s.length - bias * RADIUS, draw: () => draw(s)}); };
    const path = (s) => { ctx.beginPath(); s.forEach((q, i) => (i ? ctx.lineTo(q[0], q[1]) : ctx.moveTo(q[0], q[1]))); };
    const cover = (s, colour) => { path(s); ctx.closePath(); ctx.fillStyle = ctx.strokeStyle = colour; ctx.lineWidth = 0.6 * ratio; ctx.fill(); if (doc.type.opaque) ctx.stroke(); };
    for (let t = 0; t < (state.surface ? count : 0); t++) push(corners(t), 0, (s) => cover(s, css(times(paint ? paint[t] : theme.wall, 0.7 + 0.3 * Math.abs(dot(normals[t], light))), doc.type.opaque ? 1 : 0.4)));
    for (const t of scene.triangles) push(t.p, 0, (s) => { path(s); ctx.fillStyle = css(t.c, t.c[3]); ctx.fill(); });
    for (const l of scene.lines) push([l.p, l.q], 0, (s) => { path(s); ctx.strokeStyle = css(l.c, l.c[3]); ctx.lineWidth = ratio; ctx.stroke(); });
    for (const q of points()) push([q.p], q.chosen ? 9 : 0.12, ([[x, y]]) => { ctx.beginPath(); ctx.arc(x, y, q.size * ratio / 2, 0, 7); ctx.fillStyle = css(q.c, q.c[3]); ctx.fill(); if (q.on) { ctx.strokeStyle = q.chosen ? '#fff' : '#14171a'; ctx.lineWidth = (q.chosen ? 3 : 1) * ratio; ctx.stroke(); } });
    ctx.clearRect(0, 0, w, h);
    items.sort((a, b) => b.depth - a.depth).forEach((i) => i.draw());
  };
}
const corners = (t) => [0, 1, 2].map((i) => three(surface.vertices, surface.triangles[3 * t + i]));

// The texture's colour in the middle of each triangle.
function middles(image) {
  const c = el('canvas', {width: image.naturalWidth, height: image.naturalHeight}), g = c.getContext('2d'), fold = (x) => x - Math.floor(x);
  g.drawImage(image, 0, 0);
  const pixels = g.getImageData(0, 0, c.width, c.height).data;
  return Array.from({length: surface.triangles.length / 3}, (_, t) => {
    const [u, v] = [0, 1].map((k) => [0, 1, 2].reduce((sum, i) => sum + surface.uv[2 * surface.triangles[3 * t + i] + k] / 3, 0));
    const i = 4 * (Math.min(c.height - 1, Math.floor((1 - fold(v)) * c.height)) * c.width + Math.min(c.width - 1, Math.floor(fold(u) * c.width)));
    return [pixels[i] / 255, pixels[i + 1] / 255, pixels[i + 2] / 255];
  });
}
