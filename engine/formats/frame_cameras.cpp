#include "engine/formats/frame_cameras.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "engine/base/stop_request.hpp"
#include "engine/formats/camera_file.hpp"
#include "engine/formats/known_camera.hpp"

namespace touchable {

Result<std::vector<Camera>> read_frame_cameras(const PictureFiles& files, int width, int height) {
    constexpr double farthest = 1e6;                 // pixels; further off is a slip
    constexpr std::size_t most_frames = 10'000'000;  // each has its camera in memory
    if (files.count() > most_frames)
        return input_error(files.file(0).string() + ": is the camera of " + std::to_string(files.count()) +
                           " frames: at most " + std::to_string(most_frames) + " can have cameras");
    std::vector<Camera> cameras;
    for (std::size_t frame = 0; frame < files.count(); ++frame) {
        const std::filesystem::path& path = files.file(frame);
        if (frame > 0 && path == files.file(frame - 1)) {
            cameras.push_back(cameras.back());
            continue;
        }
        if (stop_requested())
            return Error{ErrorKind::interrupted, "interrupted while the cameras of the frames were read"};
        const std::string of_frame = " (camera, frame " + std::to_string(frame) + ")";
        const auto file = read_camera_file(path);
        if (!file) return Error{file.error().kind, file.error().message + of_frame};
        const Camera camera = scaled_camera(file->intrinsics, width, height);
        if (!(std::abs(camera.cx) < farthest) || !(std::abs(camera.cy) < farthest))
            return input_error(path.string() + of_frame +
                               ": its cx and cy must be pixels, nearer than 1e6 to the picture");
        cameras.push_back(camera);
    }
    return cameras;
}

Camera median_camera(std::span<const Camera> cameras) {
    Camera median;
    for (double Camera::*const term : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy}) {
        std::vector<double> all;
        for (const Camera& camera : cameras) all.push_back(camera.*term);
        const auto middle = all.begin() + static_cast<std::ptrdiff_t>((all.size() - 1) / 2);
        std::nth_element(all.begin(), middle, all.end());
        median.*term = *middle;
    }
    return median;
}

double PixelShift::length() const {
    return std::sqrt(columns * columns + rows * rows);
}

PixelShift shift_between(const Camera& clip, const Camera& stored, int width, int height) {
    // It grows or falls steadily along a row and a column: the largest is at an edge.
    PixelShift shift;
    const auto along = [&](double clip_f, double clip_c, double stored_f, double stored_c, int size) {
        double largest = 0;
        for (const double edge : {0.0, size - 1.0}) {
            const double there = stored_f * ((edge - clip_c) / clip_f) + stored_c;
            largest = std::max(largest, std::abs(there - edge));
            shift.is_inside &= there >= -0.5 && there < size - 0.5;
        }
        return largest;
    };
    shift.columns = along(clip.fx, clip.cx, stored.fx, stored.cx, width);
    shift.rows = along(clip.fy, clip.cy, stored.fy, stored.cy, height);
    return shift;
}

}  // namespace touchable
