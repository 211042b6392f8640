"""Moving whole cache lines, which numba has no words for: compiled loops over a few numbers spend
more time on their ends.

Arrays are flat, contiguous and of float64; indices count numbers. A line that is streamed goes to
memory past the caches, which are not made to read it first: for what nobody reads soon. It has to
begin where a cache line does.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

WIDTH = 8  # numbers in a line


def _mover(streams):
    """A function (target, i, source, j) of kernels: target[i:i + WIDTH] = source[j:j + WIDTH]."""

    @intrinsic
    def move(_, target, i, source, j):
        def generate(context, builder, signature, values):
            def pointer(k):
                array = context.make_array(signature.args[k])(context, builder, values[k])
                return builder.bitcast(
                    builder.gep(array.data, [values[k + 1]]),
                    ir.VectorType(ir.DoubleType(), WIDTH).as_pointer(),
                )

            line = builder.load(pointer(2), align=8)
            store = builder.store(line, pointer(0), align=8 * WIDTH if streams else 8)
            if streams:
                store.set_metadata(
                    "nontemporal", builder.module.add_metadata([ir.Constant(ir.IntType(32), 1)])
                )
            return context.get_dummy_value()

        return types.void(target, i, source, j), generate

    return move


move_line, stream_line = _mover(False), _mover(True)


@intrinsic
def publish(_):
    """What was streamed is there for other threads and processes from here on: no message or lock
    need do that."""

    def generate(context, builder, *_):
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.void(), generate
