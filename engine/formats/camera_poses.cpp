// SPDX-License-Identifier: Apache-2.0
// The camera's poses, from files beside pictures: lists with times (TUM RGB-D), matrices of frames (Redwood,
// Open3D) and Record3D's metadata.json. Declared in camera_sidecar.hpp.

#include <sstream>

#include "engine/base/try.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;
using checked_json::Json;

constexpr std::size_t longest_poses = std::size_t{64} << 20, longest_metadata = std::size_t{16} << 20;
constexpr double most_apart_seconds = 0.02;  // between a frame and its pose

/// Poses in the order of the frames.
using PoseRow = std::vector<std::optional<CameraPose>>;

/// The pose of 4x4 numbers, the last row 0 0 0 1; metres. Nothing if they are no pose.
std::optional<CameraPose> pose_of_matrix(const std::array<double, 16>& m, double metres_per_unit) {
    const std::array<double, 9> rotation{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
    if (!is_rotation(rotation) || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1) return {};
    return pose_at(rotation, {m[3], m[7], m[11]}, metres_per_unit);
}

/// Parses Redwood's and Open3D's poses: a line of three numbers, the first that of the frame, then the matrix
/// from the camera to the world.
Result<PoseRow> poses_of_log(const std::string& text, const std::string& name, double metres_per_unit) {
    std::istringstream words(text);
    PoseRow poses;
    for (long frame = 0, second = 0, third = 0; words >> frame >> second >> third;) {
        std::array<double, 16> matrix{};
        for (double& number : matrix) words >> number;
        const auto pose = pose_of_matrix(matrix, metres_per_unit);
        if (!words || !pose || frame < 0 || frame >= static_cast<long>(most_path_frames))
            return input_error(name + ": after " + std::to_string(poses.size()) +
                               " frames: must be three numbers, the frame's first, and a 4x4 matrix of a "
                               "rotation and a place");
        const auto index = static_cast<std::size_t>(frame);
        if (poses.size() <= index) poses.resize(index + 1);
        poses[index] = pose;
    }
    if (!words.eof() || poses.empty()) return input_error(name + ": has no poses after three numbers each");
    return poses;
}

/// Parses Record3D's poses: a list of [qx, qy, qz, qw, x, y, z] for each frame, of a camera that looks along
/// -z with y up. Empty if there are none.
Result<PoseRow> poses_of_record3d(const std::string& text, const std::string& name, double metres_per_unit) {
    PoseRow poses;
    TRY_ASSIGN(const Json json,
               checked_json::checked(name, [&] { return checked_json::parse(text, text.size()); }));
    if (!json.is_object() || !json.contains("poses") || !json["poses"].is_array()) return poses;
    for (const Json& each : json["poses"]) {
        const bool is_pose =
            each.is_array() && each.size() == 7 && poses.size() < most_path_frames &&
            std::all_of(each.begin(), each.end(), [](const Json& number) { return number.is_number(); });
        const auto n = is_pose ? each.get<std::array<double, 7>>() : std::array<double, 7>();
        auto rotation = is_pose ? rotation_of(n[0], n[1], n[2], n[3]) : std::nullopt;
        for (std::size_t k = 0; rotation && k < 9; ++k)
            if (k % 3 > 0) (*rotation)[k] *= -1;
        const auto pose = rotation ? pose_at(*rotation, {n[4], n[5], n[6]}, metres_per_unit) : std::nullopt;
        if (!pose)
            return input_error(name + ": poses[" + std::to_string(poses.size()) +
                               "] must be qx, qy, qz, qw, x, y, z");
        poses.push_back(pose);
    }
    return poses;
}

/// The pose nearest in time for each frame.
PoseRow nearest_poses(const std::vector<CameraPath::TimedPose>& poses,
                      const std::vector<double>& frame_seconds) {
    std::vector<double> seconds;
    for (const CameraPath::TimedPose& pose : poses) seconds.push_back(pose.seconds);
    PoseRow row;
    for (const double frame : frame_seconds) {
        const CameraPath::TimedPose& nearest = poses[nearest_key(seconds, frame)];
        const bool is_near = std::abs(nearest.seconds - frame) <= most_apart_seconds;
        row.push_back(is_near ? std::optional(nearest.pose) : std::nullopt);
    }
    return row;
}

Result<PoseRow> poses_of_tum(const std::string& text, const std::string& name, const PictureFiles& depth,
                             const FrameRate& rate, double metres_per_unit) {
    TRY_ASSIGN(const auto timed, parse_timed_poses(text, name, metres_per_unit));
    if (timed.empty()) return input_error(name + ": has no poses");
    const std::size_t frames = std::min(depth.count(), most_path_frames);
    std::vector<double> clip_seconds;
    for (std::size_t n = 0; n < frames; ++n)
        clip_seconds.push_back(static_cast<double>(rate.time_ns(static_cast<std::int64_t>(n))) * 1e-9);
    auto stamps = seconds_of_day(depth);
    if (stamps.size() > frames) stamps.resize(frames);
    const auto known_in = [](const PoseRow& row) { return CameraPath{row}.known(); };
    PoseRow by_stamp = stamps.empty() ? PoseRow() : nearest_poses(timed, stamps),
            by_time = nearest_poses(timed, clip_seconds);
    PoseRow& best = known_in(by_stamp) >= known_in(by_time) ? by_stamp : by_time;
    if (2 * known_in(best) >= frames || timed.size() != depth.count()) {
        if (known_in(best) == 0)
            return input_error(name + ": none of its " + std::to_string(timed.size()) +
                               " poses is at the time of a frame, to 20 ms, nor are there as many");
        return best;
    }
    PoseRow in_order;
    for (std::size_t n = 0; n < frames; ++n) in_order.push_back(timed[n].pose);
    return in_order;
}

std::vector<fs::path> pose_files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code ignored;
    const auto add = [&](const fs::path& file) {
        if (is_file(file)) files.push_back(file);
    };
    for (const char* name : {"poses.txt", "groundtruth.txt", "trajectory.log"}) add(folder / name);
    std::vector<fs::path> logs;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        const std::string name = entry.path().filename().string();
        if (name.ends_with(".log") && name.find("traj") != std::string::npos && name != "trajectory.log")
            logs.push_back(entry.path());
    }
    std::ranges::sort(logs);
    if (!logs.empty()) add(logs.front());
    add(folder / "metadata.json");
    return files;
}

}  // namespace

