"""Pack a data set into one compact file for training on another machine.

python -m samp_blender.training.scene_gan.data.packing DATA/train DATA.bin --megabytes 55

Colours are reduced to 6 bits and depth to 12 bits of its inverse; motion is rounded to 0.4 mm and 0.03 degrees. Each
array is stored as differences from a prediction, split into byte planes, by LZMA. `unpack` restores the arrays.
"""

from __future__ import annotations

import argparse
import json
import lzma
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

MAGIC = b"SGAN"
QUATERNION_SHIFT = 4  # bits dropped of int16: about 0.03 degrees
ROOT_SHIFT = 1  # bits dropped of 0.2 mm
DEPTH_SCALE = 2000.0  # units per 1 / metre
COLOUR_SHIFT = 2
PICTURES_IN_A_PART = 256


def _planar(values: np.ndarray) -> np.ndarray:
    """Return pictures (P, H, W) minus the prediction left + up - upper left, modulo 2^16."""
    out = np.diff(values, axis=1, prepend=np.zeros_like(values[:, :1]))
    return np.diff(out, axis=2, prepend=np.zeros_like(values[:, :, :1]))


def _unplanar(values: np.ndarray) -> np.ndarray:
    return np.cumsum(np.cumsum(values, axis=2, dtype=values.dtype), axis=1, dtype=values.dtype)


def _temporal(values: np.ndarray) -> np.ndarray:
    """Return motion (W, T, C) as second differences over time, modulo 2^16."""
    for _ in range(2):
        values = np.diff(values, axis=1, prepend=np.zeros_like(values[:, :1]))
    return values


def _untemporal(values: np.ndarray) -> np.ndarray:
    for _ in range(2):
        values = np.cumsum(values, axis=1, dtype=values.dtype)
    return values


def _encode_colour(colour: np.ndarray) -> np.ndarray:
    """Return green and two differences to it (3 P, H, W), uint16 of 6 bits each."""
    red, green, blue = (np.moveaxis(colour >> COLOUR_SHIFT, -1, 0)).astype(np.uint16)
    return _planar(np.concatenate([green, red - green, blue - green]))


def _decode_colour(coded: np.ndarray) -> np.ndarray:
    green, red, blue = np.split(_unplanar(coded), 3)
    rgb = np.stack([red + green, green, blue + green], -1).astype(np.uint8)
    return (rgb << COLOUR_SHIFT) + (1 << COLOUR_SHIFT - 1)


def _encode_depth(depth: np.ndarray) -> np.ndarray:
    metres = np.maximum(depth, 300) / 1000
    return _planar(np.where(depth > 0, np.round(DEPTH_SCALE / metres), 0).astype(np.uint16))


def _decode_depth(coded: np.ndarray) -> np.ndarray:
    inverse = _unplanar(coded)
    return (
        np.where(inverse > 0, np.round(1000 * DEPTH_SCALE / np.maximum(inverse, 1)), 0)
        .clip(0, 65535)
        .astype(np.uint16)
    )


def _encode_rotations(quats: np.ndarray) -> np.ndarray:
    """Return second differences (W, T, 88) of quaternions with continuous signs."""
    values = quats.astype(np.int32)
    dot = (values[:, 1:] * values[:, :-1]).sum(-1, dtype=np.int64)
    values[:, 1:] *= np.cumprod(np.where(dot < 0, -1, 1), axis=1)[..., None]
    rounded = np.round(values / (1 << QUATERNION_SHIFT)).clip(-2047, 2047).astype(np.int16)
    return _temporal(rounded.reshape(*rounded.shape[:2], -1).view(np.uint16))


def _decode_rotations(coded: np.ndarray) -> np.ndarray:
    values = _untemporal(coded).view(np.int16)
    return (values << QUATERNION_SHIFT).reshape(*values.shape[:2], -1, 4)


def _encode_root(root: np.ndarray) -> np.ndarray:
    return _temporal((root >> ROOT_SHIFT).view(np.uint16))


def _decode_root(coded: np.ndarray) -> np.ndarray:
    return _untemporal(coded).view(np.int16) << ROOT_SHIFT


Code = tuple[Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray], np.ndarray]]
CODES: dict[str, Code] = {
    "colour": (_encode_colour, _decode_colour),
    "depth": (_encode_depth, _decode_depth),
    "rotations": (_encode_rotations, _decode_rotations),
    "root": (_encode_root, _decode_root),
}


def _compressed(values: np.ndarray) -> bytes:
    raw = np.ascontiguousarray(values)
    planes = raw.view(np.uint8).reshape(-1, raw.dtype.itemsize).T  # low bytes first
    return lzma.compress(planes.tobytes(), preset=4)


