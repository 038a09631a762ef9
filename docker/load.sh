#!/bin/sh
# Hand images from buildah's store to the Docker engine. Usage: docker/load.sh qrobot:TARGET-RELEASE-ARCH...
# What is for this machine, on trixie, is called qrobot:TARGET as well.
set -eu
builder=$("$(dirname "$0")/builder.sh")
case $(uname -m) in x86_64) here=amd64 ;; aarch64) here=arm64 ;; *) here=$(uname -m) ;; esac
for name in "$@"; do
  # What buildx has built is with Docker already.
  if [ "$builder" = buildah ]; then
    id=$(buildah inspect --type image --format '{{.FromImageID}}' "localhost/$name" 2>/dev/null) || {
      echo "no image $name: make image builds it" >&2
      exit 1
    }
    if [ "$(docker image inspect --format '{{.Id}}' "$name" 2>/dev/null)" != "sha256:$id" ]; then
      # As an archive: skopeo's own way to Docker speaks too old a language for a new engine.
      skopeo copy --quiet "containers-storage:localhost/$name" "docker-archive:/dev/stdout:$name" |
        docker load --quiet >/dev/null
    fi
  fi
  docker image inspect "$name" >/dev/null
  case $name in *-trixie-"$here") docker tag "$name" "${name%%-*}" ;; esac
done
