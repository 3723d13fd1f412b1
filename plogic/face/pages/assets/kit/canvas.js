// Drawing without WebGL: everything sorted from far to near onto a plain canvas.
function farToNear(canvas, m, size) {
  const ctx = canvas.getContext('2d'), {width: w, height: h} = canvas, items = [];
  const path = (s) => { ctx.beginPath(); s.forEach((q, i) => (i ? ctx.lineTo(q[0], q[1]) : ctx.moveTo(q[0], q[1]))); };
  return {
    ctx,
    // Calls draw with the points' places on the canvas, nearer by a share of the scene's size than they are.
    add(points, bias, draw) {
      const s = points.map((p) => project(m, p, w, h));
      if (s.every(Boolean)) items.push({depth: s.reduce((sum, q) => sum + q[2], 0) / s.length - bias * size, draw: () => draw(s)});
    },
    fill(s, colour, seam) {
      path(s);
      ctx.closePath();
      ctx.fillStyle = ctx.strokeStyle = colour;
      ctx.lineWidth = seam;
      ctx.fill();
      if (seam) ctx.stroke();
    },
    line(s, colour, wide) {
      path(s);
      ctx.strokeStyle = colour;
      ctx.lineWidth = wide;
      ctx.stroke();
    },
    finish() {
      ctx.clearRect(0, 0, w, h);
      items.sort((a, b) => b.depth - a.depth).forEach((i) => i.draw());
    },
  };
}
