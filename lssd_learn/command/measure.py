"""`lssd measure scan.ply …`: body measures of scans, without a configuration or a folder of a run."""

import argparse
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from lssd_learn.errors import InputError

READER = "LSSD_READER"  # the environment's answer to --reader
UNITS = ("auto", "m", "cm", "mm")


def main(arguments: Sequence[str]) -> int:
    """Print a table of what is read of each scan; one line on standard error for each that is not.

    Args:
        arguments: of the command line, after `measure`.

    Returns:
        The exit status: 1 if any scan was not read.
    """
    asked = _parser().parse_args(arguments)
    logging.basicConfig(level=logging.WARNING, format="%(message)s", stream=sys.stderr)
    try:
        return _measure(asked)
    except InputError as error:
        return _refuse([str(error)])


def _measure(asked: argparse.Namespace) -> int:
    from lssd_learn.collections import AtHand
    from lssd_learn.models.measuring import BodyReader
    from lssd_learn.models.measuring.table import read_all, told, write_table

    reader = BodyReader.load(Path(asked.reader).expanduser()) if asked.reader else BodyReader.load()
    scans = AtHand(asked.scans)
    found, refused = read_all(reader, scans, asked.unit)
    for line in told(reader, found):
        print(line)
    for path in filter(None, (asked.json, asked.csv)):
        try:
            write_table(reader, found, Path(path).expanduser())
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from error
    if asked.pictures:
        from lssd_learn.models.measuring.picture import save_pictures

        save_pictures(reader, scans, found, Path(asked.pictures).expanduser())
    if asked.report:
        from lssd_learn.models.measuring.report import write_report

        write_report(reader, scans, found, refused, Path(asked.report).expanduser())
    return _refuse(refused) if refused else 0


def _refuse(lines: Sequence[str]) -> int:
    for line in lines:
        print(f"error: {line}", file=sys.stderr)
    return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "lssd measure",
        description="Body measures of scans of people, each with an interval; docs/measures.md says what they are.",
    )
    parser.add_argument("scans", nargs="+", help="meshes or clouds (PLY, OBJ, OFF, STL, GLB, XYZ, …), lying anyhow")
    parser.add_argument("--unit", choices=UNITS, default="auto", help="of the scans; auto finds out, scan by scan")
    parser.add_argument(
        "--reader",
        default=os.environ.get(READER),
        help=f"of your own, see experiment=measures; by default ${READER}, or ours",
    )
    parser.add_argument("--json", metavar="FILE", help="write the measures in millimetres there")
    parser.add_argument("--pictures", metavar="FOLDER", help="draw each scan with the tapes on it there")
    parser.add_argument("--report", metavar="PAGE", help="write one HTML page with tables and pictures there")
    parser.add_argument("--csv", metavar="FILE", help="the same as a table")
    return parser
