"""The numbers of README and docs/ follow from the tables under docs/results: a claim is written anew and looked for."""

from math import floor
from statistics import mean, median, stdev

import pytest
from tables import ASKED, DOCS, short, spread, table, values


def nets():
    for net, words, mse, l1 in (("cnn", "operators | CNN", 4, 3), ("mlp", "operators | MLP", 4, 3),
                                ("pointnet", "point clouds | PointNet B", 3, 3)):  # fmt: skip
        rows = table("main_job", net=net)
        assert len(rows) == 5
        gap = short(mean(values(rows, "generalisation_error")), 4)
        yield "README", f"| {words} | {spread(rows, 'test/mse', mse)} | {spread(rows, 'test/l1', l1)} | {gap} |"
    for reference, words, digits in (
        ("ridge", "operators | ridge regression", 4),
        ("mean", "nothing | mean of the", 3),
    ):
        mse, l1 = (spread(rows, f"reference/{reference}/{score}", d) for score, d in (("mse", digits), ("l1", 3)))
        rest = " training split" if reference == "mean" else ""
        yield "README", f"| {words}{rest} | {mse} | {l1} | |"


def same_input():
    """What reads the same operators: a kernel machine, ridge regression and the CNN, side by side."""
    plain, both = (table("same_input", setting=words, net="kernel") for words in ("main job", "experiment=kernel"))
    nets_on_both = table("same_input", setting="experiment=kernel", net="cnn")
    ridge, cnn = spread(plain, "reference/ridge/mse", 4), spread(table("main_job", net="cnn"), "test/mse", 4)
    yield "README", f"the main job | {spread(plain, 'test/mse', 4)} | {ridge} | {cnn} |"
    ridge, cnn = spread(both, "reference/ridge/mse", 4), spread(nets_on_both, "test/mse", 4)
    yield "README", f"`experiment=kernel` | {spread(both, 'test/mse', 5)} | {ridge} | {cnn} |"


def kernel():
    for setting, words, digits in (("collection.seed=1", "(`collection.seed=1`) it has", 5),
                                   ("data.protocol=inductive", "(`data.protocol=inductive`)", 5),
                                   ("collection.vary_age=true", "(`collection.vary_age=true`)", 4)):  # fmt: skip
        yield "README", f"{words} {short(mean(values(table('kernel_settings', setting=setting), 'test/mse')), digits)}"


def reconstruction():
    net, mean_body, near = (table("reconstruction", answer=name) for name in ("net", "mean", "nearest"))
    millimetres, of_mean, of_near = (mean(values(rows, "vertex_error_mm")) for rows in (net, mean_body, near))
    assert min(values(net, "pose_agreement")) == 1
    yield "README", f"draws the {len(net)} test bodies with a mean vertex error of {millimetres:.1f} mm"
    yield "README", f"(the mean body: {of_mean:.0f} mm), all in the right pose"
    theirs = [table("reconstruction_paper", answer=name) for name in ("reconstructor", "autoencoder")]
    for words, rows, off in (("`net=vertices`, both operators, k = 140", net, f"{millimetres:.1f} mm"),
                             ("the paper's network, area operators, k = 50", theirs[0], ""),
                             ("auto-encoder that sees the cloud itself, 300 epochs", theirs[1], ""),
                             ("training body of the nearest area operator, k = 140", near, f"{of_near:.0f} mm"),
                             ("mean body", mean_body, f"{of_mean:.0f} mm")):  # fmt: skip
        level, one, two, pose = (
            mean(values(rows, name)) for name in ("cd_over_level", "f_1cm", "f_2cm", "pose_agreement")
        )
        cells = [f"{level:.{0 if level > 10 else 2}f}", short(one, 3), short(two, 3), off, f"{100 * pose:.0f} %"]
        yield "synthesis", f"| {words} | " + " | ".join(cells).replace("|  |", "| |") + " |"


def algebra():
    test = table("analogies", part="test")
    by = {row["answer"]: row for row in test if row["role"] == "pose"}
    C = mean(values([row for row in test if row["answer"] == "C"], "vertex_error_mm"))
    best = by["multiplicative"]
    yield (
        "synthesis",
        (
            f"within {float(best['vertex_error_mm']):.1f} mm, at {float(best['cd_over_level']):.2f} times the CD of "
            "what is drawn from the true operator; added codes are at "
            f"{float(by['additive']['vertex_error_mm']):.0f} mm, C itself at {C:.0f} mm"
        ),
    )

    def parts(answer, column, part="test"):
        return mean(values(table("partial", collection="mixed", part=part, answer=answer), column))

    methods = {row["answer"] for row in table("partial")} - {"own", "A", "B", "best"}
    chosen = min(methods, key=lambda method: parts(method, "cd", "validation"))
    of = {name: parts(name, "vertex_error_mm") for name in ("plain", chosen, "own", "A", "B")}
    times = parts(chosen, "cd") / parts("own", "cd")
    yield "synthesis", f"The paper's formula comes within {of['plain']:.0f} mm of the truth"
    yield "synthesis", f"within {of[chosen]:.0f} mm, at {times:.2f} times the CD"
    yield "synthesis", f"({of['own']:.1f} mm). A itself is {of['A']:.0f} mm off, B {of['B']:.0f}."


