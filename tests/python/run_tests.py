# SPDX-License-Identifier: Apache-2.0
"""Runs all tests beside this file, and says how each went in the lines of GoogleTest, which tests/totals.py counts. As there,
GTEST_FILTER chooses: names with * and :, those after - are left out."""
import fnmatch
import os
import pathlib
import sys
import time
import unittest


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
        super().addError(test, problem)
        self.fail(test, self.errors[-1][1])

    def addSubTest(self, test, part, problem):
        super().addSubTest(test, part, problem)
        if problem:
            self.fail(part, (self.failures + self.errors)[-1][1])

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
    wanted, _, left_out = os.environ.get("GTEST_FILTER", "*").partition("-")
    matches = lambda patterns: any(fnmatch.fnmatchcase(name_of(test), one) for one in patterns.split(":") if one)
    return matches(wanted or "*") and not matches(left_out)


def main():
    here = pathlib.Path(__file__).parent
    sys.path.insert(0, str(here))
    chosen = [test for test in tests_of(unittest.defaultTestLoader.discover(str(here))) if is_chosen(test)]
    print(f"[==========] Running {len(chosen)} tests of the Python package.")
    result = InLinesOfGoogleTest()
    unittest.TestSuite(chosen).run(result)
    print(f"[==========] {result.testsRun} tests ran.")
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
