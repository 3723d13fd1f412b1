"""Changes to an input that keep most of its structure, so that they reach further than the parser.

A mutator is a function from bytes, a generator and other inputs of the kind to new bytes: ``as_json(data, rng, pool)``.
"""

from __future__ import annotations

import io
import json
import re
import struct
import warnings
import zipfile
import zlib
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from random import Random

    Mutator = Callable[[bytes, Random, Sequence[bytes]], bytes]

LONGEST = 200_000
"""Bytes of an input that is made here, unless a flood is what is tried."""
NUMBERS = (
    "0", "-0.0", "1", "-1", "2", "0.5", "1e308", "-1e308", "1e-320", "1e999", "NaN", "-Infinity", "2147483648", "-2147483649",
    "18446744073709551616", "9" * 400, "-" + "9" * 5000, "0." + "3" * 400, "1e15", "65536", "1000000007", "0x10", "1_000", ".inf", "1e",
)  # fmt: skip
TEXTS = (
    "", "a", "a" * 300, "b" * 5000, "../../secret", "/etc/passwd", "/dev/zero", "~", "null", "true", "name\n", "nul\0", "\u202egnp.exe",
    "\x1b[2J\x1b]0;title\x07", "\r\b\b", "\u2028", "\ud800", "é", "-", "--help", "%2e%2e/x", "__class__", "o'bject", 'say "x"', "X", "_", "h1",
    "box", "corner", "[]", "is", "a/b/c", "a//b", ".", "..", "file:///etc/passwd", "data:;base64,AA==", "!!python/object:os.system", "*a", "&a x",
    "{{", "]]>", "<x/>", "\\", "#", ":- halt.", "0.5::a.", "h1/roof/apex", "noise", "unknown:u1",
)  # fmt: skip
FLOOD = 2_000, 20_000, 100_000
"""Repetitions of what is repeated."""
MANY = 100_000
"""Values of a tree that are looked at, and that one change adds."""
CHANGES = 1, 1, 1, 2, 4, 8
"""Of one input: what is changed once often passes the checks, and reaches what comes after them."""


