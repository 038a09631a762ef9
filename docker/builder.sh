#!/bin/sh
# Print what builds images here: $BUILDER, or buildx where Docker has it, or buildah.
set -eu
case ${BUILDER:-} in
  buildx | buildah) echo "$BUILDER" ;;
  '')
    if docker buildx version >/dev/null 2>&1; then echo buildx
    elif command -v buildah >/dev/null; then echo buildah
    else
      echo "neither docker buildx nor buildah is here: make image-tools installs buildah" >&2
      exit 1
    fi
    ;;
  *)
    echo "BUILDER=$BUILDER: use buildx or buildah" >&2
    exit 2
    ;;
esac
