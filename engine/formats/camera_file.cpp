// SPDX-License-Identifier: Apache-2.0
// Cameras in other programs' files. JSON, XML and YAML are all read as JSON, in which a camera is any object
// with focal lengths or a matrix under the names that programs use; Middlebury's, COLMAP's and ARKitScenes'
// texts have readers of their own. Declared in source_description.hpp and camera_sidecar.hpp.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <tuple>

#include "engine/base/files.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/sidecar_text.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using checked_json::Json;

constexpr std::size_t longest_camera_file = std::size_t{16} << 20;  // Record3D's has a pose for each frame
constexpr std::size_t most_cameras = 64, longest_camera_name = 200;

bool is_side(double pixels) {
    return pixels >= 1 && pixels <= 16384;
}

/// Sets the size of a camera's pictures, if both sides can be.
void take_size(double width, double height, auto& camera) {
    if (!is_side(width) || !is_side(height)) return;
    camera.width = static_cast<int>(width);
    camera.height = static_cast<int>(height);
}

/// All numbers of a text, whatever stands between them.
std::vector<double> numbers_in(std::string_view text) {
    std::vector<double> numbers;
    const char *at = text.data(), *const end = at + text.size();
    while (at < end) {
        const bool begins = (*at >= '0' && *at <= '9') || *at == '-' || *at == '.';
        const bool in_word = at > text.data() && std::isalnum(static_cast<unsigned char>(at[-1])) != 0;
        if (!begins || in_word) {
            ++at;
            continue;
        }
        double number = 0;
        const auto [after, failure] = std::from_chars(at, end, number);
        if (failure == std::errc()) numbers.push_back(number);
        at = std::max(after, at + 1);
    }
    return numbers;
}

