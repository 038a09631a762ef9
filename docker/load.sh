#!/bin/sh
# Hand images from buildah's store to the Docker engine. Usage: docker/load.sh qrobot:TARGET-RELEASE-ARCH...
# What is for this machine is called qrobot:TARGET as well.
set -eu
case $(uname -m) in x86_64) here=amd64 ;; aarch64) here=arm64 ;; *) here=$(uname -m) ;; esac
for name in "$@"; do
  # What buildx has built is there already.
  if id=$(buildah inspect --type image --format '{{.FromImageID}}' "localhost/$name" 2>/dev/null) &&
    [ "$(docker image inspect --format '{{.Id}}' "$name" 2>/dev/null)" != "sha256:$id" ]; then
    skopeo copy --quiet "containers-storage:localhost/$name" "docker-daemon:$name"
  fi
  docker image inspect "$name" >/dev/null || { echo "no image $name: make image builds it" >&2; exit 1; }
  case $name in *-"$here") docker tag "$name" "${name%%-*}" ;; esac
done
