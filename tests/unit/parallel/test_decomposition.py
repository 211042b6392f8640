"""Memory, points and messages of ranks, for any number of them: evenly shared, without padding."""

import numpy as np
import pytest
from decomposition import busiest, rows_by_rank, share_of

MIB = 2**20
SIZES = [2**k for k in range(12, 18)]
RANKS = [1, 2, 3, 7, 16, 60, 64, 96, 256, 1000, 1024, 4096, 16384, 65536]


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", SIZES)
def test_ranks_share_work_evenly(n, dtype):
    """Points, memory and messages of the busiest rank exceed the mean by at most a tenth of the
    slab, or one MiB."""
    for ranks in [k for k in RANKS if k <= n]:
        for share in busiest((n, n), dtype, ranks):
            itemsize = share.dtype.itemsize
            slab = n * n / ranks
            more = max(0.1 * slab, MIB / itemsize)
            assert share.points <= slab + n
            # up to two rows beside its own on all levels, of n/2, n/4, ... points, each side
            beside = 2 * 2 * n
            assert share.coarse_points <= slab / 3 + beside + more, (ranks, share.grid.comm.rank)
            halo = 5 * beside  # 3 fields, then 2, and where rows are gathered once more
            assert share.level_bytes <= (23 / 24 * slab + halo) * itemsize + max(
                0.1 * slab * itemsize, MIB
            ), ranks
            assert share.level_traffic[0] <= max(0.1 * slab * itemsize, MIB) + halo * itemsize
            assert share.level_traffic[1] <= 2 + 3 * np.log2(ranks)


@pytest.mark.parametrize(
    ("n", "ranks"),
    [((48, 30), 1), ((64, 64), 5), ((300, 200), 7), ((7, 11), 9), ((1, 40), 3), ((256, 512), 16)],
)
def test_rows_columns_and_messages_match(n, ranks):
    """Every row, column, level and coarser grid has one owner, and every message sent is
    received."""
    shares = [share_of(n, np.float64, ranks, rank) for rank in range(ranks)]
    assert sum(share.points for share in shares) == n[0] * n[1]
    columns_held = [share.layout.block_widths[:, rank].sum() for rank, share in enumerate(shares)]
    assert sum(columns_held) == n[1] // 2 + 1
    steps, levels = shares[0].hierarchy
    for k, level in enumerate(levels[: len(steps)]):  # the others are whole on some ranks
        counted = [np.diff(share.hierarchy[0][k].counted_rows)[0] for share in shares]
        assert sum(counted) == level.n[0]
    grids = [grid for share in shares for grid in share.grids]
    for size in {grid.n for grid in grids}:
        assert sum(grid.shape[0] for grid in grids if grid.n == size) == size[0]
    for rank, share in enumerate(shares):
        for other_rank, other_share in enumerate(shares):
            for step, other_step in zip(share.hierarchy[0], other_share.hierarchy[0], strict=True):
                assert (step.windows is None) == (other_step.windows is None)
                if step.windows is None:
                    sent = rows_by_rank(step.overlaps.give).get(other_rank, 0)
                    received = other_step.overlaps.taken_rows.get(rank, 0)
                    assert rank == other_rank or sent == received
                    continue
                sent = rows_by_rank(step.windows.give).get(other_rank, 0)
                received = rows_by_rank(other_step.windows.take).get(rank, 0)
                assert sent == received