/// The camera of a 3x3 matrix by rows or by columns, or of a 3x4 or 4x4 one by rows. A matrix of shares of a
/// picture's sides counts if its principal point is near the middle, or in pixels.
std::optional<Intrinsics> from_matrix(const std::vector<double>& m) {
    if (m.size() == 16 || m.size() == 12)
        return from_matrix({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
    if (m.size() != 9) return {};
    const bool by_rows = m[2] != 0 || m[5] != 0;
    // Other matrices, a rotation or a pose, are no camera's. A skew of a pixel moves no point by more than
    // half a pixel.
    constexpr double most_skew = 1, least_focal = 1;
    const double cx = by_rows ? m[2] : m[6], cy = by_rows ? m[5] : m[7];
    const auto is_middle = [](double at) { return at > 0.25 && at < 0.75; };
    const bool is_of_shares =
        ((is_middle(cx) && is_middle(cy) && m[0] > 0.1) || (cx > 1 && cy > 1 && m[0] > 0.2 && m[0] != 1)) &&
        m[1] == 0 && m[3] == 0;
    const bool last_is_unit = (by_rows ? m[6] == 0 && m[7] == 0 : m[2] == 0 && m[5] == 0) && m[8] == 1;
    const bool is_camera = last_is_unit && std::abs(m[1]) <= most_skew && std::abs(m[3]) <= most_skew &&
                           ((m[0] > least_focal && std::abs(m[4]) > least_focal) || is_of_shares);
    if (!is_camera) return {};
    return Intrinsics{m[0], m[4], cx, cy};
}

void flatten(const Json& value, std::vector<double>& numbers) {
    if (value.is_number()) numbers.push_back(value.get<double>());
    if (value.is_array())
        for (const Json& each : value)
            if (numbers.size() <= 16) flatten(each, numbers);
    if (value.is_string() && numbers.empty()) {  // KITTI's "P2: 721 0 609 ..."
        const auto& text = value.get_ref<const std::string&>();
        if (text.size() < 1000 && text.find_first_not_of("0123456789+-.eE, \t") == std::string::npos)
            numbers = numbers_in(text);
    }
}

/// An object's members by their bare names: fl_x, FL.x and flx are one. Of several with one bare name the
/// first counts. Refers to the object.
class Members {
public:
    explicit Members(const Json& object) {
        constexpr std::size_t most = 1000;  // more are frames, or something else
        if (!object.is_object() || object.size() > most) return;
        for (const auto& [name, value] : object.items()) named_.emplace_back(bare_name(name), &value);
    }
    const Json* find(std::string_view name) const {
        const auto found = std::ranges::find(named_, name, &std::pair<std::string, const Json*>::first);
        return found == named_.end() ? nullptr : found->second;
    }
    bool has(std::string_view name) const { return find(name) != nullptr; }
    /// The first of these that is a number, or a word that is one; 0: none is.
    double number(std::initializer_list<const char*> names) const {
        for (const char* name : names) {
            const Json* value = find(name);
            if (value != nullptr && value->is_number()) return value->get<double>();
            if (value == nullptr || !value->is_string()) continue;
            if (const auto number = parsed_number(trimmed(value->get_ref<const std::string&>())))
                return *number;
        }
        return 0;
    }
    std::string_view words(std::string_view name) const {
        const Json* value = find(name);
        return value != nullptr && value->is_string() ? value->get_ref<const std::string&>()
                                                      : std::string_view();
    }
    /// The numbers of a member: a list, also of lists, an object with `data`, or one of two numbers; at most
    /// 17.
    std::vector<double> list(std::initializer_list<const char*> names) const {
        std::vector<double> numbers;
        for (const char* name : names) {
            const Json* value = find(name);
            if (value == nullptr) continue;
            if (value->is_object() && value->contains("data")) value = &(*value)["data"];
            if (value->is_number()) continue;
            if (value->is_object()) {
                const Members pair(*value);
                const double across = pair.number({"x", "fx", "cx", "width"}),
                             down = pair.number({"y", "fy", "cy", "height"});
                if (across > 0 && down > 0) return {across, down};
            }
            flatten(*value, numbers);
            if (!numbers.empty()) break;
        }
        return numbers;
    }

private:
    std::vector<std::pair<std::string, const Json*>> named_;
};

double degrees_of(double angle, bool is_radians) {
    return is_radians ? angle * 180 / pi : angle;
}

/// A camera's view by an angle, or by a renderer's focal length and aperture in millimetres.
std::optional<Intrinsics> view_of(const Members& members) {
    constexpr double widest = 179, least = 1, most_radians = 3.13;
    double x = members.number({"fovx", "hfov", "horizontalfov", "fovh", "fovxdeg", "xfov"}),
           y = members.number({"fovy", "vfov", "verticalfov", "fovv", "fovydeg", "yfov"});
    bool is_either_way = false;
    if (x == 0 && y == 0) {
        // CARLA's goes across; Unity's, three.js's, PyBullet's and Godot's down.
        const std::string_view kept = members.words("keepaspect");
        const bool goes_across = members.has("imagesizex") || kept == "KEEP_WIDTH";
        const bool goes_down =
            !goes_across && (kept == "KEEP_HEIGHT" || members.words("type") == "PerspectiveCamera" ||
                             members.number({"fieldofview", "aspect", "aspectratio", "nearval", "farval",
                                             "nearclipplane", "farclipplane"}) > 0);
        (goes_down ? y : x) = members.number({"fov", "fieldofview", "fovdegrees", "fovdeg", "camerafov"});
        is_either_way = !goes_across && x > 0;
    }
    const double largest = std::max(x, y);
    const bool is_radians = largest > 0 && largest < most_radians;
    x = degrees_of(x, is_radians), y = degrees_of(y, is_radians);
    if (x == 0 && y == 0) {  // NeRF's
        x = degrees_of(members.number({"cameraanglex"}), true);
        y = degrees_of(members.number({"cameraangley"}), true);
    }
    if (x == 0 && y == 0) {
        const double lens = members.number(
            {"lens", "camerafocallength", "focallength", "focallengthmm", "focalmm", "lensmm"});
        const auto pair = members.list({"cameraaperture", "aperture", "sensorsize"});
        const double wide = pair.size() == 2
                                ? pair[0]
                                : members.number({"sensorwidth", "horizontalaperture", "sensorwidthmm",
                                                  "aperturewidth", "filmwidth", "filmbackwidth"});
        if (lens > 0 && wide > 0) x = 360 / pi * arctangent(0.5 * wide / lens);
        // A sensor's height is ignored: renderers cut it to the picture's shape.
    }
    const auto is_angle = [](double degrees) { return degrees >= least && degrees <= widest; };
    if (!is_angle(x) && !is_angle(y)) return {};
    return Intrinsics{
        .fov_x = is_angle(x) ? x : 0, .fov_y = is_angle(y) ? y : 0, .is_fov_either_way = is_either_way};
}

/// The first of these members that is a camera's matrix.
template <class... Name>
std::optional<Intrinsics> first_matrix(const Members& members, Name... names) {
    std::optional<Intrinsics> found;
    (void)((found = from_matrix(members.list({names}))) || ...);
    return found;
}

std::optional<Intrinsics> intrinsics_of(const Json& object) {
    const Members members(object);
    const auto centre = [&](std::initializer_list<const char*> names) {
        const double at = members.number(names);
        return at == 0 ? std::optional<double>() : std::optional(at);  // nothing: the middle
    };
    auto cx = centre({"ppx", "cx", "u0", "cu", "k02", "principalpointx", "cxdepth", "mxdepth", "cxd"}),
         cy = centre({"ppy", "cy", "v0", "cv", "k12", "principalpointy", "cydepth", "mydepth", "cyd"});
    if (const auto pair = members.list({"principalpoint", "pp", "c", "center", "opticalcenter"});
        pair.size() == 2 && !cx)
        cx = pair[0], cy = pair[1];
    double fx = members.number({"fx", "focallengthx", "flx", "fu", "k00", "focalx", "fxdepth", "fxd"}),
           fy = members.number({"fy", "focallengthy", "fly", "fv", "k11", "focaly", "fydepth", "fyd"});
    // Metashape's principal point is measured from the middle, with whole numbers at pixels' corners.
    const Json* const resolution = members.find("resolution");
    if (const double f = members.number({"f"}); fx == 0 && f > 1 && resolution && resolution->is_object())
        if (const auto size = members.list({"resolution"}); size.size() == 2)
            return Intrinsics{f, f, 0.5 * size[0] + cx.value_or(0) - 0.5,
                              0.5 * size[1] + cy.value_or(0) - 0.5};
    if (fx == 0 && members.has("u0"))
        fx = members.number({"px", "alphau"}), fy = members.number({"py", "alphav"});
    if (fx == 0 && cx)
        if (const auto pair = members.list({"focallength", "focal", "focals", "f"}); pair.size() == 2)
            fx = pair[0], fy = pair[1];
    // A single focal length is pixels only beside a principal point in pixels.
    if (fx == 0 && cx && *cx > 1) fx = members.number({"focallength", "focal", "focallengthpx", "f"});
    const Json* const ndc = members.find("inndc");
    if (fx > 0)
        return Intrinsics{
            .fx = fx, .fy = fy > 0 ? fy : fx, .cx = cx, .cy = cy, .is_ndc = ndc && *ndc == true};
    // What programs call a camera's matrix; depth's first.
    if (const auto found = first_matrix(
            members, "kdepth", "depthk", "depthintrinsics", "depthintrinsic", "intrinsicsdepth",
            "intrinsicdepth", "depthcameramatrix", "mcalibrationdepthintrinsic", "intrinsicmatrix", "k",
            "cameramatrix", "camk", "camintr", "intrinsicsmatrix", "intrinsics", "intrinsic",
            "cameraintrinsics", "cameraintrinsic", "kmatrix", "calibrationmatrix", "perframeintrinsiccoeffs",
            "p", "p2", "prect02", "p0", "prect00", "krect02", "k02"))
        return found;
    const auto four =
        members.list({"intrinsics", "intrinsic", "perframeintrinsiccoeffs", "camintr"});  // Kalibr, Record3D
    const Json* const model = members.find("cameramodel");
    const bool is_pinhole = model == nullptr || *model == "pinhole";
    if (four.size() == 4 && is_pinhole && four[0] > 1 && four[1] > 1)
        return Intrinsics{four[0], four[1], four[2], four[3]};
    return view_of(members);
}

/// Metres between a pair's cameras: said, or by their 3x4 matrices, whose fourth numbers are fx times their
/// places; 0: not known. Lengths are metres or millimetres.
double baseline_of(const Json& object) {
    constexpr std::pair<const char*, const char*> pairs[] = {
        {"prect02", "prect03"}, {"p2", "p3"}, {"prect00", "prect01"}, {"p0", "p1"}, {"p1", "p2"}};
    constexpr double longest_metres = 2, shortest_millimetres = 20;
    const Members members(object);
    double length = members.number({"baseline", "stereobaseline"});
    for (const auto& [one, other] : pairs)
        if (const auto a = members.list({one}), b = members.list({other});
            length == 0 && a.size() == 12 && b.size() == 12 && a[0] > 0)
            length = std::abs(a[3] - b[3]) / a[0];
    return length > 0 && length < longest_metres ? length : length > shortest_millimetres ? length / 1000 : 0;
}

bool says_distortion(const Json& object) {
    const Members members(object);
    std::vector<double> terms =
        members.list({"distortioncoefficients", "distortioncoeffs", "distcoeffs", "distcoeff",
                      "radialdistortion", "coeffs", "distortion", "dist", "d"});
    for (const char* name : {"k1", "k2", "k3", "p1", "p2", "kud", "kdu"})
        terms.push_back(members.number({name}));
    return std::ranges::any_of(terms, [](double term) { return term != 0; });
}

/// Metres of a unit in words: "mm", "0.1 mm", "centimetres", "1/5000"; 0: it is none.
double metres_of_words(std::string_view words) {
    words = trimmed(words);
    const auto letters = std::min(words.find_first_not_of("0123456789./ "), words.size());
    const std::string_view number = trimmed(words.substr(0, letters));
    const auto slash = number.find('/');
    const auto above = parsed_number(trimmed(number.substr(0, slash)));
    const auto below = slash == std::string_view::npos ? std::optional(1.0)
                                                       : parsed_number(trimmed(number.substr(slash + 1)));
    if (!number.empty() && (!above || !below || *below == 0)) return 0;
    const double times = number.empty() ? 1 : *above / *below;
    std::string unit = bare_name(words.substr(letters));
    if (unit.ends_with('s')) unit.pop_back();
    if (unit.ends_with("metre")) unit.replace(unit.size() - 2, 2, "er");
    constexpr std::pair<std::string_view, double> units[] = {
        {"mm", 1e-3}, {"millimeter", 1e-3}, {"cm", 1e-2}, {"centimeter", 1e-2},
        {"m", 1},     {"meter", 1},         {"um", 1e-6}, {"micrometer", 1e-6}};
    for (const auto& [name, metres] : units)
        if (unit == name) return times * metres;
    return unit.empty() && slash != std::string_view::npos ? times : 0;
}

/// Metres of the unit that an object states for depth or a renderer's scene; 0: none. `name`: the object's.
double unit_of_members(const Json& object, const std::string& name) {
    const Members members(object);
    for (const char* member : {"depthunit", "depthunits"})
        if (const double metres = metres_of_words(members.words(member)); metres > 0) return metres;
    if (bare_name(name) == "depth")
        for (const char* member : {"unit", "units"})
            if (const double metres = metres_of_words(members.words(member)); metres > 0) return metres;
    // From tenths of a millimetre to kilometres.
    constexpr double least = 1e-4, most = 1e3;
    const double metres = members.number({"metersperunit", "meterspersceneunit"});
    return metres >= least && metres <= most ? metres : 0;
}

/// Codes in a metre, by an object's own members; 0: not stated. Three conventions are in use: codes in a
/// metre (Open3D, ORB-SLAM, ScanNet), metres of a code (RealSense, instant-ngp, nerfstudio), and millimetres
/// of a code (BOP, beside cam_K).
double codes_per_metre_of(const Json& object, const std::string& name = "") {
    const Members members(object);
    constexpr double most_metres = 0.005, most_millimetres = 20, least_codes = 50, most_codes = 1e6;
    const auto is_count = [](double codes) { return codes >= least_codes && codes <= most_codes; };
    const auto is_metres = [](double metres) { return metres > 1e-9 && metres <= most_metres; };
    const double codes =
        members.number({"depthmapfactor", "pngdepthscale", "depthfactor", "mdepthshift", "depthshift",
                        "depthmapscale", "depthscalingfactor", "depthmultiplier"});
    if (codes > 0) return is_count(codes) ? codes : is_metres(codes) ? 1 / codes : 0;
    const double metres =
        members.number({"integerdepthscale", "depthunitscalefactor", "depthunit", "depthunits", "depthunitm",
                        "depthscalefactor", "metrespercode", "depthunitinmeters", "depthtometers"});
    if (metres > 0) return is_metres(metres) ? 1 / metres : is_count(metres) ? metres : 0;
    const double millimetres = members.number({"depthscalemm"});
    if (millimetres > 0 && millimetres <= most_millimetres) return 1000 / millimetres;
    double scale = members.number({"depthscale", "depthscales", "scaledepth"});
    if (is_metres(scale)) return 1 / scale;
    if (scale > 0 && scale <= most_millimetres && members.has("camk")) return 1000 / scale;
    // 1 is BOP's millimetre, or means no scaling.
    if (scale > most_metres && scale != 1)
        return scale <= most_millimetres ? 1000 / scale : is_count(scale) ? scale : 0;
    if (const double in_words = metres_of_words(members.words("depthscale")); is_metres(in_words))
        return 1 / in_words;
    // The unit of a scene, such as centimetres, says nothing of integer codes.
    const bool is_of_scene = members.has("metersperunit") || members.has("meterspersceneunit");
    if (const double unit = unit_of_members(object, name); unit > 0 && (!is_of_scene || is_metres(unit)))
        return is_count(1 / unit) ? 1 / unit : 0;
    scale = members.has("fx") ? members.number({"scale", "scalefactor"}) : 0;  // Replica
    return is_count(scale) ? scale : 0;
}

double rate_of_members(const Json& object, const std::string& = "") {
    constexpr double highest = 1000;
    const double rate = Members(object).number(
        {"fps", "framerate", "camerafps", "framespersecond", "depthfps", "controlfreq"});
    return rate > 0 && rate <= highest ? rate : 0;
}

/// A renderer's plane, metres; 0: not stated. `which`: its place in a range of both. MuJoCo states shares of
/// the model's extent.
double plane_of(const Json& object, std::initializer_list<const char*> names, std::size_t which) {
    const Members members(object);
    const auto both = members.list({"clippingrange"});
    const double plane = both.size() == 2 ? both[which] : members.number(names),
                 extent = members.number({"extent"});
    return plane > 0 ? plane * (extent > 0 ? extent : 1) : 0;
}
double near_of_members(const Json& object, const std::string& = "") {
    return plane_of(object,
                    {"near", "znear", "nearval", "nearplane", "nearclip", "clipnear", "nearclipplane"}, 0);
}
double far_of_members(const Json& object, const std::string& = "") {
    return plane_of(object, {"far", "zfar", "farval", "farplane", "farclip", "clipfar", "farclipplane"}, 1);
}

/// A camera in a line of its own, or in a member, as librealsense prints it: "[ 640x480 p[319.1 240.2] f[600
/// 601] Brown Conrady [0 0 0 0 0] ]".
std::optional<CameraFile> from_printed(std::string_view text) {
    constexpr std::size_t longest = 1 << 12;
    text = text.substr(0, longest);
    const auto centre = text.find(" p["), focal = text.find(" f[", std::min(centre, text.size()));
    if (centre == std::string_view::npos || focal == std::string_view::npos) return {};
    const auto within = [&](std::size_t at) {
        return numbers_in(text.substr(at + 3, text.find(']', at) - std::min(text.find(']', at), at + 3)));
    };
    const auto c = within(centre), f = within(focal);
    if (c.size() != 2 || f.size() != 2) return {};
    CameraFile made{.intrinsics = {f[0], f[1], c[0], c[1]}};
    const std::string_view size = trimmed(text.substr(0, centre), " [:");
    const auto times = size.rfind('x');
    if (times != std::string_view::npos) {
        const auto before = size.find_last_not_of("0123456789", times - (times > 0 ? 1 : 0));
        const auto width =
                       parsed_number(size.substr(before == size.npos ? 0 : before + 1, times - before - 1)),
                   height = parsed_number(size.substr(times + 1));
        take_size(width.value_or(0), height.value_or(0), made.intrinsics);
    }
    const auto terms = text.find('[', focal + 3);
    const auto bends =
        terms == std::string_view::npos ? std::vector<double>() : numbers_in(text.substr(terms));
    made.has_distortion = std::ranges::any_of(bends, [](double term) { return term != 0; });
    return made;
}

/// The picture size by a section's name: a ZED stereo camera's file does not state its sections' sizes.
std::pair<int, int> size_by_name(const std::string& name) {
    constexpr std::pair<const char*, std::pair<int, int>> sizes[] = {
        {"_CAM_2K", {2208, 1242}}, {"_CAM_FHD", {1920, 1080}}, {"_CAM_FHD1200", {1920, 1200}},
        {"_CAM_HD", {1280, 720}},  {"_CAM_SVGA", {960, 600}},  {"_CAM_VGA", {672, 376}}};
    for (const auto& [end, size] : sizes)
        if (name.ends_with(end)) return size;
    return {0, 0};
}

/// The stem of the picture that an object names; empty: it names none, or one without a number.
std::string picture_of(const Json& object) {
    const Members members(object);
    for (const char* name : {"filepath", "imgname", "imagename", "filename"}) {
        const auto words = members.words(name);
        if (words.size() >= longest_camera_name) continue;
        std::string stem = std::filesystem::path(words).stem().string();
        if (!number_in(stem, 0).empty()) return stem;
    }
    return "";
}

/// What the members around an object say of it.
struct Around {
    std::string name{}, frame{};
    int width = 0, height = 0, depth = 0;
};

/// Index of the wanted picture among the `keys` of members or elements, one a frame; nothing: it is not sure.
std::optional<std::size_t> place_of(const FrameKey& wanted, const std::vector<std::string>& keys) {
    std::optional<std::size_t> found;
    if (wanted.stem.empty() || keys.size() < std::max<std::size_t>(wanted.pictures, 2)) return found;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        if (keys[k] == wanted.stem) return k;
        if (wanted.number.empty() || number_in(keys[k], 0) != wanted.number) continue;
        if (found) return std::nullopt;
        found = k;
    }
    return found;
}

void find_cameras(const Json& json, std::vector<CameraFile>& found, const FrameKey& wanted, Around around);

/// Finds cameras in a list's elements, each an object, or a pair of a name and an object.
void find_in_list(const Json& list, std::vector<CameraFile>& found, const FrameKey& wanted, Around around) {
    struct Element {
        const Json* object;
        std::string name;
    };
    std::vector<Element> elements;
    std::vector<std::string> keys;
    for (const Json& each : list) {
        if (wanted.stem.empty() && elements.size() == most_cameras) break;
        const bool is_pair =
            each.is_array() && each.size() == 2 && each[0].is_primitive() && each[1].is_object();
        if (!each.is_object() && !is_pair) continue;
        const std::string name = !is_pair              ? ""
                                 : each[0].is_string() ? each[0].get<std::string>()
                                                       : each[0].dump();
        elements.push_back({is_pair ? &each[1] : &each, name});
        keys.push_back(picture_of(*elements.back().object));
    }
    const bool are_frames = around.name == "frames" || std::ranges::none_of(keys, &std::string::empty);
    const auto one = are_frames ? place_of(wanted, keys) : std::nullopt;
    const std::string name = around.name;
    for (std::size_t k = 0; k < elements.size() && k < most_cameras; ++k) {
        const std::size_t at = one.value_or(k);
        const std::string& key = elements[at].name;
        around.name = key.empty() ? name : name + ' ' + key;
        if (are_frames) around.frame = keys[at].empty() ? '#' + std::to_string(at) : keys[at];
        find_cameras(*elements[at].object, found, wanted, around);
        if (one) break;
    }
}

/// Adds the cameras in `json` to `found`, depth's first; if each has a frame, only that of the wanted one. An
/// object with focal lengths or a matrix is one camera, whatever else is in it.
void find_cameras(const Json& json, std::vector<CameraFile>& found, const FrameKey& wanted, Around around) {
    constexpr int deepest = 6;
    if (around.depth++ > deepest || found.size() >= most_cameras) return;
    if (json.is_array()) find_in_list(json, found, wanted, around);
    if (json.is_string())
        if (auto printed = from_printed(json.get_ref<const std::string&>())) {
            printed->name = around.name;
            found.push_back(std::move(*printed));
        }
    if (!json.is_object()) return;
    const Members members(json);
    const auto pair = members.list({"resolution", "imagesize", "imagedimension", "renderproductresolution"});
    const double own_width = pair.size() == 2 ? pair[0]
                                              : members.number({"width", "w", "imagewidth", "depthwidth",
                                                                "resolutionx", "imw", "mdepthwidth"}),
                 own_height = pair.size() == 2 ? pair[1]
                                               : members.number({"height", "h", "imageheight", "depthheight",
                                                                 "resolutiony", "imh", "mdepthheight"});
    take_size(own_width, own_height, around);
    for (const char* member : {"name", "camera_name", "rostopic", "label"})
        if (json.contains(member) && json[member].is_string())
            around.name += ' ' + json[member].get<std::string>();
    around.name = around.name.substr(0, longest_camera_name);
    if (auto camera = intrinsics_of(json)) {
        std::tie(camera->width, camera->height) =
            around.width > 0 ? std::pair(around.width, around.height) : size_by_name(around.name);
        found.push_back({.intrinsics = *camera,
                         .baseline = baseline_of(json),
                         .codes_per_metre = codes_per_metre_of(json),
                         .has_distortion = says_distortion(json),
                         .name = around.name,
                         .frame = around.frame});
        return;
    }
    constexpr const char* first[] = {"depth", "depth_intrinsics", "intrinsics", "intrinsic", "camera"};
    const auto inner = [&](const std::string& member) {
        Around within = around;
        within.name = around.name.empty() ? member : around.name + ' ' + member;
        if (is_digits(member)) within.frame = member;
        find_cameras(json[member], found, wanted, within);
    };
    std::vector<std::string> keys;
    if (!wanted.stem.empty())
        for (const auto& [member, value] : json.items())
            if (value.is_object() && is_digits(member)) keys.push_back(member);
    if (const auto one = place_of(wanted, keys)) return inner(keys[*one]);
    for (const char* member : first)
        if (json.contains(member)) inner(member);
    for (const auto& [member, value] : json.items())
        if (std::ranges::find(first, member) == std::end(first)) inner(member);
}

/// What `of` finds first in `json` or up to `deepest` members down: ORB-SLAM's Camera, a configuration's cam.
template <class Of>
double first_said(const Json& json, Of of, int deepest, const std::string& name = "") {
    double said = json.is_object() ? of(json, name) : 0;
    constexpr std::size_t most = 20;
    std::size_t looked = 0;
    if (said != 0 || deepest == 0 || !json.is_structured()) return said;
    for (const auto& [member, value] : json.items())
        if (said == 0 && value.is_structured() && looked++ < most)
            said = first_said(value, of, deepest - 1, json.is_object() ? member : name);
    return said;
}

void take_members(const Json& json, const FrameKey& wanted, CameraText& said) {
    constexpr int deepest_scale = 3, deepest_rate = 1;
    find_cameras(json, said.cameras, wanted, {});
    if (said.frames_per_second == 0) said.frames_per_second = first_said(json, rate_of_members, deepest_rate);
    if (said.codes_per_metre == 0) said.codes_per_metre = first_said(json, codes_per_metre_of, deepest_scale);
    if (said.metres_per_value == 0) said.metres_per_value = first_said(json, unit_of_members, deepest_scale);
    if (said.near == 0) said.near = first_said(json, near_of_members, deepest_scale);
    if (said.far == 0) said.far = first_said(json, far_of_members, deepest_scale);
}

/// Numbers after a word that begins a line, up to its end.
std::vector<double> numbers_after(std::string_view text, std::string_view word) {
    for (std::size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1))
        if (at == 0 || text[at - 1] == '\n')
            return numbers_in(text.substr(at + word.size(), text.find('\n', at) - at - word.size()));
    return {};
}

