# SPDX-License-Identifier: Apache-2.0
import collections
import csv
import html
import importlib.util
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy
import touchable
from common import globe, longest_s, made, run, source

many_s = 10 * longest_s  # workers start and die on a busy machine
program = os.environ.get("TOUCHABLE_PROGRAM")
with_workers = unittest.skipUnless(importlib.util.find_spec("distributed"), "Debian: python3-distributed is missing")

# Stands before the program: notes which recording it is called for, and by which worker.
before_the_program = f"""#!/bin/bash
echo "$2" $PPID >> "$NOTES"
case $2 in
    */killed.mkv) mkdir "$NOTES.killed" 2>/dev/null && kill -KILL $PPID ;;
    */deadly.mkv) kill -KILL $PPID ;;
    */slow.mkv) [[ -p $NOTES.slow ]] && read -r < "$NOTES.slow" ;;
esac
exec '{program}' "$@"
"""


def command_of(*arguments):
    return [sys.executable, str(source / "examples/python/many_recordings.py"), *map(str, arguments)]


class ManyRecordings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.clips, self.out = self.folder / "clips", self.folder / "out"
        self.clips.mkdir()
        self.noting, self.notes = self.folder / "noting", self.folder / "notes"
        self.noting.write_text(before_the_program)
        self.noting.chmod(0o755)
        self.environment = {**os.environ, "NOTES": str(self.notes)}

    def run_all(self, *arguments, status=0):
        done = subprocess.run(command_of(*arguments, "--out", self.out), capture_output=True, text=True, timeout=many_s,
                              env=self.environment)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertNotIn("Traceback", done.stderr.partition("Process Dask Worker")[0])  # at its end dask says more than it should
        return done.stdout if status == 0 else done.stderr

    def rows(self, file="recordings.csv"):
        with open(self.out / file, newline="") as lines:
            rows = list(csv.DictReader(lines))
        named = {os.path.relpath(row["recording"], self.clips) if "recording" in row else row["seed"]: row for row in rows}
        self.assertEqual(len(named), len(rows), "a row each")
        for row in rows:
            self.assertNotIn(None, [*row, *row.values()])
        return named

    def noted(self):
        """Which workers called the program for each recording."""
        calls = collections.defaultdict(list)
        for line in self.notes.read_text().splitlines():
            path, worker = line.rsplit(" ", 1)
            calls[os.path.relpath(path, self.clips)].append(worker)
        self.notes.unlink()
        return calls

    @with_workers
    def test_EachFileHasRow(self):
        plane = numpy.full((96, 128), 500, numpy.uint16)
        plane[:12] = 0
        awkward = "a <b>&\"quoted\", and\na line.mkv"
        touchable.write(self.clips / awkward, [plane] * 4, camera=touchable.Camera(128, 96, fx_px=128.0))
        (self.clips / "cut.mkv").write_bytes(pathlib.Path(globe()).read_bytes()[:3000])
        (self.clips / "notes.txt").write_text("no recording")
        (self.clips / ".hidden.mkv").write_text("")
        (self.clips / "self").symlink_to("self")
        (self.clips / "deeper").mkdir()
        shutil.copy(globe(), self.clips / "deeper/globe.mkv")
        run("convert", globe(), self.clips / "pictures")
        self.out = self.clips / "out"  # is not looked at
        said = self.run_all(self.clips, "--workers", 1, "--program", program)
        self.assertIn("6 of 6 recordings are to be done", said)
        rows = self.rows()
        self.assertEqual(set(rows), {awkward, "cut.mkv", "notes.txt", "deeper/globe.mkv", "pictures", "self"})
        self.assertRegex(rows["cut.mkv"]["error"], "^is truncated")
        self.assertRegex(rows["notes.txt"]["error"], "^is of no kind that is known")
        self.assertRegex(rows["self"]["error"], "symbolic links")
        touched = rows[awkward]
        self.assertEqual(touched["error"], "")
        self.assertEqual([touched[name] for name in ("width", "height", "frames")], ["128", "96", "4"])
        self.assertEqual(float(touched["holes_percent"]), 12.5)
        self.assertEqual(float(touched["contact_percent"]), 80)  # the fingers come down in a fifth of the time
        self.assertAlmostEqual(float(touched["force_n_median"]), 3, delta=0.3)  # 5 mm of 0.6 N/mm, and friction
        self.assertLess(0, float(touched["error_degrees_median"]))
        self.assertLess(float(touched["error_degrees_median"]), 2)
        facts = json.loads(run("info", globe(), "--json"))
        for name in "deeper/globe.mkv", "pictures":
            self.assertEqual(rows[name]["verdict"].partition(":")[0], facts["verdict"].partition(":")[0])
            self.assertEqual(rows[name]["filters"], "none")
            self.assertAlmostEqual(float(rows[name]["roughness_mm"]), facts["filters"]["measured"]["roughness"], delta=1e-6)
            self.assertEqual(rows[name]["force_hash"], rows["pictures"]["force_hash"])
        page = (self.out / "recordings.html").read_text()
        self.assertIn("6 recordings: 3 done, 3 with an error.", page)
        self.assertIn(html.escape(awkward), page)
        self.assertNotIn("<b>", page)
        self.assertNotRegex(page, "https?:|src=|<script|<link")

    @with_workers
    def test_WhatIsDoneStays(self):
        for name in "a.mkv", "b.mkv":
            shutil.copy(globe(), self.clips / name)
        (self.clips / "cut.mkv").write_bytes(b"")
        self.run_all(self.clips, "--workers", 1, "--program", self.noting)
        self.assertEqual({name: len(workers) for name, workers in self.noted().items()}, {"a.mkv": 1, "b.mkv": 1, "cut.mkv": 1})
        table = self.out / "recordings.csv"
        whole = table.read_bytes()
        for cut in b"", b"\"" + os.fsencode(self.clips) + b"/torn, and", whole.splitlines(True)[1][:-2]:
            table.write_bytes(whole + cut)
            self.assertIn("0 of 3 recordings are to be done", self.run_all(self.clips, "--program", self.noting))
            self.assertEqual(table.read_bytes(), whole)
        header, row, *others = whole.splitlines(True)
        table.write_bytes(b"".join((header, b"abc".join(re.split(rb"(?<=,)[0-9.]+(?=,tcp)", row)), *others)))
        self.assertIn("1 of 3 recordings are to be done", self.run_all(self.clips, "--workers", 1, "--program", program))
        shutil.copy(made("plane", "--frames", "3", "--size", "64x48"), self.clips / "b.mkv")
        shutil.copy(globe(), self.clips / "c.mkv")
        said = self.run_all(self.clips, "--workers", 1, "--program", self.noting, "--retry")
        self.assertIn("3 of 4 recordings are to be done", said)
        self.assertEqual(set(self.noted()), {"b.mkv", "c.mkv", "cut.mkv"})
        rows = self.rows()
        self.assertEqual([rows[name]["width"] for name in ("a.mkv", "b.mkv", "c.mkv", "cut.mkv")], ["160", "64", "160", ""])
        self.assertIn("4 of 4", self.run_all(self.clips, "--workers", 1, "--program", program, "--seconds", 0.1))

    @with_workers
    def test_DeadWorkersWorkIsDoneAgain(self):
        for name in "a.mkv", "b.mkv", "c.mkv", "d.mkv", "deadly.mkv", "killed.mkv", "z.mkv":
            shutil.copy(globe(), self.clips / name)
        self.run_all(self.clips, "--workers", 2, "--program", self.noting)
        rows, calls = self.rows(), self.noted()
        self.assertEqual({name: len(workers) for name, workers in calls.items()},
                         {"a.mkv": 1, "b.mkv": 1, "c.mkv": 1, "d.mkv": 1, "deadly.mkv": 4, "killed.mkv": 2, "z.mkv": 1})
        for name in "deadly.mkv", "killed.mkv":
            self.assertEqual(len(set(calls[name])), len(calls[name]), "by another worker each time")
        self.assertEqual({name: row["error"] for name, row in rows.items() if row["error"]},
                         {"deadly.mkv": "its worker died 4 times"})
        self.assertEqual(rows["killed.mkv"]["force_hash"], rows["a.mkv"]["force_hash"])

    @with_workers
    def test_InterruptedRunGoesOn(self):
        shutil.copy(globe(), self.clips / "a.mkv")
        shutil.copy(globe(), self.clips / "slow.mkv")
        slow = f"{self.notes}.slow"
        os.mkfifo(slow)
        arguments = self.clips, "--workers", 1, "--program", self.noting
        with subprocess.Popen(command_of(*arguments, "--out", self.out), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True, start_new_session=True, env=self.environment) as begun:
            try:
                self.assertRegex(begun.stdout.readline(), "2 of 2 recordings are to be done")
                self.assertRegex(begun.stdout.readline(), "a.mkv: done")
                with open(slow, "w"):  # opens once slow.mkv is being done, which then waits for a line
                    self.assertRegex(self.run_all(*arguments, status=1), "another run is writing to .*/out")
                    os.killpg(begun.pid, signal.SIGINT)  # as the terminal's Ctrl-C
                    stderr = begun.communicate(timeout=many_s)[1]
            finally:
                begun.kill()
        self.assertEqual(begun.returncode, 1)
        self.assertRegex(stderr, "stopped; the same command goes on where this one ended")
        self.assertEqual(set(self.rows()), {"a.mkv"})
        os.remove(slow)
        self.run_all(*arguments)
        self.assertEqual({name: row["error"] for name, row in self.rows().items()}, {"a.mkv": "", "slow.mkv": ""})
        self.assertEqual(len(self.noted()["a.mkv"]), 1)

    @with_workers
    def test_ClusterOpensClipsAndSoaksSeeds(self):
        import distributed

        soak = self.folder / "touchable-soak"
        soak.write_text("#!/bin/bash\n[[ $* == --list ]] && printf 'one: x\\ntwo: y\\n\\nscenes: z\\n' && exit\n"
                        "echo \"contact; certified $4 (way), compared 2 (basins)\"; echo force_hash $2$4$6\n"
                        "[[ $2$4 == two8 ]] && echo 'touchable-soak: 3 violations' >&2 && exit 1\n"
                        "[[ $2$4 != one7 ]] || { echo 'touchable-soak: the run is empty: no contact' >&2; exit 3; }")
        soak.chmod(0o755)
        with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            with distributed.Client(cluster) as client, touchable.open(globe()) as clip:
                elsewhere = client.submit(lambda clip: (os.getpid(), clip[3].depth.sum()), clip).result(timeout=many_s)
                self.assertNotEqual(elsewhere[0], os.getpid())
                self.assertEqual(elsewhere[1], clip[3].depth.sum())
            self.run_all("--soak", "6-8", "--program", soak, "--ticks", 50, "--cluster", cluster.scheduler_address)
            shutil.copy(globe(), self.clips / "a.mkv")
            shutil.copy(globe(), self.clips / "b.mkv")
            self.run_all(self.clips, "--program", program, "--cluster", cluster.scheduler_address)
            self.assertRegex(self.run_all(self.clips, "--program", "/nowhere/touchable", "--cluster", cluster.scheduler_address,
                                          "--seconds", 2, status=1), "has no program /nowhere/touchable; install touchable")
        rows = self.rows("soak.csv")
        self.assertEqual({seed: (row["error"], row["empty_suites"], row["ticks_certified"], row["ticks_compared"])
                          for seed, row in rows.items()},
                         {"6": ("", "", "12", "4"), "7": ("", "one: the run is empty: no contact", "7", "2"),
                          "8": ("two: 3 violations", "", "8", "2")})
        self.assertEqual(len({row["force_hashes"] for row in rows.values()}), 3)
        self.assertEqual(len({row["force_hash"] for row in self.rows().values()}), 1)

    @with_workers
    def test_SoakTakesStressProgram(self):
        soak = pathlib.Path(program).parents[1] / "tests/stress/touchable-soak"
        self.run_all("--soak", "1", "--program", soak, "--ticks", 1000, "--workers", 1)
        row = self.rows("soak.csv")["1"]
        self.assertEqual(row["error"], "")
        self.assertGreater(int(row["ticks_certified"]), 10000)
        self.assertGreater(int(row["ticks_compared"]), 1000)

    def test_RefusesInOneLine(self):
        for words, arguments in {
            "give a FOLDER of recordings, or --soak SEEDS": [], "nowhere": ["/nowhere"], "'1-': must be a seed": ["--soak", "1-"],
            "'5-3': must be a seed": ["--soak", "5-3"], "'0-1000000': must be": ["--soak", "0-1000000"],
            "--workers 0": [self.clips, "--workers", "0"], "--seconds nan": [self.clips, "--seconds", "nan"],
        }.items():
            done = subprocess.run(command_of(*arguments, "--out", self.out), capture_output=True, text=True, timeout=longest_s)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(words, done.stderr.splitlines()[-1])

    def test_WithoutDaskNamesPackage(self):
        (self.clips / "a.mkv").write_text("")
        done = subprocess.run([sys.executable, "-c", "import runpy, sys\nsys.modules['distributed'] = None\n"
                               "sys.argv = sys.argv[1:]\nrunpy.run_path(sys.argv[0], run_name='__main__')",
                               *command_of(self.clips, "--out", self.out)[1:]], capture_output=True, text=True, timeout=longest_s)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "^many_recordings.py: dask.distributed is missing: apt install python3-distributed\n$")


if __name__ == "__main__":
    unittest.main()
