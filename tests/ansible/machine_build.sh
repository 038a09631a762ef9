#!/bin/sh
# Bootstrap the machine of tests/ansible/machine.py once: a Debian of this computer's own kind with
# systemd and sshd, as bare as Raspberry Pi OS Lite is for our purposes. Prints its folder.
# Usage: tests/ansible/machine_build.sh [trixie|bookworm]     QROBOT_REFRESH=1 builds it anew
set -eu
release=${1:-trixie}
cache=${XDG_CACHE_HOME:-$HOME/.cache}/qrobot/test-machine
root=$cache/$release
if [ -n "${QROBOT_REFRESH:-}" ]; then rm -rf "$root"; fi
mkdir -p "$cache"
exec 9>"$cache/.lock"
flock 9 # one session builds, another waits
if [ ! -d "$root" ]; then
  part=$(mktemp -d "$cache/part.XXXXXX")
  trap 'rm -rf "$part"' EXIT
  mmdebstrap --quiet --variant=minbase --components=main \
    --include=systemd-sysv,dbus,libpam-systemd,openssh-server,sudo,python3,python3-apt,ca-certificates,iproute2,kmod,procps,systemd-timesyncd \
    --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/doc/*' \
    "$release" "$part/root.tar"
  mkdir "$part/root"
  tar -C "$part/root" --numeric-owner --exclude='./dev/*' -xpf "$part/root.tar"
  # Every machine makes keys and an identity of its own.
  rm -f "$part"/root/etc/ssh/ssh_host_* "$part"/root/var/lib/dbus/machine-id "$part"/root/etc/machine-id
  # As a Pi's first user is: no password for sudo.
  chroot "$part/root" sh -eu -c '
    useradd --create-home --shell /bin/bash pi
    useradd --create-home --shell /bin/bash typist
    printf "pi ALL=(ALL) NOPASSWD: ALL\ntypist ALL=(ALL) NOPASSWD: ALL\n" >/etc/sudoers.d/010_pi
    chmod 0440 /etc/sudoers.d/010_pi
    systemctl --quiet enable ssh.service
    systemctl --quiet mask systemd-firstboot.service getty@tty1.service console-getty.service systemd-resolved.service apt-daily.timer apt-daily-upgrade.timer'
  mv "$part/root" "$root"
fi
echo "$root"
