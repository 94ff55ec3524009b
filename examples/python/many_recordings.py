#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Quality, filters, forces and their error bars of a folder of recordings, one by one on many processes or machines.

    many_recordings.py FOLDER --out DIR                                this machine, a process for each core
    many_recordings.py FOLDER --out DIR --cluster tcp://HOST:8786      the workers of a dask cluster
    many_recordings.py --soak 0-99 --program build/release/tests/stress/touchable-soak --out DIR

Each file in FOLDER gets a row in DIR/recordings.csv, and so does each folder that opens as one recording (pictures); in
other folders it looks further. Where something does not open, its row says why. DIR/recordings.html sums the rows up.

A row is there as soon as its recording is done. After Ctrl-C, or a fault, the same command does what has no row yet, or
was changed since. When a worker dies, another one does its recording again, three times at most; then a row says so.

Workers need touchable, the program `touchable` and, at the same paths, the recordings. --soak does the same for seeds of
the solver's stress suites. Needs dask.distributed: apt install python3-distributed.
"""
import argparse
import collections
import concurrent.futures
import contextlib
import csv
import fcntl
import functools
import hashlib
import html
import io
import itertools
import json
import logging
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

import numpy
import touchable

name = pathlib.Path(__file__).name
repeats = 3  # of what was in a worker that died
fingers_across, press_m = 4, 0.005  # a grid of fingers, each that far into the surface, metres of the hand

Columns = collections.namedtuple("Columns", "kind text figures")
recordings = Columns("recording", ("verdict", "filters", "force_hash"), (
    "width", "height", "frames", "frames_per_second", "noise_mm", "roughness_mm", "holes_percent", "tiny_holes_percent",
    "dropouts_percent", "contact_percent", "limited_percent", "force_n_mean", "force_n_median", "force_n_95", "force_n_most",
    "error_degrees_median", "error_degrees_95", "error_newtons_median", "error_newtons_95"))
seeds = Columns("seed", ("empty_suites", "force_hashes"), ("ticks_certified", "ticks_compared"))
filters = "flying_pixels", "fill_holes", "median", "temporal", "terraces"
worst_at_the_top = ("noise_mm", "holes_percent", "dropouts_percent", "limited_percent", "error_degrees_95",
                    "error_newtons_95", "seconds")


# --- What a worker does


def said(*command):
    """What a program prints. Raises RuntimeError with its last line and `status` where it fails."""
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", start_new_session=True)
    if done.returncode:
        *_, line = done.stderr.splitlines() or [f"{command[0]} ended with {done.returncode}"]
        if done.returncode < 0:
            line = f"{command[0]} was ended by signal {-done.returncode}"
        problem = RuntimeError(re.sub("^touchable[a-z-]*: ", "", line))
        problem.status = done.returncode
        raise problem
    return done.stdout


def quality_of(facts):
    """Columns of what `touchable info --json` says."""
    measured, mm = facts["filters"].get("measured", {}), 1000 * facts["metres_per_unit"]
    scaled = lambda name, by: measured.get(name, math.nan) * by
    chosen = [one for one in filters if numpy.any(facts["filters"][one])]
    return {"verdict": facts["verdict"], "filters": ", ".join(chosen) or "none", "width": facts["width"], "height": facts["height"],
            "frames": facts["frames"], "noise_mm": scaled("noise_at_median", mm),
            "roughness_mm": scaled("roughness", mm), "holes_percent": facts["first_frame"]["invalid_pct"],
            "tiny_holes_percent": scaled("tiny_holes", 100), "dropouts_percent": scaled("dropouts", 100)}


def press_and_wipe(surface, ticks):
    """A path over the surface's first picture, (ticks, fingers, 3): a grid of fingers presses, and wipes to the right."""
    scene, depth = surface.scene, surface.first_metres
    if not numpy.isfinite(depth).any():
        raise ValueError("the first frame has no surface to be touched")
    depth = numpy.where(numpy.isfinite(depth), depth, numpy.nanmedian(depth))
    middles = (numpy.arange(fingers_across) + 0.5) / fingers_across
    column, row = (numpy.ravel(grid) for grid in numpy.meshgrid(middles * scene.width, middles * scene.height))
    share = numpy.linspace(0, 1, ticks)[:, None]
    x = column + numpy.clip(share - 0.4, 0, 1) * scene.width / fingers_across / 2
    y = numpy.broadcast_to(row, x.shape)
    deep_m = press_m / surface.hand_metres_per_scene_unit * scene.metres_per_scene_unit
    return scene.points(x, y, depth[y.astype(int), x.astype(int)] + deep_m * numpy.clip(5 * share - 1, -1, 1))


