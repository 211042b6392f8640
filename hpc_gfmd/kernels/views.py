"""Views of flat memory: NumPy's reshape brings error texts, slow to compile."""

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


@intrinsic
def view_fields(_, flat, begin, fields, rows, n):
    """View flat[begin:], which must outlive it, as (fields, rows, n), unchecked, in kernels."""
    array_type = types.Array(flat.dtype, 3, "C")

    def generate(context, builder, signature, values):
        size = context.get_value_type(types.intp)
        memory = context.make_array(signature.args[0])(context, builder, values[0])
        lengths = [
            context.cast(builder, value, kind, types.intp)
            for value, kind in zip(values[2:], signature.args[2:])
        ]
        item = context.get_constant(types.intp, context.get_abi_sizeof(memory.data.type.pointee))
        row = builder.mul(lengths[2], item)
        field = builder.mul(lengths[1], row)
        count = builder.mul(lengths[0], builder.mul(lengths[1], lengths[2]))
        view = context.make_array(array_type)(context, builder)
        view.data = builder.gep(memory.data, [values[1]])
        view.shape = cgutils.pack_array(builder, lengths, ty=size)
        view.strides = cgutils.pack_array(builder, [field, row, item], ty=size)
        view.itemsize = item
        view.nitems = count
        view.meminfo = cgutils.get_null_value(view.meminfo.type)
        view.parent = cgutils.get_null_value(view.parent.type)
        return view._getvalue()

    return array_type(flat, begin, fields, rows, n), generate
