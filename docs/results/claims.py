"""What sentences of README and of the pages say, written anew from the CSV files here: (page, words) for each.

`tests/test_numbers.py` looks for them.
"""

from math import floor
from statistics import mean, stdev

from tables import short, table, values


def kernel():
    for setting, words, digits in (("collection.seed=1", "(`collection.seed=1`) it has", 5),
                                   ("data.protocol=inductive", "(`data.protocol=inductive`)", 5),
                                   ("collection.vary_age=true", "(`collection.vary_age=true`)", 4)):  # fmt: skip
        yield "README", f"{words} {short(mean(values(table('kernel_settings', setting=setting), 'test/mse')), digits)}"


def reconstruction():
    net, mean_body = (table("reconstruction", answer=name) for name in ("net", "mean"))
    millimetres, of_mean = (mean(values(rows, "vertex_error_mm")) for rows in (net, mean_body))
    assert min(values(net, "pose_agreement")) == 1
    yield "README", f"draws the {len(net)} test bodies with a mean vertex error of {millimetres:.1f} mm"
    yield "README", f"(the mean body: {of_mean:.0f} mm), all in the right pose"


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
    rows = {
        row["shapes"]: short(float(row["test mse"]), 4)
        for row in table("strangers")
        if "auto" in row["operators through"]
    }
    yield "README", f"read with an MSE of {rows['turned']}, turned clouds of 8,000 points with {rows['turned clouds']}"


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


def third_operator():
    def cell(value):
        return short(value, 5 if value < 0.001 else 4)

    for setting, words in (("eight poses, read at jitter 0", "eight poses, eight poses"),
                           ("eight poses, read at jitter 5", "eight poses, joints off by up to 5°"),
                           ("eight poses, read at jitter 15", "eight poses, joints off by up to 15°"),
                           ("jitter 15", "joints off by up to 15°, the same")):  # fmt: skip
        cells = [
            cell(mean(values(table("third_operator", setting=setting, operators=kinds), "test/mse")))
            for kinds in ("area conformal", "area conformal extrinsic")
        ]
        yield "study", f"| {words} | {' | '.join(cells)} |"
    rows = [row for row in table("third_operator") if row["setting"].startswith("held-out pose")]
    three, two = (
        mean(values([row for row in rows if row["operators"] == kinds], "test/mse"))
        for kinds in ("area conformal extrinsic", "area conformal")
    )
    yield "study", f"has {short(three, 4)} over the seven folds but `reach`, without it {short(two, 4)}"
    for pose in ("bend", "sitting", "reach"):
        plain, rehearsed = (
            short(float(table("third_operator", setting=f"615 vertices, {words}held out {pose}")[0]["test/mse"]), 4)
            for words in ("", "rehearsed, ")
        )
        yield "study", f"{rehearsed} instead of {plain} ({pose})"
    for jitter in (0, 15):
        plain, rehearsed = (
            cell(float(table("third_operator", setting=f"{words}eight poses, read at jitter {jitter}")[0]["test/mse"]))
            for words in ("", "rehearsed ")
        )
        yield "study", f"{rehearsed} instead of {plain}"


def unseen_poses():
    """The eight folds of a pose that training has not seen, at 615 vertices."""
    rows = table("unseen_poses")
    few = [row for row in rows if row["pose"] != "bend"]
    edges, kernel, rehearsed, both = (
        [short(mean(values(some, column)), 4) for some in (rows, few)]
        for column in ("edge_lengths", "kernel", "rehearsed", "both")
    )
    yield "study", f"a mean MSE of {rehearsed[0]} instead of {kernel[0]}, and {rehearsed[1]} instead of {kernel[1]}"
    yield "study", f"with a noise rehearsed alike, {edges[0]} and {edges[1]}"
    yield "study", f"on the same logarithms has {both[0]} and {both[1]}, by a script"
    other = [row for row in rows if row["pose"] in ("arms_down", "t_pose", "stride", "bend")]
    both, rehearsed, edges = (short(mean(values(other, of)), 4) for of in ("both", "rehearsed", "edge_lengths"))
    yield "study", f"other four it has {both}, the kernel machine {rehearsed}, edge lengths {edges}"


def gram():
    """Bodies drawn from their Gram forms."""

    def cell(value):
        return f"{value:.{0 if value >= 30 else 1}f}"

    for row in table("gram", way="detailed"):
        of = {each["way"]: each for each in table("gram", bodies=row["bodies"], vertices=row["vertices"])}
        cells = [cell(float(of[way]["mean_mm"])) for way in ("mean", "nearest", "smooth", "detailed")]
        title = f"| {int(row['vertices']):,}: {row['fitted']}, {row['drawn']} | "
        yield "operators", f"{' | '.join(cells)} | {cell(float(row['worst_mm']))} |"
        yield "operators", title
    answer, own, C, exact = (
        float(table("gram", way=way)[0]["mean_mm"])
        for way in (
            "analogy",
            "analogy, the truth of its own form",
            "analogy, C",
            "analogy, of A, B and C as they are",
        )
    )
    yield (
        "operators",
        f"within {answer:.0f} mm, four times as far as the truth is from what its own form gives ({own:.1f} mm)",
    )
    yield "operators", f"C itself is {C:.0f} mm off"
    yield "operators", f"nothing drawn, it comes within {exact:.0f} mm"


