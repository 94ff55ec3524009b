# SPDX-License-Identifier: Apache-2.0
"""As far as oak.py uses it, version 2."""
from datetime import timedelta
from types import SimpleNamespace as Some
import scene, time

CameraBoardSocket = Some(CAM_B=1, CAM_C=2)
MonoCameraProperties = Some(SensorResolution=Some(THE_400_P=2))

class Plug:
    def __init__(self):
        self.linked = None

    def link(self, other):
        other.linked = self

class node:
    class StereoDepth:
        PresetMode = Some(HIGH_DENSITY=1)

        def __init__(self):
            self.left, self.right, self.depth = Plug(), Plug(), Plug()

        def setDefaultProfilePreset(self, mode):
            pass

    class MonoCamera:
        def __init__(self):
            self.out = Plug()

        def setBoardSocket(self, socket):
            pass

        def setResolution(self, resolution):
            pass

    class XLinkOut:
        def __init__(self):
            self.input = Plug()

        def setStreamName(self, name):
            self.name = name

class Pipeline:
    def __init__(self):
        self.made = []

    def create(self, kind):
        self.made.append(kind())
        return self.made[-1]

class Device:
    def __init__(self, pipeline):
        stereo = next(made for made in pipeline.made if isinstance(made, node.StereoDepth))
        out = next(made for made in pipeline.made if isinstance(made, node.XLinkOut))
        assert stereo.left.linked and stereo.right.linked and out.input.linked is stereo.depth
        self.name, self.number = out.name, 0

    def __enter__(self):
        return self

    def __exit__(self, *why):
        pass

    def readCalibration(self):
        return Some(getCameraIntrinsics=lambda socket, width, height: [[60.0, 0, 31.5], [0, 60.0, 23.5], [0, 0, 1]])

    def getOutputQueue(self, name, maxSize, blocking):
        assert name == self.name and not blocking
        return self

    def get(self):
        scene.wait()
        self.number += 1
        number = self.number
        return Some(getFrame=lambda: scene.Array(scene.picture(number), (scene.height, scene.width)),
                    getWidth=lambda: scene.width, getHeight=lambda: scene.height,
                    getTimestamp=lambda: timedelta(seconds=time.monotonic()), getSequenceNum=lambda: number)
