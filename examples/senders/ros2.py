# SPDX-License-Identifier: Apache-2.0
"""Any camera that ROS 2 has: depth of 16 bits (16UC1, millimetres) and its camera_info.
touchable play --camera "pipe:python3 ros2.py [DEPTH_TOPIC INFO_TOPIC]" """
import sys
import rclpy
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image
from framesets import send

depth_topic, info_topic = sys.argv[1:3] or ("/camera/depth/image_rect_raw", "/camera/depth/camera_info")
lens, number = None, 0

def take_lens(info):
    global lens
    lens = info.k[0], info.k[4], info.k[2], info.k[5]

def take_depth(image):
    global number
    if image.encoding not in ("16UC1", "mono16") or image.is_bigendian:
        sys.exit(f"{depth_topic} has {image.encoding}; must be 16UC1, little-endian, in millimetres")
    if lens is None:
        return
    data, used = bytes(image.data), 2 * image.width
    rows = b"".join(data[y * image.step:y * image.step + used] for y in range(image.height))
    stamp = image.header.stamp
    send(rows, image.width, image.height, 0.001, *lens, stamp.sec * 10**9 + stamp.nanosec, number)
    number += 1

rclpy.init()
node = rclpy.create_node("touchable_sender")
node.create_subscription(CameraInfo, info_topic, take_lens, qos_profile_sensor_data)
node.create_subscription(Image, depth_topic, take_depth, qos_profile_sensor_data)
rclpy.spin(node)
