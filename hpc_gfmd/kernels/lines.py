"""Moving whole cache lines: compiled loops over a few numbers spend more time on their ends."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

WIDTH = 8  # numbers in a line


@intrinsic
def move_line(_, target, i, source, j):
    """Set target[i:i + WIDTH] = source[j:j + WIDTH], contiguous float64, unchecked, in kernels."""

    def generate(context, builder, signature, values):
        def pointer(k):
            array = context.make_array(signature.args[k])(context, builder, values[k])
            line = ir.VectorType(ir.DoubleType(), WIDTH).as_pointer()
            return builder.bitcast(builder.gep(array.data, [values[k + 1]]), line)

        builder.store(builder.load(pointer(2), align=8), pointer(0), align=8)
        return context.get_dummy_value()

    return types.void(target, i, source, j), generate
