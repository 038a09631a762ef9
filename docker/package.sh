#!/bin/sh
# Install qRobot itself, and the programs that the images start with.
set -eu
python=$(python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')
site=usr/local/lib/python$python/dist-packages
mkdir -p "/root-of-target/$site"
/tools/bin/uv pip install --quiet --no-cache --no-deps --offline --python /tools/bin/python \
  --no-build-isolation --target "/root-of-target/$site" /source
/tools/bin/python /docker/layer.py /root-of-target "$site"
install -m 755 /docker/entrypoint.sh /root-of-target/usr/local/bin/qrobot-entrypoint
install -m 755 /docker/lab.sh /root-of-target/usr/local/bin/qrobot-lab
