#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests of the page in a real browser, against the program: page_test.py BROWSER PROGRAM PAGE_FOLDER OUT [TEST...]

BROWSER: Chromium or Firefox. PAGE_FOLDER: the built page with its engine. OUT: gets screenshots. A recording comes from
TOUCHABLE_TEST_DATA; without it a made clip stands in. Exit code 77: the browser or the page is not there."""
import base64
import json
import os
import pathlib
import random
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

import browser as drivers
from browser import Server

SOURCE = pathlib.Path(__file__).resolve().parents[2]
MOST_MEMORY = 512 << 20


def png(width, height, row, bits=16, rows=None):
    """A grey picture of these rows, or of equal ones. After a full flush of the compressor a row becomes the same bytes: quick."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    packer, checksum, line = zlib.compressobj(6, wbits=-15), 1, b"\0" + row
    packed = packer.compress(line) + packer.flush(zlib.Z_FULL_FLUSH)
    for _ in range(height):
        checksum = zlib.adler32(line, checksum)
    data = b"\x78\x9c" + packed * height + packer.flush(zlib.Z_FINISH) + struct.pack(">I", checksum)
    if rows:
        data = zlib.compress(b"".join(b"\0" + row for row in rows))
    head = struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


class Recording:
    """What a native run keeps (docs/touch.md, "The file"): goals, commands to the clip's clock, the hash of forces."""

    def __init__(self, file):
        data = file.read_bytes()
        self.fingers, = struct.unpack_from("<I", data, 12)
        facts_size, self.ticks = struct.unpack_from("<QQ", data, len(data) - 24)
        self.frames, goals, tick_size = set(), [], 40 + 52 * self.fingers
        for at in range(16, 16 + self.ticks * tick_size, tick_size):
            before, after, blend = struct.unpack_from("<qqd", data, at + 8)
            self.frames.update([before, after] if blend > 0 else [before])
            goals += [data[begin:begin + 24] for begin in range(at + 40, at + tick_size, 52)]
        self.goals = b"".join(goals)
        facts_at = len(data) - 24 - facts_size
        count, = struct.unpack_from("<Q", data, facts_at - 8)
        self.commands = [struct.unpack_from("<qIqq", data, facts_at - 8 - 28 * (count - k)) for k in range(count)]
        self.hash = json.loads(data[facts_at:facts_at + facts_size])["force_hash"]

    def run_in(self, browser, script):
        """Runs goals and commands in the worker of an open page, in virtual time, and then the script, to which
        `result` is what the worker answered. Frames are drawn as they are met."""
        return browser.run(f"""
            const bytes = Uint8Array.from(atob('{base64.b64encode(self.goals).decode()}'),
                                          letter => letter.charCodeAt(0));
            const result = await new Promise((resolve, refuse) => {{
                touchable.worker.addEventListener('message', ({{data}}) => {{
                    if (data.is === 'verified') resolve(data);
                    if (data.is === 'fault') refuse(new Error(data.text));
                }});
                touchable.worker.postMessage({{do: 'verify', goals: new Float64Array(bytes.buffer),
                    fingers: {self.fingers}, ticks: {self.ticks}, commands: {json.dumps(self.commands)}}});
            }});""" + script)


