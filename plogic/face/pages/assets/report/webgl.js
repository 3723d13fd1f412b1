// Drawing the scene with WebGL: one program for colours, one for the picture in the frustum.
const PLAIN = ['attribute vec3 p;attribute vec4 c;attribute vec2 k;uniform mat4 m;uniform float s,b;varying vec4 v;varying float w;void main(){gl_Position=m*vec4(p,1.);gl_Position.z-=b;gl_PointSize=k.y*s;v=c;w=k.x;}',
  'precision mediump float;varying vec4 v;varying float w;uniform float d;void main(){vec4 o=v;if(d>.5){vec2 q=abs(gl_PointCoord*2.-1.);float r=w<1.5?length(q):max(q.x,q.y)*1.12;if(r>1.)discard;bool ring=mod(w,2.)>.5;if(ring&&r<.52)discard;if(!ring&&r>.78)o=vec4(o.rgb*.35+vec3(.65),1.);}gl_FragColor=vec4(o.rgb*o.a,o.a);}'];
const PICTURE = ['attribute vec3 p;attribute vec2 t;uniform mat4 m;varying vec2 u;void main(){gl_Position=m*vec4(p,1.);u=t;}',
  'precision mediump float;varying vec2 u;uniform sampler2D x;void main(){gl_FragColor=texture2D(x,u)*.94;}'];

const PAINTED = ['attribute vec3 p;attribute vec3 n;attribute vec2 t;uniform mat4 m;uniform vec3 e;varying vec2 u;varying float l;void main(){gl_Position=m*vec4(p,1.);u=t;l=abs(dot(n,e));}',
  'precision mediump float;varying vec2 u;varying float l;uniform sampler2D x;void main(){gl_FragColor=vec4(texture2D(x,u).rgb*(.85+.17*l),1.);}'];
const COLOURED = ['attribute vec3 p;attribute vec3 n;attribute vec3 c;uniform mat4 m;uniform vec3 e;varying vec3 v;void main(){gl_Position=m*vec4(p,1.);v=c*(.85+.17*abs(dot(n,e)));}',
  'precision mediump float;varying vec3 v;void main(){gl_FragColor=vec4(v,1.);}'];

// Column-major product of a matrix and a pose whose rows are given.
const posedBy = (m, T) => [0, 1, 2, 3].flatMap((j) => [0, 1, 2, 3].map((i) => [0, 1, 2, 3].reduce((sum, k) => sum + m[4 * k + i] * T[k][j], 0)));
// A direction of the camera's frame in that of what is posed.
const turnedBack = (d, T) => [0, 1, 2].map((j) => d[0] * T[0][j] + d[1] * T[1][j] + d[2] * T[2][j]);

function textureOf(gl, image) {
  const id = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, id);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
  for (const [k, v] of [[gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE], [gl.TEXTURE_MIN_FILTER, gl.LINEAR]]) gl.texParameteri(gl.TEXTURE_2D, k, v);
  return id;
}

function webglPainter(canvas) {
  const gl = webgl(canvas), plain = gl && program(gl, PLAIN, ['p', 'c', 'k']), pictured = gl && program(gl, PICTURE, ['p', 't']), covered = gl && program(gl, PAINTED, ['p', 'n', 't']), coloured = gl && program(gl, COLOURED, ['p', 'n', 'c']);
  if (!plain || !pictured || !covered || !coloured) return null;
  const buffer = gl.createBuffer();
  const bodies = new Map();
  let texture = null;
  const body = (p) => {
    if (!bodies.has(p)) {
      const rows = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, rows);
      gl.bufferData(gl.ARRAY_BUFFER, paintRows(p), gl.STATIC_DRAW);
      bodies.set(p, {rows, texture: p.image && repeated(gl, p.image)});
    }
    return bodies.get(p);
  };
  const drawPainted = ([p, T], m, light) => {
    const its = body(p), by = p.image ? covered : coloured;
    use(gl, by, posedBy(m, T));
    gl.uniform3fv(by.u('e'), turnedBack(light, T));
    if (p.image) gl.bindTexture(gl.TEXTURE_2D, its.texture);
    gl.bindBuffer(gl.ARRAY_BUFFER, its.rows);
    attributes(gl, [3, 3, p.image ? 2 : 3]);
    gl.drawArrays(gl.TRIANGLES, 0, p.triangles.length);
  };
  if (IMAGE) load(IMAGE, (image) => { if (!gl.isContextLost()) { texture = textureOf(gl, image); redraw(); } });
  // Lines and points are drawn nearer by a share of their depth, so that their own facets do not cover them.
  const draw = (mode, rows, nearer, points) => { const [n, f] = reach(); gl.uniform1f(plain.u('b'), nearer * 2 * f * n / (f - n)); gl.uniform1f(plain.u('d'), points ? 1 : 0); stream(gl, buffer, mode, rows, [3, 4, 2]); };
  return (scene, ratio) => {
    const m = clipMatrix(canvas.width / canvas.height), z = eyeAxes().z;
    const faces = (some) => some.flatMap((t) => t.p.flatMap((p) => [...p, ...times(t.c, shade(t.p, z)), t.c[3], 0, 1]));
    clear(gl);
    for (const painted of scene.painted) drawPainted(painted, m, unit(add(z, times(UP, 0.7))));
    use(gl, plain, m);
    gl.uniform1f(plain.u('s'), ratio);
    draw(gl.TRIANGLES, faces(scene.triangles.filter((t) => t.c[3] === 1)), 0, false);
    if (scene.picture && texture) {
      use(gl, pictured, m);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      stream(gl, buffer, gl.TRIANGLE_FAN, scene.picture.flatMap((p, i) => [...p, i === 1 || i === 2 ? 1 : 0, i > 1 ? 1 : 0]), [3, 2]);
      use(gl, plain, m);
    }
    gl.depthMask(false);
    draw(gl.TRIANGLES, faces(scene.triangles.filter((t) => t.c[3] < 1)), 0, false);
    draw(gl.LINES, scene.lines.flatMap((l) => [...l.p, ...l.c, 0, 1, ...l.q, ...l.c, 0, 1]), 0.002, false);
    gl.depthMask(true);
    draw(gl.POINTS, scene.points.flatMap((q) => [...q.p, ...q.c, q.kind, q.size]), 0.006, true);
  };
}