def pushes():
    (row,) = table("push", way="least_squares")
    took = float(row["cpu_seconds_fit"]) + float(row["cpu_seconds_push"])
    yield "synthesis", f"takes {took:.0f} s of processor time, to fit all {float(row['cpu_seconds_fit_to_all']):.0f}"
    yield "synthesis", f"differ by {100 * float(row['pushed_normalised_mean']):.1f} % of their spread"


def strangers():
    rows = {(row["shapes"], row["operators through"].split()[0]): float(row["test mse"]) for row in table("strangers")}
    meshes, clouds = (rows[kind, "registration"] for kind in ("remeshed", "clouds"))
    yield "README", f"read with an MSE of {short(meshes, 3)}, of 40 clouds of 8,000 points with {short(clouds, 3)}"
    yield (
        "README",
        f"turned at random, with `maps=auto`, are read with an MSE of {short(rows['turned', 'maps=auto'], 4)}",
    )
    yield "README", f"8,000 points, turned too, with {short(rows['turned clouds', 'maps=auto'], 4)}"
    yield "README", f"up to 15°, turned, are read with {short(rows['joints off by 15°', 'maps=auto'], 4)}"
    yield "README", f"mean predictor has {short(rows['either', 'mean'], 3)} and PointNet"
    yield "README", f"on 1,024 of the points, {short(rows['clouds', 'PointNet'], 3)}"


def highlights():
    every, first = (values(table("highlights", operator="area", others="middle", answer=answer), "auc")
                    for answer in ("all, at each vertex", "first function"))  # fmt: skip
    bound = short(floor(1000 * min(every)) / 1000, 3)  # "or more" is not rounded up
    alone = f"{short(min(first), 2)} to {short(max(first), 2)}"
    lowest = short(min(values(table("highlights", operator="area", others="middle", answer="all, at each vertex"),
                              "auc/lowest")), 3)  # fmt: skip
    yield "README", f"AUC of {bound} or more ({lowest} on the worst body), the best function alone with {alone}"


def skulls():
    rows = table("skulls")[:2]
    region, function = ([short(value, 2) for value in values(rows, name)] for name in ("region", "function"))
    yield (
        "gallery",
        f"of {region[0]} and {region[1]} "
        f"(`results/skulls.csv`; the best function alone {function[0]} and {function[1]})",
    )
    template = values(table("skulls"), "template")
    yield "gallery", f"correlates by {short(min(template), 2)} to {short(max(template), 2)}"


def few_labels():
    rows = table("pose_groups")
    assert all(value == 1 for value in values(rows, "conformal/accuracy/after"))
    worst = sorted(100 * value for value in values(rows, "conformal/accuracy/before"))[:2]
    yield "gallery", f"({worst[0]:.0f} and {worst[1]:.0f} %)"
    area = [100 * value for value in values(rows, "area/accuracy/after")]
    yield "gallery", f"Area operators do not: {min(area):.0f} to {max(area):.0f} %"


def study():
    def cell(row, digits=4):
        return f"{short(float(row['MSE@500']), digits)} ± {short(float(row['MSE@500 deviation']), digits)}" + (
            f" ({short(float(row['MSE@500 paper']), 3)})" if row["MSE@500 paper"] else ""
        )

    for network, words in (("clique", "clique"), ("nearest_20", "20 nearest"), ("nearest_10", "10 nearest")):
        cells = [cell(table("study", row=f"{net}, {network}, 40")[0]) for net in ("CNN", "MLP")]
        yield "study", f"| {words} | {cells[0]} | {cells[1]} |"
    yield "study", f"| PointNet B | {cell(table('study', row='PointNet')[0], 3)} | |"
    wide = {
        net: [
            short(float(table("study", row=f"{net}, {network}, 40, k = 80")[0]["MSE@500"]), 4)
            for network in ("clique", "nearest_20", "nearest_10")
        ]
        for net in ("CNN", "MLP")
    }
    yield (
        "study",
        "the CNN has {}, {} and {} on the three networks, the MLP {}, {} and {}".format(*wide["CNN"], *wide["MLP"]),
    )
    for row, words, digits in (("area operators", "area operators", (4, 3)), ("Shape-DNA", "Shape-DNA", (3, 3)),
                               ("area and conformal operators", "area and conformal operators", (4, 3)),
                               ("logarithms of vertex areas", "logarithms of vertex areas", (4, 3))):  # fmt: skip
        (found,) = table("study", row=row)
        mse, l1 = (short(float(found[name]), d) for name, d in zip(("MSE@1K", "L1@1K"), digits, strict=True))
        yield "study", f"| {words} | {mse} | {l1} |"


def poses():
    accuracies = [
        [100 * value for value in values(table("pose", **{"collection.seed": seed}), name)]
        for seed in ("0", "1")
        for name in ("test/accuracy", "reference/linear/accuracy")
    ]
    ours, linear, others, linear_others = ((f"{mean(a):.1f}", f"{stdev(a):.1f}") for a in accuracies)
    yield "study", f"{ours[0]} ± {ours[1]} % of the test shapes"
    yield "study", f"`collection.seed=1`: {others[0]} ± {others[1]})"
    yield "study", f"has {linear[0]} ± {linear[1]} and {linear_others[0]} ± {linear_others[1]} %"