# Behind the page's scripts, whose names they know. Of the page: what tests read, and `advance`, which lets so many ms pass
# for an exhibit without a visitor. Of the worker: a run of a script in virtual time, from the clip's beginning, which draws
# the frames that it meets; and in each 'state' the times of a frame.
HOOKS = {"page": """
const touchable = globalThis.touchable = {
  frames_drawn: 0, errors: [],
  get worker() { return page.worker; },
  get clip() { return page.clip; },
  get state() { return page.state; },
  get pictures_drawn() { return picture.pictures; },
  advance(ms) {
    last_input -= ms;
    fault_at -= ms;
    watch_exhibit();
  }
};
addEventListener('error', (event) => touchable.errors.push(event.message));
addEventListener('unhandledrejection', (event) => touchable.errors.push(String(event.reason)));
const page_draws = draw, page_fails = show_fault;
draw = (state, is_new = false) => {
  const before = picture.pictures;
  page_draws(state, is_new);
  touchable.frames_drawn += is_new && picture.pictures > before;
};
show_fault = (text, ...more) => {
  touchable.errors.push(text);
  page_fails(text, ...more);
};
""", "worker": """
work.verify = async function verify({goals, fingers, ticks, commands: asked}) {
  session = new_session();
  const begin = () => {
    put(Float64Array.from([...goals, ...asked.flat()]));
    engine.begin(fingers, goals.length / 3, asked.length);
  };
  begin();
  let half = Math.floor(ticks / 2);  // where a clip that begins anew takes the moment up
  const frames = [], us = new Float64Array(ticks);  // what each tick took
  for (let tick = 0; tick < ticks;) {
    if (tick === half) {
      half = -1;
      const moment = memory(Uint8Array, check(engine.save()), engine.saved_bytes()).slice();
      begin();
      while (check(1 + engine.run(1)) === 1) await give_frame(engine.wanted());
      put(moment);
      check(engine.load(moment.length));
    }
    const start = performance.now(), ran = engine.run(1);
    check(ran >= 0);
    us[tick] = 1000 * (performance.now() - start);
    tick += ran;
    if (ran === 0) {
      const frame = engine.wanted();
      if (frame < 0) refuse('The clip has no frame for a tick.');
      await give_frame(frame);
      continue;
    }
    const planes = await new_planes();
    if (!planes) continue;
    frames.push(session.shown);
    tell(planes);
  }
  const hash = text_at(engine.hash());
  reset();
  postMessage({is: 'verified', hash, ticks, frames, us});
};

const times = {build_ms: 0, decode_ms: 0}, engine_gets = give_packet, engine_builds = give_frame, worker_looks = look;
let given = 0;
give_packet = (...packet) => {
  engine_gets(...packet);
  given = performance.now();
};
give_frame = async (frame) => {
  const begin = given = performance.now();
  await engine_builds(frame);
  Object.assign(times, {build_ms: performance.now() - given, decode_ms: given - begin});
};
look = () => ({...worker_looks(), ...times});
"""}


def copy_page(page, folder):
    """The built page, with hooks."""
    for file in page.iterdir():
        hooks = HOOKS.get(file.name.split("-")[0], "") if file.suffix == ".js" else ""
        (folder / file.name).write_bytes(file.read_bytes() + hooks.encode())


class Clips:
    """A folder for a server: globe/ has the page and a clip, rough/ and recording/ too."""

    def __init__(self, program, page):
        self.program, self.page = program, page
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="touchable-page-"))
        made = self.folder / "made"
        made.mkdir()
        self.make("globe", made / "globe.mkv", "--frames", 60)
        # Eight bits make terraces. Median and terraces' removal are stated, as they might not be chosen.
        self.make("rough", made / "rough.mkv", "--frames", 60, "--bits", 8)
        self.run("init-scene", made / "rough.mkv", "--out", made / "rough.json")
        scene = json.loads((made / "rough.json").read_text())
        scene["filter"] = {**scene.get("filter", {}), "median": 3, "terraces": "on"}
        (made / "rough.json").write_text(json.dumps(scene))
        data = pathlib.Path(os.environ.get("TOUCHABLE_TEST_DATA") or SOURCE / "../shared/data", "castel_sr300")
        self.make("noise", made / "noise.mkv", "--frames", 30)
        if not data.is_dir():
            data = made / "noise.mkv"
        for name, clip, *options in (("globe", made / "globe.mkv"), ("recording", data), ("noise", made / "noise.mkv"),
                                     ("rough", made / "rough.mkv", "--scene", made / "rough.json")):
            self.pack(clip, name, *options)
        shutil.copytree(SOURCE / "web/tests/packed_1", self.folder / "packed_1")  # of version 1

    def pack(self, clip, name, *options):
        self.run("convert", clip, self.folder / name, "--web", *options)
        copy_page(self.page, self.folder / name)

    def file_of(self, name, role):
        planes = json.loads((self.folder / name / "clip.json").read_text())["planes"]
        return self.folder / name / planes[role]["file"]

    def run(self, *arguments):
        done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"touchable {' '.join(map(str, arguments))}: {done.stderr}")

    def make(self, scene, file, *options):
        self.run("make", scene, file, "--size", "320x240", *options)

    def touch(self, name):
        """A native run of two wandering fingers over the packed clip, with a seek and a loop."""
        commands, kept = self.folder / f"made/{name}.txt", self.folder / f"made/{name}.rec"
        commands.write_text("0.25 seek 0.5\n0.6 loop 0.1 0.4\n")
        self.run("touch", self.folder / name / "clip.json", "--hand", "wander:extent=0.4", "--fingers", 2,
                 "--play", commands, "--seconds", 1.2, "--record", kept, "--overwrite")
        return Recording(kept)


