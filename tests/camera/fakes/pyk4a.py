# SPDX-License-Identifier: Apache-2.0
"""As far as azure_kinect.py uses it."""
from types import SimpleNamespace as Some
import scene, time

CalibrationType, DepthMode, FPS = Some(DEPTH=0), Some(NFOV_UNBINNED=2), Some(FPS_30=2)
ColorResolution, ImageFormat = Some(RES_720P=1), Some(COLOR_BGRA32=3)

def Config(**settings):
    return settings

class PyK4A:
    def __init__(self, config):
        assert config["synchronized_images_only"] and config["color_format"] == ImageFormat.COLOR_BGRA32
        self.number = 0
        matrix = ((60.0, 0.0, 31.5), (0.0, 60.0, 23.5), (0.0, 0.0, 1.0))
        self.calibration = Some(get_camera_matrix=lambda which: matrix)

    def start(self):
        pass

    def stop(self):
        pass

    def get_capture(self):
        scene.wait()
        self.number += 1
        shape = scene.height, scene.width
        if self.number == 1:  # the first has no colour yet
            return Some(depth=scene.Array(scene.picture(1), shape), transformed_color=None)
        bgra = bytes((50, 100, 200, 255)) * (scene.width * scene.height)
        return Some(depth=scene.Array(scene.picture(self.number), shape),
                    transformed_color=scene.Array(bgra, shape + (4,)),
                    depth_timestamp_usec=int(time.monotonic() * 1e6) % 10**9)
