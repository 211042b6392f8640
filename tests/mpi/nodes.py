"""Pretend that one machine has several nodes, and count what ranks send.

Ranks on different nodes share no memory and exchange everything by messages.
"""

import numpy as np
from decomposition import stages

from hpc_gfmd.parallel import comm as communicators
from hpc_gfmd.parallel.comm import MpiComm

NODES = {
    "one": lambda rank: 0,
    "each its own": lambda rank: rank,
    "pairs": lambda rank: rank // 2,
    "in turn": lambda rank: rank % 2,
}
# Ranks of a node (None: all) for those NODES that are filled in the order of the ranks.
PER_NODE = {"one": None, "each its own": 1, "pairs": 2}


class CountingComm(MpiComm):
    """Counts the bytes and messages that this rank sends.

    Attributes
    ----------
    sent : ndarray of int
        Bytes and messages, including those of communicators derived from this one. A reduction
        counts as log2(ranks) messages, as in a tree.
    """

    def __init__(self, mpi, parent=None):
        super().__init__(mpi, parent)
        self.sent = parent.sent if parent else np.zeros(2, int)

    def _allreduce(self, values, op):
        self.sent += np.array([8 * np.size(values), 1]) * stages(self.size)
        return super()._allreduce(values, op)

    def allgather_arrays(self, send, receive, counts):
        self.sent += np.array([send.nbytes, 1]) * stages(self.size)
        super().allgather_arrays(send, receive, counts)

    def exchange(self, send, receive):
        self.sent += sum(a.nbytes for a in send.values()), len(send)
        super().exchange(send, receive)

    def alltoall_bytes(self, send, receive):
        to_others = np.delete(send[1], self.rank)
        self.sent += to_others.sum(), np.count_nonzero(to_others)
        super().alltoall_bytes(send, receive)


def sent_in_a_step(sweep):
    """Return the (bytes, messages) that this rank sends in one iteration on a CountingComm."""
    sweep.starter.solver.restart()
    sent = sweep.surface.grid.comm.sent
    before = sent.copy()
    sweep.starter.solver.step()
    return tuple((sent - before).tolist())


def on_pretended_nodes(comm, node_of, monkeypatch):
    """Return a CountingComm of all ranks, with each rank on node node_of(rank). Collective."""
    monkeypatch.setattr(
        communicators, "same_machine", lambda mpi: mpi.Split(node_of(comm.rank), mpi.Get_rank())
    )
    counting = CountingComm(comm.mpi)
    assert list(counting.node_ranks) == [
        rank for rank in range(comm.size) if node_of(rank) == node_of(comm.rank)
    ]
    return counting
