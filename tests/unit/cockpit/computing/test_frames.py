"""Messages of the computing process: packing and its inverse, what JSON cannot hold, bytes that are no frame."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from epicyclic.cockpit.state.frames import PageFrame, failed_frame, pack, unpack
from epicyclic.errors import ConvergenceError, ModelError

_TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
_HEAD = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**40), 2**40) | st.floats(allow_nan=False, allow_infinity=False) | _TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_TEXT, inner, max_size=3),
    max_leaves=8,
)
_ARRAYS = npst.arrays(np.float32, npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4))


@given(st.integers(0, 2**31), st.dictionaries(_TEXT, _HEAD, max_size=4), st.dictionaries(_TEXT, _ARRAYS, max_size=4))
def test_a_frame_comes_back(rev: int, head: dict[str, object], arrays: dict[str, np.ndarray]) -> None:
    found = unpack(pack(PageFrame(rev=rev, kind="live", head=head, arrays=arrays)))
    assert (found.rev, found.kind, found.head) == (rev, "live", head)
    assert list(found.arrays) == list(arrays)
    for name, array in arrays.items():
        assert found.arrays[name].dtype == np.float32
        assert found.arrays[name].shape == array.shape
        np.testing.assert_array_equal(found.arrays[name], array)


@given(_TEXT, _ARRAYS)
def test_numbers_begin_at_a_multiple_of_four_bytes(text: str, array: np.ndarray) -> None:
    data = pack(PageFrame(rev=1, kind="sweep", head={"text": text}, arrays={"a": array}))
    (length,) = struct.unpack_from("<I", data)
    assert (4 + length) % 4 == 0
    assert len(data) == 4 + length + 4 * array.size
    assert json.loads(data[4 : 4 + length])["arrays"] == [["a", list(array.shape), 0]]


def test_numbers_of_numpy_become_json_and_those_that_are_not_finite_null() -> None:
    head = {"a": np.float64(1.5), "b": [np.int64(3), np.nan, float("inf")], "c": np.array([1.0, -np.inf]), "d": (True,)}
    found = unpack(pack(PageFrame(rev=1, kind="live", head=head))).head
    assert found == {"a": 1.5, "b": [3, None, None], "c": [1.0, None], "d": [True]}


def test_a_head_that_is_no_json_is_refused() -> None:
    with pytest.raises(TypeError, match="object in the head"):
        pack(PageFrame(rev=1, kind="live", head={"a": object()}))


@given(st.binary(max_size=60))
def test_other_bytes_are_no_frame(data: bytes) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - of JSON, of numpy or of the frame itself
        unpack(data)


def test_a_frame_cut_short_is_none() -> None:
    data = pack(PageFrame(rev=1, kind="live", head={"a": 1}, arrays={"x": np.arange(5, dtype=np.float32)}))
    for end in (3, 20, len(data) - 4):
        with pytest.raises(ValueError):  # noqa: PT011
            unpack(data[:end])


def test_a_failure_says_where_and_what_is_allowed() -> None:
    error = ModelError("out of range", path="stages.main.sun.teeth", given=-3, allowed=">= 3")
    assert failed_frame(7, error).head == {
        "message": "out of range",
        "path": "stages.main.sun.teeth",
        "given": "-3",
        "allowed": ">= 3",
    }
    bare = failed_frame(7, ModelError("nothing to read")).head
    assert bare == {"message": "nothing to read", "path": "", "given": "", "allowed": ""}
    assert failed_frame(7, ConvergenceError("try more")).head["message"] == "try more"
