#!/usr/bin/env bash
# Runs a command in a virtual machine with Debian's own kernel, whose root is this computer's, read-only:
#
#   run.sh FOLDER COMMAND [ARGUMENTS]
#
# SCANKNIT_VM_MACHINES of them (one unless said) run the command side by side, each its share of a GoogleTest program's tests.
# FOLDER keeps the kernel (fetched the first time, about 70 MB) and of the last run each machine's output and its kernel's
# messages. Ends with the command's exit code, with 77 and the reason where there can be no such machine, and with 1 where it
# did not come to an end. A machine that gives no sign of life for two minutes is begun again, once: its kernel or QEMU has frozen.
# A command that hangs does not stop the signs of life: it is not run again, and the kernel's messages say what waits where.
set -euo pipefail
export PATH="$PATH:/usr/sbin:/sbin"
here="$(cd "$(dirname "$0")" && pwd)"
folder="$1" start="$PWD"
shift
seconds="${SCANKNIT_VM_SECONDS:-580}"
machines="${SCANKNIT_VM_MACHINES:-1}"

skip() {
  echo "SKIPPED: no virtual machine: $*"
  exit 77
}

# fetch PACKAGE: unpacks a Debian package into FOLDER/PACKAGE without installing it.
fetch() {
  if [ -d "$1" ]; then return; fi
  apt-get download "$1" >fetch.log 2>&1 || skip "apt-get download $1: $(tail -n 1 fetch.log)"
  dpkg-deb -x "$1"_*.deb "$1.part"
  rm "$1"_*.deb
  mv "$1.part" "$1"
}

for tool in qemu-system-x86_64:qemu-system-x86 busybox:busybox-static cpio:cpio depmod:kmod dpkg-deb:dpkg apt-get:apt; do
  command -v "${tool%%:*}" >/dev/null || skip "${tool%%:*} is not there (Debian package ${tool##*:})"
done

mkdir -p "$folder"
cd "$folder"
# The kernel that Debian's linux-image-amd64 stands for: the one for clouds has no USB.
image="$( (apt-cache depends linux-image-amd64 2>/dev/null || true) | sed -n 's/^ *Depends: \(linux-image-[^ ]*\)$/\1/p')"
if [ -z "$image" ]; then skip "apt knows no linux-image-amd64 (apt-get update?)"; fi
fetch "$image"
fetch udev
version="${image#linux-image-}"

# What the machine starts with: busybox, the modules on the way to our root and to USB, and the command.
modules=(virtio_pci 9pnet_virtio 9p vhci_hcd uvcvideo)
rm -rf initramfs
mkdir -p initramfs/{bin,modules,host}
cp "$(command -v busybox)" initramfs/bin/
cp "$here/init" initramfs/
[ -f "$image/lib/modules/$version/modules.dep" ] || depmod -b "$image" "$version"
modprobe --dirname "$image" --set-version "$version" --show-depends --all "${modules[@]}" |
  awk '$1 == "insmod" && !seen[$2]++ { print $2 }' >modules.txt
number=100
while read -r module; do cp "$module" "initramfs/modules/$((number++)).ko"; done <modules.txt
printf 'cd %q && ' "$start" >initramfs/command
printf '%q ' "$@" >>initramfs/command
printf '%s\n' "$PWD/udev" >initramfs/udev_folder
(cd initramfs && find . | cpio --quiet -o -H newc | gzip -1) >initramfs.gz

# The kernel as it is unpacked: an emulated processor takes four seconds to unpack it.
kernel="$image/boot/vmlinuz-$version"
if [ ! -f vmlinux ]; then
  at="$(LC_ALL=C grep -obUaP '\xFD7zXZ\x00' "$kernel" | head -n 1 | cut -d: -f1 || true)"
  if [ -n "$at" ]; then tail -c +$((at + 1)) "$kernel" | xz -dc --single-stream >vmlinux.part 2>/dev/null || true; fi
  if file_type="$(head -c 4 vmlinux.part 2>/dev/null | tr -d '\177')" && [ "$file_type" = ELF ]; then mv vmlinux.part vmlinux; fi
fi
if [ -f vmlinux ]; then kernel=vmlinux; fi

# begin_machine NUMBER. In software: hardware help is rarely there where tests run, and with it the machine would not be the same
# everywhere. Its clock counts instructions, a nanosecond each, and skips the time when nothing is to be done: nobody waits, and
# to the machine it is always fast, however busy this computer is. A processor without AVX: emulating that takes a sixth more
# time. What the kernel does not know of its command line becomes the environment.
begin_machine() {
  exec timeout "$seconds" qemu-system-x86_64 -accel tcg -icount shift=0,sleep=off -cpu Nehalem -m 768 -nodefaults -no-reboot \
    -display none -kernel "$kernel" -initrd initramfs.gz \
    -append "console=ttyS0 quiet panic=-1 GTEST_TOTAL_SHARDS=$machines GTEST_SHARD_INDEX=$1" \
    -virtfs local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap \
    -serial "file:kernel.$1.log" -serial "file:raw.$1.log" -debugcon "file:alive.$1.log" </dev/null
}

# has_ended PID NUMBER: waits for the machine; false where it gave no sign of life for two minutes, and was stopped.
has_ended() {
  local signs=-1 silent_since=$SECONDS now
  while kill -0 "$1" 2>/dev/null; do
    sleep 2
    now="$(stat -c %s "alive.$2.log" 2>/dev/null || echo 0)"
    if [ "$now" != "$signs" ]; then signs="$now" silent_since=$SECONDS; fi
    if [ "$signs" = 0 ] || [ $((SECONDS - silent_since)) -lt 120 ]; then continue; fi
    kill "$1"
    wait "$1" || true
    return 1
  done
  wait "$1" || true
}

run_machine() {
  local machine
  begin_machine "$1" &
  machine=$!
  if ! has_ended "$machine" "$1"; then
    cp "kernel.$1.log" "kernel.$1.frozen.log"
    echo "Machine $1 froze after these words, and is begun again:" >"frozen.$1.log"
    tail -n 3 "raw.$1.log" >>"frozen.$1.log"
    begin_machine "$1" &
    has_ended $! "$1" || true
  fi
  { if [ -f "frozen.$1.log" ]; then cat "frozen.$1.log"; fi; sed 's/\r$//' "raw.$1.log"; } >"output.$1.log"
}
rm -f output.*.log kernel.*.log raw.*.log alive.*.log frozen.*.log
for ((number = 0; number < machines; number++)); do run_machine "$number" & done
wait

exit_code=0
for ((number = 0; number < machines; number++)); do
  cat "output.$number.log"
  ended="$(sed -n 's/^The command ended with \([0-9]*\)$/\1/p' "output.$number.log")"
  if [ -z "$ended" ]; then
    echo "The machine did not come to an end within $seconds s. Its kernel's last words ($PWD/kernel.$number.log):"
    tail -n 20 "kernel.$number.log"
  fi
  if [ "$exit_code" = 0 ]; then exit_code="${ended:-1}"; fi
done
exit "$exit_code"
