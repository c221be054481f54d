"""The package of the parametric body, which is an extra: half a gigabyte that a folder of scans does not need."""

from importlib.metadata import PackageNotFoundError, version

from lssd_learn.errors import InputError


def body_package_version() -> str:
    """The version of anny that is installed.

    Raises:
        InputError: none; says how to get it.
    """
    try:
        return version("anny")
    except PackageNotFoundError:
        raise InputError(
            "collection: generated bodies and faces need the body model: pip install 'lssd_learn[bodies]', in a "
            "checkout pip install -e '.[bodies]'; shapes of one's own (collection=folder) do not"
        ) from None
