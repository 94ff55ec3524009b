// Cameras in the files of others. JSON, XML and YAML are all read as JSON, in which a camera is whatever has
// focal lengths or a matrix, under the names that programs use for them; Middlebury's, COLMAP's and
// ARKitScenes' texts have readers of their own. Declared in source_description.hpp and camera_sidecar.hpp.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <pugixml.hpp>
#include <sstream>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using checked_json::Json;

constexpr std::size_t longest_camera_file = std::size_t{16} << 20;  // Record3D's has a pose for each frame
constexpr std::size_t most_cameras = 64, longest_name = 200;
constexpr int deepest_yaml = 16;

Json yaml_scalar(std::string_view text) {
    text = trimmed(text);
    if (const auto number = parsed_number(text)) return *number;
    const bool is_quoted = text.size() > 1 && (text[0] == '"' || text[0] == '\'') && text.back() == text[0];
    return is_quoted ? std::string(text.substr(1, text.size() - 2)) : std::string(text);
}

/// Numbers are names as well.
std::string yaml_name(std::string_view text) {
    const Json name = yaml_scalar(text);
    return name.is_string() ? name.get<std::string>() : name.dump();
}

/// Where a comment begins: at the start, or after a space.
std::string_view without_comment(std::string_view line) {
    char quote = 0;
    for (std::size_t k = 0; k < line.size(); ++k) {
        if (quote != 0 ? line[k] == quote : line[k] == '"' || line[k] == '\'')
            quote = quote != 0 ? 0 : line[k];
        if (quote == 0 && line[k] == '#' && (k == 0 || line[k - 1] == ' ' || line[k - 1] == '\t'))
            return line.substr(0, k);
    }
    return line;
}

/// Lists and maps in brackets.
class YamlInBrackets {
public:
    explicit YamlInBrackets(std::string_view text) : rest_(text) {}
    Json value(int depth = 0) {
        skip_spaces();
        if (depth > deepest_yaml || rest_.empty()) return nullptr;
        const char open = rest_[0];
        if (open != '[' && open != '{') return yaml_scalar(taken(rest_.find_first_of(",]}")));
        const char close = open == '[' ? ']' : '}';
        Json made = open == '[' ? Json::array() : Json::object();
        rest_.remove_prefix(1);
        for (skip_spaces(); !rest_.empty() && rest_[0] != close; skip_spaces()) {
            std::string name;
            if (open == '{') {
                name = yaml_name(taken(rest_.find_first_of(":,]}")));
                if (rest_.empty() || rest_[0] != ':') return nullptr;
                rest_.remove_prefix(1);
            }
            Json inner = value(depth + 1);
            if (open == '[')
                made.push_back(std::move(inner));
            else
                made.emplace(std::move(name), std::move(inner));
            skip_spaces();
            if (rest_.empty() || (rest_[0] != ',' && rest_[0] != close)) return nullptr;
            if (rest_[0] == ',') rest_.remove_prefix(1);
        }
        if (rest_.empty()) return nullptr;
        rest_.remove_prefix(1);
        return made;
    }

private:
    std::string_view taken(std::size_t count) {
        const auto begin = rest_.substr(0, count);
        rest_.remove_prefix(begin.size());
        return begin;
    }
    void skip_spaces() {
        while (!rest_.empty() && (rest_[0] == ' ' || rest_[0] == '\t')) rest_.remove_prefix(1);
    }

    std::string_view rest_;
};

class YamlLines {
public:
    explicit YamlLines(std::string_view text) {
        while (!text.empty()) {
            const auto end = text.find('\n');
            const std::string_view line = without_comment(text.substr(0, end));
            text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
            const std::string_view inner = trimmed(line);
            if (inner == "---" || inner == "...") {
                if (!lines_.empty()) break;
                continue;
            }
            if (inner.empty() || line[0] == '%') continue;
            lines_.push_back({static_cast<std::size_t>(inner.data() - line.data()), inner});
        }
    }

    Json block(std::size_t indent, int depth) {
        if (depth > deepest_yaml) {
            at_ = lines_.size();
            return nullptr;
        }
        if (goes_on(indent) && is_item()) return items(indent, depth);
        Json map = Json::object();
        while (goes_on(indent)) {
            const std::string_view line = lines_[at_].text;
            auto colon = line.find(": ");
            if (colon == std::string_view::npos && line.back() == ':') colon = line.size() - 1;
            ++at_;
            if (colon == std::string_view::npos) continue;
            add(map, yaml_name(line.substr(0, colon)),
                value_of(trimmed(line.substr(colon + 1)), indent, depth));
            // What stands further in without a reason is passed over.
            while (at_ < lines_.size() && lines_[at_].indent > indent) ++at_;
        }
        return map;
    }

