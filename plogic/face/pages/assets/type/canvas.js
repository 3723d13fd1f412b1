// Drawing without WebGL; a textured triangle in the one colour of its middle.
function flatPainter(canvas) {
  const count = surface ? surface.triangles.length / 3 : 0, alpha = doc.type.opaque ? 1 : 0.4;
  let paint = null;
  if (PICTURE && surface.uv) load(PICTURE, (image) => { paint = middles(surface, image); redraw(); });
  const normals = Array.from({length: count}, (_, t) => { const [a, b, c] = corners(t); return unit(cross(sub(b, a), sub(c, a))); });
  return (wall, ratio) => {
    const scene = lobeScene(), light = unit(add(eyeAxes().z, [0.15, 0.1, 0.55])), flat = farToNear(canvas, clipMatrix(canvas.width / canvas.height), RADIUS), {ctx} = flat;
    const colour = (t) => css(times(paint ? paint[t] : wall, 0.7 + 0.3 * Math.abs(dot(normals[t], light))), alpha);
    for (let t = 0; t < (state.surface ? count : 0); t++) flat.add(corners(t), 0, (s) => flat.fill(s, colour(t), doc.type.opaque ? 0.6 * ratio : 0));
    for (const t of scene.triangles) flat.add(t.p, 0, (s) => flat.fill(s, css(t.c, t.c[3]), 0));
    for (const l of scene.lines) flat.add([l.p, l.q], 0, (s) => flat.line(s, css(l.c, l.c[3]), ratio));
    for (const s of sideStrokes()) flat.add([s.p, s.q], 0.12, (t) => flat.line(t, css(s.c, s.c[3]), ratio));
    for (const q of points()) flat.add([q.p], q.chosen ? 9 : 0.12, ([[x, y]]) => {
      ctx.beginPath();
      ctx.arc(x, y, q.size * ratio / 2, 0, 7);
      ctx.fillStyle = css(q.c, q.c[3]);
      ctx.fill();
      if (q.on) { ctx.strokeStyle = q.chosen ? '#fff' : '#14171a'; ctx.lineWidth = (q.chosen ? 3 : 1) * ratio; ctx.stroke(); }
    });
    flat.finish();
  };
}
const corners = (t) => [0, 1, 2].map((i) => three(surface.vertices, surface.triangles[3 * t + i]));
