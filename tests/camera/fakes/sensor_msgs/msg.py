class CameraInfo:
    pass


class Image:
    pass
