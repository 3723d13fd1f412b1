"""What scripts are given: a knowledge base, and a dataset of photos that its types are of."""

import argparse
from pathlib import Path


def of_kb_and_dataset(doc: str | None) -> argparse.ArgumentParser:
    """A parser of ``KB DATASET`` that is described by the first line of a module's ``doc``."""
    parser = argparse.ArgumentParser(description=(doc or "").partition("\n")[0])
    parser.add_argument("kb", metavar="KB")
    parser.add_argument("dataset", type=Path, metavar="DATASET")
    return parser
