#include "engine/formats/camera_sidecar.hpp"

#include <map>
#include <set>
#include <span>
#include <sstream>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;
using checked_json::Json;

constexpr std::size_t longest_poses = std::size_t{64} << 20, longest_metadata = std::size_t{16} << 20;
constexpr double most_apart_seconds = 0.02;  // between a frame and its pose

struct CameraCandidate {
    fs::path file;
    bool is_named = false;  // as a camera's file is
    bool is_own = false;    // named as the picture is
    bool is_text = false;   // neither named so nor of members: only what names its numbers is a camera
};

bool is_any_of(const std::string& name, std::initializer_list<const char*> known) {
    return std::ranges::find(known, name) != known.end();
}

/// What programs call a camera's file. Poses are none.
bool is_named_camera(const std::string& name, const std::string& stem) {
    if (has_word(name, {"extrinsic", "pose", "trajector", "groundtruth"})) return false;
    const bool is_numbered_cam =
        stem.starts_with("cam") && stem.find_first_not_of("0123456789", 3) == std::string::npos;
    return has_word(name, {"camera", "intrinsic", "calib", "camchain"}) || stem == "k" || stem == "fov" ||
           is_numbered_cam || name == "metadata.json" || name == "transforms.json";
}

/// Lists of pictures and of poses, which have readers of their own, and what this program writes.
bool is_of_others(const std::string& name) {
    return is_any_of(name,
                     {"scene.json", "poses.txt", "groundtruth.txt", "trajectory.log", "depth.txt", "rgb.txt",
                      "associations.txt", "associate.txt", "metadata.json", "depth_m_color.txt"}) ||
           has_word(name, {"readme", "license", "extrinsic"});
}

/// What lies in a folder, by name.
std::vector<fs::path> texts_in(const fs::path& folder, std::vector<std::string>& picture_stems) {
    constexpr std::size_t most = 20'000;
    std::vector<fs::path> texts;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        const std::string extension = small_letters(entry.path().extension().string());
        const std::string name = entry.path().filename().string();
        if (name.starts_with('.')) continue;
        const bool is_picture =
            is_any_of(extension, {".png", ".exr", ".tif", ".tiff", ".pgm", ".pfm", ".npy", ".npz", ".jpg",
                                  ".jpeg", ".heic", ".mkv", ".mp4", ".mov", ".avi"});
        if (texts.size() + picture_stems.size() >= most) break;
        if (is_picture)
            picture_stems.push_back(small_letters(entry.path().stem().string()));
        else
            texts.push_back(entry.path());
    }
    std::ranges::sort(texts);
    std::ranges::sort(picture_stems);
    return texts;
}

bool is_small_text(const std::string& extension) {
    return is_any_of(extension, {".json", ".yaml", ".yml", ".xml", ".txt", ".csv", ".ini", ".toml", ".cfg",
                                 ".conf", ".cal"});
}

/// Files of a folder that may be a camera's, named ones first. Of pictures' own files only this picture's.
std::vector<CameraCandidate> candidates_in(const fs::path& folder, const PicturesOfCamera& pictures) {
    constexpr std::size_t most_named = 100, most_others = 16;  // more are of something else
    constexpr std::uintmax_t longest_other = 1 << 20, longest_text = 1 << 22;
    std::vector<std::string> picture_stems;
    std::vector<CameraCandidate> named, others;
    const std::vector<fs::path> texts = texts_in(folder, picture_stems);
    for (const fs::path& file : texts) {
        const std::string name = small_letters(file.filename().string()),
                          stem = small_letters(file.stem().string()),
                          extension = small_letters(file.extension().string());
        if (!is_file(file)) continue;
        const bool has_members = is_any_of(extension, {".json", ".yaml", ".yml", ".xml"});
        std::error_code failure;
        if (is_named_camera(name, stem)) {
            if (has_members || is_any_of(extension, {"", ".txt", ".ini", ".toml", ".cfg", ".conf", ".cal",
                                                     ".bin", ".mat", ".csv", ".pincam"}))
                if (named.size() < most_named) named.push_back({file, true});
        } else if (!pictures.only_named && is_small_text(extension) && others.size() <= most_others &&
                   !is_of_others(name)) {
            const bool is_own = !stem.empty() && stem == small_letters(pictures.stem);
            // A picture of a folder: what is no other picture's may be of all.
            const bool is_shared = !std::ranges::binary_search(picture_stems, stem);
            if (!is_own && !pictures.is_whole_folder && !is_shared) continue;
            if (fs::file_size(file, failure) <= (has_members ? longest_other : longest_text) && !failure)
                others.push_back({file, false, is_own, !has_members});
        }
    }
    if (others.size() <= most_others) named.insert(named.end(), others.begin(), others.end());
    std::ranges::sort(named, {}, &CameraCandidate::file);
    return named;
}