def motion():
    """Frames of characters drawn by the paper's network."""
    net, nearest = (table("motion", answer=answer)[0] for answer in ("reconstructor", "nearest"))
    level, f = float(net["cd_over_level"]), short(float(net["f_2cm"]), 3)
    yield "synthesis", f"384 test frames at {level:.2f} times the level of the CD, with an F-score at 2 cm of {f}"
    level, f = float(nearest["cd_over_level"]), short(float(nearest["f_2cm"]), 3)
    yield "synthesis", f"nearer, {level:.2f} and {f}"
    yield "synthesis", f"the next one is {float(nearest['vertex_error_mm']):.0f} mm away"


def null():
    rates = sorted(100 * value for value in values(table("null"), "rate"))
    yield "models", f"{len(rates)} kinds of studies"
    yield "models", f"{len(rates) - 1} find something in {rates[0]:.1f} to {rates[-2]:.1f} %"
    yield "models", f"one in {rates[-1]:.1f} %"


def power():
    false = values(table("power", area="0.1", others="weight", paired="False", meshes="one"), "false")
    paired = values(table("power", paired="True"), "false")
    yield "models", f"{short(min(false), 2)} to {short(max(false), 2)} of the significant area"
    yield "models", f"of pairs {short(min(paired), 2)} to {short(max(paired), 2)}"
    apart = table("power", others="random", paired="False")
    found = [short(bound, 2) for bound in (min(values(apart, "table")), max(values(apart, "table")))]
    (neck,) = (short(float(row["anywhere"]), 2) for row in apart if row["place"] == "neck")
    yield "models", f"(.05 to {found[1]} of studies, landmarks .03), the field all but the neck ({neck})"
    assert found[0] == ".05"


def maps():
    one, two = table("maps", kind="same_person") + table("maps", kind="other_person")
    errors = [short(100 * float(row["error"]), 1) for row in (one, two)]
    worst = short(100 * max(float(row["worst"]) for row in (one, two)), 1)
    flipped = short(100 * max(float(row["flipped"]) for row in (one, two)), 1)
    yield "README", f"of {errors[0]} % of √area between scans of one person and {errors[1]} between two people"
    yield "guides/maps", f"of one person have a mean geodesic error of {errors[0]} % of √area"
    yield (
        "guides/maps",
        f"of two people {errors[1]}, the worst of all {worst}, and {flipped} % of the points on the wrong",
    )


def slopes():
    (row,) = table("slopes")
    yield (
        "models",
        f"in {100 * float(row['vertex']):.1f} % at a vertex and {100 * float(row['place']):.1f} % over the hand",
    )


def places():
    def of(shapes, column, digits=2, mask=""):
        (row,) = table("places", shapes=shapes, mask=mask)
        return short(float(row[column]), digits)

    outer, whole = ([of("24 skulls", f"landmarks{smooth}", mask=mask) for smooth in ("", "/smoothed")]
                    for mask in ("outer", ""))  # fmt: skip
    yield "guides/bones", f"correlate by {outer[0]} over the surface, by {outer[1]} where"
    yield "guides/bones", f"the spline guesses, by {whole[0]} and {whole[1]}"
    yield "models", f"by a correlation of {outer[0]} on the outside (`collection.mask=outer`), {whole[0]} with"
    right, marks = "truth/operators/smoothed", "truth/landmarks/smoothed"
    waist, weight = (f"{of(f'changed {what}', right, 3)}" for what in ("waist", "weight"))
    yield "guides/bones", f"by {waist}, 51 landmarks by {of('changed waist', marks)}; of heavier people by {weight} and"
    walled = [of("walled heads", right, mask=mask) for mask in ("outer", "")]
    yield "guides/bones", f"are right by {walled[0]} with the mask and {walled[1]} without it"
    known = [of("walled heads", marks, mask=mask) for mask in ("outer", "")]
    yield "guides/bones", f"51 landmarks by {known[0]} and {known[1]}"
    faces = "faces neutral surprised"
    yield "guides/bones", f"surprised by {of(faces, right)} and, with 16 landmarks, {of(faces, marks)}"


CLAIMS = (kernel, reconstruction, algebra, pushes, strangers, highlights, skulls, few_labels, study,
    pool, poses, third_operator, unseen_poses, gram, motion, null, power, slopes, places, maps)  # fmt: skip
