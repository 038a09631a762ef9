#!/bin/sh
# Unpack Debian packages of another machine, with all that its base image lacks for them.
# Usage: unpack.sh ARCH STATUS ROOT PACKAGE...
#
# STATUS is the base image's /var/lib/dpkg/status. apt chooses and verifies the packages as it
# would over there, but nothing of them is run here: their files are all that these packages need.
# They are listed in ROOT/var/lib/dpkg/status.d, where scanners of images look.
set -eu
arch=$1 status=$2 root=$3
shift 3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/lists/partial" "$work/archives/partial" "$root/var/lib/dpkg/status.d"
apt() {
  apt-get --quiet=2 --no-install-recommends \
    -o APT::Architecture="$arch" -o APT::Architectures="$arch" -o APT::Sandbox::User=root \
    -o Dir::State::status="$status" -o Dir::State::lists="$work/lists" \
    -o Dir::Cache::archives="$work/archives" \
    -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= "$@"
}
apt update
apt --download-only --yes install "$@"
# The base image has /lib and its like as links into /usr; some packages still name /lib.
for folder in bin lib lib64 sbin; do
  mkdir -p "$root/usr/$folder"
  ln -sfn "usr/$folder" "$root/$folder"
done
for package in "$work"/archives/*.deb; do
  dpkg-deb --fsys-tarfile "$package" | tar -x -C "$root" --keep-directory-symlink --no-same-owner \
    --exclude='./usr/share/man/*' --exclude='./usr/share/doc/*' --exclude='./usr/share/lintian/*' \
    --exclude='*/__pycache__/*'
  name=$(dpkg-deb --field "$package" Package)
  dpkg-deb --field "$package" >"$root/var/lib/dpkg/status.d/$name"
  dpkg-deb --info "$package" md5sums >"$root/var/lib/dpkg/status.d/$name.md5sums" 2>/dev/null || :
  echo "$name $(dpkg-deb --field "$package" Version) $arch"
done
for folder in bin lib lib64 sbin; do
  rm "$root/$folder"
  rmdir --ignore-fail-on-non-empty "$root/usr/$folder"
done
