"""What can go wrong while a report is made.

BeliefError
└── ReportError    the document holds a number that JSON does not know (NaN, infinity) or something that is no data
"""

from __future__ import annotations

from plogic.errors import BeliefError


class ReportError(BeliefError):
    """The document cannot be put into a page; the message says why."""
