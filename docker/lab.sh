#!/bin/sh
# Start JupyterLab, and never without a token or a password.
#
# JUPYTER_TOKEN, or better JUPYTER_TOKEN_FILE (a docker secret), or JUPYTER_PASSWORD_HASH as
# `jupyter server password` makes it. None of them is an argument, so the process list shows none.
set -eu
refuse() {
  echo "qrobot lab: $1" >&2
  echo "Give it one: docker run -e JUPYTER_TOKEN=\"\$(openssl rand -hex 24)\" -p 127.0.0.1:8888:8888 ..." >&2
  exit 2
}
if ! command -v jupyter-lab >/dev/null; then
  echo "qrobot lab: this image has no JupyterLab; use the image lab" >&2
  exit 2
fi
for argument in "$@"; do
  case $argument in
    *token* | *password* | *Token* | *Password*)
      refuse "a token or password belongs into the environment, not into '${argument%%=*}', which the process list shows" ;;
    --config* | -c | -c=* | *identity_provider* | *IdentityProvider* | *disable_check_xsrf* | *allow_unauthenticated*)
      refuse "${argument%%=*} could let everybody in, so it is no argument here" ;;
  esac
done
if [ -n "${JUPYTER_PASSWORD_HASH:-}" ]; then
  case $JUPYTER_PASSWORD_HASH in
    argon2:* | sha1:* | sha256:*) ;;
    *) refuse "JUPYTER_PASSWORD_HASH is no hash" ;;
  esac
  config=$(mktemp -d)
  printf '{"PasswordIdentityProvider": {"hashed_password": "%s"}}' "$JUPYTER_PASSWORD_HASH" \
    >"$config/jupyter_server_config.json"
  export JUPYTER_CONFIG_DIR="$config"
  unset JUPYTER_TOKEN JUPYTER_TOKEN_FILE JUPYTER_PASSWORD_HASH
  export JUPYTER_TOKEN=
else
  if [ -n "${JUPYTER_TOKEN_FILE:-}" ]; then
    [ -r "$JUPYTER_TOKEN_FILE" ] || refuse "JUPYTER_TOKEN_FILE: cannot read $JUPYTER_TOKEN_FILE"
    JUPYTER_TOKEN=$(cat "$JUPYTER_TOKEN_FILE")
    unset JUPYTER_TOKEN_FILE
    export JUPYTER_TOKEN
  fi
  token=${JUPYTER_TOKEN:-}
  [ "${#token}" -ge 16 ] || refuse "no token of 16 characters or more, and no password: it does not start"
fi
exec jupyter-lab --no-browser --ip=0.0.0.0 --port=8888 --ServerApp.root_dir=/data "$@"
