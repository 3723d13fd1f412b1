// Surfaces with textures: {vertices, triangles, uv}, flat arrays; uv may be null.
const cornerOf = (s, i) => [s.vertices[3 * i], s.vertices[3 * i + 1], s.vertices[3 * i + 2]];
// Each triangle with its own corners: place, normal, texture coordinate.
function cornerRows(s) {
  const rows = new Float32Array(s.triangles.length * 8);
  for (let t = 0; t < s.triangles.length; t += 3) {
    const at = [0, 1, 2].map((i) => s.triangles[t + i]), [a, b, c] = at.map((i) => cornerOf(s, i)), n = unit(cross(sub(b, a), sub(c, a)));
    [a, b, c].forEach((p, i) => rows.set([...p, ...n, ...(s.uv ? [s.uv[2 * at[i]], s.uv[2 * at[i] + 1]] : [0, 0])], 8 * (t + i)));
  }
  return rows;
}
// A texture that repeats, its first row on top; grey where there is none.
function repeated(gl, image) {
  const id = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, id);
  gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
  if (image) gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
  else gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array([128, 128, 128, 255]));
  gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  return id;
}
// The texture's colour in the middle of each triangle, for a canvas that has no textures.
function middles(s, image) {
  const c = el('canvas', {width: image.naturalWidth, height: image.naturalHeight}), g = c.getContext('2d'), fold = (x) => x - Math.floor(x);
  g.drawImage(image, 0, 0);
  const pixels = g.getImageData(0, 0, c.width, c.height).data;
  return Array.from({length: s.triangles.length / 3}, (_, t) => {
    const [u, v] = [0, 1].map((k) => [0, 1, 2].reduce((sum, i) => sum + s.uv[2 * s.triangles[3 * t + i] + k] / 3, 0));
    const i = 4 * (Math.min(c.height - 1, Math.floor((1 - fold(v)) * c.height)) * c.width + Math.min(c.width - 1, Math.floor(fold(u) * c.width)));
    return [pixels[i] / 255, pixels[i + 1] / 255, pixels[i + 2] / 255];
  });
}
