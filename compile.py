"""Makes C of the modules named on the command line and puts it beside them, by mypyc: `make compile`."""

import sys

from mypyc.build import mypycify
from setuptools import setup

# Contracted multiplications and additions would round otherwise than Python does, and lead elsewhere.
modules = mypycify(sys.argv[1:], opt_level="3")
for module in modules:
    module.extra_compile_args = [*module.extra_compile_args, "-ffp-contract=off"]
setup(packages=[], ext_modules=modules, script_args=["--quiet", "build_ext", "--inplace"])
