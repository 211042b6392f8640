"""Union-find on pieces of clusters that know how often the way from one piece to another crosses
the borders of the periodic cell (Newman and Ziff 2001, after Machta et al. 1996).

Letters. A node is a piece of a cluster. parent (nodes,): the node above it in its tree, the root is
its own parent. shift (nodes, 2): borders crossed along x and along y from the parent to the node.
"""

from .jit import inline, kernel


@inline
def _root(node, parent, shift):
    """Return the root of a node, and make all nodes on the way to it its direct children."""
    x = 0
    y = 0
    root = node
    while parent[root] != root:
        x += shift[root, 0]
        y += shift[root, 1]
        root = parent[root]
    while node != root:
        step_x = shift[node, 0]
        step_y = shift[node, 1]
        above = parent[node]
        parent[node] = root
        shift[node, 0] = x
        shift[node, 1] = y
        x -= step_x
        y -= step_y
        node = above
    return root


@kernel
def join(edges, parent, shift, wraps):
    """Join the trees of all pieces that edges connect: changes parent, shift and wraps.

    edges: piece a, piece b, borders crossed from a to b along x, y. parent: at the end the root.
    wraps becomes true where two ways to a piece cross different numbers of borders: around the
    cell.
    """
    for k in range(edges.shape[0]):
        a = edges[k, 0]
        b = edges[k, 1]
        root_a = _root(a, parent, shift)
        root_b = _root(b, parent, shift)
        x = shift[a, 0] + edges[k, 2] - shift[b, 0]
        y = shift[a, 1] + edges[k, 3] - shift[b, 1]
        if root_a == root_b:
            wraps[0] |= x != 0
            wraps[1] |= y != 0
        else:
            parent[root_b] = root_a
            shift[root_b, 0] = x
            shift[root_b, 1] = y
    for node in range(parent.shape[0]):
        _root(node, parent, shift)
