"""Which weights are kept: the best on validation, also up to each milestone."""

from types import SimpleNamespace

import torch

from lssd_learn.learning.best import BestWeights


class Weight(torch.nn.Module):
    """One number, and what a LightningModule has beside it."""

    hparams: dict = {}

    def __init__(self):
        super().__init__()
        self.number = torch.nn.Parameter(torch.zeros(()))


def test_a_milestone_keeps_the_best_so_far_and_not_the_last(tmp_path):
    kept = BestWeights("loss", tmp_path / "best.ckpt", milestones=[2, 4])
    trainer = SimpleNamespace(
        sanity_checking=False, is_global_zero=True, current_epoch=0, callback_metrics={},
        strategy=SimpleNamespace(barrier=lambda: None),
    )  # fmt: skip
    module = Weight()
    kept.on_fit_start(trainer, module)
    for epoch, loss in enumerate([3.0, 4.0, 1.0, 2.0, 5.0]):
        trainer.current_epoch, trainer.callback_metrics = epoch, {"loss": loss}
        with torch.no_grad():
            module.number.fill_(loss)
        kept.on_train_epoch_end(trainer, module)
    kept.on_fit_end(trainer, module)
    file = torch.load(tmp_path / "best.ckpt", weights_only=True)
    assert (file["epoch"], file["value"], float(file["state_dict"]["number"])) == (3, 1.0, 1.0)
    found = {m: (entry["epoch"], float(entry["weights"]["number"])) for m, entry in file["milestones"].items()}
    assert found == {2: (1, 3.0), 4: (3, 1.0)}
