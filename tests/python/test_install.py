"""`pip install .`: a wheel that can be imported from elsewhere."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
def test_pip_installs_the_package(tmp_path):
    if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True, check=False).returncode:
        pytest.skip("pip is not installed (python3-pip)")
    build = Path(os.environ["DUALPIXEL_BUILD_DIR"])
    subprocess.run(
        [sys.executable, "-m", "pip", "install", ".", "--no-index", "--no-deps", "--target", tmp_path / "site",
         "--config-settings", f"build-dir={build}"],
        cwd=ROOT, check=True, capture_output=True,
    )
    done = subprocess.run(
        [sys.executable, "-c", "import dualpixel; print(dualpixel.__file__); print(dualpixel.simulate.__doc__)"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path / "site")}, capture_output=True, text=True, check=True,
    )
    assert done.stdout.startswith(str(tmp_path / "site"))
    for name in ("py.typed", "_core.pyi"):
        assert (tmp_path / "site/dualpixel" / name).exists()
    # the build that it was made from keeps its Python tests
    assert "python.fast" in (build / "tests/CTestTestfile.cmake").read_text()
