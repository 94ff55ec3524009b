# SPDX-License-Identifier: Apache-2.0
"""Of what an export leaves on the disk, and of the Blender that the add-on starts: as checks.py, and run as it is."""

import contextlib
import os
import subprocess
import sys
import tempfile
import traceback
from types import SimpleNamespace

import bpy

sys.dont_write_bytecode = True
CONTENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../engine/content")
sys.path.insert(0, CONTENT)

from blender import child, faults, operators, outputs


def written(path, text):
    with open(path, "w") as file:
        file.write(text)
    return path


def folder_of(path, *names):
    os.mkdir(path)
    for name in names:
        written(os.path.join(path, name), "old")
    return path


def is_refused(output, touchable=None, overwrite=True):
    try:
        outputs.check_output(output, touchable, overwrite)
    except faults.BadUsage:
        return True
    return False


def check_replaces():
    """Pictures of a clip alone, as touchable does; and a clip that may be replaced is no leave to replace a folder of its name."""
    with tempfile.TemporaryDirectory() as folder:
        name = os.path.join(folder, "clip")
        assert not is_refused(name) and is_refused(os.path.join(folder, ".mkv"), "/bin/true")
        pictures = "scene.json", "depth.txt", "depth_000000.exr", "depth_000001.png", "haptic_000000.png", "height_000000.png", "colour_000000.png"
        folder_of(name, *pictures)
        assert not is_refused(name) and is_refused(name, overwrite=False)
        assert is_refused(name + ".mkv") and not is_refused(name + ".mkv", "/bin/true")
        for other in ("notes.txt", "depth_000000.png.bak", "depth_1.png", "my_depth_000000.png"):
            written(os.path.join(name, other), "mine")
            assert is_refused(name), other
            os.remove(os.path.join(name, other))
        os.mkdir(os.path.join(name, "haptic.png"))
        assert is_refused(name)
        assert is_refused(written(os.path.join(folder, "file"), "mine"))
        os.symlink(name, os.path.join(folder, "link"))
        assert is_refused(os.path.join(folder, "link"))
        assert is_refused(folder_of(os.path.join(folder, "folder.mkv")), "/bin/true")
        assert not is_refused(written(os.path.join(folder, "file.mkv"), "old"), "/bin/true")


def check_becomes():
    """The new one whole, or the old one as it was."""
    with tempfile.TemporaryDirectory() as folder:
        final = folder_of(os.path.join(folder, "clip"), "scene.json")
        work = outputs.work_folder(final)
        written(os.path.join(work, "scene.json"), "new")
        real = os.rename

        def rename(source, target):
            if source == work:
                raise OSError(5, "the disk fails", target)
            real(source, target)

        os.rename = rename
        try:
            outputs.publish(work, final, None, True, print)
            assert False
        except OSError:
            pass
        finally:
            os.rename = real
        assert open(os.path.join(final, "scene.json")).read() == "old"
        assert sorted(os.listdir(folder)) == sorted(["clip", os.path.basename(work)])
        # What came while it was rendered stays.
        for overwrite, other in ((False, "scene.json"), (True, "mine")):
            written(os.path.join(final, other), "old")
            try:
                outputs.publish(work, final, None, overwrite, print)
                assert False
            except faults.BadUsage:
                assert sorted(os.listdir(folder)) == sorted(["clip", os.path.basename(work)])
        os.remove(os.path.join(final, "mine"))
        outputs.publish(work, final, None, True, print)
        assert os.listdir(folder) == ["clip"] and open(os.path.join(final, "scene.json")).read() == "new"


AT_A_BAD_MOMENT = """
import os, signal, subprocess, sys, tempfile, time, types
sys.path.insert(0, {content!r})
# Of no session of its own: its folder of temporary files is everybody's, and stays.
sys.modules["bpy"] = types.SimpleNamespace(app=types.SimpleNamespace(tempdir={beside!r} + "/"))
# `job` needs Blender. This one renders until a signal ends it.
sys.modules["blender.job"] = types.SimpleNamespace(Wish=dict, Export=lambda *_: time.sleep(30))
from blender import export, outputs
def at_once(made):
    def make(*words, **options):
        thing = made(*words, **options)
        print(getattr(thing, "pid", ""), flush=True)
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.3)
        return thing
    return make
{moment}
"""
MOMENTS = {
    "the folder is made": """
tempfile.mkdtemp = at_once(tempfile.mkdtemp)
export.export([{clip!r}, "--touchable", {stand_in!r}], print)
""",
    "touchable starts": """
outputs.subprocess.Popen = at_once(subprocess.Popen)
work = outputs.work_folder({clip!r})
export.clean_up_on_signals()
outputs.publish(work, {clip!r}, {stand_in!r}, False, print)
"""}


