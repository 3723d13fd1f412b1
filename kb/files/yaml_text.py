"""YAML becomes plain data safely: within limits, without tags, and with the place of everything."""

import math
import re
import warnings
from contextlib import suppress

from ruamel.yaml import YAML
from ruamel.yaml.composer import MaxDepthExceededError
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.resolver import VersionedResolver

from kb.errors import Mistake
from kb.files.folder import MAX_BYTES, Document, Keys, dotted

MAX_NODES = 500_000
"""Most values of a document, those of an alias counted each time."""
SLOWLY_READ = 30_000
"""Characters of a text that ruamel's own parser is asked about, which reads some 50,000 a second."""
MAX_DEPTH = 60
"""Deepest nesting."""

_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_SPECIAL = {"true": True, "True": True, "false": False, "False": False, "null": None, "~": None, "": None}
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_TAGS = {f"tag:yaml.org,2002:{name}" for name in ("str", "int", "float", "bool", "null", "timestamp", "merge", "value")}


def load(file: str, content: bytes) -> Document:
    """Read a document; what is wrong with it stands in ``mistakes``, and its data is then what could be read."""
    if len(content) > MAX_BYTES:
        return _unread(file, f"{len(content)} bytes are more than the {MAX_BYTES} that a file may have")
    try:
        root = composed(content)
    except UnicodeDecodeError as error:
        return _unread(file, f"must be UTF-8: {error.reason}", content[: error.start].count(b"\n") + 1)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        deep = isinstance(error, MaxDepthExceededError)
        why = f"nested deeper than {MAX_DEPTH} levels" if deep else f"no YAML: {error.problem or error.context}"
        return _unread(file, why, line, column)
    except (YAMLError, ValueError, AssertionError) as error:  # the last of a %YAML 1.23
        return _unread(file, f"no YAML: {(str(error) or type(error).__name__).splitlines()[0]}")
    builder = _Builder(file)
    data = builder.value(root, ()) if root is not None else None
    return Document(file, data, lambda: root, tuple(builder.mistakes))


def _unread(file: str, message: str, line: int = 1, column: int = 1) -> Document:
    return Document(file, None, lambda: None, (Mistake(file, line, column, "", message),))


class _Kinds(VersionedResolver):
    """Tags by the kind of node alone: what a plain scalar means is decided below, the same for both parsers."""

    def resolve(self, kind: object, value: object, implicit: object) -> object:  # noqa: ARG002 - ruamel's signature
        if kind is ScalarNode:
            return self.DEFAULT_SCALAR_TAG
        return self.DEFAULT_SEQUENCE_TAG if kind is SequenceNode else self.DEFAULT_MAPPING_TAG


def composed(content: bytes) -> Node | None:
    """The node graph of a document.

    By libyaml where it is there and the text cannot be nested deeply, as its composer recurses in C.

    What libyaml refuses is put to ruamel's own parser, so that the same texts are YAML with and without it; but for
    long ones, as that takes seconds.
    """
    text = content.decode("utf-8-sig")
    if text.count("\n") + text.count(",") > MAX_NODES:
        raise YAMLError(f"more than {MAX_NODES} lines and commas")
    deep, short = _may_be_deep(text), len(text) <= SLOWLY_READ
    if deep and not short:
        raise YAMLError(f"too many brackets, or spaces before a line, for a file of more than {SLOWLY_READ} characters")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of anchors that are defined twice, which YAML permits
        if not short:
            return _composed(text, pure=False)
        if not deep:
            with suppress(YAMLError, ValueError):
                return _composed(text, pure=False)
        return _composed(text, pure=True)


def _composed(text: str, *, pure: bool) -> Node | None:
    yaml = YAML(typ="safe", pure=pure)
    yaml.Resolver = _Kinds
    yaml.max_depth = MAX_DEPTH + 1  # its scanner looks at each open bracket with every token
    root: Node | None = yaml.compose(text)
    return root


def _may_be_deep(text: str) -> bool:
    depth = deepest = 0
    for bracket in re.findall(r"[\[{\]}]", text):
        depth += 1 if bracket in "[{" else -1
        deepest = max(deepest, depth)
    indents = max((len(line) - len(line.lstrip(" -?")) for line in text.splitlines()), default=0)
    return deepest + 2 * indents > 1000


class _Builder:
    """Plain data of a node graph, and the mistakes met on the way."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.mistakes: list[Mistake] = []
        self.count = 0
        self.above: set[int] = set()

    def report(self, node: Node, path: Keys, message: str) -> None:
        mark = node.start_mark
        self.mistakes.append(Mistake(self.file, mark.line + 1, mark.column + 1, dotted(path), message))

    def value(self, node: Node, path: Keys) -> object:
        self.count += 1
        if isinstance(node, ScalarNode):
            return self.scalar(node, path)
        if not self.may_enter(node, path):
            return None
        self.above.add(id(node))
        result = self.mapping(node, path) if isinstance(node, MappingNode) else self.sequence(node, path)
        self.above.discard(id(node))
        return result

    def may_enter(self, node: Node, path: Keys) -> bool:
        if id(node) in self.above:
            self.report(node, path, "A2: an alias makes this a part of itself")
        elif len(path) > MAX_DEPTH:
            self.report(node, path, f"nested deeper than {MAX_DEPTH} levels")
        elif self.count > MAX_NODES:
            if self.count != math.inf:
                self.report(node, path, f"more than {MAX_NODES} values, those of aliases counted each time")
            self.count = math.inf  # type: ignore[assignment]  # once is enough
        elif str(node.tag) not in ("tag:yaml.org,2002:map", "tag:yaml.org,2002:seq"):
            self.report(node, path, f"the tag {str(node.tag)[:60]} is not allowed")
        else:
            return True
        return False

    def sequence(self, node: Node, path: Keys) -> list[object]:
        return [self.value(item, (*path, index)) for index, item in enumerate(node.value)]

    def mapping(self, node: Node, path: Keys) -> dict[str, object]:
        result: dict[str, object] = {}
        for name, item in node.value:
            if not isinstance(name, ScalarNode):
                self.report(name, path, "a key must be a text")
            elif name.value in result:
                self.report(name, (*path, name.value), "this key was given before")
            else:
                result[self.whole(name, path)] = self.value(item, (*path, name.value))
        return result

    def scalar(self, node: ScalarNode, path: Keys) -> object:
        if str(node.tag) not in _TAGS:
            self.report(node, path, f"the tag {str(node.tag)[:60]} is not allowed")
            return None
        return self.whole(node, path) if node.style else self.plain(node, path)

    def whole(self, node: ScalarNode, path: Keys) -> str:
        """The text, two halves of a character (UTF-16, as JSON escapes it) made one; a half alone is a mistake."""
        text = str(node.value).encode("utf-16-le", "surrogatepass")
        try:
            return text.decode("utf-16-le")
        except UnicodeDecodeError:
            self.report(
                node,
                tuple(str(step).encode(errors="replace").decode() for step in path),
                "holds half of a character, \\ud800 to \\udfff",
            )
            return text.decode("utf-16-le", "replace")

    def plain(self, node: Node, path: Keys) -> object:
        text = node.value
        if text in _SPECIAL:
            return _SPECIAL[text]
        if _NOT_FINITE.fullmatch(text):
            self.report(node, path, f"must be finite, not {text}")
            return 0.0
        if len(text) <= 400 and _INTEGER.fullmatch(text):
            return int(text)
        return float(text) if _FLOAT.fullmatch(text) else text
