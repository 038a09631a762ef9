#!/bin/sh
# Build one image. Usage: docker/image.sh TARGET PLATFORM RELEASE
#   such as: docker/image.sh edge linux/arm64 trixie          (or linux/arm64,linux/amd64)
#
# The result is qrobot:TARGET-RELEASE-ARCH in buildah's store (buildah), or in Docker's (buildx).
# buildah makes of several platforms one manifest list, qrobot:TARGET-RELEASE; a list by buildx
# goes to a registry: docker buildx bake -f docker/docker-bake.hcl --push. BUILDER=buildah or buildx
# decides where both are there; BASE names another base image, best by its digest.
set -eu
target=$1 platforms=$2 release=$3
cd "$(dirname "$0")/.."
base=${BASE:-docker.io/library/debian:$release-slim}
version=$(sed -n 's/^__version__ = "\(.*\)"/\1/p' qrobot/_version.py)
revision=$(git rev-parse HEAD 2>/dev/null || echo unknown)
epoch=$(git log -1 --format=%ct 2>/dev/null || echo 0)

builder=${BUILDER:-}
if [ -z "$builder" ]; then
  if docker buildx version >/dev/null 2>&1; then builder=buildx; else builder=buildah; fi
fi

case $builder in
  buildx)
    for platform in $(echo "$platforms" | tr , ' '); do
      arch=${platform#linux/}
      echo "Building qrobot:$target-$release-$arch"
      env BASE="$base" RELEASE="$release" VERSION="$version" REVISION="$revision" \
        SOURCE_DATE_EPOCH="$epoch" docker buildx bake --file docker/docker-bake.hcl "$target" \
        --set "*.platform=$platform" --set "*.tags=qrobot:$target-$release-$arch" --load
    done
    exit
    ;;
  buildah) ;;
  *) echo "BUILDER=$builder: use buildx or buildah" >&2; exit 2 ;;
esac
command -v buildah >/dev/null || {
  echo "neither docker buildx nor buildah is here: make image-tools installs buildah" >&2
  exit 1
}
case $(uname -m) in x86_64) here=amd64 ;; aarch64) here=arm64 ;; *) here=$(uname -m) ;; esac
build_base=$(docker/base.sh "$base" "$here")
# A network with a proxy of its own has its own certificates; the builder then needs them too.
secret=
if [ -s /etc/ssl/certs/ca-certificates.crt ]; then
  secret="--secret id=ca,src=/etc/ssl/certs/ca-certificates.crt"
fi

names=
for platform in $(echo "$platforms" | tr , ' '); do
  arch=${platform#linux/}
  name=localhost/qrobot:$target-$release-$arch
  echo "Building $name"
  # shellcheck disable=SC2086 # the secret is two words
  buildah build --format docker --isolation chroot --quiet ${NO_CACHE:+--no-cache} --layers \
    --platform "linux/$arch" --build-arg BUILDPLATFORM="linux/$here" \
    --build-arg TARGETPLATFORM="linux/$arch" \
    --build-arg BASE="$(docker/base.sh "$base" "$arch")" --build-arg BUILD_BASE="$build_base" \
    --build-arg VERSION="$version" --build-arg REVISION="$revision" \
    --build-arg SOURCE_DATE_EPOCH="$epoch" $secret \
    --timestamp "$epoch" --target "$target" --tag "$name" \
    --ignorefile docker/Dockerfile.dockerignore --file docker/Dockerfile . >/dev/null
  names="$names $name"
done

# shellcheck disable=SC2086 # the names are words
set -- $names
if [ $# -gt 1 ]; then
  list=localhost/qrobot:$target-$release
  buildah manifest rm "$list" >/dev/null 2>&1 || buildah rmi "$list" >/dev/null 2>&1 || :
  buildah manifest create "$list" >/dev/null
  for name in "$@"; do buildah manifest add "$list" "containers-storage:$name" >/dev/null; done
  echo "One manifest list: $list"
fi
