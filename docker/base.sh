#!/bin/sh
# Put the base image for one architecture on this machine, and print the name that it has here.
# Usage: docker/base.sh IMAGE ARCH       such as docker.io/library/debian:trixie-slim arm64
#
# Where a registry answers, the image is pulled. Where none does, the same is bootstrapped from
# Debian's signed packages: a minimal system without documents, as the slim images are. The other
# machine's maintainer scripts run under qemu-user for that (2 minutes, once: the tar stays in
# ~/.cache/qrobot). QROBOT_BOOTSTRAP=1 asks no registry, QROBOT_REFRESH=1 takes the newest
# packages or image. Needs root, buildah and mmdebstrap.
set -eu
image=$1 arch=$2
cache=${XDG_CACHE_HOME:-$HOME/.cache}/qrobot/base
release=${image##*debian:}
release=${release%%@*}
release=${release%-slim}
name=localhost/qrobot-base:$(printf '%s' "$image" | tr -c 'A-Za-z0-9' '-')-$arch

tar=$cache/$release-$arch.tar
if [ -n "${QROBOT_REFRESH:-}" ]; then
  rm -f "$tar"
elif buildah inspect --type image "$name" >/dev/null 2>&1; then
  echo "$name"
  exit
fi
why='none was asked'
if [ -z "${QROBOT_BOOTSTRAP:-}" ] && why=$(timeout 30 skopeo inspect --raw "docker://$image" 2>&1 >/dev/null); then
  buildah pull --quiet --arch "$arch" "$image" >/dev/null
  buildah tag "$image" "$name"
  echo "$name"
  exit
fi
case $image in
  *debian:trixie-slim | *debian:bookworm-slim) ;;
  *) echo "$image: no registry gives it, and only debian:trixie-slim and debian:bookworm-slim can be bootstrapped" >&2
    exit 1 ;;
esac
if [ ! -s "$tar" ]; then
  mkdir -p "$cache"
  echo "No registry gives $image (${why##*: }): bootstrapping Debian $release for $arch into $tar" >&2
  mmdebstrap --quiet --arch="$arch" --variant=minbase \
    --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/locale/*' \
    --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-include=/usr/share/doc/*/copyright' \
    "$release" "$tar.part.tar"
  mv "$tar.part.tar" "$tar"
fi
container=$(buildah from --quiet --arch "$arch" scratch)
buildah add --quiet "$container" "$tar" / >/dev/null
buildah config --arch "$arch" --os linux --cmd bash "$container"
buildah commit --quiet --rm --format docker --timestamp 0 "$container" "$name" >/dev/null
echo "$name"
