"""What is taken for an array."""
from __future__ import annotations

from typing import Any

import numpy as np

from ._errors import InvalidInput
from ._types import Array


def plain_array(values: Any, name: str) -> Array:
    """As an array of numpy. One of numpy.ma that hides values is refused: what to take in their place is for whoever
    hid them to say, and np.asarray would bring them back."""
    hidden = int(np.count_nonzero(values.mask)) if isinstance(values, np.ma.MaskedArray) else 0
    if hidden > 0:
        raise InvalidInput(f"{name}: found {hidden} of {values.size} values masked, wanted an array without a mask: "
                           ".filled(value) says what they are")
    return np.asarray(values)
