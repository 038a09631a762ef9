#!/bin/bash
# Prove the arm64 images on an emulated Cortex-A72 (the Pi 4's), as `make test-arm64`.
#
# Builds the image edge for arm64 on both Debians and for amd64, then on the emulated processor:
# a control that says which instructions that a Pi 4 lacks it refuses (all but AES, PMULL, SHA-1
# and SHA-2, which are for the scan of the wheels to find); every health check of the profile edge, on both
# Pythons; a plan or reads of every local backend, held against those of x86-64. Reports are kept
# in build/arm64. RELEASES=trixie leaves bookworm out; IMAGE=lab proves the whole appendix;
# X86_PYTHON=.venv/bin/python answers for x86-64 in place of an image, where it has the same lock.
# The searches are compiled into the images with KERNELS=arm64 only: under the emulator that takes
# a quarter of an hour. Their health check compiles what it needs.
set -euo pipefail
cd "$(dirname "$0")/.."
releases=${RELEASES:-trixie bookworm}
image=${IMAGE:-edge}
profile=$(python3 -c 'import locks, sys; print(locks.ROBOTS[sys.argv[1]])' "$image")
here=$PWD
out=$here/build/arm64
cpu=cortex-a72
if [ "$(uname -m)" = aarch64 ]; then
  echo 'this machine is an arm64 one: make test-images proves the images on it' >&2
  exit 2
fi

begin=$SECONDS
step() { printf '%4d s  %s\n' $((SECONDS - begin)) "$*"; }

case ${X86_PYTHON:-} in '' | /*) ;; *) X86_PYTHON=$here/$X86_PYTHON ;; esac
if [ "$(docker/engine.sh start)" = started ]; then trap 'docker/engine.sh stop' EXIT; fi
rm -rf "$out"
mkdir -p "$out"
chmod 1777 "$out" # the images run as an account of their own

step 'build the images'
export KERNELS=${KERNELS:-}
for release in $releases; do docker/image.sh "$image" linux/arm64 "$release"; done
for release in $releases; do docker/load.sh "qrobot:$image-$release-arm64"; done
if [ -z "${X86_PYTHON:-}" ]; then
  docker/image.sh "$image" linux/amd64 "${releases%% *}"
  docker/load.sh "qrobot:$image-${releases%% *}-amd64"
fi

# As a careful user runs them: no network, nothing writable but /tmp and the reports.
run() { # RELEASE ARCH ARGUMENT...
  local name=qrobot:$image-$1-$2 platform=linux/$2 shown=()
  # qemu-user shows the host's /proc/cpuinfo, and programs that look there for an ARM processor's
  # features die of it (LiteRT does): they are shown what a Pi 4 says.
  if [ "$2" = arm64 ]; then shown=(--volume "$PWD/docker/cpuinfo-cortex-a72.txt:/proc/cpuinfo:ro"); fi
  shift 2
  docker run --rm --platform "$platform" --env QEMU_CPU="${CPU:-$cpu}" --network none --read-only \
    --tmpfs /tmp --cap-drop ALL --security-opt no-new-privileges \
    --volume "$out:/reports" --volume "$PWD/docker:/docker:ro" "${shown[@]}" "$name" "$@"
}

step "control: which instructions that a Pi 4 lacks the emulated $cpu refuses"
for control in "$cpu" max; do
  CPU=$control run "${releases%% *}" arm64 python3 /docker/instruction_probe.py >"$out/control-$control.json" \
    2>"$out/control.txt" || {
    cat "$out/control.txt" >&2
    exit 1
  }
done
python3 docker/control.py "$out/control-$cpu.json" "$out/control-max.json" | tee "$out/control.txt" | sed 's/^/        /'

failed=0
for release in $releases; do
  step "health checks of the profile $profile, $release"
  run "$release" arm64 health --profile "$profile" --jobs 2 --timeout 900 --output "/reports/health-$release.json" \
    --junit "/reports/health-$release.xml" --html "/reports/health-$release.html" || failed=1
done

step 'plans and reads of every local backend, arm64'
run "${releases%% *}" arm64 python3 /docker/plans.py make /reports/plans-arm64.json
step 'the same on x86-64'
plans() { # ARGUMENT...
  if [ -n "${X86_PYTHON:-}" ]; then
    # As in the image: the kernels of an earlier compilation are those of another processor, and none
    # are made for these plans.
    (cd "$out" && QROBOT_COMPILE=0 NUMBA_CPU_NAME=generic NUMBA_CACHE_DIR="$out/numba" OPENBLAS_NUM_THREADS=1 \
      "$X86_PYTHON" "$here/docker/plans.py" "$@")
  else
    run "${releases%% *}" amd64 sh -c 'cd /reports && exec python3 /docker/plans.py "$@"' plans "$@"
  fi
}
plans make plans-amd64.json
plans compare plans-arm64.json plans-amd64.json |
  tee "$out/plans.txt" || failed=1

step "done: $out"
exit $failed