def check_signals():
    """One that comes at once when something was made: nothing stays, and nothing runs on."""
    for name, moment in MOMENTS.items():
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as beside:
            stand_in = written(os.path.join(beside, "touchable"), "#!/bin/sh\nexec sleep 60\n")
            os.chmod(stand_in, 0o755)
            code = AT_A_BAD_MOMENT.format(content=CONTENT, beside=beside,
                                          moment=moment.format(clip=os.path.join(folder, "clip.mkv"), stand_in=stand_in))
            ended = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, timeout=50)
            assert ended.returncode == 130, (name, ended.returncode)
            assert os.listdir(folder) == [], (name, os.listdir(folder))
            assert os.listdir(beside) == ["touchable"], name
            pid = ended.stdout.strip()
            assert not pid or not os.path.exists(f"/proc/{pid}"), name


@contextlib.contextmanager
def child_of(script):
    """A `Child` whose process is a shell script, once that has said a line."""
    made = child.Child.__new__(child.Child)
    made.error = None
    made.process = subprocess.Popen(["sh", "-c", script], stdout=subprocess.PIPE)
    made.process.stdout.readline()
    made._end = lambda: None
    made._hear = lambda line: None
    made.lines = child.queue.SimpleQueue()
    try:
        yield made
    finally:
        made.process.kill()
        made.process.wait()
        made.process.stdout.close()


def check_cancels():
    """What has finished is not cancelled; what does not end is killed; and Esc that ends playback ends no export."""
    with child_of("echo") as made:
        os.waitid(os.P_PID, made.process.pid, os.WEXITED | os.WNOWAIT)
        made.cancel()
        assert made.error is None
    with child_of("echo; exec sleep 60") as made:
        made.cancel()
        assert made.error == "cancelled"
    child.PATIENCE, patience = 0.1, child.PATIENCE
    with child_of("trap '' TERM; echo; for n in $(seq 200); do sleep 0.05; done") as made:
        made.cancel()
        assert made.error == "cancelled" and made.process.returncode == -9
    child.PATIENCE = patience
    with child_of("echo; exec sleep 60") as made:
        exporting = operators.Exporting()
        exporting.child = made
        escape = SimpleNamespace(type="ESC", value="PRESS")
        assert exporting.modal(SimpleNamespace(screen=SimpleNamespace(is_animation_playing=True)), escape) == {"PASS_THROUGH"}
        assert made.process.poll() is None


def check_scripts():
    """They run in the child only where the preferences let them run here."""
    bpy.ops.wm.read_factory_settings()
    preferences = bpy.context.preferences
    with tempfile.TemporaryDirectory() as folder:
        saved = os.path.join(folder, "mine.blend")
        bpy.ops.wm.save_as_mainfile(filepath=saved)
        copy = os.path.join(folder, "copy.blend")
        preferences.filepaths.use_scripts_auto_execute = False
        assert not bpy.app.autoexec_fail
        assert child.permission(saved) == child.permission(copy) == ["--disable-autoexec"]
        preferences.filepaths.use_scripts_auto_execute = True
        assert child.permission(saved) == child.permission(copy) == []
        excluded = preferences.autoexec_paths.new()
        excluded.path = folder
        # Of the file itself the preferences know it there too; a copy is elsewhere.
        assert child.permission(saved) == [] and child.permission(copy) == ["--disable-autoexec"]
    bpy.ops.wm.read_factory_settings()


def main():
    for name in os.environ["CHECKS"].split():
        try:
            globals()[f"check_{name}"]()
        except BaseException:
            traceback.print_exc()  # Blender says it on standard output
            raise
        print(f"checked {name}", file=sys.stderr, flush=True)


main()
