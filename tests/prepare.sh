#!/usr/bin/env bash
# Installs what the optional tests need into the build folder: tests/prepare.sh BUILD_DIR.
# What cannot be installed is left out; its tests then say SKIPPED.
set -euo pipefail
cd "$(dirname "$0")/.."
npm_dir="$1/npm"

if ! command -v npm >/dev/null; then
  echo "npm is not installed: the GLB validation, ROS 2 and browser tests will be skipped."
  exit 0
fi
mkdir -p "$npm_dir"
cp tests/package.json tests/package-lock.json "$npm_dir/"
npm ci --prefix "$npm_dir" --no-audit --no-fund --silent || echo "npm could not install gltf-validator and @mcap/core: their tests will be skipped."
npm ci --prefix tests/browser --ignore-scripts --no-audit --no-fund --silent || echo "npm could not install playwright-core: the browser tests will be skipped."
