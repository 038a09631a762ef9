#!/bin/sh
# Build the disk of the virtual Pi once, and keep it: a Debian for arm64 that boots as Raspberry
# Pi OS Lite does (systemd, cloud-init, NetworkManager, sshd, sudo, python3 and nothing of ours).
# Usage: ansible/virtual-pi/build.sh [trixie|bookworm]
#
# What it makes lies in ~/.cache/qrobot/virtual-pi/RELEASE: disk.qcow2, vmlinuz, initrd. The
# packages' scripts run under qemu-user for it: 15 minutes on two cores, once. QROBOT_REFRESH=1
# builds it anew. Needs root, mmdebstrap, qemu-user-static, qemu-utils and e2fsprogs
# (`make virtual-pi-tools`).
set -eu
release=${1:-trixie}
case $release in
  trixie | bookworm) ;;
  *) echo "virtual-pi: no release $release, give trixie or bookworm" >&2; exit 2 ;;
esac
cache=${XDG_CACHE_HOME:-$HOME/.cache}/qrobot/virtual-pi/$release
if [ -s "$cache/disk.qcow2" ] && [ -z "${QROBOT_REFRESH:-}" ]; then exit; fi
if [ "$(id -u)" -ne 0 ]; then
  echo "virtual-pi: the disk is built by root, once: sudo env HOME='$HOME' $0 $release" >&2
  exit 1
fi
for tool in mmdebstrap qemu-aarch64-static qemu-img mke2fs; do
  command -v "$tool" >/dev/null || { echo "virtual-pi: no $tool here: run \"make virtual-pi-tools\"" >&2; exit 1; }
done
here=$(cd "$(dirname "$0")" && pwd)
"$here/../../docker/engine.sh" emulation
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$cache"

# As Raspberry Pi OS Lite has it; the robot's own packages are the playbooks' to install.
packages='systemd-sysv dbus udev kmod libpam-systemd systemd-timesyncd openssh-server sudo python3
  python3-apt ca-certificates cloud-init netplan.io network-manager iproute2 iputils-ping
  initramfs-tools linux-image-arm64 e2fsprogs dosfstools fdisk locales tzdata less procps'

echo "virtual-pi: bootstrapping Debian $release for arm64: about 15 minutes, once" >&2
# An initramfs with everything takes many minutes of emulation: only what this machine boots from.
cat >"$work/hook" <<'HOOK'
#!/bin/sh
set -eu
mkdir -p "$1/etc/initramfs-tools/conf.d"
printf 'MODULES=list\nCOMPRESS=gzip\n' >"$1/etc/initramfs-tools/conf.d/virtual-pi"
printf '%s\n' virtio_pci virtio_blk virtio_net virtio_mmio ext4 >"$1/etc/initramfs-tools/modules"
HOOK
chmod +x "$work/hook"
# shellcheck disable=SC2086  # a list of words
mmdebstrap --arch=arm64 --variant=minbase --components='main' \
  --include="$(echo $packages | tr -s ' \n' ',')" \
  --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/doc/*' \
  --dpkgopt='path-include=/usr/share/doc/*/copyright' \
  --essential-hook="$work/hook" \
  "$release" "$work/root.tar"
mkdir "$work/root"
tar -C "$work/root" --numeric-owner -xpf "$work/root.tar"
rm "$work/root.tar"
root=$work/root

# A Pi's partitions: the root, and the boot partition that carries config.txt and the seed.
cat >"$root/etc/fstab" <<'FSTAB'
LABEL=rootfs / ext4 defaults,noatime 0 1
LABEL=bootfs /boot/firmware vfat defaults,x-systemd.device-timeout=900 0 2
FSTAB
mkdir -p "$root/boot/firmware"
# As Raspberry Pi OS tells cloud-init where its seed lies.
cat >"$root/etc/cloud/cloud.cfg.d/99_raspberry-pi.cfg" <<'CLOUD'
datasource_list: [NoCloud, None]
datasource:
  NoCloud:
    fs_label: bootfs
CLOUD
# As there, netplan hands the network to NetworkManager.
mkdir -p "$root/usr/lib/netplan"
printf 'network:\n  version: 2\n  renderer: NetworkManager\n' >"$root/usr/lib/netplan/00-network-manager-all.yaml"
chmod 600 "$root/usr/lib/netplan/00-network-manager-all.yaml"
# Nothing that would make all virtual Pis one: keys and the machine's id are made at the first boot.
rm -f "$root"/etc/ssh/ssh_host_* "$root/var/lib/dbus/machine-id"
# Empty, not "uninitialized": that would enable every unit by its preset, networkd beside NetworkManager.
: >"$root/etc/machine-id"
printf 'raspberrypi\n' >"$root/etc/hostname"
passwd_file=$root/etc/shadow
sed -i 's/^root:[^:]*:/root:!:/' "$passwd_file"

cp "$root"/boot/vmlinuz-* "$cache/vmlinuz"
cp "$root"/boot/initrd.img-* "$cache/initrd"
mke2fs -q -t ext4 -L rootfs -d "$root" "$work/disk.raw" 16G
qemu-img convert -O qcow2 "$work/disk.raw" "$cache/disk.part"
mv "$cache/disk.part" "$cache/disk.qcow2"
echo "virtual-pi: $(du -h "$cache/disk.qcow2" | cut -f1) in $cache" >&2
# Built with sudo for a person: it is theirs, and so is the folder that may have been made for it.
if [ -n "${SUDO_UID:-}" ] && [ -n "${SUDO_GID:-}" ]; then
  chown "$SUDO_UID:$SUDO_GID" "${XDG_CACHE_HOME:-$HOME/.cache}"
  chown -R "$SUDO_UID:$SUDO_GID" "${XDG_CACHE_HOME:-$HOME/.cache}/qrobot"
fi