    std::size_t first_indent() const { return lines_.empty() ? 0 : lines_[0].indent; }

private:
    struct Line {
        std::size_t indent;
        std::string_view text;
    };
    bool is_item() const { return lines_[at_].text == "-" || lines_[at_].text.starts_with("- "); }
    bool goes_on(std::size_t indent) const { return at_ < lines_.size() && lines_[at_].indent == indent; }

    Json items(std::size_t indent, int depth) {
        Json list = Json::array();
        while (goes_on(indent) && is_item()) {
            const std::string_view text = trimmed(lines_[at_].text.substr(1));
            const bool is_bracket = text.starts_with('[') || text.starts_with('{');
            if (!text.empty() && !is_bracket && text[0] != '"' && text[0] != '\'' &&
                (text.starts_with("- ") || text.find(": ") != std::string_view::npos || text.back() == ':')) {
                // A map or a list that begins here: as if it stood in a line of its own, at its own place.
                lines_[at_].indent += static_cast<std::size_t>(text.data() - lines_[at_].text.data());
                lines_[at_].text = text;
                list.push_back(block(lines_[at_].indent, depth + 1));
            } else {
                ++at_;
                list.push_back(value_of(text, indent, depth));
            }
        }
        return list;
    }

    /// What stands behind a name, or in the lines below it.
    Json value_of(std::string_view text, std::size_t indent, int depth) {
        while (!text.empty() && (text[0] == '!' || text[0] == '&')) {
            const auto end = text.find_first_of(" \t");
            text = end == std::string_view::npos ? std::string_view() : trimmed(text.substr(end));
        }
        if (!text.empty() && (text[0] == '[' || text[0] == '{'))
            return YamlInBrackets(gathered(text)).value();
        if (!text.empty() && text[0] != '|' && text[0] != '>') return yaml_scalar(text);
        if (!text.empty()) {  // a text of several lines, which has no numbers of a camera
            while (at_ < lines_.size() && lines_[at_].indent > indent) ++at_;
            return nullptr;
        }
        if (at_ >= lines_.size()) return nullptr;
        const std::size_t below = lines_[at_].indent;
        return below > indent || (below == indent && is_item()) ? block(below, depth + 1) : Json();
    }

    /// A value in brackets may go on over lines.
    std::string gathered(std::string_view text) {
        std::string all;
        std::ptrdiff_t open = 0;
        const auto add_text = [&](std::string_view more) {
            for (const char c : more) open += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
            (all += more) += ' ';
        };
        for (add_text(text); open > 0 && at_ < lines_.size(); ++at_) add_text(lines_[at_].text);
        return all;
    }

    /// Names with a point lead further in.
    static void add(Json& map, std::string_view name, Json value) {
        const auto point = name.find('.');
        Json* within = &map;
        if (point != std::string_view::npos && point > 0 && point + 1 < name.size()) {
            within = &map[std::string(name.substr(0, point))];
            if (within->is_null()) *within = Json::object();
            name.remove_prefix(point + 1);
        }
        if (within->is_object()) within->emplace(std::string(name), std::move(value));
    }

    std::vector<Line> lines_;
    std::size_t at_ = 0;
};

/// YAML as programs write a camera into it, as JSON: maps and lists by indentation or in brackets, numbers
/// and words. Tags, anchors and comments are passed over; of several documents the first is read, of members
/// with one name the first. What has a point in its name, such as Camera.fx of ORB-SLAM, is a member of a
/// member. Null for what is no map, is nested deeper than `deepest_yaml`, or is none of this.
Json plain_yaml(std::string_view text) {
    YamlLines lines(text);
    Json made = lines.block(lines.first_indent(), 0);
    return made.is_object() && !made.empty() ? std::move(made) : Json();
}

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

