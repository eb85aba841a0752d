#!/usr/bin/env bash
# debian.sh SUITE ROOT: install a Debian system with Blender and the packages for test-ui in the folder ROOT (trixie
# has Blender 4.3, sid 5.2). Requires root, debootstrap and 3 GB. Before deleting ROOT, unmount ROOT/proc, ROOT/sys
# and ROOT/dev.
set -euo pipefail
suite=$1 root=$(realpath -m "$2")
mirror=$(awk '/^URIs:/ { print $2; exit }' /etc/apt/sources.list.d/*.sources 2>/dev/null || true)
mkdir -p "$root"
[ -e "$root/etc/debian_version" ] || debootstrap --variant=minbase --include=ca-certificates "$suite" "$root" $mirror
cp /etc/resolv.conf "$root/etc/"
mkdir -p "$root/usr/local/share/ca-certificates"
cp /usr/local/share/ca-certificates/*.crt "$root/usr/local/share/ca-certificates/" 2>/dev/null || true
chroot "$root" update-ca-certificates >/dev/null 2>&1
mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
for part in dev sys; do mountpoint -q "$root/$part" || mount --bind "/$part" "$root/$part"; done
export DEBIAN_FRONTEND=noninteractive
# A mirror or a snapshot may be older than its Release file allows.
echo 'Acquire::Check-Valid-Until "false";' >"$root/etc/apt/apt.conf.d/90old-release"
chroot "$root" apt-get update -q
chroot "$root" apt-get install -y -q --no-install-recommends blender xvfb xdotool imagemagick libegl1 libgl1 \
    libgl1-mesa-dri libglx-mesa0 fonts-dejavu-core python3-pip python3-numpy python3-requests python3-zstandard \
    python3-torch python3-scipy python3-safetensors
# Extensions in Blender 5.2 need packages that Debian's blender does not depend on.
chroot "$root" python3 -c 'import cattrs' 2>/dev/null ||
    chroot "$root" python3 -m pip install -q --break-system-packages cattrs fastjsonschema || true
