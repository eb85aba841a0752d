"""Import motion capture files as training clips.

python -m samp_blender.training.clips.importer --input FOLDER --output CLIPS --set NAME [--beside OTHER ...]

Reads .bvh, .fbx, .amc with .asf, .c3d and the .npz of training/clips/formats/source.py, writes an .npz for each clip,
catalogue.csv and checks.md, and prints the checks.
"""

from __future__ import annotations

import argparse
import csv
import re
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...samp_addon.errors import SampError
from ...samp_addon.motion import Motion
from . import catalogue, feet, formats, labels, markers, quality
from .catalogue import ImportedClip
from .mapping import mapped
from .recording import Recording
from .retarget import retargeted
from .straightness import corrections

SUBJECT = r"^(?:[a-z]+_)?(\d+)_|^([^_]+)"
"""Pattern of the subject in a clip's name: its first number, else its first part."""

FEWEST = 12  # frames of the shortest clip


def files_of(inputs: Sequence[Path]) -> list[Path]:
    """Return the motion files in these paths, folders searched recursively. Raise SampError where there are none."""
    known = {*formats.READERS, ".c3d"}
    found: list[Path] = []
    for path in inputs:
        if not path.exists():
            raise SampError(f"'{path}' does not exist.")
        every = sorted(path.rglob("*")) if path.is_dir() else [path]
        found += [one for one in every if one.suffix.lower() in known]
    if not found:
        raise SampError("No .bvh, .fbx, .amc, .c3d or .npz file was found.")
    return found


def subject_of(name: str, pattern: str = SUBJECT) -> str:
    """Return the subject in a clip's name: the first matching group of the pattern, or the whole match."""
    match = re.search(pattern, name)
    if match is None:
        return ""
    return next((group for group in match.groups() if group), match.group(0))


def recordings_of(
    paths: Sequence[Path], pattern: str, problems: list[str]
) -> Iterator[tuple[str, list[Recording]]]:
    """Yield each subject with its recordings on one skeleton; append unreadable files to problems."""
    marked: dict[str, list[Path]] = defaultdict(list)
    solved: dict[str, list[Path]] = defaultdict(list)
    for path in paths:
        (marked if path.suffix.lower() == ".c3d" else solved)[subject_of(path.stem, pattern)].append(path)
    for subject, files in solved.items():
        groups: list[list[Recording]] = []
        for path in files:
            try:
                one = formats.read(path)
            except SampError as error:
                problems.append(str(error))
                continue
            group = next((group for group in groups if group[0].shares_skeleton(one)), None)
            if group is None:
                groups.append([one])
            else:
                group.append(one)
        for group in groups:
            yield subject, group
    for subject, files in marked.items():
        try:
            yield subject, markers.solved(files)
        except SampError as error:
            problems.append(str(error))


def imported(
    recordings: Sequence[Recording],
    subject: str = "",
    descriptions: Mapping[str, str] | None = None,
    prefix: str = "",
) -> Iterator[ImportedClip]:
    """Yield the clips of one subject's recordings on one skeleton.

    Raise SampError where its joints cannot be identified.
    """
    recordings, mapping = mapped(recordings)
    leg, arm = corrections(recordings, mapping)
    for one in recordings:
        text = (descriptions or {}).get(one.name, one.name)
        clip = finished(retargeted(one, mapping, leg, arm), one.at_rate(30.0).labels, text)
        if len(clip) >= FEWEST:
            name = prefix + one.name.removesuffix(".max")
            yield replace(clip, name=name, subject=subject, description=labels.words(text))


def finished(motion: Motion, known: np.ndarray | None, text: str) -> ImportedClip:
    """Return a retargeted motion on its floor, feet locked, labelled, pops flagged. known: labels (T,) of the file."""
    lies = (
        labels.lying(feet.grounded(motion))
        if known is None
        else np.isin(known, ("lie_down", "lie", "get_up"))
    )
    motion = feet.grounded(motion, lies)
    glitch = labels.pops(motion)
    contact = feet.touching(motion)
    motion = feet.locked(motion, contact)
    contact = feet.settled(motion, contact)
    named = known if known is not None else labels.labelled(motion, contact, text)
    part = labels.sound_part(glitch)
    return ImportedClip("", motion.pose_slice(part), named[part], contact[part], glitch[part])


def descriptions_of(path: Path | None) -> dict[str, str]:
    """Read clip -> description from a .csv with the columns clip and description."""
    if path is None:
        return {}
    with path.open(newline="", encoding="utf-8") as file:
        return {line["clip"]: line["description"] for line in csv.DictReader(file)}


def run(options: argparse.Namespace) -> dict[str, float | None]:
    """Import the files, write clips and catalogue, print problems; return the set's measures."""
    options.output.mkdir(parents=True, exist_ok=True)
    paths = files_of(options.input)
    descriptions = descriptions_of(options.descriptions)
    problems: list[str] = []
    rows, measured = [], quality.Quality()
    for subject, group in recordings_of(paths, options.subject, problems):
        try:
            for clip in imported(group, subject, descriptions, options.prefix):
                catalogue.save(clip, options.output)
                rows.append(catalogue.row(clip, options.set, options.licence))
                measured.add(clip.motion, clip.labels, clip.glitch)
        except SampError as error:
            problems.append(str(error))
    catalogue.write_catalogue(
        sorted(rows, key=lambda one: str(one["clip"])), options.output / "catalogue.csv"
    )
    for problem in problems:
        print(problem, file=sys.stderr)
    if not rows:
        raise SampError(f"No clip could be imported from {len(paths)} files.")
    return measured.numbers()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status: 1 where nothing could be imported, 2 for unusable arguments."""
    parser = argparse.ArgumentParser(prog="importer", description=__doc__.splitlines()[0])
    parser.add_argument("--input", type=Path, nargs="+", required=True, metavar="PATH")
    parser.add_argument("--output", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--set", default="import", help="name of the set, for the catalogue")
    parser.add_argument("--licence", default="", help="licence of the set, for the catalogue")
    parser.add_argument("--prefix", default="", help="prefix of the clips' names")
    parser.add_argument(
        "--subject",
        default=SUBJECT,
        help="regular expression whose first group is the subject in a file's name",
    )
    parser.add_argument(
        "--descriptions", type=Path, metavar="CSV", help="file with the columns clip and description"
    )
    parser.add_argument(
        "--beside",
        type=Path,
        nargs="*",
        default=[],
        metavar="FOLDER",
        help="folders of clips to compare with",
    )
    options = parser.parse_args(arguments)
    began = time.time()
    try:
        numbers = run(options)
    except SampError as error:
        print(error, file=sys.stderr)
        return 1
    sets = [(options.set, numbers), *((folder.name, quality.of_folder(folder)) for folder in options.beside)]
    text = quality.table(sets)
    (options.output / "checks.md").write_text(text + "\n", encoding="utf-8")
    print(text)
    for fault in quality.faults(numbers):
        print(f"Check: {fault}")
    print(f"{numbers['clips']} clips, {numbers['minutes']:.1f} minutes in {time.time() - began:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
