#!/bin/bash
# Prove the arm64 images on an emulated Cortex-A72 (the Pi 4's), as `make test-arm64`.
#
# Builds the image edge for arm64 on both Debians and for amd64, then on the emulated processor:
# a control that it refuses what a Pi 4 refuses; every health check of the profile edge, on both
# Pythons; a plan or reads of every local backend, held against those of x86-64. Reports are kept
# in build/arm64. RELEASES="trixie" leaves bookworm out.
set -euo pipefail
cd "$(dirname "$0")/.."
releases=${RELEASES:-trixie bookworm}
out=$PWD/build/arm64
cpu=cortex-a72
export BUILDER=${BUILDER:-}

begin=$SECONDS
step() { printf '%4d s  %s\n' $((SECONDS - begin)) "$*"; }

trap 'docker/engine.sh stop' EXIT
docker/engine.sh start
rm -rf "$out"
mkdir -p "$out"
chmod 1777 "$out" # the images run as an account of their own

step 'build the images'
docker/image.sh edge linux/arm64,linux/amd64 "${releases%% *}"
for release in $releases; do docker/image.sh edge linux/arm64 "$release"; done
for release in $releases; do docker/load.sh "qrobot:edge-$release-arm64"; done
docker/load.sh "qrobot:edge-${releases%% *}-amd64"

# As a careful user runs them: no network, nothing writable but /tmp and the reports.
run() { # RELEASE ARCH ARGUMENT...
  local image=qrobot:edge-$1-$2 platform=linux/$2
  shift 2
  docker run --rm --platform "$platform" --env QEMU_CPU="${CPU:-$cpu}" --network none --read-only \
    --tmpfs /tmp:exec --cap-drop ALL --security-opt no-new-privileges \
    --volume "$out:/reports" --volume "$PWD/docker:/docker:ro" "$image" "$@"
}

step "control: the emulated $cpu must refuse an LSE instruction, the emulated maximum must not"
refused=$(run "${releases%% *}" arm64 python3 /docker/lse_probe.py 2>/dev/null)
executes=$(CPU=max run "${releases%% *}" arm64 python3 /docker/lse_probe.py)
echo "        $cpu: $refused, max: $executes"
if [ "$refused $executes" != "refused executes" ]; then
  echo 'the emulator does not discriminate: nothing of this would prove anything' >&2
  exit 1
fi

failed=0
for release in $releases; do
  step "health checks of the profile edge, $release"
  run "$release" arm64 health --profile edge --jobs 2 --timeout 900 --output "/reports/health-$release.json" \
    --junit "/reports/health-$release.xml" --html "/reports/health-$release.html" || failed=1
done

step 'plans and reads of every local backend, arm64'
run "${releases%% *}" arm64 python3 /docker/plans.py make /reports/plans-arm64.json
step 'the same on amd64'
run "${releases%% *}" amd64 python3 /docker/plans.py make /reports/plans-amd64.json
run "${releases%% *}" amd64 python3 /docker/plans.py compare /reports/plans-arm64.json /reports/plans-amd64.json |
  tee "$out/plans.txt" || failed=1

step "done: $out"
exit $failed
