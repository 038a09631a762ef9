#!/bin/sh
# Make the locks from pyproject.toml. Usage: locks/compile.sh UV [--upgrade]
#
# Without --upgrade every version stays that pyproject.toml still allows. The largest set is
# resolved first and constrains the others, so a package has one version in all of them.
set -eu
cd "$(dirname "$0")/.."
uv=$1
upgrade=${2:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# A machine's own package sources must not leave a trace in the locks.
unset PIP_FIND_LINKS PIP_INDEX_URL PIP_EXTRA_INDEX_URL UV_FIND_LINKS UV_INDEX UV_EXTRA_INDEX_URL

compile() {
  name=$1
  shift
  echo "locks/$name.txt"
  "$uv" pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest \
    --prerelease disallow --generate-hashes --no-header --no-emit-index-url \
    --only-binary :all: --no-binary docplex --no-binary fastdtw \
    --output-file "$work/$name.txt" "$@" >/dev/null
}

everything=$work/everything.txt
if [ -z "$upgrade" ]; then
  cat locks/*.txt >"$everything" 2>/dev/null || :
fi
compile everything pyproject.toml --all-extras --group build --group image
compile build --group build --constraint "$everything"
compile image --group build --group image --constraint "$everything"
compile base pyproject.toml --constraint "$everything"
compile solver pyproject.toml --extra solver --constraint "$everything"
compile edge pyproject.toml --extra edge --constraint "$everything"
compile full pyproject.toml --extra full --constraint "$everything"
compile provision pyproject.toml --extra provision --constraint "$everything"
compile dev pyproject.toml --extra solver --extra excel --extra maps --extra dev --extra docs \
  --extra provision --constraint "$everything"
rm "$everything"

for file in "$work"/*.txt; do
  # The "via" comments name the constraint file of this run: noise.
  {
    echo '# Made by "make lock" from pyproject.toml: do not edit.'
    sed '/#  *-c .*everything\.txt/d' "$file"
  } >"$file.new"
  mv "$file.new" "$file"
  if grep -n ':[/]/' "$file"; then
    echo "an address in $file: nothing was written" >&2
    exit 1
  fi
done
mv "$work"/*.txt locks/
