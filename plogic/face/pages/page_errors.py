"""What can go wrong while a page is made.

BeliefError
└── PageError    the document holds a number that JSON does not know (NaN, infinity) or something that is no data
"""

from __future__ import annotations

from plogic.base.errors import BeliefError


class PageError(BeliefError):
    """The document cannot be put into a page; the message says why."""