def forces_of(touched):
    """Columns of what the fingers met."""
    contact = touched.touching
    columns = {"contact_percent": 100 * contact.mean(), "force_hash": touched.force_hash,
               "limited_percent": 100 * ((touched.guard & (touchable.Guard.FORCE | touchable.Guard.STIFFNESS)) != 0).mean()}
    force = numpy.linalg.norm(touched.force_n, axis=-1)[contact]
    if len(force):
        columns |= {"force_n_mean": force.mean(), "force_n_median": numpy.median(force),
                    "force_n_95": numpy.percentile(force, 95), "force_n_most": force.max()}
    for error in "error_degrees", "error_newtons":  # of direction and size, with 95 % confidence; NaN: unknown
        known = getattr(touched, error)[contact]
        known = known[numpy.isfinite(known)]
        if len(known):
            columns |= {error + "_median": numpy.median(known), error + "_95": numpy.percentile(known, 95)}
    return columns


def of_recording(program, verify, seconds, path):
    """The columns of a recording. `info` comes first: a file that crashes a reader crashes it, and not the worker."""
    columns = quality_of(json.loads(said(program, "info", path, "--json", *["--verify"] * verify)))
    with touchable.open(path, colour=False) as clip:
        columns["frames_per_second"] = clip.frames_per_second
        with touchable.Surface(clip[0], clip.touched_scene) as surface:
            goals = press_and_wipe(surface, round(1000 * seconds))
        return columns | forces_of(clip.touch(goals, error_bars=True))


def of_seed(program, suites, ticks, seed):
    """The columns of all stress suites with a seed."""
    told, empty, faults = "", [], []
    for suite in suites:
        try:
            told += said(program, "--suite", suite, "--seed", seed, *["--ticks", str(ticks)] * bool(ticks))
        except RuntimeError as problem:  # 3: a run that meets with nothing proves nothing, and is no fault
            (empty if problem.status == 3 else faults).append(f"{suite}: {problem}")
    ticks_that_were = lambda word: sum(map(int, re.findall(word + r" (\d+)", told)))
    return {"error": "; ".join(faults), "empty_suites": "; ".join(empty), "ticks_certified": ticks_that_were("certified"),
            "ticks_compared": ticks_that_were("compared"),
            "force_hashes": hashlib.sha256("".join(re.findall("force_hash .*", told)).encode()).hexdigest()[:16]}


def timed(work, what):
    """The columns that `work` gives for `what`, or its error in a line, and who took how long for it."""
    from distributed import get_worker

    begin = time.monotonic()
    try:
        columns = work(what)
    except Exception as problem:
        line = f"{problem}" if isinstance(problem, (touchable.Error, RuntimeError)) else f"{type(problem).__name__}: {problem}"
        columns = {"error": " ".join(line.removeprefix(f"{what}: ").split())}
    return columns | {"seconds": time.monotonic() - begin, "worker": get_worker().address}


def facilities(program):
    """What of touchable a worker has."""
    import touchable  # here, so that a worker without it says so

    return touchable.__version__, shutil.which(program)


# --- What is to be done


def recordings_in(folder, left_out):
    """Absolute paths of the files and of the folders that open, sorted; other folders are searched."""
    for entry in sorted(os.scandir(folder), key=lambda entry: entry.name):
        if entry.name.startswith(".") or entry.path in left_out:
            continue
        try:
            is_one = entry.is_file() or (entry.is_dir() and opens(entry.path))
            inside = [] if is_one or not entry.is_dir(follow_symlinks=False) else recordings_in(entry.path, left_out)
            yield from [entry.path] if is_one else inside
        except OSError:  # a link to itself, or a folder that may not be read: its row says so
            yield entry.path


