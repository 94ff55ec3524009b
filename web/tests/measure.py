#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the page in Chromium, on a quiet machine: measure.py PROGRAM PAGE_FOLDER

Prints times of ticks against the program's, frames built a second by size, pictures a second at a CPU slowed by 4, the
time from a link to the first force with cold caches, on loopback and by 10 Mbit/s and 50 ms, and bytes loaded."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from browser import Chromium, Server
from page_test import Recording, copy_page

MBIT = 125_000  # bytes
# A page that is isolated so has a clock of 5 microseconds, else of 100.
ISOLATED = {"Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Embedder-Policy": "require-corp"}


def program(*arguments):
    done = subprocess.run([str(argument) for argument in arguments], capture_output=True, text=True, check=True)
    return done.stdout


def packed(touchable, page, folder, size):
    clip = folder / f"globe{size}.mkv"
    program(touchable, "make", "globe", clip, "--size", size, "--frames", 60)
    program(touchable, "convert", clip, folder / size, "--web")
    copy_page(page, folder / size)
    return folder / size


def press(browser):
    """Milliseconds from the link to the first force, with a pointer that waits there."""
    x, y = browser.run("return [innerWidth / 2, innerHeight / 2].map(Math.round)")
    browser.wait("return globalThis.touchable?.frames_drawn > 0")
    browser.pointer("mouse", "move", x - 2, y)
    browser.pointer("mouse", "down", x, y)
    return browser.run("""while (!(touchable.state.newtons > 0)) await new Promise(requestAnimationFrame);
                          return performance.now()""")


def verified(browser, recording):
    """Hash, and microseconds a tick: mean, and the least that 99 % do not exceed."""
    return recording.run_in(browser, """
        const us = result.us.sort();
        return {hash: result.hash, mean: us.reduce((a, b) => a + b) / us.length,
                p99: us[Math.ceil(0.99 * us.length) - 1]}""")


def main(touchable, page):
    page = pathlib.Path(page)
    name = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    print(f"processor: {name.group(1) if name else 'unknown'}; {Chromium.program()}")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="touchable-measure-"))
    try:
        for size in ("320x240", "640x480", "1280x720"):
            clip, kept = packed(touchable, page, folder, size), folder / f"{size}.rec"
            report = json.loads(program(touchable, "touch", clip / "clip.json", "--hand", "wander:extent=0.4",
                                        "--seconds", 1.9, "--record", kept, "--json"))
            native, build = report["tick_us"], report["frame_ms"]
            with Server(folder, headers=ISOLATED) as server, Chromium() as browser:
                browser.open(f"{server.url}{size}/index.html")
                browser.wait("return touchable.frames_drawn > 0")
                ours = verified(browser, Recording(kept))
                # Of the frames of some seconds of play.
                decoded, built = browser.run("""const decoded = [], built = [];
                    for (const end = performance.now() + 4000; performance.now() < end;) {
                        await new Promise(requestAnimationFrame);
                        decoded.push(touchable.state.decode_ms), built.push(touchable.state.build_ms);
                    }
                    return [decoded, built].map(all => all.reduce((a, b) => a + b) / all.length)""")
            print(f"{size}: a tick {ours['mean']:.2f} us, 99 % {ours['p99']:.1f} us (program {native['mean']:.2f}, "
                  f"{native['p99']:.2f}); a frame: decoded in {decoded:.1f} ms, built in {built:.1f} ms (program "
                  f"{build['mean']:.2f} ms), {1000 / (decoded + built):.0f} a second; hash "
                  f"{'equal' if ours['hash'] == report['force_hash'] else 'DIFFERS'}")
        for factor in (1, 4):
            with Server(folder) as server, Chromium() as browser:
                browser.open(server.url + "320x240/index.html")
                press(browser)
                browser.slow_down(factor)
                # After what it takes to adapt. A picture is an animation frame with what is newest, drawn or unchanged.
                shown, frames = browser.run("""await new Promise(done => setTimeout(done, 3000));
                    let states = 0, drawn = touchable.pictures_drawn;
                    touchable.worker.addEventListener('message', ({data}) => { states += data.is === 'state'; });
                    const begin = performance.now();
                    await new Promise(done => setTimeout(done, 5000));
                    const seconds = (performance.now() - begin) / 1000;
                    return [states, touchable.pictures_drawn - drawn].map(count => count / seconds)""")
                print(f"pictures a second while pressed, the page's CPU slowed by {factor}: {shown:.0f}, of which {frames:.0f} "
                      "have a new surface, of a clip with 30")
        for name, link in (("loopback", {}), ("10 Mbit/s, 50 ms", {"rate": 10 * MBIT, "delay": 0.05})):
            for size in ("320x240", "640x480"):
                with Server(folder, **link) as server, Chromium() as browser:
                    browser.open(f"{server.url}{size}/index.html")
                    print(f"{name}, {size}: from the link to the first force {press(browser) / 1000:.2f} s; "
                          f"{server.sent / 1000:.0f} kB until then, {len(server.asked)} requests")
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
