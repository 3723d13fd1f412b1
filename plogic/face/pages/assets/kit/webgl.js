// Drawing with WebGL: what every program and every picture of it begins with.
function webgl(canvas) {
  return canvas.getContext('webgl', {antialias: true, preserveDrawingBuffer: true});
}
// A program of a vertex and a fragment shader whose attributes have these names; null where it cannot be made.
function program(gl, [vertex, fragment], names) {
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
function use(gl, its, m) {
  gl.useProgram(its.id);
  gl.uniformMatrix4fv(its.u('m'), false, m);
}
// The bound buffer's rows are of attributes with so many numbers each.
function attributes(gl, sizes) {
  const stride = 4 * sizes.reduce((a, b) => a + b);
  sizes.reduce((offset, n, i) => { gl.enableVertexAttribArray(i); gl.vertexAttribPointer(i, n, gl.FLOAT, false, stride, offset); return offset + 4 * n; }, 0);
  for (let i = sizes.length; i < 3; i++) gl.disableVertexAttribArray(i);
  return stride / 4;
}
function stream(gl, buffer, mode, rows, sizes) {
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(rows), gl.STREAM_DRAW);
  gl.drawArrays(mode, 0, rows.length / attributes(gl, sizes));
}
function clear(gl) {
  gl.viewport(0, 0, gl.canvas.width, gl.canvas.height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
}
