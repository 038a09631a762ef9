#!/bin/sh
# Build an image twice from nothing and say which files differ. Usage: docker/twice.sh TARGET PLATFORM RELEASE
# Exit code 1: some do. Needs root and buildah. Wheels are fetched and sdists built twice, too; Debian's
# packages are the newest of the moment, so this holds for builds of one day.
set -eu
cd "$(dirname "$0")/.."
target=$1 platform=$2 release=$3
name=localhost/qrobot:$target-$release-${platform#linux/}
out=build/twice
mkdir -p "$out"
for time in first second; do
  BUILDER=buildah NO_CACHE=1 docker/image.sh "$target" "$platform" "$release"
  container=$(buildah from --quiet --pull-never "$name")
  root=$(buildah mount "$container")
  python3 docker/tree.py "$root" >"$out/$time.txt"
  buildah rm "$container" >/dev/null
done
if diff "$out/first.txt" "$out/second.txt" >"$out/differs.txt"; then
  echo "the same $(wc -l <"$out/first.txt") files both times"
else
  cut -c1-160 "$out/differs.txt"
  echo "$(grep -c '^>' "$out/differs.txt") of $(wc -l <"$out/first.txt") entries differ: $out/differs.txt"
  exit 1
fi
