"""``cloud.npz``: the same cloud gives the same bytes and comes back.

Whatever else the file holds is one CloudError, and nothing in it is run.
"""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_cloud import random_cloud

from kb.clouds import learned
from kb.clouds.learned import _SHAPES, cloud_bytes, read_cloud
from kb.errors import CloudError


class Booby:
    """Leaves a file behind when it is unpickled."""

    def __init__(self, place):
        self.place = place

    def __reduce__(self):
        return Path.touch, (self.place,)


def packed(array, **how):
    memory = io.BytesIO()
    np.save(memory, array, **how)
    return memory.getvalue()


def with_member(name, content, packing=zipfile.ZIP_DEFLATED, cloud=None):
    """The file of a good cloud with one member in place of its own; None leaves it out."""
    memory = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(cloud_bytes(cloud or random_cloud()))) as old, zipfile.ZipFile(memory, "w") as new:
        for item in old.namelist():
            if item != f"{name}.npy":
                new.writestr(item, old.read(item))
        if content is not None:
            new.writestr(f"{name}.npy", content, packing)
    return memory.getvalue()


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 9), st.integers(0, 8), st.integers(0, 9), st.sampled_from([32, 128]))
def test_a_cloud_comes_back_and_is_the_same_bytes_again(seed, features, more, width):
    cloud = random_cloud(seed, features, features + more if features else 0, width=width)
    content = cloud_bytes(cloud)
    back = read_cloud(content)
    assert (
        cloud_bytes(back)
        == content
        == cloud_bytes(random_cloud(seed, features, features + more if features else 0, width=width))
    )
    assert back.detector == ("orb" if width == 32 else "sift")
    for name in _SHAPES:
        there = getattr(back, name)
        assert there.shape == getattr(cloud, name).shape
        assert not there.flags.writeable
        np.testing.assert_allclose(there, getattr(cloud, name), rtol=1e-6, atol=1e-7)


def test_every_prefix_and_every_spoilt_byte_is_a_cloud_error_or_the_same_cloud():
    content = cloud_bytes(random_cloud())
    whole = {name: getattr(read_cloud(content), name) for name in _SHAPES}
    rng = np.random.default_rng(1)
    spoilt = [content[:n] for n in rng.integers(0, len(content), 60)]
    for place in rng.integers(0, len(content), 300):
        other = bytearray(content)
        other[place] ^= int(rng.integers(1, 256))
        spoilt.append(bytes(other))
    told = []
    for some in spoilt:
        try:
            cloud = read_cloud(some)
        except CloudError as error:
            told.append(str(error))
        else:
            assert all(np.array_equal(getattr(cloud, name), whole[name]) for name in _SHAPES)
    assert len(told) > 250
    assert not any("\n" in text for text in told)


@pytest.mark.parametrize("content", [b"", b"PK", b"no zip at all", b"\x80\x04N.", packed(np.zeros(3))])
def test_what_is_no_archive_is_no_cloud(content):
    with pytest.raises(CloudError, match="is no learned cloud"):
        read_cloud(content)


def test_pickled_objects_are_refused_and_not_run(tmp_path):
    place = tmp_path / "ran"
    objects = np.array([Booby(place)], dtype=object)
    for content in (packed(objects, allow_pickle=True), objects.dumps()):
        with pytest.raises(CloudError, match="is no learned cloud"):
            read_cloud(with_member("at", content))
    assert not place.exists()


@pytest.mark.parametrize("name", list(_SHAPES))
def test_a_member_that_is_missing_or_nested_or_packed_otherwise(name):
    good = packed(getattr(random_cloud(), name))
    for content, packing in [
        (None, 0),
        (cloud_bytes(random_cloud()), 8),
        (b"", 8),
        (good[:-1], 8),
        (good + b"x", 8),
        (good, zipfile.ZIP_LZMA),
    ]:
        with pytest.raises(CloudError, match="is no learned cloud"):
            read_cloud(with_member(name, content, packing))


@pytest.mark.parametrize(
    ("shape", "kind"),
    [
        ((10**12,), "<f4"),
        ((-4,), "<f4"),
        ((2**62, 4), "<f4"),
        ((2**63, 0), "<f4"),
        ((4,), "(4, <f4"),  # numpy reads it as Python
        ((4,), "(4,)(f4"),
        ((4,), "f4,(i4"),
        ((4,), ","),
    ],
)
def test_a_header_that_promises_more_than_there_is_or_names_no_type(shape, kind):
    header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    header += " " * (117 - len(header)) + "\n"
    content = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode()
    with pytest.raises(CloudError, match="is no learned cloud"):
        read_cloud(with_member("sigma", content))


@pytest.mark.parametrize("name", list(_SHAPES))
def test_wrong_shapes_and_kinds(name):
    array = getattr(random_cloud(), name)
    for wrong in (
        array[:-1],
        array[..., None],
        array.ravel()[0],
        array.reshape(-1, 1),
        array.astype(complex),
        array.astype(str),
    ):
        if wrong.shape != array.shape or wrong.dtype.kind in "cU":
            with pytest.raises(CloudError):
                read_cloud(with_member(name, packed(wrong)))


def first(name, value, kind=float):
    array = np.array(getattr(random_cloud(), name), dtype=kind)
    array.flat[0] = value
    return with_member(name, packed(array))


@pytest.mark.parametrize("name", [name for name, (_, _, kind) in _SHAPES.items() if kind == "f"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite(name, value):
    with pytest.raises(CloudError, match=f"{name}: has a number that is not finite"):
        read_cloud(first(name, value))


@pytest.mark.parametrize(
    ("name", "value", "kind"),
    [
        ("feature", 6, int),
        ("feature", -1, int),
        ("feature", 3, int),
        ("word", -1, int),
        ("lobe_word", -1, int),
        ("hit", 1.5, float),
        ("hit", -0.1, float),
        ("sigma", 0.0, float),
        ("size", -0.01, float),
        ("half_angle", -0.2, float),
        ("r_max", 0.0, float),
        ("r_min", -0.1, float),
        ("r_min", 9.0, float),
        ("axis", 3.0, float),
        ("up", 3.0, float),
        ("normal", 0.0, float),
    ],
)
def test_numbers_that_cannot_be(name, value, kind):
    with pytest.raises(CloudError, match=r"r_m|: must"):
        read_cloud(first(name, value, kind))


def test_up_must_be_perpendicular_to_its_axis():
    with pytest.raises(CloudError, match="up: must be perpendicular to axis"):
        read_cloud(cloud_bytes(random_cloud(up=random_cloud().axis)))


@pytest.mark.parametrize("width", [1, 31, 64, 129])
def test_descriptors_of_no_known_detector(width):
    with pytest.raises(CloudError, match=f"descriptor: has {width} bytes"):
        read_cloud(cloud_bytes(random_cloud(width=width)))


def test_descriptors_that_do_not_fit_into_bytes():
    with pytest.raises(CloudError, match="descriptor"):
        read_cloud(first("descriptor", 300, np.uint16))


def test_a_bomb_is_refused_before_it_is_unpacked(monkeypatch):
    bomb = with_member("sigma", packed(np.zeros(4_000_000)))
    assert len(bomb) < 100_000
    monkeypatch.setattr(learned, "MAX_BYTES", 1_000_000)
    with pytest.raises(CloudError, match="unpacks to more than 1000000 bytes"):
        read_cloud(bomb)


def test_more_appearances_than_the_limit(monkeypatch):
    monkeypatch.setattr(learned, "MAX_LOBES", 10)
    with pytest.raises(CloudError, match="11 appearances; 10 are the most"):
        read_cloud(cloud_bytes(random_cloud()))
