"""Fixtures of the mask room's tests."""

import pytest
from small_mask import FORMATS


@pytest.fixture(params=FORMATS)
def suffix(request):
    return request.param
