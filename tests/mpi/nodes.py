"""One machine as if it were several: ranks on other nodes have no memory in common, and send each
other everything."""

from hpc_gfmd.parallel import comm as communicators
from hpc_gfmd.parallel.comm import MpiComm

NODES = {
    "one": lambda rank: 0,
    "each its own": lambda rank: rank,
    "pairs": lambda rank: rank // 2,
    "in turn": lambda rank: rank % 2,
}
PER_NODE = {
    "one": None,
    "each its own": 1,
    "pairs": 2,
}  # ranks of a node, None: all, where they are dealt out in their order


def on_pretended_nodes(comm, node_of, monkeypatch):
    """The communicator of all ranks, each on the node that node_of(rank) says. Collective."""
    monkeypatch.setattr(
        communicators, "same_machine", lambda mpi: mpi.Split(node_of(comm.rank), mpi.Get_rank())
    )
    made = MpiComm(comm.mpi)
    assert list(made.node_ranks) == [
        rank for rank in range(comm.size) if node_of(rank) == node_of(comm.rank)
    ]
    return made
