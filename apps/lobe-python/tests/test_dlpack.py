"""Tensors of other libraries enter through DLPack: of one that is written here by its specification, and of jax and torch where they are installed."""

import ctypes
import importlib

import numpy as np
import pytest

import lobe

PROCESSOR, CUDA = 1, 2

FLOAT, BFLOAT = 2, 4


class Tensor(ctypes.Structure):
    """DLTensor."""

    _fields_ = [
        ("data", ctypes.c_void_p),
        ("device_type", ctypes.c_int32),
        ("device_id", ctypes.c_int32),
        ("ndim", ctypes.c_int32),
        ("code", ctypes.c_uint8),
        ("bits", ctypes.c_uint8),
        ("lanes", ctypes.c_uint16),
        ("shape", ctypes.POINTER(ctypes.c_int64)),
        ("strides", ctypes.POINTER(ctypes.c_int64)),
        ("byte_offset", ctypes.c_uint64),
    ]


class Managed(ctypes.Structure):
    """DLManagedTensor."""


DELETER = ctypes.CFUNCTYPE(None, ctypes.POINTER(Managed))

Managed._fields_ = [("tensor", Tensor), ("context", ctypes.c_void_p), ("deleter", DELETER)]

capsule = ctypes.pythonapi.PyCapsule_New
capsule.restype, capsule.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]


class Foreign:
    """A tensor with memory of its own, which numpy knows nothing of: `numbers` from `begin` on, at steps that are counted in numbers."""

    def __init__(self, numbers, shape, strides=None, begin=0, device=PROCESSOR, code=FLOAT):
        kind = {4: ctypes.c_float, 8: ctypes.c_double}[numbers.itemsize]
        self.memory = (kind * numbers.size)(*numbers.ravel().tolist())
        self.device, self.freed = device, 0
        sizes = ctypes.c_int64 * len(shape)
        self._kept = sizes(*shape), None if strides is None else sizes(*strides), DELETER(self._free)
        at = ctypes.cast(self.memory, ctypes.c_void_p)
        tensor = Tensor(at, device, 0, len(shape), code, 8 * numbers.itemsize, 1, self._kept[0], self._kept[1], begin * numbers.itemsize)
        self._managed = Managed(tensor, None, self._kept[2])

    def _free(self, managed):
        self.freed += 1

    def __dlpack__(self, stream=None):
        return capsule(ctypes.addressof(self._managed), b"dltensor", None)

    def __dlpack_device__(self):
        return (self.device, 0)


D = [[0, 0, 1], [1, 2, 3]]


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_foreign_tensor_is_read_where_it_is_and_freed_once(dtype):
    c = np.random.default_rng(2).normal(size=(4, 9)).astype(dtype)
    tensor = Foreign(c, (4, 9))
    f = lobe.Sh(tensor)
    assert f.dtype == dtype and f.shape == (4,)
    np.testing.assert_array_equal(f.eval(D), lobe.Sh(c).eval(D))
    tensor.memory[0] = 7.0
    assert f.coefficients[0, 0] == 7, "nothing is copied"
    assert tensor.freed == 0
    del f
    assert tensor.freed == 1, "the owner is told"


def test_a_foreign_tensor_of_any_layout_has_the_same_values():
    c = np.random.default_rng(3).normal(size=(5, 9, 3))
    expected = lobe.Sh(c[1:4]).eval(D)
    by_columns = Foreign(np.ascontiguousarray(c.T), (3, 9, 3), (1, 5, 45), begin=1)
    every_second = Foreign(np.repeat(c, 2, axis=2), (3, 9, 3), (54, 6, 2), begin=54)
    backwards = Foreign(np.ascontiguousarray(c[::-1]), (3, 9, 3), (-27, 3, 1), begin=81)
    for tensor in [by_columns, every_second, backwards]:
        np.testing.assert_array_equal(lobe.Sh(tensor).eval(D), expected)


def test_foreign_directions_and_pictures_are_taken_too():
    d = np.random.default_rng(4).normal(size=(6, 3)).astype(np.float32)
    f = lobe.Sh(np.arange(9.0))
    np.testing.assert_array_equal(f.eval(Foreign(d, (6, 3))), f.eval(d))
    picture = np.random.default_rng(5).uniform(size=(4, 8, 3)).astype(np.float32)
    np.testing.assert_array_equal(lobe.project(Foreign(picture, (4, 8, 3)), 2).coefficients, lobe.project(picture, 2).coefficients)


@pytest.mark.parametrize("options", [{"device": CUDA}, {"code": BFLOAT}], ids=["of another device", "of other numbers"])
def test_a_tensor_that_cannot_be_read_is_refused_in_one_line(options):
    tensor = Foreign(np.zeros(9, np.float32), (9,), **options)
    with pytest.raises(TypeError, match="coefficients: expected a tensor of float32 or float64 in the memory of the processor: ") as fault:
        lobe.Sh(tensor)
    assert "\n" not in str(fault.value)


# How each library makes a tensor of an array, and one that it does not give away.
LIBRARIES = {
    "jax": (lambda jax, c: jax.numpy.asarray(c), lambda jax, c: jax.numpy.asarray(c, dtype="bfloat16")),
    "torch": (lambda torch, c: torch.tensor(c), lambda torch, c: torch.tensor(c, requires_grad=True)),
}


# Warnings of these libraries about the machine.
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", LIBRARIES)
def test_tensors_of_a_library_enter_without_a_copy_or_are_refused(name):
    library = pytest.importorskip(name, reason=f"{name} is not installed")
    importlib.import_module({"jax": "jax.numpy"}.get(name, name))
    tensor_of, closed = LIBRARIES[name]
    c = np.random.default_rng(6).normal(size=(4, 9)).astype(np.float32)
    tensor = tensor_of(library, c)
    f = lobe.Sh(tensor)
    assert f.dtype == np.float32 and np.shares_memory(f.coefficients, np.from_dlpack(tensor)), "nothing is copied"
    np.testing.assert_array_equal(f.eval(tensor_of(library, np.float32(D))), lobe.Sh(c).eval(np.float32(D)))
    del tensor
    np.testing.assert_array_equal(f.coefficients, c, err_msg="its memory lives as long as the function")
    with pytest.raises(TypeError, match="coefficients: expected a tensor of float32 or float64"):
        lobe.Sh(closed(library, c))