SHOWN = """const shown = [...document.querySelectorAll('#message:not([hidden]) p, #notice:not([hidden]) p')]
    .map(one => one.textContent).join(' ');"""


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = BROWSER()
        cls.server = Server(CLIPS.folder).__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.server.__exit__()

    def open(self, path="globe/index.html", server=None):
        self.errors_before = len(self.browser.errors())
        self.browser.open((server or self.server).url + path)
        self.browser.wait("return touchable.state && touchable.frames_drawn > 0")

    def press(self, kind="mouse", **settings):
        """Presses where the picture's middle is, until the page shows a force. Returns that, newtons."""
        x, y = self.middle()
        if kind == "mouse":
            self.browser.pointer(kind, "move", x - 3, y)
        self.browser.pointer(kind, "down", x, y, **settings)
        return float(self.browser.wait("const shown = document.querySelector('#force b').textContent;"
                                       "return touchable.state.newtons > 0 && +shown > 0 && shown"))

    def release(self, kind="mouse"):
        self.browser.pointer(kind, "up", *self.middle())
        self.browser.wait("return touchable.state.newtons === 0")

    def middle(self):
        return self.browser.run("const box = document.getElementById('picture').getBoundingClientRect();"
                                "return [Math.round(box.x + box.width / 2), Math.round(box.y + box.height / 2)]")

    def expect_no_errors(self):
        self.assertEqual(self.browser.run("return touchable.errors"), [])
        self.assertEqual(self.browser.errors()[self.errors_before:], [])

    def expect_responsive(self):
        """The page draws on, whatever became of its clip."""
        self.browser.run("for (let k = 0; k < 3; ++k) await new Promise(requestAnimationFrame)")
        if self.browser.name == "Chromium":
            self.assertLess(self.browser.memory(), MOST_MEMORY)

    def packed(self):
        return json.loads((CLIPS.folder / "globe/clip.json").read_text())

    def test_plays_and_is_pressed(self):
        self.open()
        self.assertFalse(self.browser.run("return document.getElementById('invitation').hidden"))
        self.browser.wait("return touchable.state.playing && touchable.frames_drawn > 3 && touchable.state.time > 0.2")
        self.press()
        self.release()
        self.press("touch")
        self.release("touch")
        # The picture is there: many colours, as a person would see it.
        picture = OUT / f"{self.browser.name}.png"
        self.browser.screenshot(picture)
        data = base64.b64encode(picture.read_bytes()).decode()
        colours = self.browser.run(f"""
            const image = new Image(); image.src = 'data:image/png;base64,{data}'; await image.decode();
            const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext('2d');
            context.drawImage(image, 0, 0);
            const pixels = new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer);
            return new Set(pixels).size""")
        self.assertGreater(colours, 500)
        self.expect_no_errors()

    def test_pen_presses_by_its_pressure(self):
        if self.browser.name != "Chromium":
            self.skipTest("Marionette knows no pens")
        self.open()
        self.browser.run("document.getElementById('play').click()")
        deepest = "return Math.max(...touchable.state.fingers.map(finger => finger.depth_mm))"
        self.press("pen", press=0.2)
        time.sleep(0.5)
        light = self.browser.run(deepest)
        self.browser.pointer("pen", "move", *self.middle(), press=0.9)
        self.browser.wait(deepest.replace("return", "return 1.5 * %r <" % light))
        self.release("pen")

    def test_hovering_presses_nowhere(self):
        """A random mouse without a button, while the view is turned, moved nearer and put back."""
        script = """
            let seed = 107, pressed = [], hovered = 0, x = innerWidth / 2, y = x;
            const random = (most) => (seed = seed * 16807 % 2147483647) / 2147483647 * most;
            const send = (message) => touchable.worker.postMessage(message);
            const hand = (verb, a, b = 0) => send({do: 'hand', verb, a, b});
            touchable.worker.addEventListener('message', ({data}) => data.newtons > 0 && pressed.push(data.newtons));
            for (let step = 0; step < 60; ++step) {
                const what = random(1), far = random(1) < 0.2 ? 300 : 20;
                if (what < 0.65) {
                    [x, y] = [x, y].map(at => Math.min(Math.max(at + random(2 * far) - far, 30), 290));
                    send({do: 'event', kind: 'moved', button: 0, x, y, seconds: step, press: 0});
                } else if (what < 0.78) hand('turn', random(40) - 20, random(20) - 10);
                else if (what < 0.83) hand('near_by', 0.8 + random(0.4));
                else if (what < 0.97) hand('home', 0);
                else hand('count', 1 + Math.floor(random(5)));
                for (let k = 0; k < 3; ++k)
                    for (const before = touchable.state; touchable.state === before;)
                        await new Promise(requestAnimationFrame);
                hovered += touchable.state.pick?.valid > 0 && touchable.state.fingers.some(finger => !finger.touching);
            }
            return [pressed, hovered]"""
        self.browser.size(360, 420)
        for name in ("globe", "rough", "recording", "noise"):
            with self.subTest(name):
                self.open(f"globe/index.html?clip=../{name}/clip.json")
                pressed, hovered = self.browser.run(script)
                self.assertEqual(pressed, [])
                self.assertGreater(hovered, 5)
        self.browser.size(1280, 800)

    def test_keys_touch_and_tell(self):
        self.open()
        self.browser.run("document.getElementById('picture').focus()")
        self.browser.key("ArrowRight")
        said, number = "return document.getElementById('said').textContent", r"\d+\.\d+"
        self.browser.wait("return touchable.state.fingers.some(finger => Math.abs(finger.depth_mm + 4) < 1)")
        self.browser.key("i")
        begin = f"globe: distance {number} metres, "
        self.assertRegex(self.browser.wait(said), begin + "[345].* above the surface, 0.0 newtons")
        self.browser.key("Enter", what="down")
        self.browser.wait("return touchable.state.newtons > 0")
        self.browser.key("i")
        self.browser.wait(said.replace(";", "") + ".includes('millimetres deep')")
        # The globe has no noise, so that no error bar holds.
        self.assertRegex(self.browser.run(said), begin + f"{number} millimetres deep, {number} newtons$")
        self.browser.key("Enter", what="up")
        self.browser.wait("return touchable.state.newtons === 0")
        self.expect_no_errors()

    def test_shows_error_bars_of_noise(self):
        film = CLIPS.folder / "made/film"
        film.mkdir()
        random.seed(7)
        for frame in range(4):
            rows = [b"".join(struct.pack(">H", 1000 + y + round(random.gauss(0, 3))) for _ in range(320)) for y in range(240)]
            (film / f"depth_{frame:06}.png").write_bytes(png(320, 240, b"", rows=rows))
        CLIPS.run("convert", film, CLIPS.folder / "film", "--web")
        self.open("globe/index.html?clip=../film/clip.json")
        self.press()
        self.browser.wait("return touchable.state.fingers.some(finger => finger.error_degrees > 0)", 20)
        self.release()

    def test_forces_equal_native_ones(self):
        for name in ("globe", "rough", "recording", "packed_1"):
            with self.subTest(name):
                native = CLIPS.touch(name)
                self.assertGreaterEqual(len(native.frames), 20)
                self.open(f"globe/index.html?clip=../{name}/clip.json")
                drawn = self.browser.run("return touchable.frames_drawn")
                result = native.run_in(self.browser, f"""
                    const {{hash, ticks, frames}} = result;
                    return {{hash, ticks, frames, drawn: touchable.frames_drawn - {drawn}}}""")
                self.assertEqual(result["hash"], native.hash)
                self.assertEqual(result["ticks"], native.ticks)
                # Of two frames that a tick lies between, one is drawn.
                self.assertLessEqual(set(result["frames"]), native.frames)
                self.assertGreaterEqual(len(set(result["frames"])), 20)
                self.assertGreaterEqual(result["drawn"], 20)
                self.expect_no_errors()

    def test_a_server_without_ranges(self):
        with Server(CLIPS.folder, ranges=False) as server:
            self.open(server=server)
            self.browser.wait("return touchable.state.time > 0.5")
            self.press()
            self.release()
            self.expect_no_errors()

    def test_opens_a_picture(self):
        ramp = b"".join(struct.pack(">H", 500 + k // 4) for k in range(320))
        file = CLIPS.folder / "made/ramp.png"
        file.write_bytes(png(320, 240, ramp))
        self.open()
        self.browser.choose_file("#file", file)
        self.browser.wait("return document.getElementById('ask').open")
        self.browser.run("document.querySelector('#ask button.main').click()")
        # A press before the picture's first tick meets no hand.
        self.browser.wait("const {clip, state} = touchable; return clip.frames === 1 && state?.tick > 0")
        self.press()
        # In the middle of the ramp: 0.54 m.
        self.browser.wait("return Math.abs(touchable.state.pick?.depth_m - 0.54) < 0.002")
        self.release()
        self.expect_no_errors()

    def test_a_ball_is_no_bowl(self):
        """Depth without a unit: near is what the program takes for near, and what a person says instead."""
        near = [[max(0, 4096 - (x - 80) ** 2 - (y - 60) ** 2) ** 0.5 for x in range(160)] for y in range(120)]
        self.open()
        file = CLIPS.folder / "made/none.png"
        file.write_bytes(b"no picture")
        self.browser.choose_file("#file", file)
        self.browser.wait(SHOWN + "return /not a PNG/.test(shown)")
        cases = {"white": lambda z: 2 * z + 90 if z else 0, "black": lambda z: 160 - 2 * z if z else 255}
        for near_is, levels in cases.items():
            with self.subTest(near_is):
                file = CLIPS.folder / f"made/{near_is}.png"
                file.write_bytes(png(160, 120, b"", 8, [bytes(int(levels(z)) for z in row) for row in near]))
                told = subprocess.run([CLIPS.program, "info", file], capture_output=True, text=True).stdout
                self.assertIn("large values near" if near_is == "white" else "small values near", told)
                self.browser.choose_file("#file", file)
                self.assertEqual(self.browser.wait("return document.getElementById('ask').open &&"
                                                   "document.getElementById('unit').value"), near_is)
                self.assertEqual(self.browser.run(SHOWN + "return shown"), "")  # the earlier file's fault has gone
                for said in "", near_is:  # a length that is none is not asked for any more
                    self.browser.run(f"""const unit = document.getElementById('unit');
                        unit.value = '{said}', document.getElementById('level').value = 'x';
                        unit.dispatchEvent(new Event('input', {{bubbles: true}}))""")
                self.assertIn("Nearest 0.5 m, farthest 1.5 m",
                              self.browser.run("return document.getElementById('extent').textContent"))
                self.browser.run("document.querySelector('#ask button.main').click()")
                self.browser.wait(f"return touchable.clip.name === '{near_is}.png' && touchable.state?.tick > 0")
                x, y = self.middle()
                self.browser.pointer("mouse", "move", x - 3, y)
                self.browser.pointer("mouse", "move", x, y)
                self.browser.wait("return Math.abs(touchable.state.pick?.depth_m - 0.5) < 0.01")
                self.browser.screenshot(OUT / f"{self.browser.name}-{near_is}.png")

    def test_refuses_a_huge_picture(self):
        file = CLIPS.folder / "made/huge.png"
        file.write_bytes(png(20000, 20000, b"\2\0" * 20000))
        self.open()
        self.browser.choose_file("#file", file)
        self.browser.wait(SHOWN + "return /20000/.test(shown)")
        self.expect_responsive()

    def test_hostile_clips_are_refused(self):
        file, engine = CLIPS.file_of("globe", "depth").name, next(CLIPS.page.glob("engine-*.bin")).name
        depth, text = ((CLIPS.folder / "globe" / name).read_bytes() for name in (file, "clip.json"))

        def changed(**members):
            return json.dumps({**json.loads(text), **members}).encode()

        planes, numbers = (json.loads(text)[name] for name in ("planes", "numbers"))
        cases = {
            "cut clip.json": {"clip.json": text[:len(text) // 2]},
            "cut depth": {file: depth[:len(depth) // 3]},
            "no depth": {file: b""},
            "huge sizes": {"clip.json": changed(planes={"depth": {**planes["depth"], "sizes": [1 << 40] * 60}})},
            "huge pictures": {"clip.json": changed(numbers={**numbers, "width": 16384, "height": 16384})},
            "large sizes": {"clip.json": changed(planes={"depth": {**planes["depth"], "sizes": [1 << 30] * 60}})},
            "many frames": {"clip.json": changed(frames=10 ** 9)},
            "an address elsewhere": {"clip.json": changed(planes={"depth": {**planes["depth"],
                                                                           "file": "http://192.0.2.1/depth.bin"}})},
            "no object": {"clip.json": b"[]"},
            "no numbers": {"clip.json": changed(numbers={})},
            "no WebAssembly": {engine: b"\0asm"},
        }
        for what, files in cases.items():
            changed_files = {f"globe/{name}": data for name, data in files.items()}
            with self.subTest(what), Server(CLIPS.folder, changed=changed_files) as server:
                self.browser.open(server.url + "globe/index.html")
                self.assertGreater(len(self.browser.wait(SHOWN + "return !/^Loading/.test(shown) && shown", 20)), 20)
                self.expect_responsive()
                self.assertFalse([url for url in self.browser.requests() if "192.0.2.1" in url])

    def test_flipped_bits_are_refused(self):
        random.seed(7)
        planes = json.loads((CLIPS.folder / "globe/clip.json").read_text())["planes"]
        for role in ("depth", "haptic", "height"):
            whole, size, flipped = CLIPS.file_of("globe", role).read_bytes(), planes[role]["sizes"][0], 0
            while flipped < 4:
                changed = bytearray(whole)
                changed[random.randrange(size)] ^= 1 << random.randrange(8)
                try:
                    zlib.decompress(changed[:size])
                    continue  # another way to pack the same picture
                except zlib.error:
                    flipped += 1
                files = {f"globe/{planes[role]['file']}": bytes(changed)}
                with self.subTest(role), Server(CLIPS.folder, changed=files) as server:
                    self.browser.open(server.url + "globe/index.html")
                    self.browser.wait(SHOWN + "return /damaged/.test(shown)", 20)

    def test_an_updated_clip_is_seen(self):
        if self.browser.name != "Chromium":
            self.skipTest("it cannot be told to stand still")
        moving = CLIPS.folder / "made/moving.mkv"
        begun = "return touchable.clip.frames === %d && touchable.state?.frame >= 0"
        CLIPS.make("moving", moving, "--frames", 32)  # more than the page fetches at first
        CLIPS.pack(moving, "site")
        for_ever = {"Cache-Control": "max-age=31536000, immutable"}
        self.browser.reduce_motion(True)
        self.addCleanup(self.browser.reduce_motion, False)
        with Server(CLIPS.folder, headers=for_ever) as server:
            self.open("site/index.html", server)
            # Of the clip that is open the files go, and with them what was not fetched yet.
            CLIPS.pack(CLIPS.folder / "made/globe.mkv", "site", "--overwrite")
            self.browser.run("document.getElementById('play').click()")
            self.browser.wait(begun % 60)
            self.assertEqual(self.browser.run("return touchable.errors"), [])
            CLIPS.pack(moving, "site", "--overwrite")
            self.open("site/index.html", server)
            self.browser.wait(begun % 32)
            self.expect_no_errors()

    def test_a_server_that_stops(self):
        for file in (CLIPS.file_of("globe", "depth").name, next(CLIPS.page.glob("engine-*.bin")).name, "clip.json"):
            cut = {"globe/" + file: (CLIPS.folder / "globe" / file).stat().st_size // 2}
            with self.subTest(file), Server(CLIPS.folder, ranges=False, cut=cut) as server:
                self.browser.open(server.url + "globe/index.html")
                self.assertGreater(len(self.browser.wait(SHOWN + "return !/^Loading/.test(shown) && shown", 20)), 20)
                self.expect_responsive()

    def test_begins_anew_after_a_fault(self):
        clip, page = "globe/clip.json", "globe/index.html"
        for query, again in (("?kiosk", "touchable.advance(60000)"), ("", "document.getElementById('again').click()")):
            with self.subTest(query), Server(CLIPS.folder, changed={clip: b"<html>"}) as server:
                self.browser.open(server.url + page + query)
                self.browser.wait(SHOWN + "return /no JSON/.test(shown)", 20)
                server.changed[page] = None  # a page that cannot be had is not left
                asked = server.asked.count(page)
                self.browser.run(again)
                end = time.monotonic() + 60
                while server.asked.count(page) == asked and time.monotonic() < end:
                    time.sleep(0.05)
                self.assertGreater(server.asked.count(page), asked)
                self.browser.wait(SHOWN + "return /no JSON/.test(shown)", 20)
                server.changed.clear()
                self.browser.run(again)
                self.browser.wait("return globalThis.touchable?.state?.time > 0.1")

    def test_goes_on_after_a_fault(self):
        haptic = "globe/" + self.packed()["planes"]["haptic"]["file"]
        closed = "document.getElementById('notice').click(); document.getElementById('seek').dispatchEvent(new Event('input'))"
        for again in "document.getElementById('go-on').click()", closed:
            cut = {haptic: (CLIPS.folder / haptic).read_bytes()[:80000]}
            with self.subTest(again), Server(CLIPS.folder, changed=cut) as server:
                self.open(server=server)
                self.browser.wait(SHOWN + "return /shorter/.test(shown)")
                server.changed.clear()
                self.browser.run(again)
                self.browser.wait(SHOWN + "return touchable.state.frame > 50 && !shown")

    def test_a_live_page_connects_again(self):
        clip = self.packed()
        depth = clip["planes"]["depth"]
        size = depth.pop("sizes")[0]
        packet = (CLIPS.folder / "globe" / depth["file"]).read_bytes()[:size]

        def live(name, numbers={}):
            scene = {**clip["numbers"], **numbers}
            text = json.dumps({**clip, "name": name, "live": "live", "planes": {"depth": depth}, "numbers": scene})
            frameset = struct.pack("<4Id", size, 0, 0, 0, 0) + packet
            return {"globe/clip.json": text.encode(), "globe/live": 3 * frameset}

        with Server(CLIPS.folder, changed=live("one")) as server:
            self.open(server=server)
            self.browser.wait("return touchable.state.frame > 6")  # of the third connection
            server.changed["globe/live"] = None
            self.browser.wait(SHOWN + "return /404/.test(shown)")
            server.changed.update(live("another", {"depth.bits": 99}))  # as of a server that is being started
            self.browser.wait(SHOWN + "return /no scene has/.test(shown)")
            server.changed.update(live("another"))
            self.browser.wait(SHOWN + "return touchable.clip.name === 'another' && touchable.state?.frame > 0 && !shown")
            server.changed.update(live("newer", {"unknown": 1}))
            self.browser.wait(SHOWN + "return /another version/.test(shown) && !document.getElementById('again').hidden")

    def test_a_slow_page_sees_all_of_a_clip(self):
        worker = next((CLIPS.folder / "globe").glob("worker-*.js"))
        text = worker.read_text() + "let clock = 0, begun = false, left = 0, done; performance.now = () => clock;"
        # In virtual time a frame takes eleven animation frames of 100 ms, and nothing else takes any.
        for begin, more in {
                "const work = {": "on() { begun = true; },",
                "function run_elapsed() {":
                    "if (begun && (left || !session.feeding)) clock += 100; if (left && !--left) done();",
                "async function give_frame(frame) {": "await new Promise((given) => { left = 11; done = given; });"
        }.items():
            self.assertIn(begin, text)
            text = text.replace(begin, begin + more)
        with Server(CLIPS.folder, changed={f"globe/{worker.name}": text.encode()}) as server:
            self.browser.open(server.url + "globe/index.html")
            self.browser.wait(SHOWN + "return touchable.clip && shown === 'Loading the first picture …'")
            self.assertNotRegex(self.browser.run("return document.body.innerText"), "off|×|frame")
            self.browser.run("""const {worker} = touchable, thirds = new Set();
                worker.addEventListener('message', ({data: {frame}}) => {
                    if (frame >= 0) document.body.dataset.thirds = thirds.add(Math.floor(frame / 20)).size;
                });
                worker.postMessage({do: 'on'})""")
            self.browser.wait("return document.body.dataset.thirds === '3'")

    def test_names_a_policy_that_forbids_webassembly(self):
        with Server(CLIPS.folder, headers={"Content-Security-Policy": "script-src 'self'"}) as server:
            self.browser.open(server.url + "globe/index.html")
            self.browser.wait(SHOWN + "return /wasm-unsafe-eval/.test(shown)", 20)

    def test_policy_and_requests(self):
        with Server(CLIPS.folder) as server:
            self.browser.open("about:blank")  # the page of the test before asks for no more
            before = len(self.browser.requests()) if self.browser.name == "Chromium" else 0
            self.open(server=server)
            self.press()
            self.release()
            self.assertEqual([url for url in self.browser.requests()[before:] if not url.startswith(server.url)], [])
            self.assertIsNone(self.browser.run("""
                const script = document.createElement('script');
                script.textContent = 'globalThis.intruder = 1';
                document.body.append(script);
                return globalThis.intruder"""))

    def test_in_a_frame(self):
        frame = b"<!doctype html><iframe src='globe/index.html' width=600 height=400></iframe>"
        with Server(CLIPS.folder, changed={"frame.html": frame}) as server:
            self.browser.open(server.url + "frame.html")
            self.browser.wait("return frames[0].touchable?.state?.time > 0.1")

    def test_from_another_address(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("192.0.2.1", 9))  # sends nothing
                own = probe.getsockname()[0]
            except OSError:
                self.skipTest("this machine has no address but loopback")
        with Server(CLIPS.folder, host=own) as server, BROWSER(reached=own) as self.browser:
            self.open(server=server)
            self.press()
            self.release()
            self.expect_no_errors()
        self.browser = type(self).browser

    def test_an_hour_of_kiosk(self):
        self.open("globe/index.html?kiosk")
        self.assertEqual(self.browser.run("return [...document.querySelectorAll('a[href], #open, #fullscreen')]"
                                          ".filter(one => one.checkVisibility()).length"), 0)
        for minute in range(60):
            if minute % 6 == 0:
                x, y = self.middle()
                self.press()
                self.release()
                self.browser.pointer("mouse", "down", x, y, keys=["control"])
                self.browser.pointer("mouse", "move", x + 60, y, keys=["control"])
                self.browser.pointer("mouse", "up", x + 60, y)
                self.browser.wait("return !touchable.state.own_view")
            self.browser.run("touchable.advance(60000)")
            if minute % 6 == 0:  # the person has gone: as freshly opened
                self.browser.wait("return touchable.state.own_view && !document.getElementById('invitation').hidden")
        self.expect_no_errors()
        self.expect_responsive()

    def test_less_motion(self):
        if self.browser.name != "Chromium":
            self.skipTest("set by a preference there")
        self.browser.reduce_motion(True)
        self.open()
        time.sleep(0.5)
        self.assertFalse(self.browser.run("return touchable.state.playing"))
        self.browser.reduce_motion(False)

    def test_lab_forces_equal_native_ones(self):
        with Server(CLIPS.page) as server:
            self.browser.open(server.url + "lab.html")
            for experiment, cases in (("filters", 4), ("figure-19", 10)):
                start = f"document.querySelector('#{experiment} button')"
                self.browser.wait(f"return !!{start}")
                self.browser.run(start + ".click()")
                self.browser.wait("return document.getElementById('status').textContent === "
                                  f"\"Done. Force hashes: {cases} equal the program's, 0 do not.\"")
            self.assertFalse([name for name in server.asked if re.match(r"engine-.*\.bin", name)])

    def test_one_file_from_disk(self):
        file = OUT / "touch.html"
        subprocess.run([SOURCE / "web/build.py", "one-file", CLIPS.folder / "globe", CLIPS.folder / "globe", file], check=True)
        self.assertLessEqual(file.stat().st_size, 3_000_000)
        before = len(self.browser.requests()) if self.browser.name == "Chromium" else 0
        self.browser.open(file.resolve().as_uri())
        self.browser.wait("return touchable.state?.time > 0.2")
        self.press()
        self.release()
        others = [url for url in self.browser.requests()[before:] if not url.startswith(("file:", "blob:", "data:"))]
        self.assertEqual(others, [])
        self.assertEqual(self.browser.run("return touchable.errors"), [])

    def test_pictures_of_the_page(self):
        """To be judged by a person: OUT/BROWSER-WIDTHxHEIGHT.png, first screen and pressed."""
        for width, height in (1280, 800), (1024, 768), (390, 844):
            self.browser.size(width, height)
            self.open()
            self.browser.wait("return touchable.frames_drawn > 3")
            self.browser.screenshot(OUT / f"{self.browser.name}-{width}x{height}.png")
            self.press()
            self.browser.wait("return touchable.state.newtons > 0.5")
            self.browser.screenshot(OUT / f"{self.browser.name}-{width}x{height}-pressed.png")
            self.release()
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth - innerWidth"), 0)
        self.browser.size(1280, 800)
        self.expect_no_errors()


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    name, program, page, OUT = sys.argv[1], *map(pathlib.Path, sys.argv[2:5])
    BROWSER = getattr(drivers, name)
    if not BROWSER.program():
        print(f"{name} is not installed: the page is not tested in it")
        sys.exit(77)
    if not any(page.glob("engine-*.bin")):
        print("the page was not built: its compiler is missing (./run install web)")
        sys.exit(77)
    OUT.mkdir(parents=True, exist_ok=True)
    CLIPS = Clips(program, page)
    try:
        unittest.main(argv=[sys.argv[0], *(f"Page.{test}" for test in sys.argv[5:])], verbosity=2)
    finally:
        shutil.rmtree(CLIPS.folder)
