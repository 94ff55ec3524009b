# SPDX-License-Identifier: Apache-2.0
"""Runs all tests beside this file, and says how each went in the lines of GoogleTest, which tests/totals.py counts. As there,
GTEST_FILTER chooses: names with * and :, those after - are left out. Without TOUCHABLE_PROGRAM: the tests on arrays, of which those
are skipped that open or write files."""
import fnmatch
import os
import pathlib
import re
import sys
import time
import unittest

without_program = "TOUCHABLE_PROGRAM" not in os.environ
# One of them wants a hint that libtouchable-media gives.
on_arrays = ("CamerasAndScenes.*:Documentation.*:ErrorBars.*:Filtering.*:ForcesAt.*:OpenSteps.*:Refusals.*:Surfaces.*"
             "-OpenSteps.test_FirstPictureGetsALine")


def name_of(test):
    return f"{type(test).__name__}.{test._testMethodName}" if hasattr(test, "_testMethodName") else str(test)


class InLinesOfGoogleTest(unittest.TestResult):
    def startTest(self, test):
        super().startTest(test)
        self.word, self.start = "      OK", time.monotonic()
        print(f"[ RUN      ] {name_of(test)}", flush=True)

    def stopTest(self, test):
        super().stopTest(test)
        print(f"[ {self.word} ] {name_of(test)} ({(time.monotonic() - self.start) * 1000:.0f} ms)", flush=True)

    def addFailure(self, test, problem):
        super().addFailure(test, problem)
        self.fail(test, self.failures[-1][1])

    def addError(self, test, problem):
        if self.lacks_media(problem):
            return self.addSkip(test, str(problem[1]))
        super().addError(test, problem)
        self.fail(test, self.errors[-1][1])

    def addSubTest(self, test, part, problem):
        if problem and self.lacks_media(problem):
            return self.addSkip(test, str(problem[1]))
        super().addSubTest(test, part, problem)
        if problem:
            self.fail(part, (self.failures + self.errors)[-1][1])

    def lacks_media(self, problem):
        return without_program and issubclass(problem[0], ImportError) and "libtouchable-media.so.0, which" in str(problem[1])

    def addSkip(self, test, why):
        super().addSkip(test, why)
        print(why)
        self.word = " SKIPPED"

    def fail(self, test, text):
        print(f"{test}\n{text}", flush=True)
        self.word = " FAILED "


def tests_of(suite):
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from tests_of(test)
        else:
            yield test


def is_chosen(test):
    wanted, _, left_out = os.environ.get("GTEST_FILTER", on_arrays if without_program else "*").partition("-")
    matches = lambda patterns: any(fnmatch.fnmatchcase(name_of(test), one) for one in patterns.split(":") if one)
    return matches(wanted or "*") and not matches(left_out) or name_of(test).startswith("_FailedTest.")  # a file that is no Python


def main():
    here = pathlib.Path(__file__).parent
    sys.path.insert(0, str(here))
    chosen = [test for test in tests_of(unittest.defaultTestLoader.discover(str(here))) if is_chosen(test)]
    print(f"[==========] Running {len(chosen)} tests of the Python package.")
    result = InLinesOfGoogleTest()
    unittest.TestSuite(chosen).run(result)
    print(f"[==========] {result.testsRun} tests ran.")
    maps = pathlib.Path("/proc/self/maps")  # in a bare root absent, as is what this looks for
    media = without_program and maps.exists() and re.search("/libav.*", maps.read_text())
    if media or len({id(test) for test, _ in result.skipped}) * 2 >= result.testsRun:
        print(f"loaded {media[0]}" if media else "half of the tests were skipped")
        return 1
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
