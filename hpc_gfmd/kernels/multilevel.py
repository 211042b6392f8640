"""Restriction and interpolation between a grid and the next coarser one, and the sweep of the
multilevel preconditioner over the levels: equation (5) in docs/method.md.

Letters. Pressures are in E* g_rms, weights of levels in units of that of the shortest wave.

=============  ===================================================================================
i, j           row and column of a fine point; n points along a row
J              coarse row or column; m points along a row. Coarse point J sits at fine position
               J n/m, so that fine point i lies between J0 = floor(i m/n) and J0 + 1, with the
               weight f = i m/n - J0 of the latter
P, R           linear interpolation; its adjoint, full weighting: R = (m/n)^2 P^T
transfer       (J_x, f_x, mode, J_y, f_y, factor), as Transfer.tables (parallel/coarsening.py) has
               it: J_x: J0 of this rank's fine rows as rows of a coarse array (halo counted), f_x:
               their weights; mode of the columns: 0 not coarsened, 1 n even (f = 0, 1/2, 0, ...),
               2 general; J_y, f_y: J0 and f of the columns; factor: (m/n)^2
r, t           fields 0 and 1 of a level: p on F and the indicator of A, restricted
x              field 2, where there is one: K d on F, restricted
z              the result: r/(weight + damping t) + P z of the next coarser level
s              indicator of the surface, restricted: the product of s_x and s_y
=============  ===================================================================================

Fields of a level are one array (fields, rows + 2, n): own rows 1 to rows, halo rows 0 and rows + 1.
"""

from .atomic import add, replace
from .jit import inline, kernel
from .views import view_fields

SUMS = 7  # that smooth_level returns
# of sweep_levels: its totals, and where those are that are no sums
TOTALS = 9
MEAN = 7
AMPLITUDE = 8
# counters that threads have in common, each in a cache line of its own
NEXT = 0
ENDED = 8
CLOSED = 16
TURNS = 24  # numbers of an array that holds them


@inline
def restrict_row(fine, coarse, factor, mode, J_y, f_y):
    """Restrict one row: coarse = factor P^T fine, P being linear interpolation."""
    real = fine.dtype.type
    n = fine.shape[0]
    m = coarse.shape[0]
    if mode == 1:
        half = factor * real(0.5)
        before = half * fine[n - 1]
        # even and odd points are read together: vectors of every second point alone would be
        # gathered
        for J in range(m):
            after = half * fine[2 * J + 1]
            coarse[J] = factor * fine[2 * J] + after + before
            before = after
    elif mode == 0:
        for J in range(m):
            coarse[J] = factor * fine[J]
    else:
        for J in range(m):
            coarse[J] = real(0)
        for j in range(n):
            J = J_y[j]
            J_next = J + 1 if J + 1 < m else 0
            value = factor * fine[j]
            coarse[J] += value * (real(1) - f_y[j])
            coarse[J_next] += value * f_y[j]


@inline
def interpolate_row(coarse, fine, mode, J_y, f_y):
    """Interpolate one periodic row linearly from the coarse level: fine = P coarse."""
    real = fine.dtype.type
    n = fine.shape[0]
    m = coarse.shape[0]
    if mode == 1:
        for J in range(m - 1):
            fine[2 * J] = coarse[J]
            fine[2 * J + 1] = real(0.5) * (coarse[J] + coarse[J + 1])
        fine[n - 2] = coarse[m - 1]
        fine[n - 1] = real(0.5) * (coarse[m - 1] + coarse[0])
    elif mode == 0:
        for J in range(m):
            fine[J] = coarse[J]
    else:
        for j in range(n):
            J = J_y[j]
            J_next = J + 1 if J + 1 < m else 0
            fine[j] = coarse[J] * (real(1) - f_y[j]) + coarse[J_next] * f_y[j]


@inline
def combine_rows(coarse, J, f, out):
    """Interpolate along x for one fine row: out = (1 - f) coarse[J] + f coarse[J + 1]."""
    m = out.shape[0]
    one = out.dtype.type(1)
    if f == 0.0:
        for column in range(m):
            out[column] = coarse[J, column]
    else:
        for column in range(m):
            out[column] = coarse[J, column] * (one - f) + coarse[J + 1, column] * f


@inline
def rows_beside(start, end, f_x, zero, one):
    """Return the two rows beside a coarse row, or others that add nothing, and their weights."""
    a = start if start < end else start - 1
    b = end - 1
    f_a = f_x[a]
    f_b = f_x[b]
    has_a = one if start < end else zero
    has_b = one if start + 1 < end else zero
    return a, b, has_a * (one - f_a), has_b * (one - f_b), has_a * f_a, has_b * f_b


