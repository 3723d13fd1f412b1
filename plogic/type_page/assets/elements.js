// Making elements. Data becomes text nodes and plain attributes, never markup.
function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [k, v] of Object.entries(attributes || {})) if (v != null) node.setAttribute(k, v);
  node.append(...children.flat(Infinity).filter((c) => c != null));
  return node;
}
const at = (id) => document.getElementById(id);
const put = (id, ...children) => at(id).replaceChildren(...children.flat(Infinity).filter((c) => c != null));

function swatch(c) {
  const s = el('span', {class: 'swatch', 'aria-hidden': 'true'});
  s.style.background = css(c);
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

const words = (s) => String(s).replace(/_/g, ' ');
const plural = (n, one, many) => n + ' ' + (n === 1 ? one : many || one + 's');
const round = (x, n = 3) => Number(x.toPrecision(n)).toString();
const metres = (x, n = 3) => (x === 0 ? '0' : x < 0.001 ? round(x * 1e3, 2) + ' mm' : x < 0.1 ? round(x * 1e2, 2) + ' cm' : x < 1e5 ? round(x, n) + ' m' : x.toExponential(1) + ' m');
const degrees = (x) => Math.round(x * 180 / Math.PI) + '\u00b0';
