"""The same intents through goals, evidence, rules, a knowledge base, an interpretation, and the shell."""

from __future__ import annotations

from benchmarks.fuzz.hostile.program import Hostile, programs

GOALS = {
    "a loader as the goal": "consult('{pl}')",
    "a loader built in the goal": "G =.. [use_module, '{py}'], call(G)",
    "a second clause after the goal": "a. :- consult('{pl}'). query(a)",
    "a goal that closes its own clause": "a), consult('{pl}'), (a",
    "a goal that defines": "(a :- consult('{pl}'))",
    "a goal with a comment left open": "a, consult('{pl}') /*",
}
SCENE_GOALS = {
    "a loader as a scene's goal": "present(H), G =.. [consult, '{pl}'], call(G)",
    "a loader in a scene's name": "present('h1\\'), consult(\\'{pl}\\'), x(\\'')",
}
GIVEN = {
    "a loader as evidence": "consult('{pl}')",
    "a loader built as evidence": "findall(x, (G =.. [use_module, '{py}'], G), [x])",
}
SCENE_GIVEN = {"a loader as a scene's evidence": "\\+ consult('{pl}')"}
RULES = {
    "a loader in rules beside a program": "c :- consult('{pl}'). evidence(c).",
    "a loader built in rules": "c :- G =.. [use_module, '{py}'], call(G). evidence(c).",
    "rules that add to what is asked": "a :- consult('{pl}'). query(consult('{pl}')).",
}
SCENE_RULES = {
    "a loader in a scene's constraint": "constraint(x) :- consult('{pl}').",
    "a loader in a scene's softened constraint": (
        "constraint(G) :- present(_), G =.. [consult, '{pl}'], G. 0.5::constraint_may_fail(consult(_))."
    ),
    "a directive in a scene's rules": ":- use_module(library('{py}')). :- ['{pl}'].",
}
CHECKED_RULES = {"a loader in a knowledge base's rules": "constraint(x) :- consult('{pl}')."}
KB_RULES = {
    "a loader built in a knowledge base's rules": "bad(H) :- present(H), G =.. [use_module, '{py}'], G. evidence(\\+ bad(_)).",
    "another library in a knowledge base's rules": ":- use_module(library(db)). :- csv_load('{csv}', row).",
}
SCENE_TEXT = {
    "a loader in an interpretation's rules": "constraint(x) :- consult('{pl}').",
    "a loader built in an interpretation's rules": "constraint(x) :- object(_, _), G =.. [use_module, '{py}'], call(G).",
}
LINES = {
    "a loader asked in the shell": "ask consult('{pl}')\nask G =.. [use_module, '{py}'], call(G)",
    "a loader observed in the shell": "observe consult('{pl}')\npredict a\nworlds 3",
    "the shell's own verbs on files": "listing {secret}\nlisting consult/1\nhelp {secret}",
    "the system's shell from the shell": "!touch {new}\n$(touch {new})\n`touch {new}`\nask a; touch {new}",
}


def other_doors() -> list[Hostile]:
    """Those that come beside something harmless."""
    return [
        *programs("goal", GOALS),
        *programs("scene goal", SCENE_GOALS),
        *programs("given", GIVEN),
        *programs("scene given", SCENE_GIVEN),
        *programs("rules", RULES),
        *programs("scene rules", SCENE_RULES, asked="present(H)"),
        *programs("kb", CHECKED_RULES),
        *programs("perceive", KB_RULES),
        *programs("interpretation", SCENE_TEXT, asked="present(H)"),
        *programs("shell", LINES),
    ]
