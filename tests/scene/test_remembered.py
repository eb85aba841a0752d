"""Results that are kept by the contents of arrays."""

from __future__ import annotations

import numpy as np
from samp_blender.samp_addon.scene.remembered import by_content


def test_equal_arrays_are_computed_once_and_changed_ones_again():
    computed = []

    @by_content(kept=2)
    def total(a, b):
        computed.append(1)
        return float(a.sum() + b.sum())

    a, b = np.ones(3), np.arange(3)
    assert total(a, b) == total(a.copy(), b.copy()) == 6.0 and len(computed) == 1
    a[0] = 2.0
    assert total(a, b) == 7.0 and len(computed) == 2
    assert total(b, a) == 7.0 and len(computed) == 3  # the order counts, and one result is dropped
    assert total(np.ones(3), b) == 6.0 and len(computed) == 4


def test_the_same_bytes_in_another_shape_or_type_are_other_arrays():
    shape = by_content(kept=4)(lambda a: (a.shape, a.dtype.kind))
    plain = np.zeros(4, np.int64)
    assert shape(plain) == ((4,), "i")
    assert shape(plain.reshape(2, 2)) == ((2, 2), "i")
    assert shape(plain.view(np.float64)) == ((4,), "f")
