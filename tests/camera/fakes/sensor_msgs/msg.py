# SPDX-License-Identifier: Apache-2.0
class CameraInfo:
    pass


class Image:
    pass
