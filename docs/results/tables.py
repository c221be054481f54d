"""The tables and the figure of README and docs/ that come from the CSV files beside this one, made from them again:
`python docs/results/tables.py` writes them where they stand. `tests/test_numbers.py` holds the pages to them.
"""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import mean, stdev
from typing import NamedTuple

DOCS = Path(__file__).parents[1]
ASKED: set[str] = set()  # the CSV files that were read


class Table(NamedTuple):
    """`page`, a name as README or study; `head`, the line of its columns; `rows`, lines."""

    page: str
    head: str
    rows: list[str]


def table(name: str, **where: str) -> list[dict[str, str]]:
    """The rows of a CSV file in which these columns say so."""
    with (DOCS / "results" / f"{name}.csv").open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if all(row[key] == value for key, value in where.items())]
    assert rows, (name, where)
    ASKED.add(name)
    return rows


def values(rows: Sequence[dict[str, str]], column: str) -> list[float]:
    return [float(row[column]) for row in rows]


def short(value: float, digits: int) -> str:
    """A number as the pages write it: .0083, without the zero, and −9.8 with a minus that is one."""
    return f"{value:.{digits}f}".replace("0.", ".", 1 if abs(value) < 1 else 0).replace("-", "−")


def spread(rows: Sequence[dict[str, str]], column: str, digits: int) -> str:
    """Mean ± standard deviation."""
    found = values(rows, column)
    return f"{short(mean(found), digits)} ± {short(stdev(found), digits)}"


def line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |".replace("|  |", "| |")


def main_job() -> Table:
    rows = []
    for net, reads, digits in (("cnn", "operators | CNN", 4), ("mlp", "operators | MLP", 4), (
                               "pointnet", "point clouds | PointNet B", 3)):  # fmt: skip
        found = table("main_job", net=net)
        assert len(found) == 5
        gap = short(mean(values(found, "generalisation_error")), 4)
        rows.append(line(reads, spread(found, "test/mse", digits), spread(found, "test/l1", 3), gap))
    for place, name, reads, digits in ((2, "ridge", "operators | ridge regression", 4), (
                                       4, "mean", "nothing | mean of the training split", 3)):  # fmt: skip
        scores = [spread(table("main_job", net="pointnet"), f"reference/{name}/{score}", d)
                  for score, d in (("mse", digits), ("l1", 3))]  # fmt: skip
        rows.insert(place, line(reads, *scores, ""))
    return Table("README", "| reads | | MSE | L1 | test − train MSE |", rows)


def same_input() -> Table:
    plain, both = (table("same_input", setting=words, net="kernel") for words in ("main job", "experiment=kernel"))
    one_cnn, other_cnn = table("main_job", net="cnn"), table("same_input", setting="experiment=kernel", net="cnn")
    edges, vertices = (
        short(float(table("study", row=row)[0]["MSE@1K"]), 5) for row in ("edge lengths", "aligned vertices")
    )
    return Table("README", "| reads | kernel machine | ridge regression | CNN |", [
        line("area operators, 40 functions: the main job", spread(plain, "test/mse", 4),
             spread(plain, "reference/ridge/mse", 4), spread(one_cnn, "test/mse", 4)),
        line("both operators, 70 functions, k = 140: `experiment=kernel`", spread(both, "test/mse", 5),
             spread(both, "reference/ridge/mse", 4), spread(other_cnn, "test/mse", 4)),
        line("no operators: Procrustes-aligned vertices, edge lengths", "", f"{vertices}, {edges}", ""),
    ])  # fmt: skip


def reconstruction() -> Table:
    ours, theirs = "reconstruction", "reconstruction_paper"
    rows = []
    for words, name, answer in (("`net=vertices`, both operators, k = 140", ours, "net"),
                                ("the paper's network, area operators, k = 50", theirs, "reconstructor"),
                                ("auto-encoder that sees the cloud itself, 300 epochs", theirs, "autoencoder"),
                                ("training body of the nearest area operator, k = 140", ours, "nearest"),
                                ("mean body", ours, "mean")):  # fmt: skip
        found = table(name, answer=answer)
        level, one, two, pose = (
            mean(values(found, score)) for score in ("cd_over_level", "f_1cm", "f_2cm", "pose_agreement")
        )
        off = mean(values(found, "vertex_error_mm")) if name == ours else None
        rows.append(line(words, f"{level:.{0 if level > 10 else 2}f}", short(one, 3), short(two, 3),
            "" if off is None else f"{off:.{0 if off > 10 else 1}f} mm", f"{100 * pose:.0f} %"))  # fmt: skip
    return Table("synthesis", "| | CD / level | F 1 cm | F 2 cm | vertices off by | right pose |", rows)


