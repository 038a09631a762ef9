#!/bin/sh
# `docker run IMAGE solve ...` is `qrobot solve ...`; `docker run LAB lab` starts JupyterLab.
set -eu
# Whatever it is called by, JupyterLab starts through the script that wants a token.
case "${1:-} ${2:-}" in
  'jupyter lab' | 'jupyter server' | 'jupyter notebook')
    case ${3:-} in
      password | list | stop) exec "$@" ;;
    esac
    shift 2
    exec /usr/local/bin/qrobot-lab "$@"
    ;;
esac
case "${1:-}" in
  lab | jupyter-lab | jupyter-server | jupyter-notebook)
    shift
    exec /usr/local/bin/qrobot-lab "$@"
    ;;
esac
# Programs of the image by their path or name: sh for a look around, python3 for a script.
case "${1:-}" in
  sh | bash | python3 | jupyter | /*) exec "$@" ;;
esac
exec /usr/local/bin/qrobot "$@"