def _restored(data: bytes, dtype: str, shape: list[int]) -> np.ndarray:
    planes = np.frombuffer(lzma.decompress(data), np.uint8).reshape(np.dtype(dtype).itemsize, -1)
    return np.ascontiguousarray(planes.T).view(dtype).reshape(shape)


def pack(arrays: dict[str, np.ndarray], path: Path) -> None:
    """Write arrays, named as in make.py, as one file."""
    contents, blobs = [], []
    for name, values in arrays.items():
        for first in range(0, max(len(values), 1), PICTURES_IN_A_PART):
            part = np.asarray(values[first : first + PICTURES_IN_A_PART])
            coded = CODES[name][0](part) if name in CODES and len(part) else part
            blobs.append(_compressed(coded))
            contents.append([name, coded.dtype.str, list(coded.shape), len(blobs[-1])])
    head = json.dumps(contents).encode()
    path.write_bytes(MAGIC + len(head).to_bytes(8, "little") + head + b"".join(blobs))


def unpack(path: Path, threads: int = 4) -> dict[str, np.ndarray]:
    """Return the arrays of a file written by `pack`. Raise ValueError for other files."""
    data = path.read_bytes()
    if data[:4] != MAGIC:
        raise ValueError(f"{path} is not a packed data set")
    size = int.from_bytes(data[4:12], "little")
    contents, at = json.loads(data[12 : 12 + size]), 12 + size
    tasks = []
    for name, dtype, shape, length in contents:
        tasks.append((name, dtype, shape, data[at : at + length]))
        at += length

    def part(task: tuple[str, str, list[int], bytes]) -> np.ndarray:
        name, dtype, shape, blob = task
        coded = _restored(blob, dtype, shape)
        return CODES[name][1](coded) if name in CODES and len(coded) else coded

    parts: dict[str, list[np.ndarray]] = {}
    with ThreadPoolExecutor(threads) as pool:
        for task, values in zip(tasks, pool.map(part, tasks), strict=True):
            parts.setdefault(task[0], []).append(values)
    return {name: np.concatenate(values) for name, values in parts.items()}


def joined(parts: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the concatenated arrays of several files or rooms, with indices counted over all of them."""
    counts = lambda name: np.cumsum([0, *(len(part[name]) for part in parts)])[:-1]
    pictures, windows, bodies, rooms = (counts(name) for name in ("depth", "root", "rest", "heights"))
    out = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    moved = {
        "pairs": [part["pairs"] + [p, w] for part, p, w in zip(parts, pictures, windows, strict=True)],
        "body": [part["body"] + b for part, b in zip(parts, bodies, strict=True)],
        "room_of_picture": [part["room_of_picture"] + r for part, r in zip(parts, rooms, strict=True)],
    }
    return out | {name: np.concatenate(values).astype(np.int32) for name, values in moved.items()}


def thinned(arrays: dict[str, np.ndarray], share: float, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return a random share of the pictures, with their pairs and windows."""
    count = len(arrays["depth"])
    pictures = np.sort(rng.permutation(count)[: max(round(share * count), 1)])
    place = np.full(count, -1)
    place[pictures] = np.arange(len(pictures))
    pairs = arrays["pairs"][place[arrays["pairs"][:, 0]] >= 0]
    windows, inverse = np.unique(pairs[:, 1], return_inverse=True)
    rows = dict.fromkeys(("colour", "depth", "classes", "lens", "extrinsics", "room_of_picture"), pictures)
    rows |= dict.fromkeys(("root", "rotations", "labels", "body"), windows)
    made = {name: values[rows[name]] if name in rows else values for name, values in arrays.items()}
    made["pairs"] = np.column_stack([place[pairs[:, 0]], inverse]).astype(np.int32)
    return made


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("source", type=Path)
    parser.add_argument("target", type=Path)
    parser.add_argument(
        "--megabytes",
        type=float,
        default=55.0,
        help="largest size, MiB; fewer pictures are packed where needed",
    )
    options = parser.parse_args()
    whole = {path.stem: np.load(path, mmap_mode="r") for path in sorted(options.source.glob("*.npy"))}
    share, rng = 1.0, np.random.default_rng(0)
    for _ in range(4):
        pack(whole if share == 1 else thinned(whole, share, rng), options.target)
        size = options.target.stat().st_size / 2**20
        print(f"{options.target}: {size:.1f} MiB, {share:.2f} of the pictures", flush=True)
        if size <= options.megabytes:
            return
        share *= 0.97 * options.megabytes / size


if __name__ == "__main__":
    main()