def networks() -> Table:
    def cell(row: dict[str, str], digits: int) -> str:
        told = f"{short(float(row['MSE@500']), digits)} ± {short(float(row['MSE@500 deviation']), digits)}"
        return told + (f" ({short(float(row['MSE@500 paper']), 3)})" if row["MSE@500 paper"] else "")

    rows = []
    for network, words in (("clique", "clique"), ("nearest_20", "20 nearest"), ("nearest_10", "10 nearest")):
        rows.append(line(words, *(cell(table("study", row=f"{net}, {network}, 40")[0], 4) for net in ("CNN", "MLP"))))
    rows.append(line("PointNet B", cell(table("study", row="PointNet")[0], 3), ""))
    return Table("study", "| | CNN | MLP |", rows)


def ridges() -> Table:
    rows = []
    for words, names, digits in (("edge lengths, or Procrustes-aligned vertices",
                                  ("edge lengths", "aligned vertices"), (5, 4)),
                                 ("logarithms of vertex areas", ("logarithms of vertex areas",), (4, 3)),
                                 ("area and conformal operators", ("area and conformal operators",), (4, 3)),
                                 ("both from one base shape: best, worst on validation",
                                  ("both, from the best base", "both, from the worst base"), (4, 3)),
                                 ("area operators", ("area operators",), (4, 3)),
                                 ("Shape-DNA", ("Shape-DNA",), (3, 3))):  # fmt: skip
        found = [table("study", row=name)[0] for name in names]
        rows.append(line(words, *(", ".join(short(float(row[score]), d) for row in found)
                                  for score, d in zip(("MSE@1K", "L1@1K"), digits, strict=True))))  # fmt: skip
    return Table("study", "| ridge regression on | MSE | L1 |", rows)


def held_out() -> Table:
    of = {row["method"]: row for row in table("held_out_pose")}
    rows = []
    for words, methods, digits in (("edge lengths, ridge", ("edge_lengths",), (4, 4, 2)),
                                   ("kernel machine on operators", ("kernel",), (4, 4, 2)),
                                   ("CNN, MLP on operators", ("cnn", "mlp"), (3, 3, 2)),
                                   ("mean of the training split", ("mean",), (3, 3, 0)),
                                   ("PointNet B", ("pointnet",), (2, 2, 1)),
                                   ("Procrustes-aligned vertices, ridge", ("vertices",), (1, 1, 0))):  # fmt: skip
        rows.append(line(words, *(", ".join(short(float(of[method][score]), d) for method in methods)
                                  for score, d in zip(("mean", "median", "R2"), digits, strict=True))))  # fmt: skip
    return Table("study", "| | mean MSE | median | R² |", rows)


def protocols() -> Table:
    rows = [line("the main job", spread(table("main_job", net="cnn"), "test/mse", 4))]
    for words, overrides in (("`data.protocol=inductive`", ["net=cnn data.protocol=inductive"]),
                             ("`latent.operators=[conformal]`", ["latent.operators=[conformal]"]),
                             ("`latent.operators=[area,conformal]`", ["latent.operators=[area,conformal]"]),
                             ("`latent.size=40`, `latent.size=80`", ["latent.size=40", "latent.size=80"]),
                             ("`collection.normalise_area=true`", ["collection.normalise_area=True"]),
                             ("`net.permute=0`", ["net.permute=0"])):  # fmt: skip
        found = (spread(table("protocols", overrides=one), "test/mse", 4) for one in overrides)
        rows.append(line(words, ", ".join(found)))
    return Table("study", "| | test MSE |", rows)


def measures() -> Table:
    rows = []
    with (DOCS / "measures.csv").open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            name, _, unit = row["measure"].rpartition("_")
            digits = {"mm": 0, "m2": 2, "l": 1}[unit]
            number = {column: float(text) for column, text in row.items() if column != "measure"}
            each = ((number[f"{who}_mean"], number[f"{who}_sd"]) for who in ("women", "men"))
            people = [f"{middle:,.{digits}f} ± {deviation:.{digits}f}" for middle, deviation in each]
            shares = [f"{number[column]:.1f}" for column in ("sd_percent", "left_by_lengths_percent")]
            alike = [f"{number[column]:.2f}" for column in ("r_height_mm", "r_waist_girth_mm")]
            rows.append(line(name.replace("_", " "), *people, *shares, *alike))
    head = line("", "women, mean ± sd", "men, mean ± sd", "sd, %", "left, %", "r with height", "r with waist")
    return Table("measures", head, rows)