std::optional<Intrinsics> intrinsics_of(const Json& object) {
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

bool says_distortion(const Json& object) {
    std::vector<double> terms =
        list_of(object, {"distortion_coefficients", "Distortion_Coefficients", "distortion_coeffs",
                         "dist_coeffs", "distCoeffs", "coeffs", "D", "d"});
    for (const char* name : {"k1", "k2", "k3", "p1", "p2", "kud", "kdu"})
        terms.push_back(number_of(object, {name}));
    return std::ranges::any_of(terms, [](double term) { return term != 0; });
}

/// Adds the cameras in `json` to `found`, depth's first. What has focal lengths or a matrix is one camera,
/// whatever else is in it. `name`, `width`, `height`: what the members around it say; `depth`: how many.
void find_cameras(const Json& json, std::vector<CameraFile>& found, const std::string& name = "",
                  int width = 0, int height = 0, int depth = 0) {
    constexpr int deepest = 6;
    if (depth > deepest || found.size() >= most_cameras) return;
    if (json.is_array()) {
        std::size_t looked = 0;
        for (const Json& each : json)
            if (each.is_object() && looked++ < most_cameras)
                find_cameras(each, found, name, width, height, depth + 1);
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
    if (auto camera = intrinsics_of(json)) {
        camera->width = width;
        camera->height = height;
        found.push_back({.intrinsics = *camera, .has_distortion = says_distortion(json), .name = own_name});
        return;
    }
    constexpr const char* first[] = {"depth", "depth_intrinsics", "intrinsics", "intrinsic", "camera"};
    const auto inner = [&](const std::string& member) {
        find_cameras(json[member], found, own_name.empty() ? member : own_name + ' ' + member, width, height,
                     depth + 1);
    };
    for (const char* member : first)
        if (json.contains(member)) inner(member);
    for (const auto& [member, value] : json.items())
        if (std::ranges::find(first, member) == std::end(first)) inner(member);
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

/// No camera in the text is no error here.
CameraText cameras_in_text(std::string_view text) {
    if (auto found = from_calib(text)) return {{std::move(*found)}};
    if (text.find_first_not_of("0123456789+-.eE, \t\r\n[];") == std::string_view::npos) {
        const auto numbers = numbers_in(text);
        if (const auto found = from_matrix(numbers)) return {{{.intrinsics = *found}}};
        if (const auto found = from_pincam(numbers)) return {{{.intrinsics = *found}}};
    }
    const Json json = json_in(text);
    CameraText said;
    find_cameras(json, said.cameras);
    said.frames_per_second = rate_in(json);
    if (said.cameras.empty()) said.cameras = from_colmap(text);
    for (CameraFile& camera : said.cameras) camera.codes_per_metre = codes_per_metre_in(json);
    return said;
}

/// Whether the principal point is in the picture, or no farther beside it than half of it.
bool is_near_picture(const Intrinsics& camera) {
    const auto fits = [](const std::optional<double>& at, int side) {
        return !at || side <= 0 || (*at > -0.5 * side && *at < 1.5 * side);
    };
    return fits(camera.cx, camera.width) && fits(camera.cy, camera.height);
}

bool has_focal_lengths(const Intrinsics& camera) {
    const auto is_length = [](double value) { return std::isfinite(value) && value > 0 && value < 1e6; };
    return is_length(camera.fx) && is_length(camera.fy);
}

}  // namespace

Result<CameraText> read_camera_text(const std::filesystem::path& file) {
    TRY_ASSIGN(auto text, read_given_file(file, file.string(), "a camera's file", longest_camera_file));
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // a mark that says UTF-8
    CameraText said = cameras_in_text(text);
    bool is_any_far = false;
    std::erase_if(said.cameras, [&](CameraFile& camera) {
        camera.intrinsics.fy = std::abs(camera.intrinsics.fy);
        const bool is_far = !is_near_picture(camera.intrinsics);
        is_any_far |= is_far;
        return is_far || !has_focal_lengths(camera.intrinsics);
    });
    if (said.cameras.empty() && is_any_far)
        return input_error(file.string() +
                           ": its principal point is far beside its picture: must be cx, cy in "
                           "pixels, in the picture or near it");
    return said;
}

Result<CameraFile> read_camera_file(const std::filesystem::path& file) {
    TRY_ASSIGN(auto said, read_camera_text(file));
    if (!said.cameras.empty()) return std::move(said.cameras.front());
    return input_error(
        file.string() +
        ": has no camera that could be read: must have fx, fy, cx, cy or px, py, u0, v0 (JSON, YAML, XML), a "
        "matrix K, intrinsic_matrix or camera_matrix (likewise), 3x3 numbers, or be COLMAP's cameras.txt, "
        "Kalibr's camchain.yaml, Middlebury's calib.txt or ARKitScenes' .pincam (width height fx fy cx cy)");
}

Result<Intrinsics> read_intrinsics(const std::filesystem::path& file) {
    TRY_ASSIGN(const auto read, read_camera_file(file));
    return read.intrinsics;
}

std::optional<Intrinsics> intrinsics_in_json(const std::string& text) {
    const CameraText said = cameras_in_text(text);
    return said.cameras.empty() ? std::nullopt : std::optional(said.cameras.front().intrinsics);
}

}  // namespace touchable