@inline
def gather_rows(fine, start, end, f_x, complete, following):
    """Restrict along x the own rows beside one coarse row: complete = following + sum of (1 - f_x)
    row, following = sum of f_x row.
    """
    real = complete.dtype.type
    a, b, of_a, of_b, next_a, next_b = rows_beside(start, end, f_x, real(0), real(1))
    for j in range(complete.shape[0]):
        row_a = fine[a + 1, j]
        row_b = fine[b + 1, j]
        complete[j] = following[j] + of_a * row_a + of_b * row_b
        following[j] = next_a * row_a + next_b * row_b


@inline
def restrict_level(fine, coarse, transfer, i0, i1, scratch):
    """Restrict fields by full weighting to the coarse rows that own rows i0 <= i < i1 lie on or
    after.

    i0 is the first row beside its coarse row; the last own row also sets the coarse row after it;
    coarse rows without fine ones stay. Rows are added up first: contiguous, and half as many
    remain.
    """
    J_x, f_x, mode, J_y, f_y, factor = transfer
    rows = fine.shape[1] - 2
    n = fine.shape[2]
    complete = scratch[0][:n]
    following = scratch[1][:n]
    # the rows of the coarse row before, which have a part of the first one
    before = i0
    while before > 0 and J_x[before - 1] == J_x[i0 - 1]:
        before -= 1
    # the coarse row after the last one of the rank has no rows beside it
    J_end = J_x[i1 - 1] + (2 if i1 == rows else 1)
    for c in range(coarse.shape[0]):
        for j in range(n):
            following[j] = fine.dtype.type(0)
        start = before
        for J in range(J_x[before], J_end):
            end = start
            while end < rows and J_x[end] == J:
                end += 1
            gather_rows(fine[c], start, end, f_x, complete, following)
            if start >= i0:
                restrict_row(complete, coarse[c, J], factor, mode, J_y, f_y)
            start = end


@inline
def smooth_level(fields, z_coarse, out, weight, damping, transfer, nominal, i0, i1, scratch):
    """Set z = r/(weight + damping t) + P z_coarse on own rows i0 <= i < i1 of a level.

    `out`, perhaps r, gets z; z_coarse has halo rows; nominal: (s_x, s_y). Returns <r, z>, <x, z>,
    <r, r>, <t, t>, <r, t>, <t, s>, <r, s>, over rows in double precision.
    """
    s_x, s_y = nominal
    J_x, f_x, mode, J_y, f_y, _ = transfer
    n = fields.shape[2]
    has_x = fields.shape[0] > 2
    zero = fields.dtype.type(0)
    coarse_row = scratch[0][: z_coarse.shape[1]]
    z_row = scratch[1][:n]
    rz = xz = rr = tt = rt = ts = rs = 0.0
    for i in range(i0, i1):
        combine_rows(z_coarse, J_x[i], f_x[i], coarse_row)
        interpolate_row(coarse_row, z_row, mode, J_y, f_y)
        row_rz = row_xz = row_rr = row_tt = row_rt = row_ts = row_rs = zero
        for j in range(n):
            r = fields[0, i + 1, j]
            t = fields[1, i + 1, j]
            z = r / (weight + damping * t) + z_row[j]
            row_rz += r * z
            row_rr += r * r
            row_tt += t * t
            row_rt += r * t
            row_ts += t * s_y[j]
            row_rs += r * s_y[j]
            z_row[j] = z
        rz += row_rz
        rr += row_rr
        tt += row_tt
        rt += row_rt
        ts += s_x[i] * row_ts
        rs += s_x[i] * row_rs
        if has_x:
            for j in range(n):
                row_xz += fields[2, i + 1, j] * z_row[j]
            xz += row_xz
        for j in range(n):
            out[i + 1, j] = z_row[j]
    return rz, xz, rr, tt, rt, ts, rs


@kernel
def join_shares(passes, shares, first_rows, coarse, J_x):
    """Complete level 1 after bpx.py's passes: add the shares' first rows, zero all others."""
    zero = coarse.dtype.type(0)
    for c in range(coarse.shape[0]):
        coarse[c, : J_x[0] + 1] = zero
        coarse[c, J_x[-1] + 2 :] = zero
        for share in range(shares.shape[0]):
            row = J_x[passes[shares[share, 0], 0]]
            for j in range(coarse.shape[2]):
                coarse[c, row, j] += first_rows[share, c, j]


