#!/bin/sh
# Make this machine ready to run images of both kinds: qemu-user for the other one, and an engine.
# Usage: docker/engine.sh start | stop | emulation
#
# Where a Docker engine answers, it is used and left alone. Where none does, one is started by
# hand as root, in build/engine, and `start` says "started": whoever reads that stops it again.
set -eu
cd "$(dirname "$0")/.."
state=$PWD/build/engine

emulation() {
  handler=/proc/sys/fs/binfmt_misc
  if [ "$(uname -m)" = aarch64 ] || ls $handler/qemu-aarch64 >/dev/null 2>&1; then return; fi
  [ -e $handler/register ] || mount -t binfmt_misc binfmt_misc $handler
  update-binfmts --enable qemu-aarch64 || {
    echo "no emulator for arm64: make image-tools installs qemu-user-static" >&2
    exit 1
  }
}

start() {
  emulation
  if docker info >/dev/null 2>&1; then return; fi
  [ "$(id -u)" = 0 ] || {
    echo "Docker does not answer: start it, or join the group docker" >&2
    exit 1
  }
  command -v dockerd >/dev/null || { echo "no Docker engine: make image-tools installs one" >&2; exit 1; }
  mkdir -p "$state"
  nohup dockerd --data-root "$state/data" --exec-root "$state/run" --pidfile "$state/pid" \
    >"$state/log" 2>&1 &
  for _ in $(seq 60); do
    if docker info >/dev/null 2>&1; then
      echo started
      return
    fi
    kill -0 $! 2>/dev/null || break
    sleep 1
  done
  tail -5 "$state/log" >&2
  echo "the Docker engine did not start: $state/log" >&2
  exit 1
}

stop() { # only the engine that was started here
  [ -s "$state/pid" ] || return 0
  pid=$(cat "$state/pid")
  if [ "$(cat "/proc/$pid/comm" 2>/dev/null)" != dockerd ]; then # the number is somebody else's by now
    rm -f "$state/pid"
    return 0
  fi
  kill "$pid" 2>/dev/null || :
  for _ in $(seq 30); do
    if ! kill -0 "$pid" 2>/dev/null; then break; fi
    sleep 1
  done
  rm -f "$state/pid"
}

case ${1:-} in
  start) start ;;
  stop) stop ;;
  emulation) emulation ;;
  *) echo "usage: docker/engine.sh start | stop | emulation" >&2; exit 2 ;;
esac