/// Middlebury: cam0=[f 0 cx; 0 f cy; 0 0 1], doffs=, baseline= (mm), width=, height=.
std::optional<CameraFile> from_calib(std::string_view text) {
    auto found = from_matrix(numbers_after(text, "cam0="));
    const auto baseline = numbers_after(text, "baseline="), offset = numbers_after(text, "doffs=");
    if (!found || baseline.size() != 1) return {};
    const auto width = numbers_after(text, "width="), height = numbers_after(text, "height=");
    if (width.size() == 1 && height.size() == 1) take_size(width[0], height[0], *found);
    return CameraFile{*found, baseline[0] / 1000, offset.size() == 1 ? offset[0] : 0};
}

/// COLMAP: id model width height parameters; its pixel centres are at a half.
std::vector<CameraFile> from_colmap(std::string_view text) {
    std::vector<CameraFile> cameras;
    std::istringstream lines{std::string(text)};
    constexpr int most_lines = 10'000;  // cameras are few, and first
    int count = 0;
    for (std::string line;
         count++ < most_lines && std::getline(lines, line) && cameras.size() < most_cameras;) {
        if (stop_requested()) break;
        std::istringstream words(line);
        long id = 0;
        std::string model;
        Intrinsics found;
        if (!(words >> id >> model >> found.width >> found.height)) continue;
        if (!is_side(found.width) || !is_side(found.height)) continue;
        std::vector<double> p;
        for (double number = 0; words >> number;) p.push_back(number);
        const bool one_focal = model.starts_with("SIMPLE_") || model.starts_with("RADIAL");
        const std::size_t of_pinhole = one_focal ? 3 : 4;
        if (p.size() < of_pinhole ||
            model.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_") != std::string::npos)
            continue;
        found.fx = p[0];
        found.fy = one_focal ? p[0] : p[1];
        found.cx = p[one_focal ? 1 : 2] - 0.5;
        found.cy = p[one_focal ? 2 : 3] - 0.5;
        const bool is_fisheye = model.ends_with("FISHEYE") || model == "FOV";
        const bool is_bent = std::any_of(p.begin() + static_cast<std::ptrdiff_t>(of_pinhole), p.end(),
                                         [](double term) { return term != 0; });
        cameras.push_back({.intrinsics = found,
                           .has_distortion = is_fisheye || is_bent,
                           .name = "camera " + std::to_string(id)});
    }
    return cameras;
}

/// ARKitScenes' .pincam: width height fx fy cx cy; Matterport3D's has five more, of a lens.
std::optional<Intrinsics> from_pincam(const std::vector<double>& numbers) {
    if ((numbers.size() != 6 && numbers.size() != 11) || !is_side(numbers[0]) || !is_side(numbers[1]))
        return {};
    Intrinsics camera{numbers[2], numbers[3], numbers[4], numbers[5]};
    take_size(numbers[0], numbers[1], camera);
    return camera;
}

/// fx fy cx cy and no more.
std::optional<Intrinsics> from_four(const std::vector<double>& n) {
    constexpr double least = 10, most_apart = 2;
    if (n.size() != 4 || !std::ranges::all_of(n, [](double number) { return number > least; })) return {};
    if (n[0] > most_apart * n[1] || n[1] > most_apart * n[0]) return {};
    return Intrinsics{n[0], n[1], n[2], n[3]};
}

/// Frames a second by these times; 0: they are no times of frames.
double rate_of_times(std::vector<double> seconds) {
    if (seconds.empty()) return 0;
    const double first = seconds.front(), unit = seconds_of_stamp(first);
    for (double& each : seconds) each = (each - first) * unit;
    if (!std::ranges::is_sorted(seconds)) return 0;
    const auto rate = rate_of_seconds(seconds);
    constexpr double highest = 1000;
    return rate && rate->per_second() <= highest ? rate->per_second() : 0;
}

/// Whether a bare name is that of depth's times.
bool is_of_times(const std::string& name) {
    return is_any_of(name, {"timestamps", "timestamp", "times", "depthtimestamps", "depthtimes"});
}

/// Sets the rate by a table's times, if it counts frames or has a camera's poses.
void read_times(const NumberTable& table, CameraText& said) {
    const int time = table.column({"timestamp", "timestamps", "time", "t", "sec", "seconds", "timestampns"});
    const bool counts = table.column({"frame", "frameid", "frameindex", "framenumber", "index"}) >= 0;
    if (time < 0 || (!counts && table.column({"qx", "qw"}) < 0)) return;
    std::vector<double> seconds;
    for (const std::vector<double>& row : table.rows) seconds.push_back(row[static_cast<std::size_t>(time)]);
    if (!std::ranges::is_sorted(seconds)) return;
    said.frames_per_second = rate_of_times(seconds);
    said.timed_rows = seconds.size();
}

/// Reads a table's rows as objects in a list of JSON: at most `most_cameras`, evenly, or the wanted one.
void read_rows(const NumberTable& table, const FrameKey& wanted, CameraText& said) {
    const int frame = table.column({"frame", "frameid", "frameindex", "framenumber", "index"});
    std::vector<std::string> keys;
    for (const std::vector<double>& row : table.rows)
        keys.push_back(frame < 0 ? "" : short_number(row[static_cast<std::size_t>(frame)], 10));
    const auto one = frame < 0 ? std::nullopt : place_of(wanted, keys);
    const std::size_t count = one ? 1 : std::min(table.rows.size(), most_cameras);
    for (std::size_t n = 0; n < count; ++n) {
        const std::size_t at = one.value_or(n * table.rows.size() / count);
        Json object = Json::object();
        for (std::size_t k = 0; k < table.names.size(); ++k)
            object.emplace(table.names[k], table.rows[at][k]);
        find_cameras(object, said.cameras, wanted, {.frame = keys[at].empty() ? '#' + keys[at] : keys[at]});
    }
}

/// If each camera is that of a frame, all become one: the median. A camera's focus moves by a few per cent;
/// cameras that differ by more are those of a rig.
void join_frames(CameraText& said) {
    constexpr double most_moved = 1.1;
    std::vector<CameraFile>& cameras = said.cameras;
    if (cameras.size() < 2 || std::ranges::any_of(cameras, &std::string::empty, &CameraFile::frame)) return;
    const CameraFile median = median_camera_file(cameras);
    const bool is_one = std::ranges::all_of(cameras, [&](const CameraFile& each) {
        const double fx = each.intrinsics.fx, of_median = median.intrinsics.fx;
        return fx <= most_moved * of_median && of_median <= most_moved * fx;
    });
    if (is_one) said.cameras = {median};
}

/// Cameras in numbers without words: a matrix, with or without more behind it (a baseline, a lens), one for
/// each frame, or bare numbers.
CameraText from_numbers(const std::vector<double>& numbers) {
    constexpr std::size_t of_matrix = 9, most_behind = 6;
    if (const auto found = from_matrix(numbers)) return {{{.intrinsics = *found}}};
    CameraText said;
    if (numbers.size() > of_matrix && numbers.size() % of_matrix == 0) {
        const std::size_t frames = numbers.size() / of_matrix, count = std::min(frames, most_cameras);
        for (std::size_t n = 0; n < count; ++n) {
            const auto first =
                numbers.begin() + static_cast<std::ptrdiff_t>(of_matrix * (n * frames / count));
            if (const auto found = from_matrix({first, first + of_matrix}))
                said.cameras.push_back({.intrinsics = *found, .frame = '#' + std::to_string(n)});
        }
        if (said.cameras.size() == count) return said;
    }
    if (numbers.size() > of_matrix && numbers.size() <= of_matrix + most_behind)
        if (const auto found = from_matrix({numbers.begin(), numbers.begin() + of_matrix})) {
            constexpr double longest_baseline = 10;  // metres
            CameraFile camera{.intrinsics = *found};
            const double next = numbers[of_matrix];
            const bool is_one = numbers.size() == of_matrix + 1;
            if (is_one && next > 0 && next < longest_baseline) camera.baseline = next;
            camera.has_distortion = !is_one && next != 0;
            return {{std::move(camera)}};
        }
    if (const auto found = from_pincam(numbers)) {
        const bool is_bent = std::any_of(numbers.begin() + 6, numbers.end(), [](double n) { return n != 0; });
        return {{{.intrinsics = *found, .has_distortion = is_bent, .is_bare = true}}};
    }
    if (const auto found = from_four(numbers)) return {{{.intrinsics = *found, .is_bare = true}}};
    return {};
}

/// MVSNet's: the word extrinsic with a 4x4 matrix, the word intrinsic with a 3x3 one, and a range of depths.
std::optional<Intrinsics> from_mvsnet(std::string_view text) {
    constexpr std::size_t longest = 1 << 12, of_matrix = 9;
    text = text.substr(0, longest);
    const auto begin = text.find("\nintrinsic");
    if (!trimmed(text, " \t\r\n").starts_with("extrinsic") || begin == std::string_view::npos) return {};
    auto numbers = numbers_in(text.substr(begin));
    if (numbers.size() < of_matrix) return {};
    numbers.resize(of_matrix);
    return from_matrix(numbers);
}

/// A text without a camera is no error here.
CameraText cameras_in_text(std::string_view text, const FrameKey& wanted = {}) {
    if (auto found = from_calib(text)) return {{std::move(*found)}};
    if (auto found = from_mvsnet(text)) return {{{.intrinsics = *found}}};
    if (text.find_first_not_of("0123456789+-.eE, \t\r\n[];") == std::string_view::npos)
        if (auto found = from_numbers(numbers_in(text)); !found.cameras.empty()) {
            join_frames(found);
            return found;
        }
    CameraText said;
    if (const NumberTable table = table_in(text); !table.rows.empty()) {
        read_rows(table, wanted, said);
        read_times(table, said);
    }
    if (said.cameras.empty()) take_members(json_in(text), wanted, said);
    if (said.cameras.empty()) said.cameras = from_colmap(text);
    if (said.cameras.empty()) take_members(members_in_lines(text), wanted, said);
    if (said.cameras.empty())
        if (auto printed = from_printed(text)) said.cameras.push_back(std::move(*printed));
    for (CameraFile& camera : said.cameras) {
        if (camera.codes_per_metre == 0) camera.codes_per_metre = said.codes_per_metre;
        said.cameras.front().scale_differs |=
            !camera.frame.empty() && camera.codes_per_metre != said.cameras.front().codes_per_metre;
    }
    join_frames(said);
    if (said.codes_per_metre == 0 && said.cameras.size() == 1)
        said.codes_per_metre = said.cameras.front().codes_per_metre;
    return said;
}

/// Reads an object in each line: the cameras of the first that has any, and the rate by their times.
CameraText cameras_in_lines(std::string_view text, const FrameKey& wanted) {
    CameraText said;
    std::vector<double> seconds;
    while (!text.empty() && seconds.size() < most_cameras) {
        const std::string_view line = cut_line(text);
        CameraText in_line = cameras_in_text(line, wanted);
        if (in_line.cameras.empty()) continue;
        const Json object = json_in(line);
        seconds.push_back(Members(object).number({"time", "timestamp", "t"}));
        if (said.cameras.empty()) said = std::move(in_line);
    }
    if (said.frames_per_second == 0) said.frames_per_second = rate_of_times(std::move(seconds));
    return said;
}

/// Whether the principal point is in the picture, or no farther beside it than half of it.
bool is_near_picture(const Intrinsics& camera) {
    const auto fits = [](const std::optional<double>& at, int side) {
        return !at || side <= 0 || (*at > -0.5 * side && *at < 1.5 * side);
    };
    return fits(camera.cx, camera.width) && fits(camera.cy, camera.height);
}

bool is_no_camera(const CameraFile& file) {
    const Intrinsics& camera = file.intrinsics;
    const auto is_length = [](double value) { return std::isfinite(value) && value > 0 && value < 1e6; };
    const bool is_view = camera.fx == 0 && (camera.fov_x > 0 || camera.fov_y > 0);
    // Millimetres beside pixels, as no pinhole camera sees 157 degrees; up to 3 it may be a share.
    if (const double cx = camera.cx.value_or(0); is_side(cx) && camera.fx > 3 && camera.fx < 0.2 * cx)
        return true;
    return !(is_view || (is_length(camera.fx) && is_length(camera.fy))) ||
           !std::isfinite(camera.cx.value_or(0)) || !std::isfinite(camera.cy.value_or(0));
}

}  // namespace

