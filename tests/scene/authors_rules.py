"""Sixty rules.pl as authors may write them (§9.7): rules, choices, evidence, constraints, softened ones.

By hand where a reader should see what is meant; the rest is drawn from pieces, the same ones every time.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

WRITTEN = {
    name: (text.strip(), goal)
    for section in Path(__file__).with_suffix(".pl").read_text(encoding="utf-8").split("\n%% ")[1:]
    for (head, _, text) in [section.partition("\n")]
    for (name, _, goal) in [head.partition(" ? ")]
}
"""What it is an example of: the text, and a goal to ask beside who is present."""

BODIES = (
    "object(X, t1)", "object(X, t2)", "object(X, 'A Box')", "present(X), present(Y), X \\= Y", "left_of(X, Y)", "near(X, Y, 0.5)", "above(X, Y)",
    "detected(X, _)", "case(X, _, c)", "occludes(X, Y)", "present(X), \\+ detected(X, _)", "ev(X, V), V < 0.5", "present(X), \\+ object(X, t1)",
    "distance(X, D), D > 1, present(X)", "in_view_of_camera(X)", "cause(_, X, _)", "nearer(X, Y), \\+ on(X, Y)",
)  # fmt: skip
"""What may stand in a body, with a variable X that is a hypothesis."""
MOST = 60


def drawn(seed: int) -> tuple[str, str]:
    """A stratified text: each predicate calls those before it, some negated; then what is observed and constrained."""
    rng = Random(seed)  # noqa: S311 - a test's

    def sign() -> str:
        return rng.choice(["", "\\+ "])

    known, lines = ["present(X)"], []
    for i in range(rng.randint(2, 4)):
        head, label = f"q{i}(X)", rng.choice(["", "", "0.3::", "0.75::"])
        more = rng.choice(["", f", {sign()}{rng.choice(known[1:])}"]) if i else ""
        if rng.random() < 0.25:
            head, label = f"0.25::q{i}(X); 0.5::r{i}(X)", ""
        lines.append(f"{label}{head} :- {rng.choice(BODIES)}{more}.")
        known.append(f"q{i}(X)")
    for i in range(rng.randint(1, 2)):
        name = rng.choice([f"c{i}", f"c{i}(X)"])
        lines.append(f"constraint({name}) :- {rng.choice(BODIES)}, {sign()}{rng.choice(known[1:])}.")
        if rng.random() < 0.7:
            lines.append(f"{rng.choice(['0.2', '0.5', '0.9'])}::constraint_may_fail({name}).")
    if rng.random() < 0.5:
        lines.append(f"0.1::odd.\nseen :- odd.\nseen :- {rng.choice(known[1:])}.\nevidence({sign()}seen).")
    return "\n".join(lines), known[-1]


TEXTS = [*WRITTEN.items(), *((f"drawn {seed}", drawn(seed)) for seed in range(MOST - len(WRITTEN)))]
