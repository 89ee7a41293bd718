#!/usr/bin/env bash
# ScanKnit on Debian 12: install what is needed, build, run.
#
#   ./quickstart.sh         build, then turn the sample recording into out/sample/model.glb
#   ./quickstart.sh test    build, then run every test whose tools are installed
#   ./quickstart.sh build   build only
set -euo pipefail
cd "$(dirname "$0")"

job="${1:-sample}"
build_dir=build/release

required_packages=(
  ccache cmake g++ ninja-build pkg-config
  libboost-dev libeigen3-dev libhwy-dev libopencv-dev libopenvdb-dev libmeshoptimizer-dev libpcl-dev libtbb-dev libtinygltf-dev
  libgdcm-dev libinsighttoolkit5-dev zlib1g-dev
  libfreenect-dev libusb-1.0-0-dev libbz2-dev liblz4-dev libzstd-dev
  libcli11-dev libfmt-dev libspdlog-dev libyaml-cpp-dev nlohmann-json3-dev
  esbuild libqrcodegencpp-dev
)
test_packages=(libgtest-dev libbenchmark-dev umockdev libumockdev-dev)

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

# three.js for the live view's page, as view/page/package-lock.json names it.
install_page_packages() {
  if [ -f view/page/node_modules/three/package.json ]; then return; fi
  command -v npm >/dev/null || install_packages nodejs npm
  echo "Installing three.js for the live view ..."
  npm ci --prefix view/page --ignore-scripts --no-audit --no-fund --silent
}

build() {
  echo "Building in $build_dir (about ten minutes the first time on two cores) ..."
  mkdir -p "$build_dir"
  local log="$build_dir/build.log"
  if ! { cmake -S . -B "$build_dir" -G Ninja -DCMAKE_BUILD_TYPE=Release "$@" && cmake --build "$build_dir"; } >"$log" 2>&1; then
    tail -n 60 "$log" >&2
    echo "The build failed; the whole log is $log" >&2
    exit 1
  fi
}

case "$job" in
  sample)
    install_packages "${required_packages[@]}"
    install_page_packages
    build -DSCANKNIT_BUILD_TESTS=OFF
    if [ ! -f out/sample_recording/trajectory.log ]; then
      echo "Rendering the sample recording with the synthetic scanner ..."
      "$build_dir/bin/scanknit" synth turntable --frames 120 --noise --seed 1 -o out/sample_recording --quiet
    fi
    "$build_dir/bin/scanknit" run out/sample_recording --preset object -o out/sample
    ;;
  test)
    install_packages "${required_packages[@]}" "${test_packages[@]}"
    install_page_packages
    build -DSCANKNIT_BUILD_TESTS=ON -DSCANKNIT_BUILD_BENCHMARKS=ON
    tests/prepare.sh "$build_dir"
    ctest --test-dir "$build_dir" --output-on-failure -j "$(nproc)"
    ;;
  build)
    install_packages "${required_packages[@]}"
    install_page_packages
    build -DSCANKNIT_BUILD_TESTS=OFF
    ;;
  *)
    sed -n '2,6s/^# \{0,1\}//p' "$0" >&2
    exit 2
    ;;
esac
