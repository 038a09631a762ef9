#!/bin/sh
# A Raspberry Pi without a Raspberry Pi: a Cortex-A72 that boots Debian for arm64, with a boot
# partition, first set up by cloud-init from the card that `qrobot image seed` writes.
# Usage: ansible/virtual-pi/virtual-pi.sh start|stop|kill|reset|ssh|status|inventory
#
#   start      boot it (from its first boot on when there is no disk) and wait until SSH answers
#   stop       shut it down as a person does
#   kill       cut its power: the emulator is ended as it stands
#   reset      stop it and throw its disk away; the next start is a first boot
#   ssh ...    log in, or run a command
#
# Its disk, key and log lie in build/virtual-pi. Environment: VPI_MEMORY (MB, 4096), VPI_CPUS (2),
# VPI_RELEASE (trixie), VPI_PORT (a free one), VPI_NETWORK=restricted (SSH only), VPI_DIR.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
state=${VPI_DIR:-$root/build/virtual-pi}
release=${VPI_RELEASE:-trixie}
cache=${XDG_CACHE_HOME:-$HOME/.cache}/qrobot/virtual-pi/$release
user=pi
host=qrobot-virtual

say() { echo "virtual-pi: $*" >&2; }
fail() { say "$*"; exit 1; }
running() { [ -s "$state/pid" ] && kill -0 "$(cat "$state/pid")" 2>/dev/null; }
port() { cat "$state/port"; }

login() {
  ssh -q -o UserKnownHostsFile="$state/known_hosts" -o StrictHostKeyChecking=accept-new \
    -o IdentitiesOnly=yes -o ConnectTimeout=10 -o ServerAliveInterval=15 \
    -i "$state/key" -p "$(port)" "$user@127.0.0.1" "$@"
}

card() { # the boot partition: what Raspberry Pi OS has on it, and the seed beside it
  mkdir -p "$state/card"
  [ -s "$state/key" ] || ssh-keygen -q -t ed25519 -N '' -C "$host" -f "$state/key"
  cp "$here/config.txt" "$here/cmdline.txt" "$state/card/"
  : >"$state/card/meta-data" # an image of trixie brings one; the seed replaces it
  "${QROBOT:-$root/.venv/bin/qrobot}" image seed "$state/card" --release "$release" --force \
    --hostname "$host" --user "$user" --key "$state/key.pub" --timezone UTC >/dev/null
  truncate -s 128M "$state/boot.img.part"
  mkfs.vfat -F 32 -n bootfs "$state/boot.img.part" >"$state/mkfs.log" 2>&1 || fail "$(cat "$state/mkfs.log")"
  mcopy -i "$state/boot.img.part" "$state"/card/* ::
  mv "$state/boot.img.part" "$state/boot.img"
}

inventory() {
  cat >"$state/inventory.yml" <<INVENTORY
# The virtual Pi, as an inventory: make provision INVENTORY=$state/inventory.yml
all:
  hosts:
    $host:
      ansible_host: 127.0.0.1
      ansible_port: $(port)
      ansible_user: $user
      ansible_ssh_private_key_file: $state/key
      ansible_ssh_common_args: -o UserKnownHostsFile=$state/known_hosts -o StrictHostKeyChecking=accept-new
INVENTORY
}

start() {
  if running; then
    say "it runs already: make virtual-pi-ssh"
    return
  fi
  command -v qemu-system-aarch64 >/dev/null || fail 'no qemu-system-aarch64 here: make virtual-pi-tools'
  "$here/build.sh" "$release"
  mkdir -p "$state"
  chmod 700 "$state"
  [ -s "$state/boot.img" ] || card
  if [ ! -s "$state/disk.qcow2" ]; then
    qemu-img create -q -f qcow2 -b "$cache/disk.qcow2" -F qcow2 "$state/disk.qcow2"
    rm -f "$state/known_hosts"
  fi
  if [ -n "${VPI_PORT:-}" ]; then
    echo "$VPI_PORT" >"$state/port"
  elif [ ! -s "$state/port" ]; then
    python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])' >"$state/port"
  fi
  # A Pi's firmware hands cmdline.txt to the kernel; so is it done here, with what this board needs.
  words=$(mtype -i "$state/boot.img" ::cmdline.txt | head -n 1 | tr ' ' '\n' |
    grep -v -E '^(root=|rootfstype=|console=|fsck.repair=|rootwait)' | tr '\n' ' ')
  restrict=off # and a busy machine emulates slowly: devices are waited for longer than a Pi needs
  [ "${VPI_NETWORK:-}" != restricted ] || restrict=on
  begin=$(date +%s)
  nohup qemu-system-aarch64 -M virt -cpu cortex-a72 -smp "${VPI_CPUS:-2}" -m "${VPI_MEMORY:-4096}" \
    -accel tcg,thread=multi -display none -serial "file:$state/console.log" \
    -monitor "unix:$state/monitor,server=on,wait=off" \
    -kernel "$cache/vmlinuz" -initrd "$cache/initrd" \
    -append "root=LABEL=rootfs rw console=ttyAMA0 net.ifnames=0 systemd.default_device_timeout_sec=900 $words" \
    -drive "file=$state/disk.qcow2,if=none,id=d0,format=qcow2,discard=unmap" -device virtio-blk-pci,drive=d0 \
    -drive "file=$state/boot.img,if=none,id=d1,format=raw" -device virtio-blk-pci,drive=d1 \
    -netdev "user,id=n0,restrict=$restrict,hostfwd=tcp:127.0.0.1:$(port)-:22" -device virtio-net-pci,netdev=n0 \
    -device virtio-rng-pci >"$state/qemu.log" 2>&1 &
  echo $! >"$state/pid"
  say "booting (a minute or two; the console: $state/console.log)"
  inventory
  for _ in $(seq 120); do
    if login true 2>/dev/null; then
      say "SSH answers after $(($(date +%s) - begin)) s: make virtual-pi-ssh, make provision INVENTORY=$state/inventory.yml"
      return
    fi
    running || fail "it ended: $(tail -n 3 "$state/qemu.log")"
    sleep 3
  done
  fail "SSH does not answer: look at $state/console.log"
}

cut() {
  running || return 0
  pid=$(cat "$state/pid")
  kill -9 "$pid"
  while kill -0 "$pid" 2>/dev/null; do sleep 0.2; done
  rm -f "$state/pid"
}

stop() {
  running || return 0
  pid=$(cat "$state/pid")
  login sudo systemctl poweroff 2>/dev/null || true
  for _ in $(seq 60); do
    if ! kill -0 "$pid" 2>/dev/null; then
      rm -f "$state/pid"
      return
    fi
    sleep 1
  done
  say 'it does not shut down: its power is cut'
  cut
}

case ${1:-} in
  start) start ;;
  stop) stop ;;
  kill) cut ;;
  reset)
    cut
    rm -rf "$state/disk.qcow2" "$state/boot.img" "$state/card" "$state/known_hosts" "$state/console.log"
    ;;
  ssh)
    running || fail 'it does not run: make virtual-pi'
    shift
    login "$@"
    ;;
  status) if running; then echo running; else echo stopped; exit 1; fi ;;
  inventory) inventory && echo "$state/inventory.yml" ;;
  *) sed -n '4,14s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
