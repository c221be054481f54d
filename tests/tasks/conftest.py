import json

import pytest


@pytest.fixture
def leave_run(tmp_path):
    """A function that leaves what a run leaves: its overrides, and metrics or an error line."""

    def make(name, overrides, metrics, error=None):
        folder = tmp_path / name
        (folder / ".hydra").mkdir(parents=True)
        (folder / ".hydra" / "overrides.yaml").write_text("\n".join(f"- {line}" for line in overrides) + "\n")
        if metrics is not None:
            (folder / "metrics.json").write_text(json.dumps(metrics))
        if error is not None:
            (folder / "error.txt").write_text(error)
        return folder

    return make
