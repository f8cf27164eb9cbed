"""Declaration of the kernel for cffi, without fused multiply-add: the same bits as in Python."""

from pathlib import Path

from cffi import FFI

ffi = FFI()
ffi.cdef("int mid_range(void *place, double time);")
source = Path(__file__).with_name("mid_range.c").read_text()
ffi.set_source("cdpr_mid_range.kernel", source, extra_compile_args=["-ffp-contract=off"])