def reader() -> Table:
    kinds = ("meshes", "clouds", "faulty", "mean")
    rows = []
    for row in table("reader"):
        title, unit, digits = _titled(row["measure"], 1)
        rows.append(line(title, *(short(float(row[kind]), digits) for kind in kinds), unit))
    return Table("measures", "| | meshes | clouds | with faults | mean body | |", rows)


PLACES, AREAS = ("foot", "hand", "face", "forearm", "neck", "back"), ("0.03", "0.05", "0.1")


def _grown(place: str, meshes: str, column: str) -> str:
    """What studies of 3, 5 and 10 % of a place have found."""
    asked = {"place": place, "meshes": meshes, "others": "weight", "paired": "False"}
    return ", ".join(short(float(table("power", area=area, **asked)[0][column]), 2) for area in AREAS)


def power() -> Table:
    columns = ("table", "auc", "dice/core", "landmarks/table", "landmarks/dice")
    rows = [line(place, *(_grown(place, "one", column) for column in columns)) for place in PLACES]
    return Table("models", "| | found | AUC | core | landmarks: found | Dice |", rows)


def power_of_computed_maps() -> Table:
    columns = ("table", "auc", "dice/core", "false", "landmarks/table")
    rows = []
    for row in table("power", meshes="own"):
        area = 100 * float(row["area"])
        words = f"{row['place']}, {area:.0f} %" if area >= 1 else "nothing"
        known = columns if area >= 1 else ("table", "landmarks/table")
        rows.append(line(words, *(short(float(row[name]), 2) if name in known else "" for name in columns)))
    return Table("models", "| | found | AUC | core | elsewhere | landmarks: found |", rows)


def strangers() -> Table:
    rows = []
    for words, shapes, through, maps in (
        ("remeshed", "remeshed", "registration to one neighbour", "`registration`"),
        ("clouds of 8,000 points", "clouds", "registration to one neighbour", "`registration`"),
        ("remeshed, turned", "turned", "maps=auto to a mixture of the training shapes", "`auto`"),
        ("clouds, turned", "turned clouds", "maps=auto to a mixture of the training shapes", "`auto`"),
        ("every joint off by up to 15°, remeshed, turned", "joints off by 15°",
         "maps=auto to a bent mixture of the training shapes", "`auto`"),
        ("clouds, PointNet on 1,024 of the points", "clouds", "PointNet A on 1024 of the points", "none"),
        ("mean of the training bodies", "either", "mean of the training bodies", "none")):  # fmt: skip
        found = {row["operators through"]: row for row in table("strangers", shapes=shapes)}
        rows.append(line(words, maps, short(float(found[through]["test mse"]), 4 if maps == "`auto`" else 3)))
    return Table("guides/maps", "| bodies | `maps=` | MSE |", rows)


def _titled(measure: str, digits: int) -> tuple[str, str, int]:
    """What a measure is called, its unit, and the digits that errors of it have."""
    name, _, unit = measure.rpartition("_")
    return name.replace("_", " "), {"m2": "m²"}.get(unit, unit), {"mm": digits, "m2": digits + 2, "l": digits + 1}[unit]


TABLES = (main_job, same_input, reconstruction, networks, ridges, held_out, protocols, measures, reader, strangers,
    power, power_of_computed_maps)  # fmt: skip


def page(name: str) -> Path:
    return DOCS.parent / "README.md" if name == "README" else DOCS / f"{name}.md"


def placed(text: str, made: Table) -> str:
    """The text of a page with the rows of this table under its head."""
    lines = text.split("\n")
    start = lines.index(made.head) + 2
    end = next(i for i in range(start, len(lines) + 1) if i == len(lines) or not lines[i].startswith("|"))
    return "\n".join([*lines[:start], *made.rows, *lines[end:]])


def figure() -> None:
    """docs/study.png: test error against the number of functions."""
    from lssd_learn.studies.study import functions_figure

    def points() -> Iterator[tuple[str, str, int, float, float]]:
        for row in table("study"):
            if row["row"].count(", ") == 2 and row["MSE@500"] and not row["row"].startswith("ridge"):
                net, network, keep = row["row"].split(", ")
                yield net.lower(), network, int(keep), float(row["MSE@500"]), float(row["MSE@500 deviation"])

    functions_figure(points(), float(table("study", row="PointNet")[0]["MSE@500"])).savefig(DOCS / "study.png")


if __name__ == "__main__":
    for make in TABLES:
        made = make()
        file = page(made.page)
        file.write_text(placed(file.read_text(encoding="utf-8"), made), encoding="utf-8")
    figure()