def as_bytes(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """One to eight changes of bytes, wherever they fall."""
    out = bytearray(data)
    for _ in range(1 << rng.randrange(4)):
        at, size = rng.randrange(len(out) + 1), 1 << rng.randrange(8)
        change = rng.randrange(7)
        if change == 0 and at < len(out):
            out[at] ^= 1 << rng.randrange(8)
        elif change == 1:
            out[at:at] = rng.randbytes(size)
        elif change == 2:
            del out[at : at + size]
        elif change == 3:
            out[at : at + size] = rng.randbytes(len(out[at : at + size]))
        elif change == 4:
            number = rng.choice((0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, rng.randrange(1 << 32)))
            packed = struct.pack(rng.choice("<>") + "I", number)[: rng.choice((1, 2, 4))]
            out[at : at + len(packed)] = packed
        elif change == 5:
            other = rng.choice(pool)
            start = rng.randrange(len(other) + 1)
            out[at : at + size] = other[start : start + 4 * size]
        elif rng.randrange(8) == 0:
            del out[at:]
        else:
            out[at:at] = out[at : at + size] * rng.choice((1, 2, 16))
    return bytes(out[: 4 * LONGEST])


WORDS = (
    ("e", (0.0, -0.0, 1.0, 65504.0, float("inf"), float("nan"))),
    ("f", (0.0, -1.0, 1e-38, 3e38, float("inf"), float("nan"))),
    ("d", (0.0, -1.0, 1e-9, 1e9, 1e308, 5e-324, float("inf"), float("nan"))),
    ("i", (0, 1, -1, 2**31 - 1, -(2**31), 65_536)),
    ("q", (0, 1, -1, 2**31, 2**53, 2**63 - 1, -(2**63))),
)
"""Numbers of 2, 4 and 8 bytes, by their codes of ``struct``."""


def as_numbers(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """One to eight numbers in their places, which leaves the length; now and then, as bytes."""
    if len(data) < 8 or rng.randrange(4) == 0:
        return as_bytes(data, rng, pool)
    out = bytearray(data)
    for _ in range(rng.choice(CHANGES)):
        code, numbers = rng.choice(WORDS)
        size = struct.calcsize(code)
        at = rng.randrange(len(out) // size) * size + len(out) % size * rng.randrange(2)  # counted from either end
        struct.pack_into(f"<{code}", out, min(at, len(out) - size), rng.choice(numbers))
    return bytes(out)


# -- trees -------------------------------------------------------------------------------------------------------------


class _Raw(str):
    """What stands in the text as it is."""

    __slots__ = ()


def as_json(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """One to eight changes anywhere in the tree; now and then, of the text."""
    try:
        tree = json.loads(data)
    except (ValueError, RecursionError):
        return as_text(data, rng, pool)
    if rng.randrange(12) == 0:
        return as_text(data, rng, pool)
    for _ in range(rng.choice(CHANGES)):
        tree = changed(tree, rng)
    return _dumped(tree, 10 * LONGEST).encode("utf-8", "surrogatepass")


def as_log(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """One line of a log as JSON, with the head that a line has; now and then, all as a text."""
    lines = data.splitlines(keepends=True)
    if not lines or rng.randrange(8) == 0:
        return as_text(data, rng, pool)
    at = rng.randrange(len(lines))
    line = as_json(lines[at], rng, pool).replace(b'{"format": ', b'{"format":', 1) + b"\n"
    lines[at : at + rng.randrange(2)] = [line] * rng.choice((1, 1, 1, 2))
    return b"".join(lines)


def as_yaml(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """As JSON, which is YAML as well, or as a text."""
    if rng.randrange(2) or len(data) > LONGEST // 10:
        return as_text(data, rng, pool)
    try:
        text = json.dumps(YAML(typ="safe").load(data))
    except (YAMLError, ValueError, TypeError, RecursionError):
        return as_text(data, rng, pool)
    return as_json(text.encode(), rng, pool)


def changed(tree: Any, rng: Random) -> Any:  # noqa: ANN401 - JSON
    """The tree, with one of its values another."""
    holders = [(at, key) for at in values(tree) for key in _keys(at)][:MANY]
    if not holders or rng.randrange(60) == 0:
        return _value(tree, rng)
    at, key = rng.choice(holders)
    what = rng.randrange(8)
    if what == 0:
        del at[key]
    elif what == 1:
        _beside(at, key, rng)
    elif what == 2:
        other, elsewhere = rng.choice(holders)
        at[key] = other[elsewhere] if all(inner is not at for inner in values(other[elsewhere])) else None
    elif what == 3 and isinstance(at, dict):
        at[rng.choice((*TEXTS, *map(str, at)))] = at.pop(key)
    else:
        at[key] = _value(at[key], rng)
    return tree


def _beside(at: Any, key: Any, rng: Random) -> None:  # noqa: ANN401 - JSON
    """One more element, or key, like one that is there."""
    if isinstance(at, list):
        times = rng.choice((1, 1, 1, 3, 50, rng.choice(FLOOD) if rng.randrange(20) == 0 else 2))
        at[key:key] = [at[key]] * min(times, MANY // len(values(at[key])))
    else:
        at[rng.choice(TEXTS)] = at[key]


def _value(old: Any, rng: Random) -> Any:  # noqa: ANN401 - JSON
    if type(old) in (int, float) and abs(old) < 1e12 and rng.randrange(2):
        return _near(old, rng)
    what = rng.randrange(9)
    if what < 3:
        return _Raw(rng.choice(NUMBERS))
    if what < 5:
        return rng.choice(TEXTS)
    if what == 5:
        return _Raw(nested(rng))
    return rng.choice((None, True, False, [], {}, [old], {"a": old}, [0.0] * 3, [[1, 0], [0, 1]], [old, old]))


def _near(old: float, rng: Random) -> float:
    """A number that may stand there as well."""
    return rng.choice((-old, old * 1e6, old + 1e-9, old / 3, int(old), old + 1, old - 1, old * 1.01, 0, 0.999, 1e-300))


def nested(rng: Random) -> str:
    """Brackets in brackets, as deep as a parser may like or not."""
    deep = rng.choice((3, 30, 90, 300, 1200, 6000))
    opened, closed = rng.choice((("[", "]"), ('{"a":', "}")))
    return opened * deep + "1" + closed * (deep if rng.randrange(3) else deep - 1)


def values(tree: Any) -> list[Any]:  # noqa: ANN401 - JSON
    """The tree, and what is in it, at most ``MANY`` values."""
    every = [tree]
    for at in every:  # which grows
        if len(every) >= MANY:
            break
        every += [at[key] for key in _keys(at)]
    return every[:MANY]


def _keys(at: Any) -> Sequence[Any]:  # noqa: ANN401 - JSON
    return list(at) if isinstance(at, dict) else range(len(at)) if isinstance(at, list) else ()


def _dumped(tree: Any, most: int) -> str:  # noqa: ANN401 - JSON
    """JSON, in which what is ``_Raw`` stands as it is; so many characters at most, since parts may be shared."""
    waiting, done, size = [tree], list[str](), 0
    while waiting and size < most:
        at = waiting.pop()
        if isinstance(at, dict | list):
            named = {key: f"{json.dumps(str(key))}: " for key in at} if isinstance(at, dict) else {}
            ends = ("{", "}") if isinstance(at, dict) else ("[", "]")
            parts = [part for key in _keys(at) for part in (_Raw(", " + named.get(key, "")), at[key])]
            parts[:1] = [_Raw(part[2:]) for part in parts[:1]]
            waiting += [_Raw(ends[1]), *reversed(parts), _Raw(ends[0])]
        else:
            done.append(str(at) if isinstance(at, _Raw) else json.dumps(at))
            size += len(done[-1])
    return "".join(done)[:most]


# -- texts -------------------------------------------------------------------------------------------------------------

_TOKEN = re.compile(r"\d+\.?\d*(?:[eE][-+]?\d+)?|\w+|\s+|[^\w\s]")
_BRACKETS = "[", "{", "(", "<", "- ", "? ", "'", '"', "[[", "{a: ", "f(", "<a>", "&a [", "\\+", "%", "/*", "|\n"


def as_text(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """One to eight changes of tokens or lines; now and then, of bytes."""
    if rng.randrange(15) == 0:
        return as_bytes(data, rng, pool)
    tokens = _TOKEN.findall(data.decode("utf-8", "replace"))
    for _ in range(rng.choice(CHANGES)):
        _reworded(tokens, rng, pool)
    return "".join(tokens).encode("utf-8", "surrogatepass")[: 10 * LONGEST]


def _reworded(tokens: list[str], rng: Random, pool: Sequence[bytes]) -> None:
    at, what = rng.randrange(len(tokens) + 1), rng.randrange(10)
    if what < 3 and tokens:
        numbers = [i for i, token in enumerate(tokens) if token[:1].isdigit()]
        place = rng.choice(numbers) if numbers and rng.randrange(3) else min(at, len(tokens) - 1)
        tokens[place] = _reworded_one(tokens[place], rng)
    elif what == 3:
        del tokens[at : at + rng.choice((1, 1, 2, 5, 20))]
    elif what == 4:
        tokens[at:at] = tokens[at : at + rng.choice((1, 3, 10))] * rng.choice((1, 2, 100))
    elif what == 5:
        other = _TOKEN.findall(rng.choice(pool).decode("utf-8", "replace"))
        start = rng.randrange(len(other) + 1)
        tokens[at:at] = other[start : start + rng.choice((1, 5, 30))]
    elif what == 6:
        tokens[at:at] = [rng.choice(_BRACKETS) * rng.choice((1, 1, 1, 20, rng.choice(FLOOD)))]
    elif what == 7 and len(tokens) > 1:
        one, other_place = rng.randrange(len(tokens)), rng.randrange(len(tokens))
        tokens[one], tokens[other_place] = tokens[other_place], tokens[one]
    elif what == 8:
        tokens[at:at] = [rng.choice(("\n", "\t", "\r\n", "\n\n- ", "\ufeff", "\x00", "\n---\n", ": ", ",", "."))]
    else:
        tokens[at:at] = [rng.choice((*NUMBERS, *TEXTS))]


def _reworded_one(token: str, rng: Random) -> str:
    if token.isdecimal() and len(token) < 9 and rng.randrange(2):
        return str(_near(int(token), rng))
    return rng.choice(NUMBERS if token[:1].isdigit() and rng.randrange(4) else TEXTS)


def as_xml(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """As a text; now and then with entities that expand, or name a file."""
    if rng.randrange(10):
        return as_text(data, rng, pool)
    bomb = "".join(f'<!ENTITY e{i} "{f"&e{i - 1};" * 10 if i else "ha"}">' for i in range(9))
    entity = rng.choice((bomb, '<!ENTITY e8 SYSTEM "file:///etc/passwd">', '<!ENTITY % e8 SYSTEM "x.dtd"> %e8;'))
    text = re.sub(rb"^\s*<\?xml[^>]*\?>", b"", data)
    return f"<!DOCTYPE r [{entity}]>".encode() + text.replace(b">", b">&e8;", rng.choice((1, 2, 3)))


# -- files with checksums and tables, which are put right again --------------------------------------------------------

PNG_START = b"\x89PNG\r\n\x1a\n"


def as_png(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """One chunk's body changed, gone or doubled, the checksums right; now and then, the bytes."""
    if not data.startswith(PNG_START) or rng.randrange(5) == 0:
        return as_bytes(data, rng, pool)
    chunks, at = [], len(PNG_START)
    while at + 8 <= len(data):
        size, name = struct.unpack_from(">I4s", data, at)
        chunks.append((name, data[at + 8 : at + 8 + size]))
        at += 12 + size
    place = rng.randrange(len(chunks)) if chunks else 0
    for name, body in chunks[place : place + 1]:
        other = _repacked(body, rng, pool) if name == b"IDAT" and rng.randrange(2) else as_bytes(body, rng, pool)
        chunks[place : place + 1] = [(name, other)] * rng.choice((1, 1, 1, 1, 0, 2))
    rows = [
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body)) for name, body in chunks
    ]
    return PNG_START + b"".join(rows)


def _repacked(body: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    try:
        return zlib.compress(as_bytes(zlib.decompressobj().decompress(body, LONGEST), rng, pool))
    except zlib.error:
        return body


HEADER = 128
"""Bytes before an array's numbers."""


def as_archive(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """One member of a ZIP changed, gone, doubled or renamed, the table right; now and then, the bytes."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = [(name, archive.read(name)[:LONGEST]) for name in archive.namelist()]
    except (
        zipfile.BadZipFile,
        OSError,
        ValueError,
        NotImplementedError,
        RuntimeError,
        zlib.error,
        EOFError,
        struct.error,
    ):
        return as_bytes(data, rng, pool)
    if not members or rng.randrange(6) == 0:
        return as_bytes(data, rng, pool)
    place = rng.randrange(len(members))
    name, body = members[place]
    head = rng.randrange(3)
    if head == 0:  # the head of an array tells its type and shape as text
        end = min(len(body), HEADER)
        body = as_text(body[10:end], rng, [body[10:end]])
        body = members[place][1][:8] + struct.pack("<H", len(body) & 0xFFFF) + body + members[place][1][end:]
    elif head == 1 and len(body) > HEADER:
        body = body[:HEADER] + as_numbers(body[HEADER:], rng, [body])
    else:
        body = as_bytes(body, rng, pool)
    members[place : place + 1] = rng.choice(
        ([(name, body)], [(name, body)], [], [(name, body)] * 2, [(rng.choice(TEXTS) or "x", body)])
    )
    out = io.BytesIO()
    with (
        warnings.catch_warnings(action="ignore"),
        zipfile.ZipFile(out, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive,
    ):
        for name, body in members:
            archive.writestr(zipfile.ZipInfo(name.encode("utf-8", "replace").decode().replace("\0", "")[:200]), body)
    return out.getvalue()


def as_glb(data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
    """The JSON of a GLB changed as a tree, the lengths right; now and then, the bytes."""
    if data[:4] != b"glTF" or len(data) < 20 or rng.randrange(3) == 0:
        return as_bytes(data, rng, pool)
    size = struct.unpack_from("<I", data, 12)[0]
    tree = as_json(data[20 : 20 + size], rng, [b"{}"])
    tree += b" " * (-len(tree) % 4)
    rest = data[20 + size :]
    return (
        struct.pack("<4sII", b"glTF", 2, 20 + len(tree) + len(rest))
        + struct.pack("<I4s", len(tree), b"JSON")
        + tree
        + rest
    )
