"""Disjoint parts of a job, for schedulers of job arrays: each state is in one of them."""

from __future__ import annotations

import re
from dataclasses import dataclass

from skyshine.schemas.errors import InputError


@dataclass(frozen=True)
class Part:
    """One of several parts of a job.

    Attributes
    ----------
    number, count : int
        Counted from 1, and of how many.
    """

    number: int
    count: int

    @classmethod
    def of_text(cls, text: str) -> Part:
        """The part of a text such as 3/12.

        Raises
        ------
        InputError
            It is no part.
        """
        match = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
        if match is None or not 1 <= int(match[1]) <= int(match[2]):
            raise InputError(f"found --part '{text}'; allowed: a number of a count, 1/12 to 12/12; write I/N")
        return cls(int(match[1]), int(match[2]))

    @property
    def label(self) -> str:
        """Beginning of the names of its files."""
        return f"build.part-{self.number}-of-{self.count}"

    def has_state(self, site: int, sites: int, state: int, states: int) -> bool:
        """Whether a state, counted from 1, of a site, counted from 0, is in the part: all states of all sites in their
        order, in stretches of one length.

        Examples
        --------
        >>> [Part(2, 3).has_state(0, 1, state, 6) for state in range(1, 7)]
        [False, False, True, True, False, False]
        """
        return (site * states + state - 1) * self.count // (sites * states) == self.number - 1

    def has_site(self, site: int, sites: int) -> bool:
        """Whether any state of a site, counted from 0, may be in the part."""
        lowest, highest = site * self.count // sites, ((site + 1) * self.count - 1) // sites
        return lowest <= self.number - 1 <= highest
