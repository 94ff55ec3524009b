#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Which small changes of the product no test sees: mutants.py [MODULE...], as ./run mutants calls it.

In a copy of the sources, build/mutants, places of each module are changed by rule (places.py), each behind a switch of its own
(mutant.hpp), so that all are compiled once. A place's change does not depend on other places: it is chosen by a hash of its line. Every
test program is run once unchanged and says for each test which places it reached. Then each change is switched on for the tests that
reach its place, shortest first, until one fails, crashes or hangs; that one has to pass without the change right after, or it does not
count. A change that lives is a gap of the tests, or cannot be seen by any; then survivors.txt names it with the reason.

With a MODULE only its own tests run: those programs first that link the least of what uses it, for at most four minutes each."""
import concurrent.futures
import fcntl
import functools
import hashlib
import json
import mmap
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import places

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TREE = ROOT / "build/mutants"
BUILD = TREE / "build/release"
REFUSED = TREE / "build/refused.json"
RESULT = ROOT / "out/mutants.txt"
SEED = "1"
OF_EACH, OF_CORE, CORE = 12, 60, ("haptics_cpu", "device")
WANTED, WANTED_OF_CORE = 90, 97  # per cent
MOST_MARKS = 4096  # as in mutant.cpp
STEPS = (2, 10, 40)  # seconds of tests: the shortest ones first, and more where these see nothing
MODULE_SECONDS = 240
JOBS = os.cpu_count() or 1

say_lock = threading.Lock()


def say(*words):
    with say_lock:
        print(*words, flush=True)


def run(words, **more):
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", **more)


def write_if_new(path, content):
    if not path.exists() or path.read_bytes() != content:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


# Which places.

class Mutant:
    def __init__(self, module, file, place, lines):
        self.module, self.file, self.place, self.number = module, file, place, 0
        self.line_text = " ".join(lines[place.line - 1].split())
        self.key = f"{file} :: {place.rule} :: {self.line_text}"
        self.rank = hashlib.sha256(f"{SEED} {self.key} {place.was} {place.now}".encode()).hexdigest()
        self.tests, self.caught_by = 0, None

    def __str__(self):
        return f"{self.file}:{self.place.line}: {self.place.rule}: {self.place.was} -> {self.place.now}"


def modules():
    """The folders that docs/architecture.md calls modules, by what their CMakeLists.txt says."""
    return sorted({str(at.parent.relative_to(ROOT)) for part in ("capi", "engine", "haptics_cpu", "device", "player")
                   for at in (ROOT / part).rglob("CMakeLists.txt") if "touchable_module(" in at.read_text()})


@functools.cache
def possible(module, path):
    text = path.read_text()
    lines = text.split("\n")
    return sorted((Mutant(module, str(path.relative_to(ROOT)), place, lines) for place in places.places(text)), key=lambda m: m.rank)


def chosen(module, refused):
    """The module's mutants, spread over its files by their length; from each the rule that had the fewest so far."""
    files, found, lines = sorted((ROOT / module).glob("*.cpp")), {}, {}
    for path in files:
        lines[path] = path.read_text().count("\n")
        found[path] = [m for m in possible(module, path) if m.rank not in refused]
    wanted = OF_CORE if module in CORE else OF_EACH
    total, taken, rules = sum(lines.values()), {path: [] for path in files}, {}
    while sum(map(len, taken.values())) < wanted:
        open_files = [path for path in files if found[path]]
        if not open_files:
            break
        path = max(open_files, key=lambda p: lines[p] / total * wanted - len(taken[p]))
        mutant = min(found[path], key=lambda m: (rules.get(m.place.rule, 0), m.rank))
        found[path] = [m for m in found[path] if m.place.last < mutant.place.line or m.place.line > mutant.place.last]
        taken[path].append(mutant)
        rules[mutant.place.rule] = rules.get(mutant.place.rule, 0) + 1
    return sorted((m for some in taken.values() for m in some), key=lambda m: (m.file, m.place.line))


def write_tree(mutants):
    changed = {}
    for mutant in mutants:
        changed.setdefault(mutant.file, []).append(mutant)
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True,
                            check=True).stdout.decode().split("\0")
    for name in filter(None, listed):
        path = ROOT / name
        if not path.is_file() or path.is_symlink():
            continue
        content = path.read_bytes()
        if name in changed:
            text = content.decode()
            for mutant in sorted(changed[name], key=lambda m: -m.place.start):
                place = mutant.place
                text = text[:place.start] + place.text.replace("@K@", str(mutant.number)) + text[place.end:]
            content = ('#include "tests/mutants/mutant.hpp"\n#line 1\n' + text).encode()
        write_if_new(TREE / name, content)
        shutil.copymode(path, TREE / name)
    for path in TREE.rglob("*"):  # gone since
        if path.is_file() and not path.is_relative_to(TREE / "build") and str(path.relative_to(TREE)) not in listed:
            path.unlink()


