# SPDX-License-Identifier: Apache-2.0
"""As far as realsense.py uses it; a D405's unit."""
from types import SimpleNamespace as Some
import scene, time

stream, format = Some(depth="depth", color="color"), Some(z16="z16", rgb8="rgb8")

class config:
    def __init__(self):
        self.streams = []

    def enable_stream(self, *asked):
        self.streams.append(asked)

class Frame:
    def __init__(self, data, number):
        self.data, self.number = data, number

    def get_data(self):
        return memoryview(self.data)

    def get_timestamp(self):  # ms, of a clock of its own
        return 1.7e12 + 1000 * time.monotonic()

    def get_frame_number(self):
        return self.number

    def get_width(self):
        return scene.width

    def get_height(self):
        return scene.height

class pipeline:
    def start(self, config):
        assert config.streams == [("depth", 640, 480, "z16", 30), ("color", 640, 480, "rgb8", 30)]
        self.number = 0
        lens = Some(width=scene.width, height=scene.height, fx=60.0, fy=60.0, ppx=31.5, ppy=23.5)
        video = Some(as_video_stream_profile=lambda: Some(get_intrinsics=lambda: lens))
        sensor = Some(get_depth_scale=lambda: 0.0001)
        return Some(get_device=lambda: Some(first_depth_sensor=lambda: sensor), get_stream=lambda which: video)

    def wait_for_frames(self):
        scene.wait()
        self.number += 1
        return self.number

    def stop(self):
        pass

class align:
    def __init__(self, onto):
        assert onto == "depth"

    def process(self, number):
        depth = Frame(scene.picture(number, 10000), number)
        colour = Frame(bytes((200, 100, 50)) * (scene.width * scene.height), number)
        return Some(get_depth_frame=lambda: depth, get_color_frame=lambda: colour)
