// Surfaces with their textures, in their own frames: {vertices, triangles, uv, image, colours} by type; image and colours once it has come.
const paints = new Map(Object.entries(doc.assets.paints || {}).map(([type, p]) => [type, {vertices: floats(p.vertices), triangles: shorts(p.triangles), uv: floats(p.uv), source: address(p.picture), image: null, colours: null}])
  .filter(([, p]) => p.source && p.uv.length * 3 === p.vertices.length * 2));
const paintOf = (h) => { const p = shape.texture && h.opaque !== false ? paints.get(h.type) : null; return p && p.image ? p : null; };
function startPaints() {
  for (const p of paints.values()) load(p.source, (image) => { p.image = image; redraw(); });
}
