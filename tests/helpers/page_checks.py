"""What is asked of every page, whatever it shows: as text, and in a browser."""

from __future__ import annotations

import base64
import hashlib
import re

FOREIGN = re.compile(r"https?://(?!www\.w3\.org/2000/svg)")
UNSAFE = re.compile(r"\son\w+=|innerHTML|outerHTML|insertAdjacent|document\.write|\beval\b|new Function|javascript:")
COUNT = "return document.querySelectorAll(arguments[0]).length"
DATA = "return {...document.querySelector('#stage canvas').dataset}"
COLOURS = """const c = document.querySelector('#stage canvas'), d = document.createElement('canvas');
d.width = c.width; d.height = c.height;
const x = d.getContext('2d'); x.drawImage(c, 0, 0);
const p = x.getImageData(0, 0, d.width, d.height).data, seen = new Set(); let drawn = 0, sum = 0;
for (let i = 0; i < p.length; i += 4) if (p[i + 3] > 250) {
  drawn += 1; sum = (sum * 31 + p[i] * 65536 + p[i + 1] * 256 + p[i + 2]) % 1e9; seen.add(p[i] + ',' + p[i + 1] + ',' + p[i + 2]); }
return [drawn, seen.size, sum]"""
"""How many of the stage's pixels are drawn, in how many colours, and a number that any change of one changes."""
CONTRAST = """const light = (c) => { const v = c.match(/[\\d.]+/g).slice(0, 3)
  .map((x) => { x /= 255; return x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4; });
  return 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2]; };
const ground = light(getComputedStyle(document.body).backgroundColor), out = [];
const written = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()) && e.offsetParent;
for (const e of [...document.querySelectorAll('body *:not(svg *)')].filter(written)) {
  const l = light(getComputedStyle(e).color); out.push((Math.max(l, ground) + 0.05) / (Math.min(l, ground) + 0.05)); }
return [out.length, Math.min(...out)]"""


def element(text, name, attributes=""):
    """The content of the page's only element of that name."""
    found = re.findall(f"<{name}{attributes}>(.*?)</{name}>", text, re.DOTALL)
    assert len(found) == 1
    return found[0]


def data_text(text):
    return element(text, "script", ' type="application/json" id="data"')


def check_policy(text, name):
    """It names the hash of the page's own script or style, and allows nothing else."""
    digest = base64.b64encode(hashlib.sha256(element(text, name).encode()).digest()).decode()
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text).group(1)
    assert f"{name}-src 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none'; ")
    assert "unsafe" not in policy


def check_harmless(text):
    """Nothing is loaded, no markup is made from data, no text is run."""
    assert not UNSAFE.search(text)
    assert not FOREIGN.search(text)


def complaints(browser):
    """The browser's messages but for the software renderer's remark that reading pixels is slow."""
    return [m for m in browser.log() if "GPU stall due to ReadPixels" not in m]


def contrast(browser, *, dark):
    """How many texts there are, and the least contrast of one with the page's ground."""
    browser.dark(on=dark)
    texts, least = browser.run(CONTRAST)
    browser.dark(on=False)
    return texts, least


def shown_as(browser, folder, text, *size):
    """The browser with that page open."""
    file = folder / "page.html"
    file.write_text(text, encoding="utf-8")
    browser.open(file, *size)
    return browser
