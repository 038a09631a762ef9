#!/bin/sh
# Build one image. Usage: docker/image.sh TARGET PLATFORM RELEASE
#   such as: docker/image.sh edge linux/arm64 trixie          (or linux/arm64,linux/amd64)
#
# The result is qrobot:TARGET-RELEASE-ARCH in buildah's store (buildah), or in Docker's (buildx).
# buildah makes of several platforms one manifest list, qrobot:TARGET-RELEASE; a list by buildx
# goes to a registry: docker buildx bake -f docker/docker-bake.hcl --push. BUILDER=buildah or buildx
# decides where both are there; BASE names another base image, best by its digest; NO_CACHE=1
# builds and fetches everything anew; KERNELS says for which machines the searches are compiled
# (arm64,amd64; under an emulator that takes a quarter of an hour).
set -eu
target=$1 platforms=$2 release=$3
cd "$(dirname "$0")/.."
base=${BASE:-docker.io/library/debian:$release-slim}
version=$(sed -n 's/^__version__ = "\(.*\)"/\1/p' qrobot/_version.py)
revision=$(git rev-parse HEAD 2>/dev/null || echo unknown)
git diff --quiet HEAD 2>/dev/null || revision=$revision-dirty
epoch=$(git log -1 --format=%ct 2>/dev/null || echo 0)
builder=$(docker/builder.sh)
# A network with a proxy of its own has its own certificates; the builder then needs them too.
secret=
if [ -s /etc/ssl/certs/ca-certificates.crt ]; then
  secret="id=ca,src=/etc/ssl/certs/ca-certificates.crt"
fi
case $(uname -m) in x86_64) here=amd64 ;; aarch64) here=arm64 ;; *) here=$(uname -m) ;; esac

kernels() { case ,${KERNELS-arm64,amd64}, in *,$1,*) echo true ;; *) echo false ;; esac; } # ARCH

with_buildx() { # ARCH
  env BASE="$base" RELEASE="$release" VERSION="$version" REVISION="$revision" \
    SOURCE_DATE_EPOCH="$epoch" docker buildx bake --file docker/docker-bake.hcl "$target" \
    --set "*.platform=linux/$1" --set "*.tags=qrobot:$target-$release-$1" \
    ${secret:+--set "*.secrets=$secret"} \
    --set "*.args.KERNELS=$(kernels "$1")" \
    ${NO_CACHE:+--no-cache --set "*.args.UV_NO_CACHE=true"} --load
}

with_buildah() { # ARCH
  target_base=$(docker/base.sh "$base" "$1")
  build_base=$(docker/base.sh "$base" "$here")
  buildah build --format docker --isolation chroot --quiet --layers \
    ${NO_CACHE:+--no-cache --build-arg UV_NO_CACHE=true} ${secret:+--secret "$secret"} \
    --platform "linux/$1" --build-arg BUILDPLATFORM="linux/$here" \
    --build-arg TARGETPLATFORM="linux/$1" --build-arg TARGETARCH="$1" \
    --build-arg KERNELS="$(kernels "$1")" \
    --build-arg BASE="$target_base" --build-arg BUILD_BASE="$build_base" \
    --build-arg VERSION="$version" --build-arg REVISION="$revision" \
    --build-arg SOURCE_DATE_EPOCH="$epoch" --timestamp "$epoch" \
    --target "$target" --tag "localhost/qrobot:$target-$release-$1" \
    --ignorefile docker/Dockerfile.dockerignore --file docker/Dockerfile . >/dev/null
}

names=
for platform in $(echo "$platforms" | tr , ' '); do
  arch=${platform#linux/}
  echo "Building qrobot:$target-$release-$arch with $builder"
  "with_$builder" "$arch"
  names="$names localhost/qrobot:$target-$release-$arch"
done

# shellcheck disable=SC2086 # the names are words
set -- $names
if [ $# -gt 1 ] && [ "$builder" = buildah ]; then
  list=localhost/qrobot:$target-$release
  buildah manifest rm "$list" >/dev/null 2>&1 || buildah rmi "$list" >/dev/null 2>&1 || :
  buildah manifest create "$list" >/dev/null
  for name in "$@"; do buildah manifest add "$list" "containers-storage:$name" >/dev/null; done
  echo "One manifest list: $list"
fi
