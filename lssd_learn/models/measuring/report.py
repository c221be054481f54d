"""One HTML page of what was read of scans: tables with intervals, pictures with the tapes, signs of faults. It needs
nothing else and opens from disk, without a network.
"""

import io
from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from PIL import Image

from lssd_learn.collections import Collection
from lssd_learn.collections.anthropometry.measures import MEASURES
from lssd_learn.errors import InputError
from lssd_learn.models.measuring.picture import drawn
from lssd_learn.models.measuring.reader import BodyReader, Reading
from lssd_learn.models.measuring.table import CAUTION, numbers_of, towards
from lssd_learn.progress import track
from lssd_learn.view.reports.blocks import table, words
from lssd_learn.view.reports.filled import fill

HINT = (
    "A body that varies as generated grown-ups do was laid on each scan, put at rest, and measured there, in the sense "
    "of ISO 8559-1: as if the person stood upright, arms held off, whatever the pose of the scan. An interval holds "
    "with the probability that is said, for scans as those that the reader was calibrated on. Look whether the tapes "
    "lie where they should. Not for diagnosis, dosage or made-to-measure cutting."
)


def write_report(
    reader: BodyReader, scans: Collection, found: Mapping[str, Reading], refused: Sequence[str], path: Path
) -> None:
    """Write the page. Texts are plain; what could be markup in them is shown as it is.

    Args:
        scans: of which some were read.
        found: name → what was read of each of these.
        refused: a line for each of the others.

    Raises:
        InputError: a file that cannot be written.
    """
    place = {name: i for i, name in enumerate(scans.names)}
    parts = [
        _scan(reader, scans, place[name], name, reading) for name, reading in track(list(found.items()), "pictures")
    ]
    if refused:
        lines = "\n".join(f'<p class="refused">{escape(line)}</p>' for line in refused)
        parts.append(f"<section>\n<h2>Not read</h2>\n{lines}\n</section>")
    count = f"{len(found)} scan{'s' if len(found) != 1 else ''} read"
    summary = (
        f"{count}, {len(refused)} refused; {100 * reader.level:g} % intervals. Nothing of a scan has left the machine."
    )
    page = fill(
        "measured.html",
        title="Body measures",
        summary=escape(summary),
        scans="\n".join(parts),
        hint=escape(f"{HINT} {CAUTION[0].upper()}{CAUTION[1:]}."),
        words=words({measure.title: measure.means for measure in MEASURES if measure.name in reader.names}),
        footer="lssd_learn, lssd measure",
    )
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error


def _scan(reader: BodyReader, scans: Collection, number: int, name: str, reading: Reading) -> str:
    rows = [list(row) for row in numbers_of(reader, reading)]
    signs = "\n".join(f'<p class="sign">Look at it: {escape(sign)}</p>' for sign in reading.signs)
    stream = io.BytesIO()
    Image.fromarray(drawn(scans[number], reading, reader)).save(stream, "PNG")
    picture = b64encode(stream.getvalue()).decode()
    alt = escape(f"{name}, from the front and from behind, with the tapes on it")
    return f"""<section>
<h2>{escape(name)}</h2>
<p class="note">Taken to be in {reading.unit}; its hips stand up towards {towards(reading)} of the file.</p>
{signs}
<div class="scan">
{table(("", "", "from", "to"), rows)}
<figure><img src="data:image/png;base64,{picture}" alt="{alt}"></figure>
</div>
</section>"""