/// Digits of a stem, without zeros before them: the last ones, or of those the ones `from_end` before them;
/// empty: there are none.
std::string number_in(std::string_view stem, int from_end) {
    constexpr const char* digits = "0123456789";
    for (;; --from_end) {
        const auto last = stem.find_last_of(digits);
        if (last == std::string_view::npos) return "";
        const auto before = stem.find_last_not_of(digits, last);
        const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
        if (from_end > 0) {
            stem = stem.substr(0, begin);
            continue;
        }
        const std::string_view number = stem.substr(begin, last + 1 - begin);
        return std::string(number.substr(std::min(number.find_first_not_of('0'), number.size() - 1)));
    }
}

/// Which number of these stems, from their ends, tells one from the other: 16 in 0001_depth16 does not.
int telling_number(std::span<const std::string> stems) {
    constexpr int most_numbers = 8;
    for (int from_end = 0; from_end < most_numbers; ++from_end) {
        std::set<std::string> numbers;
        for (const std::string& stem : stems) numbers.insert(number_in(stem, from_end));
        if (numbers.size() == stems.size()) return from_end;
    }
    return 0;
}

/// Cameras of a folder in which each frame has a file of its own, of the same name or number.
struct OwnCameras {
    CameraFile median;
    fs::path first;
    std::string files;  ///< "*.json"
};
std::optional<OwnCameras> cameras_of_frames(const fs::path& folder, const PicturesOfCamera& pictures) {
    constexpr std::size_t most_read = 64;
    const std::size_t frames = pictures.frames.size();
    if (frames < 2) return {};
    std::vector<std::string> ignored, stems_of_frames;
    for (const fs::path& frame : pictures.frames) stems_of_frames.push_back(frame.stem().string());
    const int telling_of_frames = telling_number(stems_of_frames);
    std::map<std::string, std::map<std::string, fs::path>> by_extension;
    for (const fs::path& file : texts_in(folder, ignored)) {
        const std::string extension = small_letters(file.extension().string());
        if (!is_any_of(extension, {".json", ".yaml", ".yml", ".xml", ".txt"})) continue;
        by_extension[extension].emplace(file.stem().string(), file);
    }
    for (const auto& [extension, files] : by_extension) {
        if (files.size() < 2) continue;
        std::vector<std::string> stems;
        for (const auto& [stem, file] : files) stems.push_back(stem);
        const int telling = telling_number(stems);
        std::map<std::string, fs::path> by_number;
        for (const auto& [stem, file] : files)
            // cam0 and cam1 are two cameras of all frames.
            if (const std::string number = number_in(stem, telling);
                !number.empty() && stem != "cam" + number)
                by_number.emplace(number, file);
        std::vector<CameraFile> cameras;
        OwnCameras own;
        const std::size_t count = std::min(frames, most_read);
        for (std::size_t n = 0; n < count && cameras.size() == n; ++n) {
            if (stop_requested()) return {};
            const std::string stem = pictures.frames[n * frames / count].stem().string();
            auto found = files.find(stem);
            if (found == files.end()) {
                found = by_number.find(number_in(stem, telling_of_frames));
                if (found == by_number.end()) break;
            }
            auto said = read_camera_text(found->second);
            // Four or six numbers without names may be anything.
            if (!said || said->cameras.size() != 1 || said->cameras.front().is_bare) break;
            if (n == 0) own.first = found->second;
            cameras.push_back(std::move(said->cameras.front()));
        }
        if (cameras.size() != count) continue;
        own.median = median_camera_file(cameras);
        own.median.frames = frames;
        own.median.is_of_files = true;
        own.files = '*' + own.first.extension().string();
        return own;
    }
    return {};
}

/// How well a camera goes with depth's pictures, what counts most first.
std::array<bool, 5> mark_of(const CameraCandidate& candidate, const CameraFile& camera,
                            const PicturesOfCamera& pictures) {
    const std::string name =
        small_letters(camera.name) + ' ' + small_letters(candidate.file.filename().string());
    const bool is_of_depth = has_word(name, {"depth"}),
               is_of_colour = !is_of_depth && has_word(name, {"color", "colour", "rgb"});
    return {candidate.is_named, is_of_depth,
            camera.intrinsics.width == pictures.width && camera.intrinsics.height == pictures.height,
            !is_of_colour, !camera.has_distortion};
}