# The build.

def configure():
    switch = TREE / "build/mutant.o"
    (TREE / "build").mkdir(parents=True, exist_ok=True)
    subprocess.run(["c++", "-std=c++20", "-O2", "-fPIC", "-fvisibility=hidden", "-c", HERE / "mutant.cpp", "-o", switch], check=True)
    subprocess.run(["objcopy", "--weaken", switch], check=True)
    words = ["cmake", "--preset", "release", "-DTOUCHABLE_BENCH=OFF", "-DTOUCHABLE_TESTS=ON", f"-DTOUCHABLE_TEST_DATA={TREE}/nothing",
             f"-DCMAKE_CXX_STANDARD_LIBRARIES={switch}"]
    if shutil.which("ccache"):
        words.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    done = run(words, cwd=TREE)
    if done.returncode:
        sys.exit(done.stdout)


def test_programs():
    """By name: where each is that `./run test --all` runs, and the environment that CTest gives it."""
    tests = json.loads(subprocess.run(["ctest", "--show-only=json-v1", "-LE", "^trial$"], cwd=BUILD, capture_output=True,
                                      check=True).stdout)["tests"]
    programs = {}
    for test in tests:
        properties = {each["name"]: each["value"] for each in test["properties"]}
        name = "test_" + test["name"].split(".")[0]
        environment = dict(word.split("=", 1) for word in properties.get("ENVIRONMENT", []))
        if "GTEST_SHARD_INDEX" in environment and name != "test_modules":  # which reads the sources as they are
            settings = {key: value for key, value in environment.items() if not key.startswith("GTEST_")}
            programs[name] = {"folder": properties["WORKING_DIRECTORY"], "environment": settings,
                              "inputs": subprocess.run(["ninja", "-t", "inputs", name], cwd=BUILD, capture_output=True, text=True,
                                                       check=True).stdout.split()}
    return programs


def pick():
    """The mutants of all modules, but for those that are known not to compile."""
    refused, mutants = set(json.loads(REFUSED.read_text())) if REFUSED.exists() else set(), []
    for k, module in enumerate(modules()):
        for n, mutant in enumerate(chosen(module, refused)):
            mutant.number = 100 * k + n + 1
            mutants.append(mutant)
    write_tree(mutants)
    return mutants, refused


def users():
    """By module (its folder): the folders of the modules that use it, and those that use these."""
    folder_of, uses = {}, {}
    for folder in modules():
        for name, words in re.findall(r"touchable_module\((\w+)([^)]*)", (ROOT / folder / "CMakeLists.txt").read_text()):
            folder_of[name] = folder
            used = re.search(r"\bUSES((?:\s+[a-z_]\w*)*)", words)
            uses.setdefault(folder, set()).update(used.group(1).split() if used else [])
    direct = {folder: {user for user in uses if any(folder_of[name] == folder for name in uses[user])} for folder in uses}

    def all_of(folder):
        return set().union(direct[folder], *(all_of(user) for user in direct[folder] - {folder}))
    return {folder: all_of(folder) - {folder} for folder in uses}


def build(targets):
    """Compiles and links the targets; a place that does not compile gives way to another. The mutants."""
    while True:
        mutants, refused = pick()
        with open(TREE / "build/ninja.log", "w+") as log:
            done = subprocess.run(["ninja", "-k", "0", f"-j{JOBS}", *targets], cwd=BUILD, stdout=log, stderr=subprocess.STDOUT)
            log.seek(0)
            said = log.read()
        if done.returncode == 0:
            return mutants
        mentioned = re.findall(r"^(\S+?\.cpp):(\d+):\d+: (?:fatal )?error:", said, re.M) or re.findall(r"(\S+?\.cpp):(\d+)", said)
        wrong = set()
        for name, line in mentioned:
            file = os.path.relpath(os.path.normpath(BUILD / name), TREE)
            near = [m for m in mutants if m.file == file and m.place.line <= int(line)]
            if near:  # what no longer compiles below a change is its fault
                wrong.add(max(near, key=lambda m: m.place.line))
        if not wrong:
            sys.exit(said[-5000:] + "\nmutants: the changed sources do not compile, and no place is to blame")
        for mutant in wrong:
            say("does not compile, another one instead:", mutant)
        refused |= {m.rank for m in wrong}
        REFUSED.write_text(json.dumps(sorted(refused)))


# The tests.