def opens(path):
    try:
        touchable.open(path, colour=False).close()
    except touchable.Error:
        return False
    return True


def stamp_of(path):
    """What tells that a file, or one in a folder, was changed: their size and the last change's nanosecond."""
    inside = [os.path.join(folder, file) for folder, _, files in os.walk(path) for file in files]
    states = [os.stat(file) for file in inside or [path] if os.path.exists(file)]
    return f"{sum(state.st_size for state in states)} bytes of {max((state.st_mtime_ns for state in states), default=0)} ns"


def suites_of(program):
    return [line.partition(":")[0] for line in itertools.takewhile(str.strip, said(program, "--list").splitlines())]


def seeds_of(first_and_last):
    """Seeds of a range such as 0-99."""
    match = re.fullmatch(r"(\d{1,19})(?:-(\d{1,19}))?", first_and_last)
    first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
    if not 0 <= last - first < 1_000_000:
        raise argparse.ArgumentTypeError(
            f"{first_and_last!r}: must be a seed, or the first and the last of up to a million: 0-99")
    return [str(seed) for seed in range(first, last + 1)]


# --- The table, which is good at every moment


class Table:
    """A CSV file to which rows are added, whole or not at all. One process at a time has it."""

    def __init__(self, path, columns):
        self.path = path
        self.header = [columns.kind, "stamp", "error", *columns.text, *columns.figures, "seconds", "worker"]
        self.lock = os.open(path.parent, os.O_RDONLY)
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            sys.exit(f"{name}: another run is writing to {path.parent}; wait for it, or give another --out")
        text = path.read_bytes().decode(errors="surrogateescape") if path.exists() else ""
        reader = csv.DictReader(io.StringIO(text[: text.rfind("\n") + 1], newline=""))  # without a row that was cut off
        try:
            if reader.fieldnames not in (None, self.header):
                sys.exit(f"{name}: {path} has other columns, of another version; give another --out")
            self.rows = {row[columns.kind]: row for row in reader if self.is_whole(row, columns)}
        except csv.Error as fault:
            sys.exit(f"{name}: {path} cannot be read: {fault}; give another --out")

    @staticmethod
    def is_whole(row, columns):
        try:
            return None not in row and None not in row.values() and all(
                math.isfinite(float(row[figure] or 0)) for figure in (*columns.figures, "seconds"))
        except ValueError:
            return False

    def keep(self, wanted):
        """Drops the rows that are not `wanted`; others may then be added."""
        self.rows = {what: row for what, row in self.rows.items() if wanted(row)}
        lines = [self._line(self.header), *(self._line(row.values()) for row in self.rows.values())]
        replace(self.path, "".join(lines))
        self.file = os.open(self.path, os.O_WRONLY | os.O_APPEND)

    def add(self, columns):
        row = {column: shown(columns.get(column)) for column in self.header}
        line = self._line(row.values()).encode(errors="surrogateescape")
        if os.write(self.file, line) != len(line):
            raise OSError(f"{self.path}: no room for another row")
        os.fsync(self.file)
        self.rows[row[self.header[0]]] = row
        return row

    def _line(self, values):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerow(values)
        return text.getvalue()


def shown(value):
    """A value of a row as text; of what is unknown none."""
    if isinstance(value, (float, numpy.floating)):
        return f"{value:.6g}" if math.isfinite(value) else ""
    return "" if value is None else str(value)


def replace(path, text):
    """Writes a file that appears whole."""
    fresh = path.with_name(path.name + ".new")
    fresh.write_bytes(text.encode(errors="surrogateescape"))
    os.replace(fresh, path)


# --- The work


