"""Where work that goes shape by shape is done: on the cores of this machine, or on a Dask or Ray cluster.

Both are reached through joblib, which `in_parallel` goes by. Every machine of a cluster needs this package, the folder
of the shapes and the folder of the cache, under the same paths.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from joblib import parallel_config
from joblib.parallel import get_active_backend

from lssd_learn.errors import InputError

log = logging.getLogger(__name__)

CONNECTING = 10.0  # seconds after which nobody is thought to answer
BACKENDS = ("local", "dask", "ray")


@contextmanager
def cluster(backend: str, address: str | None = None) -> Iterator[None]:
    """Eigenbases and clouds that are computed inside go to the workers of a cluster.

    In a job that itself runs on a Ray cluster they stay with the job, whose share of it they are.

    Args:
        backend: one of `BACKENDS`; "local" changes nothing.
        address: of a cluster that is there; None starts one on this machine and stops it at the end.

    Raises:
        InputError: another backend, one that is not installed, no cluster at the address.
    """
    if backend not in BACKENDS:
        raise InputError(f"parallel.backend={backend}: expected one of {', '.join(BACKENDS)}")
    if backend == "local":
        if address is not None:
            raise InputError(f"parallel.address={address}: expected parallel=dask or parallel=ray with it")
        yield
        return
    try:
        opened = _dask(address) if backend == "dask" else _ray(address)
    except ModuleNotFoundError as error:
        raise InputError(
            f"parallel={backend}: {error.name} is not installed: pip install 'lssd_learn[{backend}]'"
        ) from None
    with opened:
        yield


def is_on_cluster() -> bool:
    """Whether joblib has been told, by `cluster` or by the user, to go somewhere else than to processes of its own."""
    return type(get_active_backend()[0]).__name__ not in ("LokyBackend", "SequentialBackend")


def _dask(address: str | None):
    from distributed import Client  # pyright: ignore[reportMissingImports] of an extra

    logging.getLogger("distributed").setLevel(logging.ERROR)  # it tells of every worker that comes and goes

    @contextmanager
    def opened() -> Iterator[None]:
        try:
            # One thread a process: no two shapes share the threads of the libraries.
            own = {"threads_per_worker": 1, "dashboard_address": None, "silence_logs": logging.ERROR}
            client = Client(address, **(own if address is None else {"timeout": CONNECTING}))
        except (OSError, ValueError) as error:
            raise InputError(f"parallel.address={address}: no Dask cluster there: {error}") from None
        with client, parallel_config("dask", wait_for_workers_timeout=60):
            log.info("Dask cluster %s, %d workers", client.scheduler.address, len(client.scheduler_info()["workers"]))
            yield

    return opened()


def _ray(address: str | None):
    import ray  # pyright: ignore[reportMissingImports] of an extra
    from ray.util.joblib import register_ray  # pyright: ignore[reportMissingImports]

    @contextmanager
    def opened() -> Iterator[None]:
        if ray.is_initialized():  # by the launcher of a sweep: this is one of its jobs
            yield
            return
        try:
            ray.init(address=address, log_to_driver=False, include_dashboard=False, logging_level=logging.ERROR)
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise InputError(f"parallel.address={address}: no Ray cluster there: {error}") from None
        try:
            register_ray()
            log.info("Ray cluster, %d processors", ray.cluster_resources().get("CPU", 0))
            with parallel_config("ray"):
                yield
        finally:
            ray.shutdown()

    return opened()