def run_tests(name, program, seconds, names=None, **settings):
    """The exit code of a test program, None where it hung, and what it said."""
    words = [f"{program['folder']}/{name}", "--gtest_fail_fast" if names else "--gtest_brief=0"]
    if names:
        words.append("--gtest_filter=" + ":".join(names))
    scratch = tempfile.mkdtemp(prefix="m", dir=TREE / "build/tmp")
    environment = {**os.environ, **program["environment"], "TOUCHABLE_SHORT_SWEEPS": "1", "TOUCHABLE_TEST_DATA": f"{TREE}/nothing",
                   "TMPDIR": scratch, **settings}
    with tempfile.TemporaryFile(dir=TREE / "build/tmp") as said:
        process = subprocess.Popen(words, cwd=program["folder"], env=environment, stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                                   start_new_session=True)
        try:
            code = process.wait(seconds)
        except subprocess.TimeoutExpired:
            code = None
        if code != 0:
            end_session(process)
        said.seek(0)
        text = said.read().decode(errors="replace")
    shutil.rmtree(scratch, ignore_errors=True)
    return code, text


def end_session(process):
    """Ends a test program with all that it started."""
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            if int(stat.read_text().rsplit(")", 1)[1].split()[3]) == process.pid:
                os.kill(int(stat.parent.name), signal.SIGKILL)
        except (OSError, ValueError, IndexError):
            pass  # it has ended
    process.wait()


def record(name, program):
    """Runs a test program as it is. Its tests that pass: name, seconds, numbers of mutants reached. Kept until the program changes."""
    kept = TREE / f"build/reached/{name}.json"
    built = [BUILD / at for at in program["inputs"] if re.search(r"player/touchable$|capi/lib\w[\w-]*\.so", at)]
    state = [[str(path), path.stat().st_mtime_ns] for path in (pathlib.Path(program["folder"]) / name, *built) if path.exists()]
    if kept.exists():
        before = json.loads(kept.read_text())
        if before["state"] == state:
            return before["tests"]
    kept.parent.mkdir(exist_ok=True)
    marks, report = kept.with_suffix(".marks"), kept.with_suffix(".report")
    marks.write_bytes(bytes(4 * MOST_MARKS))
    report.write_text("")
    started = time.monotonic()
    code, text = run_tests(name, program, 1200, TOUCHABLE_MUTANTS_REACHED=str(marks), TOUCHABLE_MUTANTS_REPORT=str(report))
    tests = []
    for line in report.read_text().splitlines():
        test, milliseconds, passed, reached = line.split("\t")
        if passed == "1":
            tests.append([test, int(milliseconds) / 1000, [int(k) for k in reached.split()]])
        elif re.search(rf"\[  FAILED  \] {re.escape(test)}\b", text):
            say(f"left out, as it fails unchanged: {name} {test}")
    say(f"recorded {name}: {len(tests)} tests, {time.monotonic() - started:.0f} s" + (f", exit code {code}" if code else ""))
    if code in (0, 1):
        kept.write_text(json.dumps({"state": state, "tests": tests}))
    return tests


unsteady = set()  # tests that failed without a change, too


def examine(mutant, tests, programs):
    """Runs the tests (program, name, seconds), which reach it, until one sees it."""
    tests = sorted(tests, key=lambda test: test[2])
    mutant.tests += len(tests)
    begin, spent = 0, 0.0
    for most in STEPS:
        end = begin
        while end < len(tests) and (spent + tests[end][2] <= most or end == 0):
            spent += tests[end][2]
            end += 1
        by_program = {}
        for name, test, seconds in tests[begin:end]:
            if (name, test) not in unsteady:
                by_program.setdefault(name, []).append((test, seconds))
        begin = end
        for name, some in sorted(by_program.items(), key=lambda item: sum(seconds for _, seconds in item[1])):
            while some:
                part, limit = [test for test, _ in some[:800]], 5 + 3 * sum(seconds for _, seconds in some[:800])
                code, text = run_tests(name, programs[name], limit, part, TOUCHABLE_MUTANT=str(mutant.number))
                if code is None:  # or the machine was busy
                    code, text = run_tests(name, programs[name], 4 * limit, part, TOUCHABLE_MUTANT=str(mutant.number))
                if code == 0:
                    some = some[800:]
                    continue
                failed = re.search(r"^\[  FAILED  \] ([^\s,]+)", text, re.M)
                begun = re.findall(r"^\[ RUN      \] (\S+)", text, re.M)
                by = failed.group(1) if failed else begun[-1] if begun else part[-1]
                again = [by] if by in part else part
                code_without, _ = run_tests(name, programs[name], limit, again)
                if code_without == 0:
                    mutant.caught_by = f"{name} {by}" + (" hangs" if code is None else " crashes" if code < 0 else "")
                    return
                say(f"unsteady, does not count: {name} {by}")
                unsteady.add((name, by))
                some = [each for each in some if each[0] != by] if by in part else []


# The whole.

