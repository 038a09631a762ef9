#!/bin/sh
# Start JupyterLab, and never without a token or a password.
#
# JUPYTER_TOKEN_FILE (a docker secret or a mounted file), or JUPYTER_TOKEN from an --env-file, or
# JUPYTER_PASSWORD_HASH as `jupyter server password` makes it. None of them is an argument: the
# process list shows those, also the ones of `docker run -e NAME=VALUE`.
set -eu
refuse() {
  cat >&2 <<END
qrobot lab: $1
Give it a token by a file:
  (umask 077; printf 'JUPYTER_TOKEN=%s\\n' "\$(openssl rand -hex 24)" >lab.env)
  docker run --env-file lab.env -p 127.0.0.1:8888:8888 ...
END
  exit 2
}
if ! command -v jupyter-lab >/dev/null; then
  echo "qrobot lab: this image has no JupyterLab; use the image lab" >&2
  exit 2
fi

# Only arguments that cannot change who gets in: Jupyter has hundreds, takes most under several
# names (a base class sets what its children have) and accepts the beginning of one for the whole.
check_argument() {
  case $1 in
    -h | --help | --help-all | --version | --debug) return ;;
    --log-level=* | --LabApp.default_url=/* | --ServerApp.base_url=/*) return ;;
    --certfile=/* | --keyfile=/* | --ServerApp.terminals_enabled=*) return ;;
    --MappingKernelManager.cull_*=* | --ServerApp.shutdown_no_activity_timeout=*) return ;;
    --ServerApp.max_body_size=* | --ServerApp.max_buffer_size=*) return ;;
    *[Tt][Oo][Kk][Ee][Nn]* | *[Pp][Aa][Ss][Ss][Ww][Oo][Rr][Dd]*)
      refuse "a token or password belongs into a file, not into '${1%%=*}', which the process list shows" ;;
  esac
  refuse "'${1%%=*}' is not an argument of the lab: it takes --debug, --log-level=, --certfile=/, --keyfile=/, --LabApp.default_url=/, --ServerApp.base_url=/, terminals_enabled=, max_body_size=, max_buffer_size= and shutdown_no_activity_timeout= of --ServerApp, and --MappingKernelManager.cull_...="
}

check_token() {
  [ "${#1}" -ge 16 ] || refuse "no token of 16 characters or more, and no password: it does not start"
  case $1 in
    *[!!-~]*) refuse "the token has a space, a line break or a character that is not ASCII: it does not start" ;;
  esac
  twice=$1$1 inner=${twice#?}
  case ${inner%?} in
    *"$1"*) refuse "the token repeats a short pattern: it does not start" ;;
  esac
  distinct=$(printf '%s' "$1" | fold -w 1 | sort -u | wc -l)
  [ "$distinct" -ge 8 ] || refuse "the token has fewer than 8 different characters: it does not start"
}

# What Jupyter itself writes, whole: it takes a cut one without a word, and then nobody gets in.
# The characters are checked first: grep looks at each line, and the text goes into a file of JSON.
check_hash() {
  case $1 in
    *[!A-Za-z0-9:=,+/\$]*) refuse "JUPYTER_PASSWORD_HASH is not a hash as 'jupyter server password' makes it" ;;
  esac
  printf '%s\n' "$1" | grep -Exq \
    -e 'argon2:[$]argon2(id|i|d)[$]v=19[$]m=[1-9][0-9]*,t=[1-9][0-9]*,p=[1-9][0-9]*[$][A-Za-z0-9+/]{11,}[$][A-Za-z0-9+/]{22,}' \
    -e 'sha1:[0-9A-Za-z]{8,}:[0-9a-f]{40}' -e 'sha256:[0-9A-Za-z]{8,}:[0-9a-f]{64}' ||
    refuse "JUPYTER_PASSWORD_HASH is not a whole hash as 'jupyter server password' makes it"
}

for argument in "$@"; do
  check_argument "$argument"
done
if [ -n "${JUPYTER_PASSWORD_HASH:-}" ]; then
  check_hash "$JUPYTER_PASSWORD_HASH"
else
  if [ -n "${JUPYTER_TOKEN_FILE:-}" ]; then
    if [ ! -r "$JUPYTER_TOKEN_FILE" ] || [ -d "$JUPYTER_TOKEN_FILE" ]; then
      refuse "JUPYTER_TOKEN_FILE: cannot read $JUPYTER_TOKEN_FILE"
    fi
    JUPYTER_TOKEN=$(cat "$JUPYTER_TOKEN_FILE")
  fi
  check_token "${JUPYTER_TOKEN:-}"
fi

# A configuration file in the home, or in a folder that the environment names, could switch the token
# off: only this folder counts. Where the interface keeps its settings stays the same.
config=$(mktemp -d)
: "${HOME:=/tmp}"
export JUPYTERLAB_SETTINGS_DIR="${JUPYTERLAB_SETTINGS_DIR:-$HOME/.jupyter/lab/user-settings}"
export JUPYTERLAB_WORKSPACES_DIR="${JUPYTERLAB_WORKSPACES_DIR:-$HOME/.jupyter/lab/workspaces}"
export JUPYTER_CONFIG_DIR="$config"
unset JUPYTER_CONFIG_PATH
if [ -n "${JUPYTER_PASSWORD_HASH:-}" ]; then
  printf '{"PasswordIdentityProvider": {"hashed_password": "%s"}}' "$JUPYTER_PASSWORD_HASH" \
    >"$config/jupyter_server_config.json"
  JUPYTER_TOKEN=
fi
unset JUPYTER_PASSWORD_HASH JUPYTER_TOKEN_FILE
export JUPYTER_TOKEN
exec jupyter-lab --no-browser --ip=0.0.0.0 --port=8888 --ServerApp.root_dir=/data "$@"
