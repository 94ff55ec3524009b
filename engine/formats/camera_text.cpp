#include "engine/formats/camera_text.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <pugixml.hpp>
#include <sstream>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/formats/plain_yaml.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using checked_json::Json;

constexpr std::size_t most_cameras = 64, longest_name = 200;

bool is_side(double pixels) {
    return pixels >= 1 && pixels <= 16384;
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

/// Of 3x3 numbers by rows or by columns, or 4x4 by rows.
std::optional<Intrinsics> from_matrix(const std::vector<double>& m) {
    if (m.size() == 16) return from_matrix({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
    if (m.size() != 9) return {};
    const bool by_rows = m[2] != 0 || m[5] != 0;
    // Other matrices, a rotation or a pose, are no camera's. A pixel's skew moves no place by more than half.
    constexpr double most_skew = 1, least_focal = 1;
    const bool last_is_unit = (by_rows ? m[6] == 0 && m[7] == 0 : m[2] == 0 && m[5] == 0) && m[8] == 1;
    const bool is_camera = last_is_unit && std::abs(m[1]) <= most_skew && std::abs(m[3]) <= most_skew &&
                           m[0] > least_focal && std::abs(m[4]) > least_focal;
    if (!is_camera) return {};
    return Intrinsics{m[0], m[4], by_rows ? m[2] : m[6], by_rows ? m[5] : m[7]};
}

void flatten(const Json& value, std::vector<double>& numbers) {
    if (value.is_number()) numbers.push_back(value.get<double>());
    if (value.is_array())
        for (const Json& each : value)
            if (numbers.size() <= 16) flatten(each, numbers);
}

/// Of a member that is a list, of lists or with its numbers in `data`; at most 17.
std::vector<double> list_of(const Json& object, std::initializer_list<const char*> names) {
    std::vector<double> numbers;
    for (const char* name : names) {
        if (!object.contains(name)) continue;
        const Json& list = object[name];
        flatten(list.is_object() && list.contains("data") ? list["data"] : list, numbers);
        if (!numbers.empty()) break;
    }
    return numbers;
}

double number_of(const Json& object, std::initializer_list<const char*> names) {
    for (const char* name : names)
        if (object.contains(name) && object[name].is_number()) return object[name].get<double>();
    return 0;
}

/// Looks for cameras in what JSON, YAML and XML hold.
class CamerasInJson {
public:
    std::vector<CameraFile> found() && { return std::move(found_); }
    void look_at(const Json& json, const std::string& name, int width = 0, int height = 0, int depth = 0);

private:
    static std::optional<Intrinsics> intrinsics(const Json& object);
    static bool has_distortion(const Json& object);

    std::vector<CameraFile> found_;
};

std::optional<Intrinsics> CamerasInJson::intrinsics(const Json& object) {
    const auto centre = [&](std::initializer_list<const char*> names) {
        const double at = number_of(object, names);
        return at == 0 ? std::optional<double>() : std::optional(at);  // the middle where it is not said
    };
    const auto cx = centre({"ppx", "cx", "u0"}), cy = centre({"ppy", "cy", "v0"});
    double fx = number_of(object, {"fx", "focal_length_x", "fl_x"}),
           fy = number_of(object, {"fy", "focal_length_y", "fl_y"});
    if (fx == 0 && object.contains("u0")) fx = number_of(object, {"px"}), fy = number_of(object, {"py"});
    if (fx > 0) return Intrinsics{fx, fy > 0 ? fy : fx, cx, cy};
    for (const char* matrix : {"intrinsic_matrix", "K", "k", "intrinsicMatrix", "camera_matrix",
                               "Camera_Matrix", "cameraMatrix", "cam_K"})
        if (const auto found = from_matrix(list_of(object, {matrix}))) return found;
    const auto four = list_of(object, {"intrinsics"});  // Kalibr
    const bool is_pinhole = !object.contains("camera_model") || object["camera_model"] == "pinhole";
    if (four.size() == 4 && is_pinhole && four[0] > 1 && four[1] > 1)
        return Intrinsics{four[0], four[1], four[2], four[3]};
    return {};
}

bool CamerasInJson::has_distortion(const Json& object) {
    std::vector<double> terms =
        list_of(object, {"distortion_coefficients", "Distortion_Coefficients", "distortion_coeffs",
                         "dist_coeffs", "distCoeffs", "coeffs", "D", "d"});
    for (const char* name : {"k1", "k2", "k3", "p1", "p2", "kud", "kdu"})
        terms.push_back(number_of(object, {name}));
    return std::any_of(terms.begin(), terms.end(), [](double term) { return term != 0; });
}

/// What has focal lengths or a matrix is one camera, whatever is in it. Depth's come first.
void CamerasInJson::look_at(const Json& json, const std::string& name, int width, int height, int depth) {
    constexpr int deepest = 6;
    if (depth > deepest || found_.size() >= most_cameras) return;
    if (json.is_array()) {
        std::size_t looked = 0;
        for (const Json& each : json)
            if (each.is_object() && looked++ < most_cameras) look_at(each, name, width, height, depth + 1);
        return;
    }
    if (!json.is_object()) return;
    const auto pair = list_of(json, {"resolution", "image_size", "image_dimension"});
    const double own_width = pair.size() == 2 ? pair[0] : number_of(json, {"width", "w", "image_width"}),
                 own_height = pair.size() == 2 ? pair[1] : number_of(json, {"height", "h", "image_height"});
    if (is_side(own_width) && is_side(own_height)) {
        width = static_cast<int>(own_width);
        height = static_cast<int>(own_height);
    }
    std::string own_name = name;
    for (const char* member : {"name", "camera_name", "rostopic"})
        if (json.contains(member) && json[member].is_string())
            own_name += ' ' + json[member].get<std::string>();
    own_name = own_name.substr(0, longest_name);
    if (auto camera = intrinsics(json)) {
        camera->width = width;
        camera->height = height;
        found_.push_back({.intrinsics = *camera, .has_distortion = has_distortion(json), .name = own_name});
        return;
    }
    constexpr const char* first[] = {"depth", "depth_intrinsics", "intrinsics", "intrinsic", "camera"};
    const auto inner = [&](const std::string& member) {
        look_at(json[member], own_name.empty() ? member : own_name + ' ' + member, width, height, depth + 1);
    };
    for (const char* member : first)
        if (json.contains(member)) inner(member);
    for (const auto& [member, value] : json.items())
        if (std::find(std::begin(first), std::end(first), member) == std::end(first)) inner(member);
}

/// How many codes a metre has. Open3D says so much; RealSense metres, and BOP millimetres a code.
double codes_per_metre_in(const Json& json) {
    if (!json.is_object()) return 0;
    const double factor = number_of(json, {"DepthMapFactor"});  // ORB-SLAM
    if (factor > 0) return factor;
    const double scale = number_of(json, {"depth_scale"});
    constexpr double most_metres = 0.005, most_millimetres = 20;
    if (!(scale > 0) || scale == 1) return 0;  // 1 is BOP's millimetre, or says that there is nothing to do
    return scale <= most_metres ? 1 / scale : scale <= most_millimetres ? 1000 / scale : scale;
}

double rate_in(const Json& json) {
    constexpr double highest = 1000;
    const auto of = [](const Json& object) {
        return object.is_object()
                   ? number_of(object, {"fps", "frame_rate", "frameRate", "framerate", "FrameRate"})
                   : 0;
    };
    double rate = of(json);
    if (rate == 0 && json.is_object() && json.contains("Camera")) rate = of(json["Camera"]);  // ORB-SLAM
    return rate > 0 && rate <= highest ? rate : 0;
}

/// An element as JSON has it: numbers, words, members; several of one name are a list.
Json json_of(const pugi::xml_node& node, int depth = 0) {
    constexpr int deepest = 8;
    Json members = Json::object();
    if (depth > deepest) return nullptr;
    for (const pugi::xml_node& child : node.children()) {
        if (child.type() != pugi::node_element) continue;
        Json value = json_of(child, depth + 1);
        auto [there, is_new] = members.emplace(child.name(), Json());
        if (is_new) {
            *there = std::move(value);
            continue;
        }
        if (!there->is_array()) *there = Json::array({std::move(*there)});
        there->push_back(std::move(value));
    }
    if (!members.empty()) return members;
    std::istringstream words(node.child_value());
    Json list = Json::array();
    for (std::string word; words >> word;) {
        const auto number = parsed_number(word);
        if (!number) return std::string(node.child_value());
        list.push_back(*number);
    }
    return list.size() == 1 ? list[0] : list;
}

Json json_in(std::string_view text) {
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return nullptr;
    if (text[begin] == '{' || text[begin] == '[') {
        try {
            return checked_json::parse(text, text.size());
        } catch (const checked_json::Refusal&) {
        } catch (const Json::exception&) {
        }
        return nullptr;
    }
    if (text[begin] == '<') {
        pugi::xml_document document;
        return document.load_buffer(text.data(), text.size()) ? json_of(document) : Json();
    }
    return plain_yaml(text);
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
    if (width.size() == 1 && height.size() == 1 && is_side(width[0]) && is_side(height[0])) {
        found->width = static_cast<int>(width[0]);
        found->height = static_cast<int>(height[0]);
    }
    return CameraFile{*found, baseline[0] / 1000, offset.size() == 1 ? offset[0] : 0};
}

/// COLMAP: id model width height parameters; its pixel centres are at a half.
std::vector<CameraFile> from_colmap(std::string_view text) {
    std::vector<CameraFile> cameras;
    std::istringstream lines{std::string(text)};
    for (std::string line; std::getline(lines, line) && cameras.size() < most_cameras;) {
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

/// ARKitScenes' .pincam: width height fx fy cx cy.
std::optional<Intrinsics> from_pincam(const std::vector<double>& numbers) {
    if (numbers.size() != 6 || !is_side(numbers[0]) || !is_side(numbers[1])) return {};
    return Intrinsics{numbers[2],
                      numbers[3],
                      numbers[4],
                      numbers[5],
                      static_cast<int>(numbers[0]),
                      static_cast<int>(numbers[1])};
}

}  // namespace

CameraText cameras_in_text(std::string_view text) {
    if (auto found = from_calib(text)) return {{std::move(*found)}};
    if (text.find_first_not_of("0123456789+-.eE, \t\r\n[];") == std::string_view::npos) {
        const auto numbers = numbers_in(text);
        if (const auto found = from_matrix(numbers)) return {{{.intrinsics = *found}}};
        if (const auto found = from_pincam(numbers)) return {{{.intrinsics = *found}}};
    }
    const Json json = json_in(text);
    CamerasInJson cameras;
    cameras.look_at(json, "");
    CameraText said{std::move(cameras).found(), rate_in(json)};
    if (said.cameras.empty()) said.cameras = from_colmap(text);
    for (CameraFile& camera : said.cameras) camera.codes_per_metre = codes_per_metre_in(json);
    return said;
}

}  // namespace touchable
