"""What the documents say is what the program says.

Commands, vocabulary, the README's outputs and its knowledge base.
"""

import importlib.util
import math
import re
import shlex
from pathlib import Path

import click
import pytest
from console import good

from cli import cli
from plogic.cycle.judging import FEWEST
from plogic.cycle.state import MOST_EQUAL, MOST_RIVALS
from plogic.facts.dependence import LARGEST_BLOCK, MOST_OCCLUDERS
from plogic.facts.vocabulary import VOCABULARY
from plogic.match.hand.links import MOST_PAIRS
from plogic.match.hand.view_cells import CELLS
from plogic.match.judged.evidence import FIXED_BY
from plogic.match.judged.rivals import SAME_PLACE, SAME_ROTATION, SHARED_CLAIMS, SHARED_VOLUME
from plogic.run.perceive import SMOOTHED

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
README = ROOT / "README.md"
HOW = "run `python docs/generate.py`"
WORDS = {2: "two", 3: "three", 4: "four", 6: "six", 8: "eight", 10: "ten"}
LINK = re.compile(r"\]\(([^)#:]+)\)")


@pytest.fixture(scope="module")
def generate():
    spec = importlib.util.spec_from_file_location("docs_generate", DOCS / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


FIGURES = [
    (f"from {CELLS} directions", "how-it-works.md"),
    (f"ln {MOST_PAIRS}", "how-it-works.md"),
    (f"at least {WORDS[FEWEST]} *expected* features", "how-it-works.md"),
    (f"without its {WORDS[FIXED_BY]} best matches", "how-it-works.md"),
    (f"beyond {SHARED_VOLUME * 100:g} % of the smaller one", "how-it-works.md"),
    (f"At most {WORDS[MOST_RIVALS]} rivals", "how-it-works.md"),
    (f"up to {WORDS[MOST_EQUAL]} that are as heavy", "how-it-works.md"),
    (f"smoothed by {SMOOTHED:g}", "how-it-works.md"),
    (f"at most {WORDS[LARGEST_BLOCK]} hypotheses", "how-it-works.md"),
    (f"({round(math.degrees(SAME_ROTATION))}°, {SAME_PLACE * 100:g} % of the distance)", "how-it-works.md"),
    ("at most half of what the one with fewer claims does" if SHARED_CLAIMS == 0.5 else "", "how-it-works.md"),
    (f"smoothed by {SMOOTHED:g}", "limits.md"),
    (f"At most {WORDS[MOST_OCCLUDERS]} occluders", "limits.md"),
    (f"more than {WORDS[LARGEST_BLOCK]} hypotheses", "limits.md"),
    (f"share {SHARED_VOLUME * 100:g} % of the smaller volume", "paper-map.md"),
]


def leaves(command, path):
    members = getattr(command, "commands", {})
    return (
        [leaf for name, member in members.items() for leaf in leaves(member, f"{path} {name}")] if members else [path]
    )


def read(path):
    return path.read_text(encoding="utf-8")


def test_every_command_is_documented():
    titles = re.findall(r"^## (.+)$", read(DOCS / "commands.md"), re.MULTILINE)
    assert set(leaves(cli, "plogic")) <= set(titles)


def test_every_option_of_a_command_is_documented():
    text = read(DOCS / "commands.md")
    options = {
        o for command in cli.commands.values() for p in command.params if isinstance(p, click.Option) for o in p.opts
    }
    assert options
    assert not [option for option in options if option not in text]


def test_the_help_texts_are_current(generate):
    assert read(DOCS / "commands.md") == generate.commands(), HOW


def test_the_vocabulary_is_current(generate):
    text = read(DOCS / "vocabulary.md")
    assert text == generate.vocabulary(), HOW
    assert all(f"`{entry.usage}`" in text for entry in VOCABULARY)


def test_the_page_of_the_face_for_python_is_current(generate):
    assert read(DOCS / "api.md") == generate.api(), HOW + " --quick"


def test_the_page_of_formats_is_current(generate):
    assert read(DOCS / "formats.md") == generate.formats(), HOW + " --quick"


def test_the_drawing_of_floors_and_rooms_is_current(generate):
    assert read(DOCS / "architecture.md") == generate.page(), HOW + " --quick"
    assert read(DOCS / "architecture.svg") == generate.drawing(), HOW + " --quick"


@pytest.fixture
def once(generate, monkeypatch):
    """Each command runs once: several pages show the same, of which the same files are left.

    One that is nothing but our console script runs as the other tests' do; a shell runs all others.
    """
    shown, printed = {}, generate._printed
    settings = {"COLUMNS": "110", "NO_COLOR": "1"}

    def first(command, folder):
        name, *args = shlex.split(command)
        if command not in shown and name == "plogic" and not {"|", "<"} & set(args):
            text = good(*args, cwd=folder, **settings)
            shown[command] = "\n".join(line.rstrip() for line in text.strip("\n").splitlines())
        elif command not in shown:
            shown[command] = printed(command, folder)
        return shown[command]

    monkeypatch.setattr(generate, "_printed", first)


def test_readme_and_guides_print_what_their_commands_print(generate, once):
    texts = [read(page) for page in generate.GUIDES]
    assert [bool(generate.BLOCK.findall(text)) for text in texts] == [True] * len(texts)
    assert generate.guides(texts) == texts, HOW


def test_the_readme_is_short():
    assert len(read(README).split()) <= 1800


def test_the_guide_shows_the_example_as_it_is():
    shown = re.findall(r"^```yaml\n(.*?)^```$", read(DOCS / "knowledge-bases.md"), re.DOTALL | re.MULTILINE)
    folder = ROOT / "kb" / "first"
    assert len(shown) == 2
    assert shown[0] == read(folder / "kb.yaml")
    assert read(folder / "objects" / "box" / "object.yaml").startswith(shown[1])


@pytest.mark.parametrize(
    "page", [README, ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md"))], ids=lambda page: page.name
)
def test_links_lead_somewhere(page):
    assert not [target for target in LINK.findall(read(page)) if not (page.parent / target).exists()]


def test_the_picture_is_small():
    assert (DOCS / "demo.png").stat().st_size <= 250_000


@pytest.mark.parametrize(("words", "page"), FIGURES)
def test_a_figure_in_the_text_is_the_codes(words, page):
    assert words
    assert words in " ".join(read(DOCS / page).split())