def known_survivors():
    known, path = {}, HERE / "survivors.txt"
    for line in path.read_text().splitlines() if path.exists() else []:
        if line.strip() and not line.startswith("#"):
            parts = line.split(" :: ")
            if len(parts) != 4 or not parts[3].strip():
                sys.exit(f"survivors.txt: '{line}'; must be FILE :: RULE :: LINE :: REASON")
            known[" :: ".join(parts[:3])] = parts[3]
    return known


def table(mutants, known, seconds):
    lines, is_enough = [], True
    lines.append(f"{'module':18} mutants reached caught known      %")
    for module in dict.fromkeys(m.module for m in mutants):
        own = [m for m in mutants if m.module == module]
        caught = [m for m in own if m.caught_by]
        excused = [m for m in own if not m.caught_by and m.key in known]
        share = 100 * len(caught) / max(1, len(own) - len(excused))
        wanted = WANTED_OF_CORE if module in CORE else WANTED
        is_enough &= share >= wanted
        lines.append(f"{module:18} {len(own):7} {sum(bool(m.tests) for m in own):7} {len(caught):6} {len(excused):5} {share:6.1f}" +
                     ("" if share >= wanted else f"  fewer than {wanted} %"))
    caught = sum(bool(m.caught_by) for m in mutants)
    lines.append(f"{'all':18} {len(mutants):7} {sum(bool(m.tests) for m in mutants):7} {caught:6}       {100 * caught / len(mutants):6.1f}")
    alive = [m for m in mutants if not m.caught_by]
    lines += ["", "No test sees:"]
    lines += [f"{m}" + ("" if m.tests else " (no test reaches it)") + (f" ({known[m.key]})" if m.key in known else "") for m in alive]
    read = {m.module for m in mutants}
    gone = [key for key in known if os.path.dirname(key.split(" :: ")[0]) in read and key not in {m.key for m in alive}]
    lines += [f"survivors.txt names one that is caught, or gone: {key}" for key in gone]
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    lines.append(f"\n{seconds:.0f} s, {usage.ru_utime + usage.ru_stime:.0f} s of processors")
    return lines, is_enough and not gone


def main(asked):
    began, every = time.monotonic(), modules()
    for name in asked:
        if name not in every:
            sys.exit(f"mutants: '{name}' is no module; there are {', '.join(every)}")
    known = known_survivors()
    # Changed code may write and allocate for ever.
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (16 << 30, 16 << 30))  # a test has a sparse file of 8 GiB
    resource.setrlimit(resource.RLIMIT_DATA, (6 << 30, 6 << 30))
    (TREE / "build/tmp").mkdir(parents=True, exist_ok=True)
    lock = open(TREE / "build/lock", "w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        sys.exit("mutants: another run is at work in build/mutants")
    pick()
    configure()
    programs = test_programs()
    groups = [list(programs)]
    if asked:
        linked = {name: {os.path.dirname(at) for at in program["inputs"] if at.endswith(".a")} for name, program in programs.items()}
        above = set().union(*(users()[module] for module in asked)) - set(asked)
        near = sorted((name for name in programs if linked[name] & set(asked)),
                      key=lambda name: (len(linked[name] & above), len(linked[name])))
        groups = [near[k:k + 2 * JOBS] for k in range(0, len(near), 2 * JOBS)]
    mutants, left, spent = [], [], 0.0
    with concurrent.futures.ThreadPoolExecutor(JOBS) as threads:
        for group in groups:
            if mutants and (all(m.caught_by for m in mutants) or spent > MODULE_SECONDS * len(asked)):
                left += group
                continue
            say(f"building {len(group)} test programs, {time.monotonic() - began:.0f} s")
            mutants = [m for m in build(group) if not asked or m.module in asked]
            started, reaching = time.monotonic(), {}
            for name, tests in zip(group, threads.map(lambda name: record(name, programs[name]), group)):
                for test, seconds, reached in tests:
                    for k in reached:
                        reaching.setdefault(k, []).append((name, test, seconds))
            alive = [m for m in mutants if not m.caught_by and m.number in reaching]
            for k, _ in enumerate(threads.map(lambda m: examine(m, reaching[m.number], programs), alive)):
                if k % 10 == 9 or k + 1 == len(alive):
                    say(f"{k + 1} of {len(alive)} examined, {sum(bool(m.caught_by) for m in mutants)} of {len(mutants)} caught, "
                        f"{time.monotonic() - began:.0f} s")
            spent += time.monotonic() - started
    lines, is_enough = table(mutants, known, time.monotonic() - began)
    if left:
        lines.append(f"Not run, as time was over: {' '.join(left)}")
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text("\n".join(lines) + "\n\nCaught:\n" + "".join(f"{m} by {m.caught_by}\n" for m in mutants if m.caught_by))
    say("\n".join(lines))
    sys.exit(not is_enough)


if __name__ == "__main__":
    main(sys.argv[1:])
