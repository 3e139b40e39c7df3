#!/usr/bin/env python3
"""Runs clang-tidy on files; those of one target as one file, since headers take most of the time.

    tools/lint.py BUILD FILE...        (BUILD: a build folder in this tree, without unity build)

Where such a file has a fault, its parts are linted by themselves, and they decide. Status 1 where anything is found.
"""

import concurrent.futures
import json
import os
import pathlib
import shlex
import subprocess
import sys

MOST = 16  # files at once; more take more memory


def compiles_alone(entry):
    """Whether it includes what it uses, which a file of several does not show."""
    arguments = shlex.split(entry["command"])
    at = arguments.index("-o")
    return subprocess.run([*arguments[:at], "-fsyntax-only", *arguments[at + 2:]], cwd=entry["directory"]).returncode == 0


def lint(build, number, entries):
    files = [entry["file"] for entry in entries]
    checks = ["--checks=-clang-analyzer-*"] if os.path.relpath(files[0]).startswith("tests/") else []  # tests/.clang-tidy

    def tidy(database, file):
        return subprocess.run(["clang-tidy", "-p", database, "--quiet", "--warnings-as-errors=*", *checks, file],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    if len(files) > 1:
        folder = pathlib.Path(build, "lint", str(number)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        together = str(folder / "together.cpp")
        # Not by #include: clang's analyzer follows paths in the main file alone.
        parts = (f'#line 1 "{file}"\n{pathlib.Path(file).read_text()}\n' for file in files)
        pathlib.Path(together).write_text("".join(parts))
        entry = entries[0] | {"file": together, "command": entries[0]["command"].replace(files[0], together)}
        (folder / "compile_commands.json").write_text(json.dumps([entry]))
        if all(compiles_alone(entry) for entry in entries) and tidy(folder, together).returncode == 0:
            return True
    results = [tidy(build, file) for file in files]
    sys.stdout.write("".join(result.stdout for result in results if result.returncode))
    return not any(result.returncode for result in results)


def main(build, *files):
    wanted = {os.path.realpath(file) for file in files}
    targets = {}  # files by the flags that they share
    for entry in json.loads(pathlib.Path(build, "compile_commands.json").read_text()):
        if entry["file"] in wanted:
            target = entry["command"].split(" -o ")[0]
            targets.setdefault(target, []).append(entry)
    groups = [group[i:i + MOST] for group in targets.values() for i in range(0, len(group), MOST)]
    missing = wanted - {entry["file"] for group in groups for entry in group}
    groups += [[{"file": file}] for file in sorted(missing)]  # clang-tidy takes the flags of the nearest file
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        clean = list(pool.map(lambda i: lint(build, i, groups[i]), range(len(groups))))
    sys.exit(0 if all(clean) else 1)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