CameraFile median_camera_file(std::span<const CameraFile> cameras) {
    CameraFile median = cameras.front();
    // The median of a number over the cameras that have it.
    const auto middle = [&](auto value_of) {
        std::vector<double> all;
        for (const CameraFile& each : cameras)
            if (const std::optional<double> value = value_of(each)) all.push_back(*value);
        if (all.empty()) return std::optional<double>();
        std::ranges::sort(all);
        median.differs = median.differs || all.back() - all.front() > 1e-3 * std::abs(all.back());
        return std::optional(all[(all.size() - 1) / 2]);
    };
    Intrinsics& of = median.intrinsics;
    for (double Intrinsics::*const number :
         {&Intrinsics::fx, &Intrinsics::fy, &Intrinsics::fov_x, &Intrinsics::fov_y})
        of.*number = *middle([&](const CameraFile& each) { return std::optional(each.intrinsics.*number); });
    of.cx = middle([](const CameraFile& each) { return each.intrinsics.cx; });
    of.cy = middle([](const CameraFile& each) { return each.intrinsics.cy; });
    median.codes_per_metre =
        *middle([](const CameraFile& each) { return std::optional(each.codes_per_metre); });
    median.frames = cameras.size();
    median.name.clear();
    return median;
}

Result<CameraText> read_camera_text(const std::filesystem::path& file, const FrameKey& wanted) {
    constexpr std::size_t enough_lines = 1 << 18;
    if (is_any_of(small_letters(file.extension().string()), {".npy", ".npz"}))
        return cameras_in_arrays(small_arrays_in(SourceFile(file)));
    const bool is_of_lines = small_letters(file.extension().string()) == ".jsonl";
    TRY_ASSIGN(auto text, is_of_lines
                              ? Result<std::string>(first_bytes(SourceFile(file), enough_lines))
                              : read_given_file(file, file.string(), "a camera's file", longest_camera_file));
    if (is_git_lfs_pointer(text)) return input_error(file.string() + ": " + git_lfs_words);
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // a mark that says UTF-8
    CameraText said = is_of_lines ? cameras_in_lines(text, wanted) : cameras_in_text(text, wanted);
    bool is_any_far = false;
    std::erase_if(said.cameras, [&](CameraFile& camera) {
        camera.intrinsics.fy = std::abs(camera.intrinsics.fy);
        const bool is_far = !is_near_picture(camera.intrinsics);
        is_any_far |= is_far;
        return is_far || is_no_camera(camera);
    });
    if (said.cameras.empty() && is_any_far)
        return input_error(file.string() +
                           ": its principal point is far beside its picture: must be cx, cy in pixels, in "
                           "the picture or near it");
    return said;
}

