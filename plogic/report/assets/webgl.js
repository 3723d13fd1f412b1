// Drawing the scene with WebGL: one program for colours, one for the picture in the frustum.
const VERTEX = 'attribute vec3 p;attribute vec4 c;attribute vec2 k;uniform mat4 m;uniform float s,b;varying vec4 v;varying float w;void main(){gl_Position=m*vec4(p,1.);gl_Position.z-=b*gl_Position.w;gl_PointSize=k.y*s;v=c;w=k.x;}';
const FRAGMENT = 'precision mediump float;varying vec4 v;varying float w;uniform float d;void main(){vec4 o=v;if(d>.5){vec2 q=abs(gl_PointCoord*2.-1.);float r=w<1.5?length(q):max(q.x,q.y)*1.12;if(r>1.)discard;bool ring=mod(w,2.)>.5;if(ring&&r<.52)discard;if(!ring&&r>.78)o=vec4(o.rgb*.35+vec3(.65),1.);}gl_FragColor=vec4(o.rgb*o.a,o.a);}';
const PICTURE = ['attribute vec3 p;attribute vec2 t;uniform mat4 m;varying vec2 u;void main(){gl_Position=m*vec4(p,1.);u=t;}',
  'precision mediump float;varying vec2 u;uniform sampler2D x;void main(){gl_FragColor=texture2D(x,u)*.94;}'];

function program(gl, vertex, fragment, names) {
  const id = gl.createProgram();
  [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]].forEach(([kind, text]) => {
    const s = gl.createShader(kind);
    gl.shaderSource(s, text);
    gl.compileShader(s);
    gl.attachShader(id, s);
  });
  names.forEach((n, i) => gl.bindAttribLocation(id, i, n));
  gl.linkProgram(id);
  return gl.getProgramParameter(id, gl.LINK_STATUS) ? {id, u: (n) => gl.getUniformLocation(id, n)} : null;
}

function webglPainter(canvas, redraw) {
  const gl = canvas.getContext('webgl', {antialias: true, preserveDrawingBuffer: true});
  const flat = gl && program(gl, VERTEX, FRAGMENT, ['p', 'c', 'k']), pictured = gl && program(gl, ...PICTURE, ['p', 't']);
  if (!flat || !pictured) return null;
  const buffer = gl.createBuffer();
  let texture = null;
  if (IMAGE) {
    const image = new Image();
    image.onload = () => {
      texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
      for (const [k, v] of [[gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE], [gl.TEXTURE_MIN_FILTER, gl.LINEAR]]) gl.texParameteri(gl.TEXTURE_2D, k, v);
      redraw();
    };
    image.src = IMAGE;
  }
  function batch(mode, rows, sizes) {
    const stride = 4 * sizes.reduce((a, b) => a + b);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(rows), gl.STREAM_DRAW);
    sizes.reduce((offset, n, i) => { gl.enableVertexAttribArray(i); gl.vertexAttribPointer(i, n, gl.FLOAT, false, stride, offset); return offset + 4 * n; }, 0);
    for (let i = sizes.length; i < 3; i++) gl.disableVertexAttribArray(i);
    gl.drawArrays(mode, 0, rows.length * 4 / stride);
  }
  return (scene, ratio) => {
    const m = clipMatrix(canvas.width / canvas.height), z = eyeAxes().z;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(flat.id);
    gl.uniformMatrix4fv(flat.u('m'), false, m);
    gl.uniform1f(flat.u('s'), ratio);
    const draw = (mode, items, bias, points, rows) => { gl.uniform1f(flat.u('b'), bias); gl.uniform1f(flat.u('d'), points ? 1 : 0); batch(mode, items.flatMap(rows), [3, 4, 2]); };
    const faces = (t) => { const l = shade(t.p, z); return t.p.flatMap((p) => [...p, t.c[0] * l, t.c[1] * l, t.c[2] * l, t.c[3], 0, 1]); };
    draw(gl.TRIANGLES, scene.triangles.filter((t) => t.c[3] === 1), 0, false, faces);
    if (scene.picture && texture) {
      gl.useProgram(pictured.id);
      gl.uniformMatrix4fv(pictured.u('m'), false, m);
      batch(gl.TRIANGLE_FAN, scene.picture.flatMap((p, i) => [...p, i === 1 || i === 2 ? 1 : 0, i > 1 ? 1 : 0]), [3, 2]);
      gl.useProgram(flat.id);
    }
    gl.depthMask(false);
    draw(gl.TRIANGLES, scene.triangles.filter((t) => t.c[3] < 1), 0, false, faces);
    draw(gl.LINES, scene.lines, 0.0004, false, (l) => [...l.p, ...l.c, 0, 1, ...l.q, ...l.c, 0, 1]);
    gl.depthMask(true);
    draw(gl.POINTS, scene.points, 0.0012, true, (q) => [...q.p, ...q.c, q.kind, q.size]);
  };
}
