#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles each file of the project by itself, without making code, which takes a third of the time: whether it includes
what it uses, which a module that is compiled as one hides. Warnings are errors."""

import concurrent.futures
import json
import os
import pathlib
import shlex
import subprocess
import sys

BUILD = pathlib.Path(__file__).resolve().parent.parent / "build/file-by-file"


def complaints(unit):
    command = shlex.split(unit["command"])
    at = command.index("-o")
    del command[at:at + 2]
    command[command.index("-c")] = "-fsyntax-only"
    run = subprocess.run(command, cwd=unit["directory"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return run.stdout or f"{unit['file']}: exit code {run.returncode}\n" if run.returncode else ""


subprocess.run(["./run", "build", "file-by-file", "generated_headers"], cwd=BUILD.parent.parent, check=True)
units = json.loads((BUILD / "compile_commands.json").read_text())
wrong = 0
with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as threads:
    for words in threads.map(complaints, units):
        if words:
            wrong += 1
            print(words, flush=True)
print(f"{len(units)} files, {wrong} that do not compile by themselves")
sys.exit(wrong > 0 or not units)
