"""Union-find with crossings against breadth-first search."""

import numpy as np
import pytest

from hpc_gfmd.kernels.clusters import join


def by_search(nodes, edges):
    """(clusters as sets, positions of nodes in the unfolded plane, axes that are wrapped)."""
    neighbours = {node: [] for node in range(nodes)}
    for a, b, x, y in edges:
        neighbours[a].append((b, np.array([x, y])))
        neighbours[b].append((a, -np.array([x, y])))
    place = {}
    clusters = []
    wraps = np.zeros(2, bool)
    for start in range(nodes):
        if start in place:
            continue
        place[start] = np.zeros(2, int)
        members = [start]
        for a in members:
            for b, crossed in neighbours[a]:
                if b not in place:
                    place[b] = place[a] + crossed
                    members.append(b)
                wraps |= place[b] != place[a] + crossed
        clusters.append(set(members))
    return clusters, place, wraps


@pytest.mark.parametrize("count", [0, 5, 12, 25])
@pytest.mark.parametrize("seed", range(4))
def test_join(count, seed):
    random = np.random.default_rng([count, seed])
    nodes = 15
    edges = np.concatenate(
        [random.integers(0, nodes, (count, 2)), random.integers(-1, 2, (count, 2))], axis=1
    )
    if seed == 0:
        edges[:, 2] = 0  # no edge crosses the border along x
    parent = np.arange(nodes)
    shift = np.zeros((nodes, 2), int)
    wraps = np.zeros(2, bool)
    join(edges, parent, shift, wraps)
    clusters, place, wrapped = by_search(nodes, edges.tolist())
    assert {frozenset(np.flatnonzero(parent == root)) for root in parent} == set(
        map(frozenset, clusters)
    )
    assert wraps.tolist() == wrapped.tolist()
    if not wrapped.any():  # otherwise the shift depends on the path
        for node in range(nodes):
            root = parent[node]
            assert shift[node].tolist() == (place[node] - place[root]).tolist()