@kernel
def sweep_levels(
    pieces,
    end,
    turns,
    patience,
    memory,
    levels,
    tables,
    numbers,
    softness,
    damping,
    mode,
    mode_level,
    scratch,
    sums,
    totals,
):
    """Sweep over consecutive levels, down to a single point, all of whose rows one rank has.

    r and t are restricted to all levels, and r becomes z (`smooth_level`). All threads call this;
    each takes the next piece when all stages before it are closed, and who ends a stage's last
    piece closes it.

    pieces (pieces, 6): level, rows i0 <= i < i1, whether smoothed (or restricted), first piece of
    the stage and the one after the last; a stage is one level down or up. turns: counters NEXT,
    ENDED, CLOSED, set by the caller to the first piece; end: after the last. patience: looks at a
    stage that is not closed before returning. memory: fields of all levels, and zeros. levels
    (levels + 1, 7): where fields begin, their number, rows, points a row, mode of the columns,
    where rows and columns begin in `tables`, with J_x, f_x, J_y, f_y, s_x, s_y. numbers: weight and
    factor of each level; softness: its weight in the sums. mode: the gap mode of level
    `mode_level`, or empty.

    `sums`: of each smoothed piece; `totals`: <r, z>, <x, z> on level 0, other sums of
    `smooth_level` times softness, mean of r, product of gap mode and r. Returns whether all pieces
    are taken; if not, the thread has lost patience and must call again, and nothing is lost.
    """
    J_x, f_x, J_y, f_y, s_x, s_y = tables
    coarsest = levels.shape[0] - 2
    looks = 0
    while True:
        piece = add(turns, NEXT, 0)
        if piece >= end:
            return True
        k, i0, i1, is_smoothed, stage, next_stage = pieces[piece]
        if add(turns, CLOSED, 0) < stage:
            looks += 1
            if looks > patience:
                return False
            continue
        looks = 0
        if not replace(turns, NEXT, piece, piece + 1):
            continue  # another thread has taken it
        begin, count, rows, n, along, at_x, at_y = levels[k]
        next_begin, _, next_rows, next_n, _, _, _ = levels[k + 1]
        fields = view_fields(memory, begin, count, rows + 2, n)
        coarse = view_fields(memory, next_begin, 2 - is_smoothed, next_rows + 2, next_n)
        transfer = (J_x[at_x:], f_x[at_x:], along, J_y[at_y:], f_y[at_y:], numbers[k, 1])
        if is_smoothed:
            if k == coarsest:
                _begin_smoothing(memory, levels, mode, mode_level, totals)
            nominal = (s_x[at_x:], s_y[at_y:])
            z = fields[0]
            of_piece = smooth_level(
                fields, coarse[0], z, numbers[k, 0], damping, transfer, nominal, i0, i1, scratch
            )
            for c in range(SUMS):
                sums[piece, c] = of_piece[c]
        else:
            restrict_level(fields, coarse, transfer, i0, i1, scratch)
        if add(turns, ENDED, 1) + 1 == next_stage:
            if is_smoothed:
                has_mode = k == mode_level and mode.shape[0] > 0
                _close_smoothing(
                    fields, sums[stage:next_stage], softness[k], has_mode, mode, totals
                )
            else:
                for c in range(2):  # the axis is periodic: the row after the last is the first
                    for j in range(next_n):
                        coarse[c, 1, j] += coarse[c, next_rows + 1, j]
            add(turns, CLOSED, next_stage - stage)


@inline
def _begin_smoothing(memory, levels, mode, mode_level, totals):
    """Set totals from r before it becomes z: its MEAN, the AMPLITUDE <mode, r>, others 0."""
    coarsest = levels.shape[0] - 2
    for c in range(TOTALS):
        totals[c] = 0.0
    totals[MEAN] = memory[levels[coarsest, 0] + levels[coarsest, 3]]
    if mode.shape[0] > 0:
        begin = levels[mode_level, 0] + levels[mode_level, 3]
        amplitude = memory.dtype.type(0)
        for i in range(mode.shape[0]):
            amplitude += mode[i] * memory[begin + i]
        totals[AMPLITUDE] = amplitude


@inline
def _close_smoothing(fields, sums, softness, has_mode, mode, totals):
    """Finish a level once z is there: add its sums times softness, <r, z> and <x, z> of this level
    alone, the gap mode (has_mode; its amplitude in totals), halo rows of z.
    """
    rows = fields.shape[1] - 2
    n = fields.shape[2]
    for c in range(SUMS):
        total = 0.0
        for piece in range(sums.shape[0]):
            total += sums[piece, c]
        totals[c] = total if c < 2 else totals[c] + softness * total
    if has_mode:
        amplitude = fields.dtype.type(totals[AMPLITUDE])
        totals[0] += amplitude * amplitude
        xz = 0.0
        for i in range(rows):
            for j in range(n):
                mode_ij = mode[i * n + j]
                fields[0, i + 1, j] += amplitude * mode_ij
                if fields.shape[0] > 2:
                    xz += amplitude * (mode_ij * fields[2, i + 1, j])
        totals[1] += xz
    for j in range(n):
        fields[0, 0, j] = fields[0, rows, j]
        fields[0, rows + 1, j] = fields[0, 1, j]
