#!/usr/bin/env bash
# run.sh ZIP SHOTS: run the session of story.py with the Blender named by BLENDER, or with that of the system in ROOT.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
zip=$(realpath "$1") shots=$2
mkdir -p "$shots"
rm -f "$shots"/*.png
if [ -z "${ROOT:-}" ]; then
    if ! command -v "${BLENDER:-blender}" >/dev/null; then
        echo "test-ui: skipped because '${BLENDER:-blender}' was not found; set BLENDER to its path, or ROOT to a system that has it"
        exit 0
    fi
    exec python3 "$here/driver.py" --blender "${BLENDER:-blender}" --zip "$zip" --shots "$shots"
fi
inside=$ROOT/opt/samp-ui
rm -rf "$inside"
mkdir -p "$inside/tests" "$inside/demo" "$inside/shots"
cp -r "$here" "$inside/tests/"
cp "$here/../../demo/build_room.py" "$inside/demo/"
cp "$zip" "$inside/samp.zip"
status=0
chroot "$ROOT" python3 /opt/samp-ui/tests/ui/driver.py --blender blender --zip /opt/samp-ui/samp.zip \
    --shots /opt/samp-ui/shots || status=$?
cp "$inside"/shots/* "$shots"/
exit $status
