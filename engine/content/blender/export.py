# SPDX-License-Identifier: Apache-2.0
"""Makes a touchable clip of a scene, without a window:

    blender -b scene.blend -P export.py -- OUT [options]

OUT is NAME.mkv (or .mp4, .gltf), or a folder for the pictures.
"""

import argparse
import importlib
import os
import re
import shutil
import signal
import sys
import threading
import traceback

import bpy

sys.dont_write_bytecode = True

LAST_FRAME = 1048574  # Blender's last frame; its first is the negative


def package():
    """The folder that this file is in, whatever it is called."""
    folder = os.path.dirname(os.path.abspath(__file__))
    parent, name = os.path.split(folder)
    if parent not in sys.path:
        sys.path.insert(0, parent)
    return importlib.import_module(name)


def part(name):
    return importlib.import_module(f"{package().__name__}.{name}")


class Words(argparse.ArgumentParser):
    def error(self, message):
        raise part("faults").BadUsage(f"{message}; blender -b -P export.py -- --help says what there is")


def frames(text):
    found = re.fullmatch(r"(-?\d+)(?:-(-?\d+))?", text)
    if not found or int(found[2] or found[1]) < int(found[1]):
        raise argparse.ArgumentTypeError(f"frames '{text}'; must be like 1-90 or 7")
    first, last = int(found[1]), int(found[2] or found[1])
    if first < -LAST_FRAME or last > LAST_FRAME:
        raise argparse.ArgumentTypeError(f"'{text}' are not all Blender's; must be frames from {-LAST_FRAME} to {LAST_FRAME}")
    return first, last


def size(text):
    found = re.fullmatch(r"(\d+)x(\d+)", text)
    if not found or not all(4 <= int(side) <= 16384 for side in found.groups()):
        raise argparse.ArgumentTypeError(f"'{text}' is no size; must be like 720x480, of 4 to 16384 pixels a side")
    return int(found[1]), int(found[2])


def metres(text):
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"'{text}' is no distance in metres; must be like 0.5")
    return value


def samples(text):
    if not re.fullmatch(r"[1-9]\d{0,5}", text):
        raise argparse.ArgumentTypeError(f"'{text}' are no samples; must be like 64")
    return int(text)


def parse(words):
    parser = Words(prog="blender -b scene.blend -P export.py --", allow_abbrev=False,
                   description="makes a touchable clip of a Blender scene: colour, depth, haptic and height pictures of every frame")
    parser.add_argument("output", metavar="OUT", help="NAME.mkv, NAME.mp4 or NAME.gltf; a name without a dot: a folder of pictures with a scene.json")
    parser.add_argument("--frames", metavar="A-B", type=frames, help="these frames; otherwise the scene's range, or one frame where nothing moves")
    parser.add_argument("--size", metavar="WxH", type=size, help="pictures of this size instead of the scene's")
    parser.add_argument("--near", metavar="METRES", type=metres, help="what is nearer is no surface; otherwise the nearest depth of all frames")
    parser.add_argument("--far", metavar="METRES", type=metres, help="what is farther is no surface; otherwise the farthest depth of all frames")
    parser.add_argument("--colour-samples", metavar="N", type=samples, help="colour with so many samples instead of the scene's")
    parser.add_argument("--no-colour", action="store_true", help="leave colour out")
    parser.add_argument("--overwrite", action="store_true", help="replace what is there already")
    parser.add_argument("--touchable", metavar="PATH", help="the program touchable; otherwise $TOUCHABLE, or where programs are")
    asked = parser.parse_args(words)
    if not asked.output:
        parser.error("OUT is empty; must be NAME.mkv")
    if asked.near and asked.far and asked.near >= asked.far:
        parser.error(f"--near {asked.near:g} is not before --far {asked.far:g}")
    return asked


class Speaker:
    """Says lines on standard output, onto which Blender no longer writes its own."""

    def __init__(self):
        sys.stdout.flush()
        self.out = os.fdopen(os.dup(1), "w", encoding="utf-8", errors="replace")
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1)
        os.close(nothing)

    def __call__(self, line):
        try:
            print(f"touchable: {line}", file=self.out, flush=True)
        except BrokenPipeError:
            pass


CLEANER = 'code=$1; shift; rm -rf -- "$@"; exit "$code"'  # a shell script


def clean_up_on_signals():
    """SIGINT and its like end Blender at once, also amid a render, and nothing is left of the work. A thread of its own hears of them:
    Blender's main thread runs no Python while it renders."""
    hear, tell = os.pipe()
    os.set_blocking(tell, False)
    signal.set_wakeup_fd(tell, warn_on_full_buffer=False)
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    for number in numbers:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, lambda *_: None)
    code = part("faults").INTERRUPTED

    def wait():
        os.read(hear, 1)
        outputs = part("outputs")
        outputs.steady.acquire()  # never released
        for child in list(outputs.children):
            child.terminate()
            child.wait()
        left = list(outputs.folders)
        own = bpy.app.tempdir  # shared with other programs if Blender could not make its own
        if os.path.basename(os.path.normpath(own)).startswith("blender_"):
            left.append(own)
        if os.name == "posix":
            # Blender makes a picture's missing folder anew, so it ends first: the cleaner replaces its process.
            signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
            os.execv("/bin/sh", ["sh", "-c", CLEANER, "sh", str(code), *left])
        for folder in left:
            shutil.rmtree(folder, ignore_errors=True)
        os._exit(code)

    threading.Thread(target=wait, daemon=True).start()


def export(words, say):
    """What is there in the end."""
    job, outputs = part("job"), part("outputs")
    asked = parse(words)
    touchable = outputs.program(asked.touchable)
    output = os.path.abspath(asked.output) + ("/" if asked.output.endswith("/") else "")
    output = output.rstrip("/") or "/"
    outputs.check_output(output, touchable, asked.overwrite)
    clean_up_on_signals()
    work = outputs.work_folder(outputs.final_path(output, touchable))
    try:
        job.Export(job.Wish(frames=asked.frames, size=asked.size, near=asked.near, far=asked.far, colour=not asked.no_colour,
                            colour_samples=asked.colour_samples), work, say).run()
        say("writing")
        return outputs.publish(work, output, touchable, asked.overwrite, say)
    finally:
        with outputs.steady:  # blocks for ever once a signal ends this process
            shutil.rmtree(work, ignore_errors=True)


def main():
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    faults = part("faults")
    try:
        if "--help" in words or "-h" in words:
            parse(["--help"])
        say = Speaker()
        say(f"done: {export(words, say)}")
    except faults.Fault as fault:
        print(f"touchable: {fault}", file=sys.stderr, flush=True)
        return fault.code
    except ModuleNotFoundError as fault:
        print(f"touchable: Blender's Python has no module {fault.name}; install it (Debian: python3-{fault.name})", file=sys.stderr, flush=True)
        return faults.NoRenderer.code
    except OSError as fault:
        print(f"touchable: {fault.filename or 'the output'}: {fault.strerror or fault}", file=sys.stderr, flush=True)
        return 1
    except Exception as fault:  # from Blender or from this code
        traceback.print_exc()
        print(f"touchable: the export failed: {str(fault).strip() or type(fault).__name__}", file=sys.stderr, flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