def pool():
    best = min(table("pool"), key=lambda row: float(row["validation/mse"]))
    rate = short(float(best["net.learning_rate"]), 3)
    yield "study", f"PointNet {best['net.variant']} with a learning rate of {rate} is the best of the paper's fifteen"
    assert len(table("pool")) == 15


def held_out():
    of = {row["method"]: row for row in table("held_out_pose")}
    folds = [name for name in of["kernel"] if name not in ("method", "mean", "median", "R2")]
    for row in of.values():  # what the table says of its own folds
        found = [float(row[fold]) for fold in folds]
        assert float(row["mean"]) == pytest.approx(mean(found), rel=1e-4)
        assert float(row["median"]) == pytest.approx(median(found), rel=1e-4)
    for method, words, digits in (("edge_lengths", "edge lengths, ridge", (4, 4, 2)),
                                  ("mean", "mean of the training split", (3, 3, 0)),
                                  ("kernel", "kernel machine on operators", (4, 4, 2)),
                                  ("pointnet", "PointNet B", (2, 2, 1)),
                                  ("vertices", "Procrustes-aligned vertices, ridge", (1, 1, 0))):  # fmt: skip
        cells = [short(float(of[method][name]), d) for name, d in zip(("mean", "median", "R2"), digits, strict=True)]
        yield "study", f"| {words} | {' | '.join(cells)} |"


def protocols():
    for overrides, words in (("net=cnn data.protocol=inductive", "`data.protocol=inductive`"),
                             ("net.permute=0", "`net.permute=0`"),
                             ("latent.operators=[conformal]", "`latent.operators=[conformal]`"),
                             ("latent.operators=[area,conformal]", "`latent.operators=[area,conformal]`"),
                             ("collection.normalise_area=True", "`collection.normalise_area=true`")):  # fmt: skip
        yield "study", f"| {words} | {spread(table('protocols', overrides=overrides), 'test/mse', 4)} |"
    both = [spread(table("protocols", overrides=f"latent.size={size}"), "test/mse", 4) for size in (40, 80)]
    yield "study", f"| `latent.size=40`, `latent.size=80` | {both[0]}, {both[1]} |"


def null():
    rates = sorted(100 * value for value in values(table("null"), "rate"))
    yield "models", f"{len(rates)} kinds of studies"
    yield "models", f"{len(rates) - 1} find something in {rates[0]:.1f} to {rates[-2]:.1f} %"
    yield "models", f"one in {rates[-1]:.1f} %"


def power():
    places = ("foot", "neck", "forearm", "hand", "face")
    (rows,) = zip(
        *(table("power", place=place, area="0.1", others="weight", paired="False") for place in places), strict=True
    )
    assert all(float(row["table"]) == 1 for row in rows)
    core, marks = ([short(value, 2) for value in values(rows, name)] for name in ("dice/core", "landmarks/dice"))
    yield "models", f"of {', '.join(core[:-1])} and {core[-1]} (51 landmarks"
    yield "models", f"thin-plate spline: {', '.join(marks)})"
    false = values(rows, "false")
    paired = values(table("power", paired="True"), "false")
    yield "models", f"{short(min(false), 2)} to {short(max(false), 2)} of the significant area"
    yield "models", f"of pairs {short(min(paired), 2)} to {short(max(paired), 2)}"


def slopes():
    (row,) = table("slopes")
    yield (
        "models",
        f"in {100 * float(row['vertex']):.1f} % at a vertex and {100 * float(row['place']):.1f} % over the hand",
    )


CLAIMS = (nets, same_input, kernel, reconstruction, algebra, pushes, strangers, highlights, skulls, few_labels, study,
    pool, poses, held_out, protocols, null, power, slopes)  # fmt: skip


def page(name):
    path = DOCS.parent / "README.md" if name == "README" else DOCS / f"{name}.md"
    return " ".join(path.read_text(encoding="utf-8").split())


@pytest.mark.parametrize("claims", CLAIMS, ids=lambda claims: claims.__name__)
def test_a_number_is_what_its_table_says(claims):
    missing = [f"{name}: {claim}" for name, claim in claims() if " ".join(claim.split()) not in page(name)]
    assert missing == []


def test_a_number_that_its_table_does_not_say_would_be_seen():
    assert short(0.0083, 4) == ".0083"
    assert short(0.00999, 4) == ".0100"
    assert short(-9.825, 1) == "−9.8"
    assert short(4.6, 1) == "4.6"
    name, claim = next(nets())
    assert claim in page(name)
    assert claim.replace(".0083", ".0082") not in page(name)


def test_every_table_is_asked():
    """A new table of results gets its claims here; those of `exploration` stand in sentences without its digits."""
    ASKED.clear()
    for claims in CLAIMS:
        list(claims())
    assert ASKED | {"exploration"} == {file.stem for file in (DOCS / "results").glob("*.csv")}
