#!/bin/sh
# Install a lock for the target machine into a layer. Usage: wheels.sh PROFILE [PROFILE-BELOW]
#
# The layer holds what the one below has not. Files come byte-compiled, checked by no date, so
# that a start reads them as they are, from a file system that may be read-only.
set -eu
profile=$1
below=${2:-}
case $TARGETARCH in
  amd64) machine=x86_64 ;;
  arm64) machine=aarch64 ;;
  *) echo "no images for $TARGETARCH: use linux/arm64 or linux/amd64" >&2; exit 1 ;;
esac
python=$(python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')
site=usr/local/lib/python$python/dist-packages # where Debian's Python looks
if [ -s /run/secrets/ca ]; then export SSL_CERT_FILE=/run/secrets/ca; fi
lock=/locks/$profile.txt
if [ -n "$below" ]; then
  PYTHONPATH=/ /tools/bin/python -m locks.above "$lock" "/locks/$below.txt" "$TARGETARCH" >/tmp/lock.txt
  lock=/tmp/lock.txt
fi
mkdir -p "/layers/$profile/$site"
# --no-deps: the lock has everything; what the layer below holds is not asked for again.
/tools/bin/uv pip install --quiet --cache-dir /cache --link-mode copy --no-progress \
  --python /tools/bin/python --no-build-isolation --require-hashes --no-deps \
  --python-platform "$machine-manylinux_2_28" --python-version "$python" \
  --target "/layers/$profile/$site" --requirement "$lock"
/tools/bin/python -W ignore /docker/layer.py "/layers/$profile" "$site"
