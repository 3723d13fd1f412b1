// Drawing with WebGL: the surface from buffers that stay, points and lobes anew each time.
const SOLID = ['attribute vec3 p;attribute vec3 n;attribute vec2 t;uniform mat4 m;uniform vec3 e;varying vec2 u;varying float l;void main(){gl_Position=m*vec4(p,1.);u=t;l=abs(dot(n,e));}',
  'precision mediump float;varying vec2 u;varying float l;uniform sampler2D x;uniform vec4 c;uniform float k;void main(){vec3 o=mix(c.rgb*(.62+.38*l),texture2D(x,u).rgb*(.85+.17*l),k);gl_FragColor=vec4(o*c.a,c.a);}'];
const PLAIN = ['attribute vec3 p;attribute vec4 c;attribute float s;uniform mat4 m;uniform float b;varying vec4 v;varying float w;void main(){gl_Position=m*vec4(p,1.);gl_Position.z-=b*gl_Position.w;gl_PointSize=s;v=c;w=s;}',
  'precision mediump float;varying vec4 v;varying float w;uniform float d;void main(){vec4 o=v;if(d>.5){float r=length(gl_PointCoord*2.-1.);if(r>1.)discard;if(d>1.5&&r>.78)o=vec4(1.);else if(v.a>.9&&r>(d>1.5?.6:.86-1./w))o=vec4(.07,.08,.1,1.);o.a*=clamp((1.-r)*w*.5,0.,1.);}gl_FragColor=vec4(o.rgb*o.a,o.a);}'];

// A stroke as two triangles, so wide to each side.
function ribbon({p, q, beside}, wide, c) {
  const [a, b, d, e] = [[p, wide], [p, -wide], [q, wide], [q, -wide]].map(([o, w]) => [...add(o, times(beside, w)), ...c, 1]);
  return [...a, ...b, ...d, ...b, ...d, ...e];
}

function webglPainter(canvas) {
  const gl = webgl(canvas), solid = gl && program(gl, SOLID, ['p', 'n', 't']), plain = gl && program(gl, PLAIN, ['p', 'c', 's']);
  if (!solid || !plain) return null;
  const buffer = gl.createBuffer(), body = gl.createBuffer();
  let texture = repeated(gl, null), painted = false;
  if (surface) {
    gl.bindBuffer(gl.ARRAY_BUFFER, body);
    gl.bufferData(gl.ARRAY_BUFFER, cornerRows(surface), gl.STATIC_DRAW);
  }
  if (PICTURE) load(PICTURE, (image) => { if (!gl.isContextLost()) { texture = repeated(gl, image); painted = true; redraw(); } });
  const drawSolid = (m, z, wall) => {
    use(gl, solid, m);
    gl.uniform3fv(solid.u('e'), unit(add(z, [0.15, 0.1, 0.55])));
    gl.uniform4fv(solid.u('c'), wall);
    gl.uniform1f(solid.u('k'), painted && surface.uv ? 1 : 0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.bindBuffer(gl.ARRAY_BUFFER, body);
    attributes(gl, [3, 3, 2]);
    gl.drawArrays(gl.TRIANGLES, 0, surface.triangles.length);
  };
  const draw = (mode, rows, bias, round) => { gl.uniform1f(plain.u('b'), bias); gl.uniform1f(plain.u('d'), round); stream(gl, buffer, mode, rows, [3, 4, 1]); };
  return (wall, ratio) => {
    const m = clipMatrix(canvas.width / canvas.height), scene = lobeScene(), dots = points(), packed = (some) => some.flatMap((q) => [...q.p, ...q.c, q.size * ratio]);
    clear(gl);
    if (surface && state.surface) drawSolid(m, eyeAxes().z, [...wall, doc.type.opaque ? 1 : 0.4]);
    use(gl, plain, m);
    const sides = sideStrokes();
    draw(gl.TRIANGLES, sides.filter((s) => s.on).flatMap((s) => ribbon(s, 0.4 * LONG, [0.07, 0.08, 0.1, 1])), 0.0296, 0);
    draw(gl.TRIANGLES, sides.flatMap((s) => ribbon(s, 0.2 * LONG, s.c)), 0.03, 0);
    draw(gl.POINTS, packed(dots), 0.03, 1);
    gl.depthMask(false);
    draw(gl.TRIANGLES, scene.triangles.flatMap((t) => t.p.flatMap((p) => [...p, ...t.c, 1])), 0, 0);
    draw(gl.LINES, scene.lines.flatMap((l) => [...l.p, ...l.c, 1, ...l.q, ...l.c, 1]), 0.0002, 0);
    gl.disable(gl.DEPTH_TEST);
    draw(gl.POINTS, packed(dots.filter((q) => q.chosen)), 0, 2);
    gl.depthMask(true);
  };
}
