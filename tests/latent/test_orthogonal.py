import numpy as np
import torch
from scipy.linalg import orthogonal_procrustes

from lssd_learn.latent.orthogonal import nearest_orthogonal


def test_it_is_the_one_of_procrustes_and_many_at_once_are_each_their_own():
    rng = np.random.default_rng(0)
    A, B = (torch.from_numpy(rng.normal(size=(4, 9, 5))) for _ in range(2))
    Q = nearest_orthogonal(A.mT @ B)
    for i in range(4):
        np.testing.assert_allclose(Q[i], orthogonal_procrustes(A[i].numpy(), B[i].numpy())[0], atol=1e-12)
