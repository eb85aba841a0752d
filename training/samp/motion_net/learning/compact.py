"""A compact file format for the training set. Positions are rounded to 0.02 mm; quaternions are lossless.

python -m samp_blender.training.samp.motion_net.learning.compact MOTION.npz MOTION.bin --mocap FOLDER ...
"""

from __future__ import annotations

import argparse
import io
import lzma
from pathlib import Path

import numpy as np

from .... import planes

STEP = 2e-5  # metres; resolution of the pelvis position
UNIT = 32767
CELLS = (8, 8, 8)


def write(raw: dict[str, np.ndarray], path: Path) -> None:
    """Write the arrays of a training set."""
    kept = {
        name: values for name, values in raw.items() if name not in ("root", "rotations", "piece_centres")
    }
    kept["piece_occupancy"] = np.round(raw["piece_occupancy"] * 255).astype(np.uint8)
    for name in ("actions", "contacts"):
        kept[name] = np.round(raw[name].astype(np.float32) * 250).astype(np.uint8)
    corners = raw["piece_centres"].reshape(-1, *CELLS, 3)
    kept["piece_corners"] = np.stack([corners[:, 0, 0, 0], corners[:, -1, -1, -1]], 1)
    quats = raw["rotations"]
    # Except for the pelvis, w is computed from x, y and z.
    signed = np.where(quats[..., :1] < 0, -quats, quats)[:, 1:, 1:]
    kept["pelvis"] = planes.encoded(quats[:, 0].view(np.uint16))
    kept["joints"] = planes.encoded(signed.reshape(len(quats), -1).view(np.uint16))
    kept["way"] = planes.encoded(
        np.round(raw["root"].astype(np.float64) / STEP).astype(np.int32).view(np.uint32)
    )
    held = io.BytesIO()
    np.savez(held, **kept)
    path.write_bytes(lzma.compress(held.getvalue(), preset=3))


def read(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays of a training set, named as in ``save`` of training/composition/sequence.py."""
    with np.load(io.BytesIO(lzma.decompress(path.read_bytes()))) as data:
        raw = {name: data[name] for name in data.files}
    count = int(raw["lengths"].sum())
    joints = planes.decoded(raw.pop("joints"), count, np.int16).reshape(count, -1, 3)
    pelvis = planes.decoded(raw.pop("pelvis"), count, np.int16)
    w = np.sqrt(np.maximum(UNIT**2 - joints.astype(np.float64).__pow__(2).sum(-1), 0))
    quats = np.concatenate([np.round(w)[..., None].astype(np.int16), joints], -1)
    raw["rotations"] = np.concatenate([pelvis[:, None], quats], 1)
    raw["root"] = (planes.decoded(raw.pop("way"), count, np.int32) * STEP).astype(np.float32)
    for name in ("actions", "contacts"):
        raw[name] = (raw[name] / 250).astype(np.float16)
    low, high = np.moveaxis(raw.pop("piece_corners"), 1, 0)
    share = np.indices(CELLS).reshape(3, -1).T / (np.array(CELLS) - 1)
    raw["piece_centres"] = (low[:, None] + share * (high - low)[:, None]).astype(np.float32)
    raw["piece_occupancy"] = (raw["piece_occupancy"] / 255).astype(np.float32)
    return raw


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("source", type=Path)
    parser.add_argument("target", type=Path)
    parser.add_argument("--mocap", type=Path, nargs="+", help="folders of clips for the start poses")
    options = parser.parse_args()
    raw = dict(np.load(options.source))
    if options.mocap:
        from ..export import start_poses  # reads clips, which are absent on the training machine

        raw["start_heights"], raw["start_rotations"] = start_poses(options.mocap)
    write(raw, options.target)
    print(f"{options.target}: {options.target.stat().st_size / 2**20:.1f} MiB")


if __name__ == "__main__":
    main()