def columns_as_done(client, work, whats):
    """What was done and its columns, as they come.

    Each task is bound to a worker with a free thread. Left to the scheduler, what killed a worker would wait for another one
    behind a good recording, and kill it before that one's columns have come."""
    import distributed

    waiting, deaths, running = collections.deque(whats), collections.Counter(), {}  # future: what, worker
    while waiting or running:
        threads = client.nthreads()
        for future, (what, worker) in list(running.items()):
            fault = future.exception() if future.status == "error" else None
            if worker not in threads or isinstance(fault, distributed.KilledWorker):
                deaths[what] += 1
                if deaths[what] <= repeats:
                    waiting.append(what)
                else:
                    yield what, {"error": f"its worker died {deaths[what]} times", "worker": worker}
                future.cancel()
            elif future.status == "finished":
                try:
                    yield what, future.result(timeout=10)
                except TimeoutError:  # the worker died with it, which the next round sees
                    continue
            elif fault:
                yield what, {"error": f"{type(fault).__name__}: {fault}", "worker": worker}
            else:
                continue
            del running[future]
        free = collections.Counter(threads)
        free.subtract(worker for _, worker in running.values())
        for worker in itertools.islice(free.elements(), len(waiting)):
            what = waiting.popleft()
            running[client.submit(timed, work, what, pure=False, workers=[worker])] = what, worker
        if not running:
            client.wait_for_workers(1, timeout=300)
            continue
        try:
            distributed.wait(list(running), timeout=1, return_when="FIRST_COMPLETED")
        except TimeoutError:
            pass  # to look whether a worker died
        except concurrent.futures.CancelledError:
            raise RuntimeError("the scheduler is gone; the same command goes on where this one ended") from None


def cluster_of(options):
    """A client of the workers that are wanted, which have all that they need."""
    try:
        import dask
        import distributed
    except ImportError:
        sys.exit(f"{name}: dask.distributed is missing: apt install python3-distributed")
    logging.disable()  # what dask says of workers that die, the rows say
    try:
        dask.config.set({"distributed.deploy.lost-worker-timeout": "1h"})  # by then a worker that died has started again
        client = distributed.Client(options.cluster or distributed.LocalCluster(
            n_workers=options.workers, threads_per_worker=1, dashboard_address=None, silence_logs="CRITICAL"))
        client.wait_for_workers(1, timeout=300)
        have = client.run(facilities, options.program)
    except Exception as problem:
        sys.exit(f"{name}: the workers cannot be used: {problem}")
    for worker, (version, program) in have.items():
        if version != touchable.__version__:
            sys.exit(f"{name}: {worker} has touchable {version}; must be {touchable.__version__}, as here")
        if not program:
            sys.exit(f"{name}: {worker} has no program {options.program}; install touchable there, or name it by --program")
    return client


# --- The page


def number(row, column):
    return float(row.get(column) or math.nan)


class Drawing(str):
    """HTML, where other text is escaped."""


def table_of(header, lines):
    cell = lambda value: value if isinstance(value, Drawing) else html.escape(str(value))
    rows = [f"<tr>{''.join(f'<{tag}>{cell(value)}</{tag}>' for value in line)}</tr>"
            for tag, line in (("th", header), *(("td", line) for line in lines))]
    return f"<table>{''.join(rows)}</table>"


def histogram(values):
    counts, _ = numpy.histogram(values, 40)
    bars = "".join(f'<rect x="{4 * k}" y="{30 - 30 * count / counts.max():.1f}" width="3" height="30"/>'
                   for k, count in enumerate(counts) if count)
    return Drawing(f'<svg width="160" height="30">{bars}</svg>')


