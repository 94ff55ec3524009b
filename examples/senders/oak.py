# SPDX-License-Identifier: Apache-2.0
"""Luxonis OAK-D, by depthai 2: depth of the two grey cameras, as the right one sees it.
touchable play --camera "pipe:python3 oak.py" """
import depthai as dai
from framesets import send

pipeline = dai.Pipeline()
stereo = pipeline.create(dai.node.StereoDepth)
stereo.setDefaultProfilePreset(dai.node.StereoDepth.PresetMode.HIGH_DENSITY)
for socket, eye in ((dai.CameraBoardSocket.CAM_B, stereo.left), (dai.CameraBoardSocket.CAM_C, stereo.right)):
    camera = pipeline.create(dai.node.MonoCamera)
    camera.setBoardSocket(socket)
    camera.setResolution(dai.MonoCameraProperties.SensorResolution.THE_400_P)
    camera.out.link(eye)
out = pipeline.create(dai.node.XLinkOut)
out.setStreamName("depth")
stereo.depth.link(out.input)
with dai.Device(pipeline) as device:
    queue = device.getOutputQueue("depth", maxSize=1, blocking=False)
    lens = None
    while True:
        frame = queue.get()
        width, height = frame.getWidth(), frame.getHeight()
        if lens is None:
            lens = device.readCalibration().getCameraIntrinsics(dai.CameraBoardSocket.CAM_C, width, height)
        send(frame.getFrame().tobytes(), width, height, 0.001, lens[0][0], lens[1][1], lens[0][2], lens[1][2],
             int(frame.getTimestamp().total_seconds() * 1e9), frame.getSequenceNum())
