#!/usr/bin/env bash
# Builds the documentation's site and checks it: check_site.sh SOURCE_DIR SITE_DIR PYTHON. Exit code 77: skipped.
set -euo pipefail
source_dir="$1" site_dir="$2" python="$3"
export PYTHONDONTWRITEBYTECODE=1

command -v mkdocs >/dev/null || { echo "SKIPPED: mkdocs is not installed (Debian package mkdocs-material)"; exit 77; }
[ -d /usr/share/mkdocs/themes/material ] || { echo "SKIPPED: mkdocs-material is not installed"; exit 77; }
mkdocs build --quiet --strict --config-file "$source_dir/mkdocs.yml" --site-dir "$site_dir"
"$python" -B "$source_dir/tests/docs/check_site.py" "$site_dir"
