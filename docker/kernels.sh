#!/bin/sh
# Compile the searches inside the image that is built, for the processor that NUMBA_CPU_NAME names, into
# TREE: what numba keeps beside the package. Usage: kernels.sh TREE
#
# The compiler is a part of numba and writes for the kind of machine that it runs on, so this alone runs the
# other machine's programs, under an emulator where that machine is another one. KERNELS=false leaves it out.
set -eu
tree=$1
mkdir -p "$tree"
if [ "${KERNELS:-true}" != true ]; then exit; fi
# Hashes that are the same each time, so that the files are.
env -u NUMBA_CACHE_DIR PYTHONHASHSEED=0 qrobot compile
cd /
find usr/local/lib/python3*/dist-packages/qrobot -name '*.nb[ci]' -exec cp --parents -t "$tree" '{}' +
