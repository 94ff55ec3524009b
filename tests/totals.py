#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Adds up tests: totals.py FOLDER SECONDS TEST_PRESET...

Of each preset, FOLDER has CTest's results in PRESET.xml (JUnit), and in PRESET.built the seconds that building took, or "failed". A
CTest test that is a program of GoogleTest is as many tests as it has cases: its output says how each went. A case without an end,
as after a crash, has failed. SECONDS is how long everything took. The exit code is 1 if something failed."""
import pathlib
import re
import sys
import xml.etree.ElementTree as xml


class Totals:
    def __init__(self):
        self.passed = self.failed = self.skipped = 0
        self.failures = []

    def add(self, test):
        output = test.findtext("system-out") or ""
        cases = sum(int(count) for count in re.findall(r"^\[==========\] Running (\d+) tests?\b", output, re.M))
        passed = len(re.findall(r"^\[       OK \]", output, re.M))
        skipped = len(re.findall(r"^\[  SKIPPED \] .* ms\)$", output, re.M))
        failed = cases - passed - skipped
        named = re.findall(r"^\[  FAILED  \] (.*?),? .*\(\d+ ms\)$", output, re.M)
        status, reason = test.get("status"), test.find("skipped")
        if not cases:
            passed, skipped = status == "run", reason is not None and reason.get("message", "").startswith("SKIP_")
        if status != "run" and not failed and (cases or not skipped):
            failed = 1  # CTest's own, such as a program that is missing, or a leak after the last case
        self.passed += passed
        self.failed += failed
        self.skipped += skipped
        if failed:
            self.failures.append(f"{test.get('name')}: {', '.join(named) or 'see above'}")


def main(folder, seconds, *presets):
    everything = Totals()
    for preset in presets:
        built, results = (pathlib.Path(folder, preset + ending) for ending in (".built", ".xml"))
        building = built.read_text().strip() if built.exists() else "0"
        of_preset, testing = Totals(), 0
        if results.exists():
            root = xml.parse(results).getroot()
            testing = float(root.get("time") or 0)
            for test in root.iter("testcase"):
                of_preset.add(test)
            tests = of_preset.passed + of_preset.failed + of_preset.skipped
            if not tests:
                of_preset.failed = 1
            print(f"{preset:24} {tests:5} tests, {of_preset.failed} failed, {of_preset.skipped} skipped; "
                  f"building {building:>4} s, testing {testing:4.0f} s")
        else:
            of_preset.failed = 1
            print(f"{preset:24} " + ("does not build" if building == "failed" else "no test was run"))
        everything.passed += of_preset.passed
        everything.failed += of_preset.failed
        everything.skipped += of_preset.skipped
        everything.failures += [f"{preset}: {failure}" for failure in of_preset.failures]
    for failure in everything.failures:
        print("failed:", failure)
    print(f"{everything.passed} passed, {everything.failed} failed, {everything.skipped} skipped; {seconds} s")
    return everything.failed > 0 or everything.passed == 0


if __name__ == "__main__":
    print("\n== summary")
    sys.exit(main(*sys.argv[1:]))
