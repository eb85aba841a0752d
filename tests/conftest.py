"""What tests of several folders share."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module")
def registered():
    """The extension, registered in this process while the tests of a file run."""
    import samp_blender

    samp_blender.register()
    yield
    samp_blender.unregister()
