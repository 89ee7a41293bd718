#!/usr/bin/env bash
# The Debian packages: package.sh TEST PACKAGES_DIR SOURCE_DIR BUILD_DIR. Exit code 77: skipped.
set -euo pipefail
test_name="$1" packages="$2" source_dir="$3" build_dir="$4"

skip() { echo "SKIPPED: $1"; exit 77; }
fail() { echo "FAILED: $1"; exit 1; }

is_installed() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null || true)" = installed ]; }
is_known() { [[ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null || true)" != @(|not-installed) ]]; }

package() { echo "$packages"/"$1"_*.deb; }

expect_files() {
  local name="$1" listing
  shift
  listing="$(dpkg-deb --fsys-tarfile "$(package "$name")" | tar -t)"
  for pattern in "$@"; do
    grep -qE "^\./$pattern$" <<<"$listing" || fail "$name lacks $pattern"
  done
  if grep -qE "^\./(usr/local|home|tmp|work|root)" <<<"$listing"; then fail "$name reaches outside of /usr"; fi
}

expect_field() {
  local name="$1" field="$2" pattern="$3" value
  value="$(dpkg-deb -f "$(package "$name")" "$field")"
  grep -qE "$pattern" <<<"$value" || fail "$name: $field is '$value', expected $pattern"
}

IsBuilt() {
  rm -rf "$packages"
  cpack --config "$build_dir/CPackConfig.cmake" -B "$packages"
  rm -rf "$packages/_CPack_Packages"
}

HoldsWhatItShould() {
  expect_files scanknit usr/bin/scanknit 'usr/lib/(.*/)?libscanknit_core\.so\.[0-9.]+' 'usr/lib/(.*/)?scanknit/libscanknit_commands\.so' usr/lib/udev/rules.d/60-scanknit.rules \
    usr/share/man/man1/scanknit.1.gz usr/share/man/man1/scanknit-run.1.gz usr/share/bash-completion/completions/scanknit \
    usr/share/zsh/vendor-completions/_scanknit usr/share/fish/vendor_completions.d/scanknit.fish \
    usr/share/scanknit/configs/turntable.yaml usr/share/scanknit/samples/turntable.mcap usr/share/doc/scanknit/copyright usr/share/doc/scanknit/changelog.gz \
    usr/share/doc/scanknit/scanknit.spdx.json
  expect_files libscanknit-dev usr/include/scanknit/scan/scan.h usr/include/scanknit/fusion/volume/tsdf_volume.h 'usr/lib/(.*/)?libscanknit_core\.so' \
    'usr/lib/(.*/)?cmake/ScanKnit/ScanKnitConfig.cmake' 'usr/lib/(.*/)?pkgconfig/scanknit.pc' \
    usr/share/doc/libscanknit-dev/examples/cpp/mesh_a_wall.cpp usr/share/doc/libscanknit-dev/copyright
  local module
  for module in acquire_pcl align_pcl calibrate_opencv features_opencv finish_pcl glb_reader recording_commands stereo_opencv synth_commands volume_files; do
    expect_files scanknit "usr/lib/(.*/)?scanknit/libscanknit_$module\\.so"
  done
  expect_field scanknit Depends 'libpcl-io'
  expect_field scanknit Depends 'libgdcm'
  expect_field scanknit Depends 'libopenvdb'
  expect_field scanknit Depends 'libtbb12'
  expect_field scanknit Depends 'libc6'
  expect_field scanknit Section '^graphics$'
  local name synopsis
  for name in scanknit libscanknit-dev; do
    synopsis="$(dpkg-deb -f "$(package "$name")" Description)"
    [[ "$synopsis" == "coloured meshes from depth cameras"* ]] || fail "$name: the synopsis is '$synopsis'"
  done
  expect_field libscanknit-dev Depends 'scanknit \(= [0-9.]+\)'
  expect_field libscanknit-dev Section '^libdevel$'
  if [ -e "$(package scanknit-openni2)" ]; then
    expect_files scanknit-openni2 'usr/lib/(.*/)?scanknit/libscanknit_openni2\.so'
  fi
  if [ -e "$(package scanknit-step)" ]; then
    expect_files scanknit-step 'usr/lib/(.*/)?scanknit/libscanknit_step_reader\.so'
  fi
  # A program that needs no driver of OpenNI2 and no CAD library does not ask for them.
  local bytes depends
  depends="$(dpkg-deb -f "$(package scanknit)" Depends)"
  [[ "$depends" != *openni* ]] || fail "scanknit depends on OpenNI2"
  [[ "$depends" != *occt* ]] || fail "scanknit depends on Open CASCADE"
  bytes="$(stat -c %s "$(package scanknit)")"
  [ "$bytes" -lt 8000000 ] || fail "scanknit has $bytes bytes"
  echo "scanknit: $bytes bytes; $depends"
}

SatisfiesLintian() {
  command -v lintian >/dev/null || skip "lintian is not installed"
  lintian --fail-on error --allow-root "$packages"/*.deb
}

# The files of the system, without what dpkg and ldconfig keep for themselves.
list_system() {
  find /usr /etc /var /opt \( -path /var/lib/dpkg -o -path /var/log -o -path /var/cache \) -prune -o -print | LC_ALL=C sort
}

# In the clean root. The build folder and the sources are hidden there.
live_inside() {
  local debs="$1"
  list_system >/tmp/before
  dpkg -i "$debs"/*.deb >/tmp/dpkg.log 2>&1 || { cat /tmp/dpkg.log; fail "dpkg -i"; }
  cd "$(mktemp -d)"

  if ldd /usr/bin/scanknit | grep scanknit | grep -v '=> /\(usr/\)\?lib/'; then fail "a library from elsewhere"; fi
  scanknit run /usr/share/scanknit/samples/turntable.mcap --preset object -o out >summary
  cat summary
  grep -qE '^Frames +36 of 36 fused$' summary || fail "the sample was not fused whole"
  scanknit info out/model.glb
  [ -s out/report.json ] || fail "no report"
  scanknit synth sphere --frames 8 --width 160 --height 120 -o recording --quiet
  scanknit run recording --set fusion.voxel_size=8mm -o other --quiet
  if ldd /usr/lib/*/scanknit/*.so | grep 'not found'; then fail "a module lacks a library"; fi
  local module_settings=(fusion.voxel_size=8mm acquire.outlier_neighbours=8 finish.ground=remove)
  scanknit run recording "${module_settings[@]/#/--set=}" -o by_modules --quiet 2>said || { cat said; fail "a module is not found"; }
  if grep 'cannot be used' said; then fail "a module is not found"; fi
  printf '%s\n' NRRD0004 'type: uint8' 'dimension: 3' 'sizes: 2 2 2' 'spacings: 1 1 1' 'encoding: ascii' '' '0 1 2 3 4 5 6 7' >cube.nrrd
  scanknit info cube.nrrd
  local preset
  preset="$(find /usr/share/scanknit/configs -name object.yaml)"
  scanknit config check "$preset" >/dev/null
  if is_installed scanknit-openni2; then
    if scanknit record --device openni2: -o a.mcap >said 2>&1; then fail "there is a camera in a clean root"; fi
    if ! grep -q 'OpenNI2 sees no camera' said; then cat said; fail "the module for OpenNI2 is not found"; fi
  fi

  cp -r /usr/share/doc/libscanknit-dev/examples/cpp example
  cmake -S example -B built >/dev/null && cmake --build built >/dev/null
  built/mesh_a_wall wall.glb
  # shellcheck disable=SC2046  # the flags are words
  c++ -std=c++20 example/mesh_a_wall.cpp -o by_pkg_config $(pkg-config --cflags --libs scanknit)
  ./by_pkg_config same.glb
  cmp wall.glb same.glb || fail "two builds of the example differ"
  if is_installed python3-scanknit; then
    python3 -c 'import scanknit; print("python3", scanknit.__version__)'
    python3 -c 'import sys, scanknit; scanknit.scan("recording", "by_python", settings=sys.argv[1:])' "${module_settings[@]}"
  fi

  local names
  mapfile -t names < <(for deb in "$debs"/*.deb; do dpkg-deb -f "$deb" Package; done)
  dpkg --purge "${names[@]}" >/tmp/dpkg.log 2>&1 || { cat /tmp/dpkg.log; fail "dpkg --purge"; }
  if grep -iE 'not empty|warning' /tmp/dpkg.log; then fail "dpkg --purge had to leave something"; fi
  for name in "${names[@]}"; do
    if is_known "$name"; then fail "dpkg still knows $name"; fi
  done
  if [ -e /usr/bin/scanknit ]; then fail "scanknit is still there"; fi
  list_system >/tmp/after
  diff /tmp/before /tmp/after || fail "the files before and after differ"
}

# The root of this machine under an overlay in memory, so that nothing that is done there stays.
LivesAndLeavesNothing() {
  [ "$(id -u)" -eq 0 ] || skip "a clean root needs root"
  if is_installed scanknit; then skip "scanknit is installed here"; fi
  command -v unshare >/dev/null || skip "unshare is not installed"
  top="$(mktemp -d)"
  trap 'rmdir "$top"' EXIT
  local status=0
  unshare --mount --propagation private "$0" enter "$packages" "$source_dir" "$build_dir" "$top" || status=$?
  return "$status"
}

enter() {
  local top="$1"
  mount -t tmpfs none "$top" || skip "no file system can be mounted here"
  mkdir "$top/upper" "$top/work" "$top/root"
  mount -t overlay overlay -o "lowerdir=/,upperdir=$top/upper,workdir=$top/work" "$top/root" || skip "no overlay can be mounted here"
  local root="$top/root"
  mount --bind /proc "$root/proc"
  mount --bind /dev "$root/dev"
  mount -t tmpfs none "$root/tmp"
  mkdir "$root/tmp/packages"
  cp "$packages"/*.deb "$root/tmp/packages/"
  cp "$0" "$root/tmp/package.sh"
  for folder in "$source_dir" "$build_dir"; do
    if [ -d "$root$folder" ]; then mount -t tmpfs none "$root$folder"; fi
  done
  exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp TMPDIR=/tmp LC_ALL=C.UTF-8 \
    chroot "$root" /tmp/package.sh inside - - -
}

case "$test_name" in
  IsBuilt | HoldsWhatItShould | SatisfiesLintian | LivesAndLeavesNothing) "$test_name" ;;
  enter) enter "$5" ;;
  inside) live_inside /tmp/packages ;;
  *) fail "no test $test_name" ;;
esac