double rate_in_file_of_times(const std::filesystem::path& file, std::size_t frames) {
    constexpr std::size_t longest = 1 << 22;
    const std::string stem = bare_name(file.stem().string());
    const bool is_rate = is_any_of(stem, {"fps", "framerate"});
    if (!is_rate && !is_of_times(stem)) return 0;
    const auto text = read_given_file(file, file.string(), "times of frames", longest);
    if (!text || text->find_first_not_of("0123456789+-.eE, \t\r\n[];") != std::string::npos) return 0;
    const std::vector<double> numbers = numbers_in(*text);
    constexpr double highest = 1000;
    if (is_rate) return numbers.size() == 1 && numbers[0] > 0 && numbers[0] <= highest ? numbers[0] : 0;
    // In lines of a number and a time, or of times alone.
    const bool is_list = text->starts_with('[');
    const std::size_t columns = is_list ? 1 : numbers_in(text->substr(0, text->find('\n'))).size();
    if (columns < 1 || columns > 2 || numbers.size() % columns != 0) return 0;
    std::vector<double> seconds;
    for (std::size_t k = columns - 1; k < numbers.size(); k += columns) seconds.push_back(numbers[k]);
    return frames > 0 && seconds.size() != frames ? 0 : rate_of_times(std::move(seconds));
}

