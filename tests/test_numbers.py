"""The numbers of README and docs/ follow from the CSV files under docs/results: tables of the pages are made anew,
claims of sentences are written anew and looked for."""

from statistics import mean, median

import pytest
from claims import CLAIMS, kernel
from tables import ASKED, DOCS, TABLES, page, placed, short, table


def words_of(name):
    return " ".join(page(name).read_text(encoding="utf-8").split())


@pytest.mark.parametrize("make", TABLES, ids=lambda make: make.__name__)
def test_a_table_of_a_page_is_what_its_csv_makes_of_it(make):
    made = make()
    text = page(made.page).read_text(encoding="utf-8")
    assert text == placed(text, made), "python docs/results/tables.py"
    assert text != placed(text, made._replace(rows=made.rows[:-1]))


@pytest.mark.parametrize("claims", CLAIMS, ids=lambda claims: claims.__name__)
def test_a_number_is_what_its_table_says(claims):
    missing = [f"{name}: {claim}" for name, claim in claims() if " ".join(claim.split()) not in words_of(name)]
    assert missing == []


def test_a_number_that_its_table_does_not_say_would_be_seen():
    assert short(0.0083, 4) == ".0083"
    assert short(0.00999, 4) == ".0100"
    assert short(-9.825, 1) == "−9.8"
    assert short(4.6, 1) == "4.6"
    name, claim = next(kernel())
    assert claim in words_of(name)
    assert claim.replace(".00026", ".00027") not in words_of(name)


def test_the_folds_make_the_means_of_their_table():
    of = {row["method"]: row for row in table("held_out_pose")}
    folds = [name for name in of["kernel"] if name not in ("method", "mean", "median", "R2")]
    for row in of.values():
        found = [float(row[fold]) for fold in folds]
        assert float(row["mean"]) == pytest.approx(mean(found), rel=1e-4)
        assert float(row["median"]) == pytest.approx(median(found), rel=1e-4)


def test_every_csv_is_asked():
    """A new file of results gets a table or claims; those of `exploration` stand in sentences without its digits."""
    ASKED.clear()
    for make in (*CLAIMS, *TABLES):
        list(make())
    assert ASKED | {"exploration"} == {file.stem for file in (DOCS / "results").glob("*.csv")}
