"""Learning from operators or clouds: data, split, training and the references a net has to beat.

data = ShapeData(area.unsqueeze(1), parameters, split=split(n, seed), seed=seed)
metrics = fit(nets.CNN, data, epochs=500, learning_rate=0.007, seed=seed, out="outputs/cnn")
regression = load("outputs/cnn/best.ckpt", nets.CNN)
"""

from lssd_learn.division.split import Split, split
from lssd_learn.learning.checkpoint import load
from lssd_learn.learning.classification import Classification
from lssd_learn.learning.datamodule import ShapeData
from lssd_learn.learning.evaluation import evaluate, predict
from lssd_learn.learning.fit import fit
from lssd_learn.learning.module import Learner
from lssd_learn.learning.reconstruction import Reconstruction, VertexReconstruction
from lssd_learn.learning.references.classes import ClassReference, linear_reference, majority_reference
from lssd_learn.learning.references.parameters import Reference, mean_reference, operator_features, ridge_reference
from lssd_learn.learning.regression import Regression

__all__ = [
    "ClassReference",
    "Classification",
    "Learner",
    "Reconstruction",
    "Reference",
    "Regression",
    "ShapeData",
    "Split",
    "VertexReconstruction",
    "evaluate",
    "fit",
    "linear_reference",
    "load",
    "majority_reference",
    "mean_reference",
    "operator_features",
    "predict",
    "ridge_reference",
    "split",
]