Result<CameraFile> read_camera_file(const std::filesystem::path& file) {
    TRY_ASSIGN(auto said, read_camera_text(file));
    if (!said.cameras.empty()) return std::move(said.cameras.front());
    return input_error(file.string() +
                       ": has no camera that could be read: must be JSON, YAML or XML with fx, fy, cx, cy "
                       "(or px, py, u0, v0), a matrix K, intrinsic_matrix or camera_matrix, or fov_x in "
                       "degrees; or 3x3 numbers, COLMAP's cameras.txt, Kalibr's camchain.yaml, Middlebury's "
                       "calib.txt or ARKitScenes' .pincam (width height fx fy cx cy)");
}

Result<Intrinsics> read_intrinsics(const std::filesystem::path& file) {
    TRY_ASSIGN(const auto read, read_camera_file(file));
    return read.intrinsics;
}

CameraText cameras_in_arrays(std::span<const SmallArray> arrays, std::int64_t frames) {
    constexpr std::size_t most_of_lens = 14;
    CameraText said;
    Json numbers = Json::object();
    for (const SmallArray& array : arrays) {
        if (is_of_times(bare_name(array.name)) && std::ssize(array.numbers) == frames)
            said.frames_per_second = rate_of_times(array.numbers);
        if (array.numbers.size() == 1) numbers.emplace(array.name, array.numbers.front());
        if (array.numbers.size() > 1 && array.numbers.size() <= most_of_lens)
            numbers.emplace(array.name, array.numbers);
        // Of 3x3, 3x4 or 4x4; HDF5's have no shape.
        const auto shape = array.shape.empty() ? std::vector<std::int64_t>{3, 3} : array.shape;
        const auto across = shape.back(), down = shape.size() > 1 ? shape[shape.size() - 2] : 0;
        const bool is_matrices = across <= 4 && down >= 3 && down <= across;
        const auto each = static_cast<std::size_t>(is_matrices ? across * down : across == 4 ? 4 : 0);
        if (each == 0 || array.numbers.size() % each != 0) continue;
        const std::size_t count = array.numbers.size() / each;
        std::vector<CameraFile> cameras;
        for (std::size_t n = 0; n < std::min(count, most_cameras); ++n) {
            const auto first =
                array.numbers.begin() +
                static_cast<std::ptrdiff_t>(each * (n * count / std::min(count, most_cameras)));
            Json object = Json::object();
            // A matrix is a camera's by its numbers, whatever its name.
            object[is_matrices ? "k" : array.name] =
                std::vector<double>(first, first + static_cast<std::ptrdiff_t>(each));
            if (const auto found = intrinsics_of(object)) cameras.push_back({.intrinsics = *found});
        }
        std::erase_if(cameras, is_no_camera);
        if (!cameras.empty()) {
            said.cameras.push_back(median_camera_file(cameras));
            said.cameras.back().name = array.name.substr(0, longest_camera_name);
        }
    }
    if (said.cameras.empty()) find_cameras(numbers, said.cameras, {}, {});
    std::erase_if(said.cameras, is_no_camera);
    std::stable_partition(said.cameras.begin(), said.cameras.end(),
                          [](const CameraFile& camera) { return has_word(camera.name, {"depth"}); });
    for (CameraFile& camera : said.cameras) camera.has_distortion = says_distortion(numbers);
    said.codes_per_metre = codes_per_metre_of(numbers);
    if (said.frames_per_second == 0) said.frames_per_second = rate_of_members(numbers);
    said.near = near_of_members(numbers);
    said.far = far_of_members(numbers);
    return said;
}

std::optional<Intrinsics> intrinsics_in_json(const std::string& text) {
    const CameraText said = cameras_in_text(text);
    return said.cameras.empty() ? std::nullopt : std::optional(said.cameras.front().intrinsics);
}

}  // namespace touchable