/// Whether a text has a number in it: in its first 64 KiB.
bool has_number(const fs::path& file) {
    constexpr std::size_t enough = 1 << 16;
    return first_bytes(SourceFile(file), enough).find_first_of("0123456789") != std::string::npos;
}

void take_rate(double frames_per_second, const fs::path& file, CameraBeside& beside) {
    if (beside.frames_per_second > 0 || frames_per_second <= 0) return;
    beside.frames_per_second = frames_per_second;
    beside.rate_file = file;
}

void take_scale(double codes_per_metre, const fs::path& file, CameraBeside& beside) {
    if (beside.codes_per_metre > 0 || codes_per_metre <= 0) return;
    beside.codes_per_metre = codes_per_metre;
    beside.scale_file = file;
}

/// Takes the cameras of a folder in which each frame has its own.
void take_frames(const fs::path& folder, const PicturesOfCamera& pictures, CameraBeside& beside) {
    auto own = cameras_of_frames(folder, pictures);
    if (!own) return;
    take_scale(own->median.codes_per_metre, own->first, beside);
    const fs::path within = folder.lexically_relative(pictures.folder);
    beside.file = own->first;
    if (own->median.differs && !within.empty() && *within.begin() != "..")
        beside.frame_cameras = (within == "." ? fs::path(own->files) : within / own->files).string();
    beside.camera = std::move(own->median);
}

/// Adds to `beside` what files of one folder say. `tells`: also names those that are not understood.
void look_in(const fs::path& folder, const PicturesOfCamera& pictures, bool tells, CameraBeside& beside) {
    std::array<bool, 5> best{};
    bool is_of_here = false;
    if (!beside.camera) take_frames(folder, pictures, beside);
    const bool is_known = beside.camera.has_value();
    if (is_known && !tells) return;
    for (const CameraCandidate& candidate : candidates_in(folder, pictures)) {
        if (stop_requested()) return;
        const std::string name = candidate.file.filename().string();
        auto said = read_camera_text(candidate.file);
        // A camera is what names its numbers, or is a whole matrix; four or six numbers may be anything.
        if (said && candidate.is_text)
            std::erase_if(said->cameras, [](const CameraFile& camera) { return camera.is_bare; });
        // Beside a single picture an angle alone, in a file of any name, may be that of a window.
        if (said && !pictures.is_whole_folder && !candidate.is_named && !candidate.is_own)
            std::erase_if(said->cameras, [](const CameraFile& camera) { return camera.intrinsics.fx == 0; });
        const bool has_camera = said && !said->cameras.empty();
        const bool is_odometry = said && said->timed_rows > 0;
        const double rate = said && (candidate.is_named || has_camera || is_odometry || !candidate.is_text)
                                ? said->frames_per_second
                                : 0;
        const double scale = said ? said->codes_per_metre : 0;
        const bool is_silent = !has_camera && rate <= 0 && scale <= 0;
        if (is_silent && candidate.is_named && tells && small_letters(name) != "metadata.json")
            beside.not_understood.push_back(name);
        else if (is_silent && tells && pictures.is_whole_folder && has_number(candidate.file))
            beside.not_used.push_back(name);
        if (!said) continue;
        take_rate(rate, candidate.file, beside);
        take_scale(scale, candidate.file, beside);
        const bool is_one = said->cameras.size() == 1;
        for (CameraFile& camera : said->cameras) {
            const auto mark = mark_of(candidate, camera, pictures);
            if (is_known || (is_of_here && mark <= best)) continue;
            if (is_one) camera.name.clear();
            best = mark;
            is_of_here = true;
            beside.camera = std::move(camera);
            beside.file = candidate.file;
        }
    }
}

/// Whether a folder is a part of a recording by its name: what lies above it is of the recording as well.
bool is_part_by_name(const fs::path& folder) {
    const std::string name = small_letters(folder.filename().string());
    return has_word(name, {"depth", "disp", "camera", "cam_", "frames", "image", "rgb", "color", "colour",
                           "data", "keyframes", "left", "right"}) ||
           (!name.empty() && name.find_first_not_of("0123456789") == std::string::npos);
}

/// How far a point is from the middle of a side, of which it is a share.
double off_middle(double at, int side) {
    return std::abs((at + 0.5) / side - 0.5);
}

/// Poses in the order of the frames.
using PoseRow = std::vector<std::optional<CameraPose>>;

