"""The twenty names: what they mean, their converses, and their coarsenings to the six and to LOS-14 (§3.7)."""

from collections import Counter

import pytest

from geometry.visibility.roc import (
    COARSE,
    RCC8,
    ROC20,
    coarse,
    coarse_converse,
    converse,
    los14,
    parts_of,
    rcc_converse,
    roc,
)


def test_there_are_twenty_and_each_is_an_image_and_an_order():
    assert len(set(ROC20)) == 20
    assert len({parts_of(r) for r in ROC20}) == 20
    assert all(roc(*parts_of(r)) == r for r in ROC20)
    assert Counter(coarse(r) for r in ROC20) == dict(zip(COARSE, (2, 3, 3, 3, 3, 6), strict=True))


def test_no_order_without_a_common_interior_and_no_common_interior_without_an_order():
    apart = {r for r in ROC20 if parts_of(r)[1] == "nobody"}
    assert {parts_of(r)[0] for r in apart} == {"DC", "EC"}
    with pytest.raises(KeyError):
        roc("DC", "x")
    with pytest.raises(KeyError):
        roc("PO", "nobody")


@pytest.mark.parametrize("relation", ROC20)
def test_the_converse_swaps_images_and_order(relation):
    (rcc, front), (back_rcc, back_front) = parts_of(relation), parts_of(converse(relation))
    assert converse(converse(relation)) == relation
    assert back_rcc == rcc_converse(rcc)
    assert (front, back_front) in {("x", "y"), ("y", "x"), ("both", "both"), ("nobody", "nobody")}
    assert coarse(converse(relation)) == coarse_converse(coarse(relation))


def test_the_self_converse_ones_are_the_formalisms():
    own = {r for r in ROC20 if converse(r) == r}
    assert own == {"non_occludes_dc", "non_occludes_ec", "mutually_occludes_po", "mutually_occludes_eq"}
    assert converse("mutually_occludes_tpp") == "mutually_occludes_tppi"
    assert converse("partially_occludes_tpp") == "partially_occluded_by_tppi"
    assert converse("totally_occludes_ntppi") == "totally_occluded_by_ntpp"


def test_who_is_in_front_of_a_covered_image_occludes_it_totally():
    assert len(RCC8) == 8
    for rcc in RCC8[2:]:
        covered = rcc in ("EQ", "TPPi", "NTPPi")
        assert coarse(roc(rcc, "x")) == ("totally_occludes" if covered else "partially_occludes")
        assert roc(rcc, "x").endswith(f"_{rcc.lower()}")


def test_los_14_is_what_is_not_mutual():
    names = {r: los14(r) for r in ROC20}
    assert len({n for n in names.values() if n}) == 14
    assert {r for r, n in names.items() if n is None} == {r for r in ROC20 if coarse(r) == "mutually_occludes"}
    for relation, name in names.items():
        if name and name not in ("C", "JC"):
            assert los14(converse(relation)) == (name[:-1] if name.endswith("I") else f"{name}I")
