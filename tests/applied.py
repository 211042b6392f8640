"""K and its inverse applied to whole fields."""

from hpc_gfmd.operators.elastic import reader


def stiffness_times(elastic, u, out):
    """out = K u, local slabs; returns this rank's share of <u, K u>."""
    return _through(elastic, u, elastic.pressure_columns, out)


def compliance_times(elastic, p, out):
    """out = S p with zero mean, local slabs; returns this rank's share of <p, S p>."""
    return _through(elastic, p, elastic.displacement_columns, out)


def _through(elastic, field, columns, out):
    def use(i0, i1, x):
        out[i0:i1] = x[: i1 - i0]

    elastic.pressure_rows(reader(field))
    energy = columns()
    elastic.use_rows(use)
    return energy
