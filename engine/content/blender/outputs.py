# SPDX-License-Identifier: Apache-2.0
"""Where an export goes: a clip, where `touchable` is there to make one, or the folder of its pictures. It appears whole or not at all."""

import os
import re
import shlex
import shutil
import subprocess
import tempfile
import threading

from .faults import BadUsage, Fault

# For code that ends this process: children to end, folders to remove, and a lock held wherever an end would leave something behind.
children, folders, steady = [], [], threading.Lock()
CLIPS = (".mkv", ".mp4", ".gltf")
PICTURE_NAME = re.compile(r"(depth|colour|haptic|height)(_\d{6,})?\.png|depth_\d{6,}\.exr|scene\.json|depth\.txt")


def program(named):
    """The path of `touchable`: as named, from $TOUCHABLE, or where programs are; None: it is not there."""
    for name in (named, os.environ.get("TOUCHABLE")):
        if name:
            found = shutil.which(os.path.expanduser(name))
            if not found:
                raise BadUsage(f"'{name}' is no program; must be the path of touchable")
            return found
    return shutil.which("touchable")


def is_clip(path):
    return path.lower().endswith(CLIPS)


def final_path(output, touchable):
    """What will be there in the end: the output itself, or for want of the program a folder of its name."""
    return output if touchable or not is_clip(output) else os.path.splitext(output)[0]


def check_output(output, touchable, overwrite):
    """Refuses what cannot be written, before anything is rendered."""
    if not is_clip(output) and os.path.splitext(os.path.basename(output.rstrip("/")))[1]:
        raise BadUsage(f"'{output}' is no clip and no folder; must be NAME.mkv, or a name without a dot for the folder of pictures")
    if os.path.basename(output).lower() in CLIPS:
        raise BadUsage(f"'{output}' has no name before its ending; must be NAME.mkv")
    final = final_path(output, touchable)
    folder = os.path.dirname(os.path.abspath(final))
    if not os.path.isdir(folder):
        raise BadUsage(f"'{folder}' is no folder, and the output shall be there")
    if not os.access(folder, os.W_OK):
        raise BadUsage(f"'{folder}' cannot be written to")
    if os.path.lexists(final):
        if final != output:
            # --overwrite lets a clip be replaced, but not a folder of its name.
            raise BadUsage(f"touchable is not installed here, so '{final}' would be a folder of pictures, and it is there already; give another name")
        if not overwrite:
            raise BadUsage(f"'{final}' is there already; --overwrite replaces it")
        _check_replaced(final)


def _check_replaced(final):
    """A clip replaces a file, and a folder of pictures one in which nothing else is: what `touchable` itself replaces."""
    if is_clip(final):
        if not os.path.isfile(final):
            raise BadUsage(f"'{final}' is no file, and is not replaced; give another name")
    elif os.path.islink(final) or not os.path.isdir(final):
        raise BadUsage(f"'{final}' is no folder, and is not replaced; give another name")
    elif not all(entry.is_file() and PICTURE_NAME.fullmatch(entry.name) for entry in os.scandir(final)):
        raise BadUsage(f"'{final}' is a folder of something else, and is not replaced; give another name")


def work_folder(output):
    """An empty one beside the output, on the same disk, so that it can become the output."""
    with steady:
        folder = tempfile.mkdtemp(prefix=".touchable-", dir=os.path.dirname(os.path.abspath(output)))
        folders.append(folder)
    return folder


def publish(work, output, touchable, overwrite, say):
    """The pictures in `work` become the output; returns what that is."""
    final = final_path(output, touchable)
    if is_clip(final):
        _convert(work, final, touchable, overwrite)
    else:
        _become(work, final, overwrite and final == output)
        if is_clip(output):
            say(f"touchable is not installed here, so this is a folder of pictures; where it is: touchable convert {shlex.quote(final)} {shlex.quote(output)}")
    return final


def _convert(work, final, touchable, overwrite):
    command = [touchable, "convert", work, final] + (["--overwrite"] if overwrite else [])
    before = _state(final)
    # In a session of its own, so that Ctrl-C reaches it only through this process.
    with steady:
        running = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                   start_new_session=True)
        children.append(running)
    told = running.communicate()[1].strip()
    with steady:  # blocks for ever once a signal has ended `running`
        children.remove(running)
    if running.returncode != 0:
        last = (told or f"it ended with code {running.returncode}").splitlines()[-1]
        fault = Fault(f"touchable convert: {last.removeprefix('touchable: ')}")
        fault.code = running.returncode if running.returncode > 0 else 1
        raise fault
    # The user may have named any program, and `true` succeeds as well.
    if _state(final) in (None, before) or os.path.getsize(final) == 0:
        raise Fault(f"'{touchable}' wrote no clip; must be the path of touchable")


def _state(path):
    """Something else once the file is written anew; None: it is not there."""
    try:
        found = os.stat(path)
    except FileNotFoundError:
        return None
    return found.st_ino, found.st_mtime_ns, found.st_size


def _become(work, final, overwrite):
    os.chmod(work, 0o755)
    with steady:
        if not os.path.lexists(final):
            os.rename(work, final)
            return
        # It may have appeared, or changed, during rendering.
        if not overwrite:
            raise BadUsage(f"'{final}' is there by now; it stays as it is")
        _check_replaced(final)
        before = f"{work}-before"
        os.rename(final, before)
        try:
            os.rename(work, final)
        except BaseException:
            os.rename(before, final)
            raise
        shutil.rmtree(before, ignore_errors=True)
