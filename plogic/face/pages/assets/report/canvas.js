// Drawing the scene without WebGL; lines in eight pieces, so that they pass behind what stands before them.
function flatPainter(canvas) {
  return (scene, ratio) => {
    const z = eyeAxes().z, {ctx, add, fill, line, finish} = farToNear(canvas, clipMatrix(canvas.width / canvas.height), eye.far);
    for (const t of scene.triangles) add(t.p, 0, (s) => fill(s, css(times(t.c, shade(t.p, z)), t.c[3]), ratio * 0.6));
    for (const [p, T] of scene.painted) {
      p.middles = p.middles || flatColours(p);
      for (let t = 0; t < p.middles.length; t += 1) {
        const s = [0, 1, 2].map((i) => place(T, cornerOf(p, p.triangles[3 * t + i])));
        add(s, 0, (q) => fill(q, css(times(p.middles[t], shade(s, z)), 1), ratio * 0.6));
      }
    }
    for (const l of scene.lines) for (let i = 0; i < 8; i++) add([mix(l.p, l.q, i / 8), mix(l.p, l.q, (i + 1) / 8)], 0.02, (s) => line(s, css(l.c, l.c[3]), ratio));
    for (const q of scene.points) add([q.p], 0.03, ([[x, y]]) => {
      const r = q.size * ratio / 2.3;
      ctx.beginPath();
      if (q.kind < 2) ctx.arc(x, y, r, 0, 7); else ctx.rect(x - r * 0.9, y - r * 0.9, r * 1.8, r * 1.8);
      ctx.fillStyle = ctx.strokeStyle = css(q.c, q.c[3]);
      ctx.lineWidth = ratio * 1.6;
      if (q.kind % 2) ctx.stroke(); else ctx.fill();
    });
    finish();
  };
}
