"""`trainer` as it is configured is what Lightning's Trainer is given."""

import lightning
import pytest
from lightning.pytorch.strategies import DDPStrategy

from lssd_learn.errors import InputError
from lssd_learn.shapes import save

SMALL = ("collection=folder", "basis.k=10", "latent.size=8", "latent.keep=6", "task.epochs=2")
CHOSEN = {
    "devices": 2,
    "num_nodes": 3,
    "precision": "bf16-mixed",
    "gradient_clip_val": 0.5,
    "accumulate_grad_batches": 4,
    "strategy": "ddp",
}


@pytest.fixture
def spheres_of_sizes(deformed_spheres, tmp_path):
    """A folder of twelve spheres, each with a size."""
    folder = tmp_path / "shapes"
    folder.mkdir()
    for i, mesh in enumerate(deformed_spheres(12, 1)):
        save(mesh, folder / f"s{i:02d}.ply")
    (folder / "labels.csv").write_text("name,size\n" + "".join(f"s{i:02d},{i / 12}\n" for i in range(12)))
    return folder


def test_every_key_reaches_lightning(runs_of, spheres_of_sizes, monkeypatch):
    began = []
    monkeypatch.setattr(lightning.Trainer, "fit", lambda trainer, *_, **__: began.append(trainer))
    run = runs_of(*SMALL, f"collection.path={spheres_of_sizes}")
    for keys in ((), [f"trainer.{key}={value}" for key, value in CHOSEN.items()]):
        with pytest.raises(InputError, match="no epoch had a finite"):  # nothing has been trained
            run(*keys)
    plain, chosen = began
    names = ("precision", "gradient_clip_val", "accumulate_grad_batches", "num_devices", "num_nodes")
    assert [getattr(plain, name) for name in names] == ["32-true", None, 1, 1, 1]
    assert [getattr(chosen, name) for name in names] == ["bf16-mixed", 0.5, 4, 2, 3]
    assert isinstance(chosen.strategy, DDPStrategy)
    assert not isinstance(plain.strategy, DDPStrategy)


def test_double_precision_trains_in_double_and_accumulation_takes_fewer_steps(runs_of, spheres_of_sizes, monkeypatch):
    """Two epochs of nine training shapes, three a batch: six steps one by one, two of three batches each."""
    seen, fit = [], lightning.Trainer.fit

    def recorded(trainer, learner, **options):
        fit(trainer, learner, **options)
        seen.append((trainer.global_step, next(learner.parameters()).dtype.itemsize))

    monkeypatch.setattr(lightning.Trainer, "fit", recorded)
    run = runs_of(*SMALL, f"collection.path={spheres_of_sizes}", "data.batch=3")
    run()
    run("trainer.precision=64-true", "trainer.accumulate_grad_batches=3")
    assert seen == [(6, 4), (2, 8)]
