// Surfaces with their textures or their vertices' colours, in their own frames, by type: {vertices, triangles, uv, colours, source, image, middles}; image once it has come.
const paints = new Map(Object.entries(doc.assets.paints || {}).map(([type, p]) => [type, {vertices: floats(p.vertices), triangles: shorts(p.triangles), uv: p.uv ? floats(p.uv) : null,
  colours: p.colours ? new Uint8Array(bytes(p.colours)) : null, source: address(p.picture), image: null, middles: null}])
  .filter(([, p]) => (p.colours ? p.colours.length === p.vertices.length : p.source && p.uv && p.uv.length * 3 === p.vertices.length * 2)));
const paintOf = (h) => { const p = shape.texture && h.opaque !== false ? paints.get(h.type) : null; return p && (p.image || p.colours) ? p : null; };
// The colour of vertex i.
const shadeOf = (p, i) => [0, 1, 2].map((k) => p.colours[3 * i + k] / 255);
// The colour of each triangle, for a canvas that has no textures.
const flatColours = (p) => (p.image ? middles(p, p.image) : Array.from({length: p.triangles.length / 3}, (_, t) => times([0, 1, 2].map((i) => shadeOf(p, p.triangles[3 * t + i])).reduce(add), 1 / 3)));
// As rows of its corners: place, normal, then the texture's coordinate or a colour.
function paintRows(p) {
  const rows = cornerRows(p);
  return p.image ? rows : Float32Array.from([...p.triangles].flatMap((i, t) => [...rows.subarray(8 * t, 8 * t + 6), ...shadeOf(p, i)]));
}
function startPaints() {
  for (const p of paints.values()) if (p.source) load(p.source, (image) => { p.image = image; redraw(); });
}
