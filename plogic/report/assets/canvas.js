// Drawing the scene without WebGL: everything sorted from far to near onto a plain canvas.
function flatPainter(canvas) {
  const ctx = canvas.getContext('2d');
  return (scene, ratio) => {
    const w = canvas.width, h = canvas.height, m = clipMatrix(w / h), z = eyeAxes().z, items = [];
    const see = (p) => {
      const [x, y, , d] = [0, 1, 2, 3].map((i) => m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i]);
      return d > eye.far * 0.02 ? [(x / d + 1) * w / 2, (1 - y / d) * h / 2, d] : null;
    };
    const put = (points, bias, draw) => { const s = points.map(see); if (s.every(Boolean)) items.push({depth: s.reduce((a, q) => a + q[2], 0) / s.length - bias * eye.far, draw: () => draw(s)}); };
    const css = (c, l = 1) => `rgba(${c.slice(0, 3).map((v) => Math.round(255 * Math.min(1, v * l))).join()},${c[3]})`;
    const path = (s) => { ctx.beginPath(); s.forEach((q, i) => (i ? ctx.lineTo(q[0], q[1]) : ctx.moveTo(q[0], q[1]))); };
    for (const t of scene.triangles) put(t.p, 0, (s) => { path(s); ctx.closePath(); ctx.fillStyle = ctx.strokeStyle = css(t.c, shade(t.p, z)); ctx.lineWidth = ratio * 0.6; ctx.fill(); ctx.stroke(); });
    for (const l of scene.lines) for (let i = 0; i < 8; i++) put([mix(l.p, l.q, i / 8), mix(l.p, l.q, (i + 1) / 8)], 0.02, (s) => { path(s); ctx.strokeStyle = css(l.c); ctx.lineWidth = ratio; ctx.stroke(); });
    for (const q of scene.points) put([q.p], 0.03, ([[x, y]]) => {
      const r = q.size * ratio / 2.3;
      ctx.beginPath();
      if (q.kind < 2) ctx.arc(x, y, r, 0, 7); else ctx.rect(x - r * 0.9, y - r * 0.9, r * 1.8, r * 1.8);
      ctx.fillStyle = ctx.strokeStyle = css(q.c);
      ctx.lineWidth = ratio * 1.6;
      if (q.kind % 2) ctx.stroke(); else ctx.fill();
    });
    ctx.clearRect(0, 0, w, h);
    items.sort((a, b) => b.depth - a.depth).forEach((i) => i.draw());
  };
}
