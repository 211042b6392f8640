"""Counters that threads change without a lock; who sees a change sees all writes before it, too."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

ORDER = "seq_cst"
COUNTER = ir.IntType(64)


def _address(context, builder, signature, values):
    """Return the address of counters[index], the first two of the values."""
    counters = context.make_array(signature.args[0])(context, builder, values[0])
    return builder.gep(
        counters.data, [context.cast(builder, values[1], signature.args[1], types.intp)]
    )


@intrinsic
def add(_, counters, index, value):
    """Add a number to a counter in one step; return the counter before it. Only in kernels."""

    def generate(context, builder, signature, values):
        number = context.cast(builder, values[2], signature.args[2], types.int64)
        address = _address(context, builder, signature, values)
        return builder.atomic_rmw("add", address, number, ORDER)

    return types.int64(counters, index, value), generate


@intrinsic
def replace(_, counters, index, expected, value):
    """Set a counter to `value` in one step if it is `expected`; return whether it was."""

    def generate(context, builder, signature, values):
        before, after = (
            context.cast(builder, number, kind, types.int64)
            for number, kind in zip(values[2:], signature.args[2:])
        )
        address = _address(context, builder, signature, values)
        result = builder.cmpxchg(address, before, after, ORDER)
        return builder.extract_value(result, 1)

    return types.boolean(counters, index, expected, value), generate