/// 4x4 numbers, the last row 0 0 0 1; metres.
std::optional<CameraPose> pose_of_matrix(const std::array<double, 16>& m, double metres_per_unit) {
    const std::array<double, 9> rotation{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
    if (!is_rotation(rotation) || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1) return {};
    return pose_at(rotation, {m[3], m[7], m[11]}, metres_per_unit);
}

/// Redwood's and Open3D's: a line of three numbers, the first that of the frame, then the matrix that brings
/// the camera's points into the world.
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

/// Record3D's: a list of [qx, qy, qz, qw, x, y, z] for each frame, of a camera that looks along -z with y up.
/// Nothing where it has none.
Result<PoseRow> poses_of_record3d(const std::string& text, const std::string& name, double metres_per_unit) {
    PoseRow poses;
    Json json;
    try {
        json = checked_json::parse(text, text.size());
    } catch (const checked_json::Refusal& refusal) {
        return input_error(name + ": " + refusal.message);
    }
    if (!json.is_object() || !json.contains("poses") || !json["poses"].is_array()) return poses;
    for (const Json& each : json["poses"]) {
        std::array<double, 7> n{};
        bool is_pose = each.is_array() && each.size() == 7 && poses.size() < most_path_frames;
        for (std::size_t k = 0; is_pose && k < 7; ++k) {
            is_pose = each[k].is_number();
            if (is_pose) n[k] = each[k].get<double>();
        }
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

/// The nearest in time for each frame.
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

/// Texts whose names say colour, sorted.
std::vector<fs::path> texts_of_colour(const fs::path& folder) {
    constexpr std::size_t most = 1000;
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
        if (has_word(entry.path().extension().string(), {".txt", ".json", ".yaml", ".yml"}) &&
            has_word(entry.path().stem().string(), {"color", "colour", "rgb"}) && files.size() < most)
            files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
}

/// A matrix of three or four rows; nothing where the file has none, or one that moves nothing.
std::optional<CameraPose> movement_of(const fs::path& file) {
    constexpr std::size_t longest = 1 << 12;
    auto text = read_given_file(file, file.string(), "a matrix", longest);
    if (!text) return {};
    std::istringstream words(std::move(*text));
    std::vector<double> numbers;
    for (double number = 0; words >> number;) numbers.push_back(number);
    if (!words.eof() || (numbers.size() != 12 && numbers.size() != 16)) return {};
    CameraPose pose;
    bool moves = false;
    for (std::size_t k = 0; k < 12; ++k) {
        moves = moves || std::abs(numbers[k] - (k % 5 == 0 ? 1 : 0)) > 1e-6;
        (k % 4 == 3 ? pose.translation[k / 4] : pose.rotation[k / 4 * 3 + k % 4]) = numbers[k];
    }
    return moves ? std::optional(pose) : std::nullopt;
}

/// A camera that names no size is of pictures of this size.
Intrinsics sized(Intrinsics camera, int width, int height) {
    if (camera.width <= 0 || camera.height <= 0) camera.width = width, camera.height = height;
    return camera;
}

/// Whether a pixel is elsewhere by more than two hundredths of the picture.
bool differs(const Camera& a, const Camera& b, const Scene& scene) {
    constexpr double share = 0.02;
    return std::abs(a.fx - b.fx) > share * b.fx || std::abs(a.fy - b.fy) > share * b.fy ||
           std::abs(a.cx - b.cx) > share * scene.width || std::abs(a.cy - b.cy) > share * scene.height;
}

}  // namespace

Camera camera_of_fov(double degrees, int width, int height) {
    const double half = degrees * pi / 360, f = 0.5 * width * cosine(half) / sine(half);
    return {f, f, 0.5 * (width - 1), 0.5 * (height - 1)};
}

std::string guessed_field_of_view(double degrees) {
    constexpr double more = 10;  // degrees
    const auto width = [](double whole) { return sine(whole * pi / 360) / cosine(whole * pi / 360); };
    const double other = std::min(degrees + more, 175.0);
    return std::string(camera_guess_mark) + short_number(degrees) +
           " degrees from left to right; if it sees " + short_number(other) + ", all shapes are " +
           short_number(100 * (1 - width(degrees) / width(other)), 2) + " % too narrow";
}

CameraBeside camera_beside(const PicturesOfCamera& pictures_of) {
    constexpr int farthest_above = 3;
    PicturesOfCamera pictures = pictures_of;
    CameraBeside beside;
    std::error_code failure;
    fs::path here = fs::weakly_canonical(pictures.folder.empty() ? "." : pictures.folder, failure);
    if (failure) here = pictures.folder;
    pictures.folder = here;
    if (!pictures.own.cameras.empty()) {
        beside.camera = pictures.own.cameras.front();
        beside.file = pictures.own_file;
    }
    beside.not_used = pictures.own_not_used;
    take_scale(pictures.own.codes_per_metre, pictures.own_file, beside);
    take_rate(pictures.own.frames_per_second, pictures.own_file, beside);
    const fs::path of_depth =
        pictures.within.empty() ? here : (here / pictures.within / "").lexically_normal().parent_path();
    std::vector<fs::path> folders{here};
    if (of_depth != here) folders.push_back(of_depth);
    folders.push_back(here / "sparse" / "0");
    std::vector<fs::path> around{here};
    if (of_depth.parent_path() != here) around.push_back(of_depth.parent_path());
    for (const fs::path& base : around)
        for (const char* name : {"cameras", "camera", "intrinsics", "intrinsic", "calib", "calibration",
                                 "corrected_cameras", "cam", "poses", "pose"})
            folders.push_back(base / name);
    for (const fs::path& folder : folders)
        look_in(folder, pictures, folder == here || folder == of_depth, beside);
    PicturesOfCamera above = pictures;
    above.is_whole_folder = false;
    above.stem.clear();
    above.frames.clear();
    fs::path at = here;
    for (int n = 0; n < farthest_above && !beside.camera && at.has_relative_path(); ++n) {
        const bool goes_on = is_part_by_name(at);
        at = at.parent_path();
        above.only_named = !goes_on;
        look_in(at, above, false, beside);
        if (!goes_on) break;
    }
    if (beside.camera && beside.camera->codes_per_metre > 0) {
        beside.codes_per_metre = beside.camera->codes_per_metre;
        beside.scale_file = beside.file;
    }
    if (beside.camera)
        beside.camera->intrinsics =
            trusted_intrinsics(beside.camera->intrinsics, pictures.width, pictures.height, beside.doubt);
    return beside;
}

namespace {

/// A size of pictures in use, of the shape of these and at most a thirtieth from this width; nothing where
/// there is none.
std::optional<std::pair<int, int>> usual_size(double near_width, int width, int height) {
    constexpr std::pair<int, int> usual[] = {
        {320, 240},   {480, 360},   {512, 384},   {512, 424},   {640, 360},   {640, 480},
        {640, 576},   {720, 960},   {848, 480},   {960, 540},   {960, 720},   {1024, 576},
        {1024, 768},  {1080, 1440}, {1280, 720},  {1280, 800},  {1280, 960},  {1280, 1024},
        {1440, 1080}, {1440, 1920}, {1600, 1200}, {1920, 1080}, {1920, 1440}, {2048, 1536},
        {2560, 1440}, {2560, 1920}, {3024, 4032}, {3840, 2160}, {4032, 3024}, {4096, 3072}};
    std::optional<std::pair<int, int>> best;
    double nearest = near_width / 30;
    for (const auto& [w, h] : usual) {
        const bool is_of_shape = std::abs(double(w) * height - double(h) * width) < 0.01 * w * height;
        if (!is_of_shape || std::abs(w - near_width) > nearest) continue;
        nearest = std::abs(w - near_width);
        best = {w, h};
    }
    return best;
}

}  // namespace

Intrinsics trusted_intrinsics(Intrinsics camera, int width, int height, std::string& doubt) {
    if (!camera.cx || !camera.cy || width <= 0 || height <= 0) return camera;
    const double cx = *camera.cx, cy = *camera.cy;
    const auto is_share = [](double at) { return at > 0 && at < 1; };
    constexpr double longest_share = 10, far_off = 0.2, near_middle = 0.1, most_apart = 0.1;
    if (camera.fx < longest_share && camera.fy < longest_share && is_share(cx) && is_share(cy)) {
        doubt = "whose numbers are shares of a picture";
        return {camera.fx * width, camera.fy * height, cx * width - 0.5, cy * height - 0.5, width, height};
    }
    const bool says_size = camera.width > 0 && camera.height > 0;
    if (says_size && (camera.width != width || camera.height != height)) {
        const bool is_theirs =
            off_middle(cx, width) <= near_middle && off_middle(cy, height) <= near_middle &&
            (off_middle(cx, camera.width) > far_off || off_middle(cy, camera.height) > far_off);
        if (!is_theirs) return camera;
        doubt = "which says that its pictures have " + std::to_string(camera.width) + "x" +
                std::to_string(camera.height) + " pixels, but whose principal point is the middle of these";
        camera.width = camera.height = 0;
    } else if (!says_size && (off_middle(cx, width) > far_off || off_middle(cy, height) > far_off)) {
        const double across = (2 * cx + 1) / width, down = (2 * cy + 1) / height;
        if (!(across > 0.01 && down > 0.01) || std::abs(across - down) > most_apart * across) return camera;
        const double times = 0.5 * (across + down);
        camera.width = static_cast<int>(std::lround(std::min(times * width, 1e6)));
        camera.height = static_cast<int>(std::lround(std::min(times * height, 1e6)));
        doubt =
            "whose principal point is the middle of pictures " + short_number(times, 3) + " times as large";
        if (const auto usual = usual_size(times * width, width, height)) {
            camera.width = usual->first;
            camera.height = usual->second;
            doubt +=
                ", which is taken for " + std::to_string(usual->first) + "x" + std::to_string(usual->second);
        }
    }
    return camera;
}

Result<std::vector<Camera>> read_frame_cameras(const PictureFiles& files, int width, int height) {
    constexpr double farthest = 1e6;                 // pixels; further off is a slip
    constexpr std::size_t most_frames = 10'000'000;  // each has its camera in memory
    if (files.count() > most_frames)
        return input_error(files.file(0).string() + ": is the camera of " + std::to_string(files.count()) +
                           " frames: at most " + std::to_string(most_frames) + " can have cameras");
    std::vector<Camera> cameras;
    for (std::size_t frame = 0; frame < files.count(); ++frame) {
        const fs::path& path = files.file(frame);
        if (frame > 0 && path == files.file(frame - 1)) {
            cameras.push_back(cameras.back());
            continue;
        }
        if (stop_requested()) return interrupted_error();
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

Result<std::optional<GuessedCameras>> guess_cameras(const fs::path& folder, const std::string& depth_pattern,
                                                    int width, int height) {
    const std::vector<PictureGroup> groups = camera_groups(folder);
    if (groups.empty()) return std::optional<GuessedCameras>();
    const auto fits = [&](const PictureGroup& group) {
        const auto file = read_camera_file(group.first);
        return file && file->intrinsics.width == width && file->intrinsics.height == height;
    };
    const auto fitting = std::ranges::find_if(groups, fits);
    FolderSource source;
    source.depth = depth_pattern;
    source.cameras = (fitting == groups.end() ? groups.front() : *fitting).pattern;
    TRY_ASSIGN(const auto frames, depth_files(folder, source));
    TRY_ASSIGN(const auto files, camera_files(folder, source, frames));
    TRY_ASSIGN(const auto cameras, read_frame_cameras(files, width, height));
    return std::optional(GuessedCameras{source.cameras, median_camera(cameras)});
}

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

std::optional<fs::path> colour_movement_in(const fs::path& folder) {
    for (const fs::path& file : texts_of_colour(folder))
        if (has_word(file.stem().string(), {"depth", "extrinsic"}) && movement_of(file)) return file;
    return {};
}

std::optional<VispColourCamera> visp_colour_camera(const fs::path& movement, const fs::path& camera_of_depth,
                                                   int width, int height) {
    const std::string stem = camera_of_depth.stem().string(), of_depth = "_depth";
    const auto to_depth = movement_of(movement);
    if (movement.filename() != "depth_M_color.txt" || !stem.ends_with(of_depth) || !to_depth) return {};
    fs::path file = camera_of_depth;
    file.replace_filename(stem.substr(0, stem.size() - of_depth.size()) +
                          camera_of_depth.extension().string());
    auto read = read_camera_file(file);
    if (!read || read->has_distortion) return {};
    return VispColourCamera{{scaled_camera(sized(read->intrinsics, width, height), width, height),
                             width,
                             height,
                             {},
                             to_depth->inverse()},
                            file};
}

std::optional<fs::path> camera_of_colour_in(const fs::path& folder, const Scene& scene, int width,
                                            int height) {
    for (const fs::path& file : texts_of_colour(folder)) {
        if (has_word(file.stem().string(), {"depth"})) continue;
        auto read = read_camera_file(file);
        if (!read) continue;
        const Intrinsics of_colour = sized(read->intrinsics, width, height);
        if (differs(scaled_camera(of_colour, scene.width, scene.height), scene.camera, scene)) return file;
    }
    return {};
}

}  // namespace touchable