std::optional<FoundPoses> poses_beside(const fs::path& folder, const PictureFiles& depth,
                                       const FrameRate& rate, double metres_per_unit) {
    std::optional<FoundPoses> not_understood;
    for (const fs::path& file : pose_files_in(folder)) {
        const std::string name = file.filename().string(), extension = file.extension().string();
        const auto text = read_given_file(file, file.string(), "poses of the camera",
                                          extension == ".json" ? longest_metadata : longest_poses);
        auto row = !text                  ? Result<PoseRow>(text.error())
                   : extension == ".json" ? poses_of_record3d(*text, name, metres_per_unit)
                   : extension == ".log"  ? poses_of_log(*text, name, metres_per_unit)
                                          : poses_of_tum(*text, name, depth, rate, metres_per_unit);
        if (!row) {
            if (!not_understood)
                not_understood =
                    FoundPoses{{}, file, "poses of the camera are not read: " + row.error().message};
            continue;
        }
        if (row->size() > depth.count()) row->resize(depth.count());
        FoundPoses found{{std::move(*row)}, file};
        if (found.path.known() == 0) continue;
        found.remark = "where the camera stood is known of " + std::to_string(found.path.known()) + " of " +
                       std::to_string(depth.count()) + " frames, by " + name;
        return found;
    }
    return not_understood;
}

}  // namespace touchable
