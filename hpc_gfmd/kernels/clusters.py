"""Union-find on pieces of clusters that know how often the way from one piece to another crosses
the borders of the periodic cell."""

from .jit import inline, kernel


@inline
def _top(node, parent, shift):
    """Return the root of a node, which becomes the parent of all on the way there."""
    x = y = 0
    top = node
    while parent[top] != top:
        x += shift[top, 0]
        y += shift[top, 1]
        top = parent[top]
    while node != top:
        step_x, step_y, above = shift[node, 0], shift[node, 1], parent[node]
        shift[node, 0], shift[node, 1], parent[node] = x, y, top
        x -= step_x
        y -= step_y
        node = above
    return top


@kernel
def join(edges, parent, shift, wraps):
    """Make one tree of all pieces that edges (m, 4) join: piece a, piece b, borders crossed from a
    to b along x and along y.

    parent (n,): each piece its own at first, its root at the end; shift (n, 2): 0 at first, then
    borders crossed from the root to the piece; wraps (2,): becomes true for an axis where two ways
    to the same piece differ, that is where a closed one goes around the cell (Newman and Ziff 2001,
    after Machta et al. 1996).
    """
    for k in range(edges.shape[0]):
        a, b = edges[k, 0], edges[k, 1]
        top_a, top_b = _top(a, parent, shift), _top(b, parent, shift)
        x = shift[a, 0] + edges[k, 2] - shift[b, 0]
        y = shift[a, 1] + edges[k, 3] - shift[b, 1]
        if top_a == top_b:
            wraps[0] |= x != 0
            wraps[1] |= y != 0
        else:
            parent[top_b], shift[top_b, 0], shift[top_b, 1] = top_a, x, y
    for node in range(parent.shape[0]):
        _top(node, parent, shift)
