"""What users call an array: a numpy array, or what numpy makes one of."""
import numpy


def array_of(values):
    """A numpy array; a masked one stays one, which the compiled part refuses."""
    return numpy.asanyarray(values)


def floats_of(values):
    """An array of floats. Other numbers are converted, unless that would copy more than 64 MiB."""
    array = array_of(values)
    is_other_number = array.dtype.kind in "iub" and not hasattr(array, "mask")
    return array.astype(float) if is_other_number and array.nbytes <= 64 << 20 else array
