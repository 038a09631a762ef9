#!/bin/sh
# `docker run IMAGE solve ...` is `qrobot solve ...`; `docker run LAB lab` starts JupyterLab.
set -eu
start_lab() {
  exec /usr/local/bin/qrobot-lab "$@"
}
# Whatever it is called by, JupyterLab starts through the script that wants a token.
program=${1:-}
case ${program##*/} in
  lab) [ "$program" != lab ] || { shift && start_lab "$@"; } ;;
  jupyter-lab | jupyter-labhub | jupyter-server | jupyter-notebook) shift && start_lab "$@" ;;
  jupyter)
    # `jupyter --debug lab` starts it too: the first word that is not an option is the command.
    command='' position=1
    for word in "$@"; do
      [ "$word" = "$program" ] || case $word in
        -*) ;;
        *) command=$word && break ;;
      esac
      position=$((position + 1))
    done
    case $command in
      lab | labhub | server | notebook)
        case ${3:-} in
          password | list | stop) [ "${2:-}" != "$command" ] || exec "$@" ;;
        esac
        shift "$position" && start_lab "$@"
        ;;
    esac
    ;;
esac
# Programs of the image by their path or name: sh for a look around, python3 for a script.
case $program in
  sh | bash | python3 | jupyter | /*) exec "$@" ;;
esac
exec /usr/local/bin/qrobot "$@"
