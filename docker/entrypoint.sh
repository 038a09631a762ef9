#!/bin/sh
# `docker run IMAGE solve ...` is `qrobot solve ...`; `docker run LAB lab` starts JupyterLab.
set -eu
if [ "${1:-}" = lab ]; then
  shift
  exec /usr/local/bin/qrobot-lab "$@"
fi
# Programs of the image by their path or name: sh for a look around, python3 for a script.
case "${1:-}" in
  sh | bash | python3 | jupyter | /*) exec "$@" ;;
esac
exec /usr/local/bin/qrobot "$@"