def page_of(table, columns):
    """The table summed up, as a page that needs nothing else."""
    rows, kind = list(table.rows.values()), columns.kind
    failed = [row for row in rows if row["error"]]
    parts = [f"<p>{len(rows)} {kind}s: {len(rows) - len(failed)} done, {len(failed)} with an error.</p>"]
    for title, column in ("Verdicts", "verdict"), ("Filters", "filters"), ("Errors", "error"):
        by_text = collections.defaultdict(list)
        for row in rows:
            if text := re.split(r": | \(", row.get(column, ""))[0]:  # without figures and names of files
                by_text[text].append(row[kind])
        lines = sorted(((len(them), text, ", ".join(them[:5])) for text, them in by_text.items()), reverse=True)
        if lines:
            parts += [f"<h2>{title}</h2>", table_of(("how many", "", "such as"), lines)]
    known = {column: sorted(value for row in rows if math.isfinite(value := number(row, column)))
             for column in (*columns.figures, "seconds")}
    parts += ["<h2>Distributions</h2>", table_of(
        ("", "how many", "least", "5 %", "median", "95 %", "most", ""),
        [(column, len(values), *map(shown, numpy.percentile(values, (0, 5, 50, 95, 100))), histogram(values))
         for column, values in known.items() if values])]
    for column in worst_at_the_top:
        worst = sorted((row for row in rows if number(row, column) > 0), key=lambda row: -number(row, column))
        if worst:
            parts += [f"<h2>Most {column}</h2>", table_of((column, kind), [(row[column], row[kind]) for row in worst[:5]])]
    return ("<!doctype html><meta charset=utf-8><title>Many recordings</title><style>body{font:14px sans-serif;margin:2em}"
            "td,th{padding:.2em .8em;text-align:left;vertical-align:top}rect{fill:#357}</style>"
            f"<h1>{html.escape(str(table.path))}</h1>" + "".join(parts))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", metavar="FOLDER", help="of recordings")
    parser.add_argument("--soak", metavar="SEEDS", type=seeds_of, help="instead of recordings: seeds of the stress suites, such as 0-99")
    parser.add_argument("--out", metavar="DIR", required=True, help="where table and page are written")
    parser.add_argument("--cluster", metavar="ADDRESS", help="of a dask scheduler: tcp://HOST:8786")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)), help="processes of this machine")
    parser.add_argument("--program", default="touchable", help="as workers find it; of --soak: touchable-soak")
    parser.add_argument("--seconds", type=float, default=1, help="how long each recording is touched (1)")
    parser.add_argument("--ticks", type=int, help="of each seed of --soak")
    parser.add_argument("--verify", action="store_true", help="read recordings whole, for faults that would be felt")
    parser.add_argument("--retry", action="store_true", help="do again what ended with an error")
    options = parser.parse_args()
    if (options.folder is None) == (options.soak is None):
        parser.error("give a FOLDER of recordings, or --soak SEEDS")
    if options.workers < 1 or not 0.001 <= options.seconds <= 3600:
        parser.error(f"--workers {options.workers}, --seconds {options.seconds}: must be 1 or more, and 0.001 to 3600")
    if "/" in options.program:
        options.program = os.path.abspath(options.program)
    out = pathlib.Path(os.path.abspath(options.out))
    out.mkdir(parents=True, exist_ok=True)
    columns, stem = (seeds, "soak") if options.soak else (recordings, "recordings")
    table, page = Table(out / f"{stem}.csv", columns), out / f"{stem}.html"
    if options.soak:
        work = functools.partial(of_seed, options.program, suites_of(options.program), options.ticks)
        how = f"{stamp_of(options.program)}, {options.ticks or 'usual'} ticks"
        stamps = dict.fromkeys(options.soak, how)
    else:
        work = functools.partial(of_recording, options.program, options.verify, options.seconds)
        how = f", {options.seconds:g} s" + ", verified" * options.verify
        stamps = {path: stamp_of(path) + how for path in
                  recordings_in(os.path.abspath(options.folder), {str(out), str(table.path), str(page)})}
    current = lambda row: stamps.get(row[columns.kind], row["stamp"]) == row["stamp"] and not (options.retry and row["error"])
    waiting = [what for what in stamps if what not in table.rows or not current(table.rows[what])]
    print(f"{len(waiting)} of {len(stamps)} {columns.kind}s are to be done", flush=True)
    try:
        with cluster_of(options) if waiting else contextlib.nullcontext() as client:
            table.keep(current)
            for what, found in columns_as_done(client, work, waiting):
                row = table.add({columns.kind: what, "stamp": stamps[what], **found})
                print(f"{what}: {row['error'] or 'done'} ({row['seconds'] or '?'} s)", flush=True)
    except KeyboardInterrupt:
        sys.exit(f"{name}: stopped; the same command goes on where this one ended")
    finally:
        replace(page, page_of(table, columns))
    print(f"see {page}")


if __name__ == "__main__":
    try:
        main()
    except (OSError, RuntimeError) as problem:
        sys.exit(f"{name}: {problem}")
