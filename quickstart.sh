#!/usr/bin/env bash
# ScanKnit on Debian 12: install what is needed, build, run.
#
#   ./quickstart.sh               build, then turn the sample recording into out/sample/model.glb
#   ./quickstart.sh test          build, then run every test whose tools are installed
#   ./quickstart.sh test --quick  build, then run each room's unit tests
#   ./quickstart.sh test --full   install all of those tools first (browser, Blender, QEMU ...), then the same
#   ./quickstart.sh tools         install those tools only
#   ./quickstart.sh build         build only, with Python's and OpenNI2's modules if their packages are installed
set -euo pipefail
cd "$(dirname "$0")"

job="${*:-sample}"
build_dir=build/release

required_packages=(
  ccache cmake g++ ninja-build pkg-config
  libboost-dev libeigen3-dev libhwy-dev libopencv-dev libopenvdb-dev libmeshoptimizer-dev libpcl-dev libtbb-dev libtinygltf-dev
  libgdcm-dev libinsighttoolkit5-dev libjpeg62-turbo-dev libpng-dev zlib1g-dev
  libfreenect-dev libusb-1.0-0-dev libbz2-dev liblz4-dev libzstd-dev
  libcli11-dev libfmt-dev libocct-data-exchange-dev libkainjow-mustache-dev libspdlog-dev libyaml-cpp-dev nlohmann-json3-dev
  esbuild libqrcodegencpp-dev
)
test_packages=(
  libgtest-dev libbenchmark-dev umockdev libumockdev-dev
  pybind11-dev python3-dev python3-numpy python3-pybind11
)
# Each lets one more test run: docs/testing.md. Some are looked for when the build is configured.
tool_packages=(
  admesh assimp-utils blender colmap python3-open3d
  chromium fish zsh mandoc man-db lintian mkdocs-material
  python3-rosbag python3-sensor-msgs python3-tf2-msgs python3-scapy
  clang clang-format libclang-rt-14-dev libopenvdb-tools invesalius-examples mricron-data
  munge slurm-client slurmctld slurmd
  libfreenect-bin libopenni2-dev libuvc-dev qemu-system-x86 busybox-static cpio kmod v4l-utils
)

is_installed() { dpkg-query -W -f='${Status}' "$1" 2>/dev/null | grep -q '^install ok installed$'; }

# Installs the missing ones of the named Debian packages.
install_packages() {
  local missing=()
  for package in "$@"; do is_installed "$package" || missing+=("$package"); done
  if [ ${#missing[@]} -eq 0 ]; then return; fi
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then as_root=(sudo); fi
  echo "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  "${as_root[@]}" apt-get update -qq
  DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# The modules for Python and OpenNI2, if their packages are installed. The sample needs neither.
with_optional_parts=(-DSCANKNIT_BUILD_PYTHON=AUTO -DSCANKNIT_WITH_OPENNI2=AUTO)

# Debian's only where there is no other.
install_npm() { command -v npm >/dev/null || install_packages nodejs npm; }

install_tools() {
  install_packages "${tool_packages[@]}"
  install_npm
}

# three.js and its renderer of tiles for the live view's page, as view/page/package-lock.json names them.
install_page_packages() {
  local packages=view/page/node_modules
  if [ -f $packages/three/package.json ] && [ -f $packages/3d-tiles-renderer/package.json ]; then return; fi
  install_npm
  echo "Installing three.js for the live view ..."
  npm ci --prefix view/page --ignore-scripts --no-audit --no-fund --silent
}

build() {
  echo "Building in $build_dir (a quarter of an hour the first time on two cores, with tests up to forty minutes) ..."
  mkdir -p "$build_dir"
  local log="$build_dir/build.log"
  # A unity build: docs/testing.md.
  if ! { cmake -S . -B "$build_dir" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON "$@" &&
         cmake --build "$build_dir" -j "$(nproc)"; } >"$log" 2>&1; then
    tail -n 60 "$log" >&2
    echo "The build failed; the whole log is $log" >&2
    exit 1
  fi
}

build_tests() {
  install_packages "${required_packages[@]}" "${test_packages[@]}"
  install_page_packages
  build -DSCANKNIT_BUILD_TESTS=ON -DSCANKNIT_BUILD_BENCHMARKS=ON "${with_optional_parts[@]}"
  tests/prepare.sh "$build_dir"
}

run_tests() {
  build_tests
  ctest --test-dir "$build_dir" --output-on-failure -j "$(nproc)" "$@"
}

case "$job" in
  sample)
    install_packages "${required_packages[@]}"
    install_page_packages
    build -DSCANKNIT_BUILD_TESTS=OFF -DSCANKNIT_BUILD_PYTHON=OFF -DSCANKNIT_WITH_OPENNI2=OFF
    if [ ! -f out/sample_recording/trajectory.log ]; then
      echo "Rendering the sample recording with the synthetic scanner ..."
      "$build_dir/bin/scanknit" synth turntable --frames 120 --noise --seed 1 -o out/sample_recording --quiet
    fi
    "$build_dir/bin/scanknit" run out/sample_recording --preset object -o out/sample
    ;;
  test) run_tests ;;
  "test --quick") run_tests -L '^(core|layering|acquire|synth|align|fusion|extract|extract_volume|finish|export|scan|view|app_units|python)$' ;;
  "test --full")
    install_tools
    run_tests
    ;;
  tools) install_tools ;;
  build)
    install_packages "${required_packages[@]}"
    install_page_packages
    build -DSCANKNIT_BUILD_TESTS=OFF "${with_optional_parts[@]}"
    ;;
  *)
    sed -n '2,9s/^# \{0,1\}//p' "$0" >&2
    exit 2
    ;;
esac
