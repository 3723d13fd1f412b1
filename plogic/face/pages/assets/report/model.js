// What the page knows: the document, the world that is shown, and what the four cases are in it (D7, D8). No drawing here.
const list = (x) => (Array.isArray(x) ? x : []);
const doc = Object.assign({camera: {}, measures: {}, assets: {}, kb: {}}, read);
const appearances = list(doc.appearances), hypotheses = list(doc.hypotheses), facts = list(doc.facts);
const worlds = list(doc.worlds).length ? doc.worlds
  : [{probability: null, present: hypotheses.filter((h) => h.status === 'accepted').map((h) => h.id), causes: {}}];
const byId = new Map(hypotheses.map((h) => [h.id, h]));
const appearanceById = new Map(appearances.map((a) => [a.id, a]));
const colours = new Map([...hypotheses.filter((h) => h.status === 'accepted'), ...hypotheses.filter((h) => h.status !== 'accepted')]
  .map((h, i) => [h.id, PALETTE[i % PALETTE.length]]));
const MUTED = '#9aa0a6', colour = (id) => colours.get(id) || MUTED;
const standing = (world) => world.present.map((id) => byId.get(id)).filter(Boolean);
const label = (id) => { const h = byId.get(id); return h ? String(h.label || h.type) : String(id); };
const called = (id) => `${label(id)} (${id})`;
const rivals = new Set(facts.filter((f) => f.fact === 'rival').flatMap((f) => [f.args.join('\n'), f.args.slice().reverse().join('\n')]));

const state = {shown: worlds[0], layers: new Set(['marks', 'appearances', 'expected', 'hidden', 'missed', 'outlines', 'unseen', 'ground', 'labels']), chosen: null};

// Whether g hides what is behind it of h in the shown world: it is there, opaque, and no rival.
const hides = (g, h) => state.shown.present.includes(g) && (byId.get(g) || {}).opaque !== false && !rivals.has(h.id + '\n' + g);
// The feature in the shown world: {expected, detected, letter, hiders}; letter is null outside the image.
function caseOf(h, f) {
  const by = list(f.hidden_by).filter((g) => hides(g, h));
  const expected = Boolean(f.in_image && f.in_lobe && !(f.self_hidden && h.opaque !== false) && !by.length);
  const taken = doc.reconsider === 'reassign' && !expected && f.match && (claimant(f.match) || {h}).h !== h;
  const detected = f.match != null && !taken;
  return {expected, detected, hiders: by, letter: !f.in_image ? null : expected ? (detected ? 'A' : 'C') : (detected ? 'D' : 'B')};
}

// What causes the appearance in the world: {h, f}, or null for noise and for what nobody knows.
function claimant(id, world = state.shown) {
  const cause = String((world.causes || {})[id] || ''), cut = cause.indexOf('/'), h = byId.get(cause.slice(0, cut));
  return h && cut > 0 ? {h, f: list(h.features).find((f) => f.id === cause.slice(cut + 1))} : null;
}

const MINUS = '\u2212';
const fixed = (x, n) => (x == null || !isFinite(x) ? '\u2013' : (x < 0 && Number(x.toFixed(n)) !== 0 ? MINUS : '') + Math.abs(x).toFixed(n));
const chance = (p) => (p == null ? '\u2013' : p > 0 && p < 0.0005 ? '<0.001' : p < 1 && p > 0.9995 ? '>0.999' : p.toFixed(3));
const and = (xs) => (xs.length < 2 ? xs.join('') : xs.slice(0, -1).join(', ') + ' and ' + xs[xs.length - 1]);

// Why the feature is in its case, in one sentence.
function reason(h, f) {
  const c = caseOf(h, f), a = appearanceById.get(f.match), cause = f.match != null ? claimant(f.match) : null;
  const found = a ? `${a.id} (${named(a.type)})` + (f.residual != null ? `, ${fixed(f.residual, 1)} px ${isSide(f) ? 'off across the edge' : 'from its place'}` : '') : '';
  const because = c.hiders.length ? `it is hidden behind ${and(c.hiders.map(called))}`
    : f.self_hidden ? 'its own object hides it' : !f.in_lobe ? 'it does not show itself from this viewpoint' : 'it lies outside the image';
  if (c.letter === 'A') return `Expected and detected as ${found}.`;
  if (c.letter === 'C') {
    const would = list(f.hidden_by).filter((g) => !state.shown.present.includes(g) && byId.has(g));
    return 'Expected, but nothing was detected: missed by the detectors, or hidden by something unknown.'
      + (would.length ? ` ${and(would.map(called))} would hide it, but is not in this world.` : '');
  }
  if (c.letter === 'D') {
    return `Not expected, since ${because}; yet ${found} is there. `
      + (cause && cause.h !== h ? `Here that is explained by ${called(cause.h.id)}.` : 'Noise, or something that is not known.');
  }
  return c.letter === 'B' ? `Not expected, since ${because}; and not detected.` : 'It lies outside the image, so it counts neither way.';
}
