#!/bin/sh
# Add the account that the images run as, and the certificates. Usage: account.sh BASE ROOT
set -eu
base=$1 root=$2
mkdir -p "$root/etc/ssl" "$root/data" # what is mounted there; nobody may write into it
cp "$base/passwd" "$base/group" "$root/etc/"
echo 'qrobot:x:10001:10001:qRobot:/tmp:/usr/sbin/nologin' >>"$root/etc/passwd"
echo 'qrobot:x:10001:' >>"$root/etc/group"
# The same package, installed here, has made the bundle that unpacking alone does not make.
cp -a /etc/ssl/certs "$root/etc/ssl/"
