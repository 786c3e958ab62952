"""Blocks as columns and back."""

from __future__ import annotations

import numpy as np

from benchtool.block import Block, Channel
from benchtool.block.arrow import TimeBase, batch_of, block_of, schema_of


def test_a_block_read_back_is_the_same_and_each_channel_lies_in_one_piece() -> None:
    data = np.random.default_rng(1).normal(size=(1000, 3))
    block = Block(tuple(Channel(name, "A") for name in "abc"), 70, 2, 1e-4, data)
    base = TimeBase.of(block)
    schema = schema_of(block.channels, base)
    batch = batch_of(block, schema)

    read = block_of(schema, [batch.slice(0, 300), batch.slice(300)], 1000, base, ())

    np.testing.assert_array_equal(read.data, data)
    assert (read.channels, read.first_tick, read.stride) == (block.channels, 70, 2)
    assert all(read.column(name).flags.c_contiguous for name in read.names)
