// The document, who watches it, and making elements. Data becomes text nodes and plain attributes, never markup.
const block = (id) => JSON.parse((document.getElementById(id) || {}).textContent || '{}');
const read = block('data');
const watchers = [];
const changed = (what) => watchers.forEach((w) => w(what));

function make(space, name, attributes, children) {
  const node = space ? document.createElementNS(space, name) : document.createElement(name);
  for (const [k, v] of Object.entries(attributes || {})) if (v != null) node.setAttribute(k, v);
  node.append(...children.flat(Infinity).filter((c) => c != null));
  return node;
}
const el = (name, attributes, ...children) => make(null, name, attributes, children);
const tag = (kind, ...children) => el('span', {class: kind}, ...children);
const svg = (name, attributes, ...children) => make('http://www.w3.org/2000/svg', name, attributes, children);
const at = (id) => document.getElementById(id);
const fill = (node, ...children) => node.replaceChildren(...children.flat(Infinity).filter((c) => c != null));
const put = (id, ...children) => fill(at(id), ...children);

function swatch(c) {
  const s = el('span', {class: 'swatch', 'aria-hidden': 'true'});
  s.style.background = c;
  return s;
}
function bar(share) {
  const fill = el('i');
  fill.style.width = 100 * Math.max(0, Math.min(1, share || 0)) + '%';
  return el('span', {class: 'bars', 'aria-hidden': 'true'}, fill);
}
function toggle(name, on, text, change) {
  const box = el('input', {type: 'checkbox', 'data-layer': name});
  box.checked = on;
  box.addEventListener('change', () => change(box.checked));
  return el('label', null, box, text);
}
function button(text, click, attributes) {
  const b = el('button', {type: 'button', ...attributes}, text);
  b.addEventListener('click', click);
  return b;
}

// Arrays that travel as base64.
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const floats = (text) => new Float32Array(bytes(text || '')), shorts = (text) => new Uint16Array(bytes(text || ''));

const words = (s) => String(s).replace(/_/g, ' ');
const plural = (n, one, many) => n + ' ' + (n === 1 ? one : many || one + 's');
function head(kicker, title, lead) {
  put('kicker', el('b', null, 'plogic'), kicker);
  put('headline', title);
  put('lead', lead);
}
const foot = (source, digest) => put('foot', el('p', null, `Made by plogic from ${source}, digest ${String(digest || '').slice(0, 16)}. This page is whole in itself and loads nothing.`));

// An image of the document as an address, null for what is none.
const address = (i) => (i && /^image\/(png|jpeg)$/.test(i.media_type) && /^[A-Za-z0-9+/=]+$/.test(i.base64) ? `data:${i.media_type};base64,${i.base64}` : null);
function load(source, then) {
  const image = new Image();
  image.onload = () => then(image);
  image.src = source;
}
