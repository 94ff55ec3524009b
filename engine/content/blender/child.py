# SPDX-License-Identifier: Apache-2.0
"""An export that a Blender of its own makes of the file, beside the one that a person works in: whose file stays as it is."""

import os
import queue
import re
import subprocess
import tempfile
import threading

import bpy

PATIENCE = 5.0  # seconds that a child has to tidy up
PROGRESS = re.compile(r"(colour|depth) (\d+) of (\d+)$")


def saved_file(folder):
    """The file as it is in this window: itself where all is saved, otherwise a copy in `folder`, whose paths still lead to the same files."""
    if bpy.data.filepath and not bpy.data.is_dirty:
        return bpy.data.filepath
    path = os.path.join(folder, os.path.basename(bpy.data.filepath) or "untitled.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True, check_existing=False, relative_remap=True)
    return path


def unsaved_images():
    """Names of painted images that no file has yet: another Blender cannot see what is new in them."""
    return [image.name for image in bpy.data.images if image.is_dirty and image.users]


def permission(path):
    """Options for a Blender that opens `path`: its scripts and drivers run there only where the preferences let them run here. Without an
    option the preferences decide there, but those folders that they exclude do not name a copy."""
    preferences = bpy.context.preferences
    is_trusted = preferences.filepaths.use_scripts_auto_execute and not bpy.app.autoexec_fail
    return [] if is_trusted and (path == bpy.data.filepath or not preferences.autoexec_paths) else ["--disable-autoexec"]


class Child:
    """One export. Ask `poll` now and then."""

    def __init__(self, scene, output, options):
        self.folder = tempfile.TemporaryDirectory(prefix="touchable-", dir=bpy.app.tempdir)
        self.share, self.line, self.error = 0.0, "starting Blender", None
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "export.py")
        file = saved_file(self.folder.name)
        self.errors = tempfile.TemporaryFile(mode="w+", dir=self.folder.name, errors="replace")
        self.process = subprocess.Popen(
            [bpy.app.binary_path, "--background", *permission(file), file, "--scene", scene.name, "--python-exit-code", "1",
             "--python", script, "--", output, "--overwrite", *options],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self.errors, text=True, errors="replace")
        self.lines = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        for line in self.process.stdout:
            self.lines.put(line.strip())

    def poll(self):
        """Takes in what it said; whether it still runs."""
        while not self.lines.empty():
            self._hear(self.lines.get())
        if self.process.poll() is None:
            return True
        self._end()
        return False

    def _hear(self, line):
        if not line.startswith("touchable: "):
            return
        self.line = line.removeprefix("touchable: ")
        found = PROGRESS.match(self.line)
        if found:
            done = int(found[2]) / int(found[3])
            self.share = 0.05 + (0.45 * done if found[1] == "colour" else 0.45 + 0.45 * done)

    def _end(self):
        self.process.wait()
        if self.process.returncode != 0 and self.error is None:
            self.errors.seek(0)
            told = [line.strip() for line in self.errors if line.startswith("touchable: ")]
            self.error = told[-1].removeprefix("touchable: ") if told else f"Blender ended with code {self.process.returncode}"
        self.errors.close()
        self.folder.cleanup()

    def cancel(self):
        """Ends it, and all that it made goes with it, unless it has finished. Blender's window waits meanwhile, but not for ever."""
        self.process.terminate()
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        if self.process.returncode != 0:
            self.error = "cancelled"
