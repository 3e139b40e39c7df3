"""Builds the wheel for `pip install .` with CMake (PEP 517), and needs no package that Debian 12 lacks.

Options, as `pip install . --config-settings NAME=VALUE`:
  build-dir  CMake's folder, default build/python; build/release reuses what is compiled there
"""

import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

_ROOT = Path(__file__).resolve().parent.parent


def _project(field):
    """A text of [project] in pyproject.toml, which Python 3.9 has no parser for."""
    return re.search(rf'^{field} = "(.*)"$', (_ROOT / "pyproject.toml").read_text(), re.MULTILINE).group(1)


def _metadata():
    return (
        f"Metadata-Version: 2.1\nName: {_project('name')}\nVersion: {_project('version')}\n"
        f"Summary: {_project('description')}\nRequires-Python: {_project('requires-python')}\nRequires-Dist: numpy\n"
    )


def _compile(build, installed):
    if (build / "CMakeCache.txt").exists():
        configure = ["cmake", build]
    else:
        configure = ["cmake", "--preset", "release", "-B", build, "-DDUALPIXEL_TESTS=OFF"]
    # pip hides the system's packages from Python here; CMake asks for them, and its folder may be one that is used again
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    subprocess.run([*configure, f"-DPython3_EXECUTABLE={sys.executable}"], cwd=_ROOT, env=env, check=True)
    subprocess.run(["cmake", "--build", build, "--target", "dualpixel_python"], env=env, check=True)
    subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", installed, "--strip"], check=True)


def get_requires_for_build_wheel(config_settings=None):
    return []


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name, version = _project("name"), _project("version")
    tag = sysconfig.get_config_var("SOABI").split("-")[1]  # cpython-311-x86_64-linux-gnu
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    info = f"{name}-{version}.dist-info"
    wheel = f"{name}-{version}-cp{tag}-cp{tag}-{platform}.whl"
    files = {
        f"{info}/METADATA": _metadata().encode(),
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: {name}\nRoot-Is-Purelib: false\nTag: cp{tag}-cp{tag}-{platform}\n".encode(),
    }
    with tempfile.TemporaryDirectory() as folder:
        _compile(_ROOT / (config_settings or {}).get("build-dir", "build/python"), folder)
        for path in sorted(Path(folder).rglob("*")):
            if path.is_file():
                files[path.relative_to(folder).as_posix()] = path.read_bytes()
    record = ""
    with zipfile.ZipFile(Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            archive.writestr(path, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record += f"{path},sha256={digest},{len(data)}\n"
        archive.writestr(f"{info}/RECORD", f"{record}{info}/RECORD,,\n")
    return wheel
