"""Parts of a block: by its rows, and the stretches in which no row is missing."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace
from itertools import pairwise

from benchtool.block import Block, Gap


def rows_of(block: Block, first: int, last: int) -> Block:
    """Return rows from `first` to before `last`, with the gaps between them; there must be one at least."""
    if (first, last) == (0, len(block.data)):
        return block
    skipped = sum(gap.missing_rows for gap in block.gaps if gap.row <= first)
    return replace(
        block,
        first_tick=block.first_tick + (first + skipped) * block.stride,
        data=block.data[first:last],
        gaps=tuple(Gap(gap.row - first, gap.missing_rows) for gap in block.gaps if first < gap.row < last),
    )


def unbroken(block: Block) -> Iterator[Block]:
    """Return the stretches of a block in which no row is missing, in their order."""
    edges = [0, *(gap.row for gap in block.gaps), len(block.data)]
    return (rows_of(block, first, last) for first, last in pairwise(edges) if first < last)


def longest_unbroken(block: Block) -> Block:
    """Return the longest of these stretches, and of equal ones the first."""
    return max(unbroken(block), key=lambda each: len(each.data))


def without(block: Block, names: Set[str]) -> Block:
    """Return the block without these channels; as it is, if it has none of them."""
    kept = [place for place, name in enumerate(block.names) if name not in names]
    if len(kept) == len(block.names):
        return block
    return replace(block, channels=tuple(block.channels[place] for place in kept), data=block.data[:, kept])
