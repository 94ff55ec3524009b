// Cameras in the files of others. JSON, XML and YAML are all read as JSON, in which a camera is whatever has
// focal lengths or a matrix, under the names that programs use for them; Middlebury's, COLMAP's and
// ARKitScenes' texts have readers of their own. Declared in source_description.hpp and camera_sidecar.hpp.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <pugixml.hpp>
#include <sstream>

#include "engine/base/files.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/sidecar_text.hpp"
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

/// A matrix of 3x3 numbers by rows or by columns, or of 3x4 or 4x4 by rows. Of shares of a picture's sides it
/// is taken where both its points are near the middle.
std::optional<Intrinsics> from_matrix(const std::vector<double>& m) {
    if (m.size() == 16 || m.size() == 12)
        return from_matrix({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
    if (m.size() != 9) return {};
    const bool by_rows = m[2] != 0 || m[5] != 0;
    // Other matrices, a rotation or a pose, are no camera's. A pixel's skew moves no place by more than half.
    constexpr double most_skew = 1, least_focal = 1;
    const double cx = by_rows ? m[2] : m[6], cy = by_rows ? m[5] : m[7];
    const auto is_middle = [](double at) { return at > 0.25 && at < 0.75; };
    const bool is_of_shares = is_middle(cx) && is_middle(cy) && m[1] == 0 && m[3] == 0 && m[0] > 0.1;
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
/// first is there. Refers to the object.
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
    /// The first of these that is a number; 0: none is.
    double number(std::initializer_list<const char*> names) const {
        for (const char* name : names)
            if (const Json* value = find(name); value != nullptr && value->is_number())
                return value->get<double>();
        return 0;
    }
    /// Of a member that is a list, of lists or with its numbers in `data`; at most 17.
    std::vector<double> list(std::initializer_list<const char*> names) const {
        std::vector<double> numbers;
        for (const char* name : names) {
            const Json* value = find(name);
            if (value == nullptr) continue;
            if (value->is_object() && value->contains("data")) value = &(*value)["data"];
            if (value->is_number()) continue;
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

/// How wide a camera sees: an angle, or a renderer's focal length and aperture in millimetres.
std::optional<Intrinsics> view_of(const Members& members) {
    constexpr double widest = 179, least = 1, most_radians = 3.13;
    double x = members.number({"fovx", "hfov", "horizontalfov", "fovh", "fovxdeg", "xfov"}),
           y = members.number({"fovy", "vfov", "verticalfov", "fovv", "fovydeg", "yfov"});
    if (x == 0 && y == 0) x = members.number({"fov", "fieldofview", "fovdegrees", "fovdeg", "camerafov"});
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
        // The height of a sensor says nothing: renderers cut it to the picture's shape.
    }
    const auto is_angle = [](double degrees) { return degrees >= least && degrees <= widest; };
    if (!is_angle(x) && !is_angle(y)) return {};
    Intrinsics seen;
    if (is_angle(x)) seen.fov_x = x;
    if (is_angle(y)) seen.fov_y = y;
    return seen;
}

std::optional<Intrinsics> intrinsics_of(const Json& object) {
    const Members members(object);
    const auto centre = [&](std::initializer_list<const char*> names) {
        const double at = members.number(names);
        return at == 0 ? std::optional<double>() : std::optional(at);  // the middle where it is not said
    };
    auto cx = centre({"ppx", "cx", "u0", "cu", "k02", "principalpointx", "cxdepth", "mxdepth", "cxd"}),
         cy = centre({"ppy", "cy", "v0", "cv", "k12", "principalpointy", "cydepth", "mydepth", "cyd"});
    if (const auto pair = members.list({"principalpoint", "pp", "c", "center", "opticalcenter"});
        pair.size() == 2 && !cx)
        cx = pair[0], cy = pair[1];
    double fx = members.number({"fx", "focallengthx", "flx", "fu", "k00", "focalx", "fxdepth", "fxd"}),
           fy = members.number({"fy", "focallengthy", "fly", "fv", "k11", "focaly", "fydepth", "fyd"});
    if (fx == 0 && members.has("u0"))
        fx = members.number({"px", "alphau"}), fy = members.number({"py", "alphav"});
    if (fx == 0 && cx)
        if (const auto pair = members.list({"focallength", "focal", "focals", "f"}); pair.size() == 2)
            fx = pair[0], fy = pair[1];
    // One number is pixels only beside a principal point in pixels.
    if (fx == 0 && cx && *cx > 1) fx = members.number({"focallength", "focal", "focallengthpx", "f"});
    if (fx > 0) return Intrinsics{fx, fy > 0 ? fy : fx, cx, cy};
    for (const char* matrix : {"intrinsicmatrix",
                               "k",
                               "cameramatrix",
                               "camk",
                               "depthk",
                               "intrinsicsmatrix",
                               "depthintrinsics",
                               "depthintrinsic",
                               "intrinsics",
                               "intrinsic",
                               "cameraintrinsics",
                               "cameraintrinsic",
                               "kmatrix",
                               "depthcameramatrix",
                               "calibrationmatrix",
                               "perframeintrinsiccoeffs",
                               "p",
                               "p2",
                               "prect02",
                               "p0",
                               "prect00",
                               "krect02",
                               "k02"})
        if (const auto found = from_matrix(members.list({matrix}))) return found;
    const auto four =
        members.list({"intrinsics", "intrinsic", "perframeintrinsiccoeffs"});  // Kalibr, Record3D
    const Json* const model = members.find("cameramodel");
    const bool is_pinhole = model == nullptr || *model == "pinhole";
    if (four.size() == 4 && is_pinhole && four[0] > 1 && four[1] > 1)
        return Intrinsics{four[0], four[1], four[2], four[3]};
    return view_of(members);
}

bool says_distortion(const Json& object) {
    const Members members(object);
    std::vector<double> terms = members.list(
        {"distortioncoefficients", "distortioncoeffs", "distcoeffs", "coeffs", "distortion", "d"});
    for (const char* name : {"k1", "k2", "k3", "p1", "p2", "kud", "kdu"})
        terms.push_back(members.number({name}));
    return std::ranges::any_of(terms, [](double term) { return term != 0; });
}

/// How many codes a metre has, by an object's own members; 0: it does not say. Three ways are in use: codes
/// in a metre (Open3D, ORB-SLAM, ScanNet), metres of a code (RealSense, instant-ngp, nerfstudio), and
/// millimetres of a code (BOP, beside cam_K).
double codes_per_metre_of(const Json& object) {
    const Members members(object);
    constexpr double most_metres = 0.005, most_millimetres = 20, least_codes = 50, most_codes = 1e6;
    const auto is_count = [](double codes) { return codes >= least_codes && codes <= most_codes; };
    const auto is_metres = [](double metres) { return metres > 1e-9 && metres <= most_metres; };
    const double codes = members.number(
        {"depthmapfactor", "pngdepthscale", "depthfactor", "mdepthshift", "depthshift", "depthmapscale"});
    if (codes > 0) return is_count(codes) ? codes : is_metres(codes) ? 1 / codes : 0;
    const double metres = members.number({"integerdepthscale", "depthunitscalefactor", "depthunit",
                                          "depthunits", "depthunitm", "depthscalefactor", "metrespercode"});
    if (metres > 0) return is_metres(metres) ? 1 / metres : is_count(metres) ? metres : 0;
    double scale = members.number({"depthscale", "depthscales", "scaledepth"});
    if (is_metres(scale)) return 1 / scale;
    if (scale > 0 && scale <= most_millimetres && members.has("camk")) return 1000 / scale;
    // 1 is BOP's millimetre, or says that there is nothing to do.
    if (scale > most_metres && scale != 1)
        return scale <= most_millimetres ? 1000 / scale : is_count(scale) ? scale : 0;
    scale = members.has("fx") ? members.number({"scale"}) : 0;  // Replica
    return is_count(scale) ? scale : 0;
}

double rate_of_members(const Json& object) {
    constexpr double highest = 1000;
    const double rate =
        Members(object).number({"fps", "framerate", "camerafps", "framespersecond", "depthfps"});
    return rate > 0 && rate <= highest ? rate : 0;
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
                find_cameras(each, found, name == "frames" ? std::to_string(looked) : name, width, height,
                             depth + 1);
        return;
    }
    if (!json.is_object()) return;
    const Members members(json);
    const auto pair = members.list({"resolution", "imagesize", "imagedimension", "renderproductresolution"});
    const double own_width =
                     pair.size() == 2
                         ? pair[0]
                         : members.number({"width", "w", "imagewidth", "depthwidth", "resolutionx", "imw"}),
                 own_height = pair.size() == 2 ? pair[1]
                                               : members.number({"height", "h", "imageheight", "depthheight",
                                                                 "resolutiony", "imh"});
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
        found.push_back({.intrinsics = *camera,
                         .codes_per_metre = codes_per_metre_of(json),
                         .has_distortion = says_distortion(json),
                         .name = own_name});
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

/// Of the whole text, or of a member of it: ORB-SLAM's Camera, a configuration's cam.
template <class Of>
double first_said(const Json& json, Of of) {
    if (!json.is_object()) return 0;
    double said = of(json);
    constexpr std::size_t most = 20;
    std::size_t looked = 0;
    for (const auto& [name, value] : json.items())
        if (said == 0 && value.is_object() && looked++ < most) said = of(value);
    return said;
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

/// fx fy cx cy and no more.
std::optional<Intrinsics> from_four(const std::vector<double>& n) {
    constexpr double least = 10, most_apart = 2;
    if (n.size() != 4 || !std::ranges::all_of(n, [](double number) { return number > least; })) return {};
    if (n[0] > most_apart * n[1] || n[1] > most_apart * n[0]) return {};
    return Intrinsics{n[0], n[1], n[2], n[3]};
}

/// How often a table's frames come, by their times: of one that counts frames or says where a camera stood.
void read_times(const NumberTable& table, CameraText& said) {
    const int time = table.column({"timestamp", "timestamps", "time", "t", "sec", "seconds", "timestampns"});
    const bool counts = table.column({"frame", "frameid", "frameindex", "framenumber", "index"}) >= 0;
    if (time < 0 || (!counts && table.column({"qx", "qw"}) < 0)) return;
    std::vector<double> seconds;
    for (const std::vector<double>& row : table.rows) seconds.push_back(row[static_cast<std::size_t>(time)]);
    // Since 1970, in nano-, micro- and milliseconds.
    constexpr std::pair<double, double> units[] = {{1e17, 1e-9}, {1e14, 1e-6}, {1e11, 1e-3}};
    for (const auto& [least, unit] : units)
        if (seconds.front() > least) {
            const double first = seconds.front();
            for (double& each : seconds) each = (each - first) * unit;
            break;
        }
    if (!std::ranges::is_sorted(seconds)) return;
    const auto rate = rate_of_seconds(seconds);
    constexpr double highest = 1000;
    if (rate && rate->per_second() <= highest) said.frames_per_second = rate->per_second();
    said.timed_rows = seconds.size();
}

/// A row of a table is an object, as in a list of JSON; at most `most_cameras`, evenly.
void read_rows(const NumberTable& table, CameraText& said) {
    const std::size_t count = std::min(table.rows.size(), most_cameras);
    for (std::size_t n = 0; n < count; ++n) {
        const std::vector<double>& row = table.rows[n * table.rows.size() / count];
        Json object = Json::object();
        for (std::size_t k = 0; k < row.size(); ++k) object.emplace(table.names[k], row[k]);
        find_cameras(object, said.cameras, std::to_string(n));
    }
}

bool is_number_name(const std::string& name) {
    return !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
}

/// Where each camera is that of a frame, as numbers for names tell, all become one: the median. A camera's
/// focus moves by a few per cent; what differs by more is the cameras of a rig.
void join_frames(CameraText& said) {
    constexpr double most_moved = 1.1;
    std::vector<CameraFile>& cameras = said.cameras;
    if (cameras.size() < 2 || !std::ranges::all_of(cameras, is_number_name, &CameraFile::name)) return;
    const CameraFile median = median_camera_file(cameras);
    const bool is_one = std::ranges::all_of(cameras, [&](const CameraFile& each) {
        const double fx = each.intrinsics.fx, of_median = median.intrinsics.fx;
        return fx <= most_moved * of_median && of_median <= most_moved * fx;
    });
    if (is_one) said.cameras = {median};
}

/// No camera in the text is no error here.
CameraText cameras_in_text(std::string_view text) {
    if (auto found = from_calib(text)) return {{std::move(*found)}};
    if (text.find_first_not_of("0123456789+-.eE, \t\r\n[];") == std::string_view::npos) {
        const auto numbers = numbers_in(text);
        if (const auto found = from_matrix(numbers)) return {{{.intrinsics = *found}}};
        if (const auto found = from_pincam(numbers)) return {{{.intrinsics = *found, .is_bare = true}}};
        if (const auto found = from_four(numbers)) return {{{.intrinsics = *found, .is_bare = true}}};
    }
    CameraText said;
    const auto take = [&](const Json& json) {
        find_cameras(json, said.cameras);
        if (said.frames_per_second == 0) said.frames_per_second = first_said(json, rate_of_members);
        if (said.codes_per_metre == 0) said.codes_per_metre = first_said(json, codes_per_metre_of);
    };
    if (const NumberTable table = table_in(text); !table.rows.empty()) {
        read_rows(table, said);
        read_times(table, said);
    }
    if (said.cameras.empty()) take(json_in(text));
    if (said.cameras.empty()) said.cameras = from_colmap(text);
    if (said.cameras.empty()) take(members_in_lines(text));
    for (CameraFile& camera : said.cameras)
        if (camera.codes_per_metre == 0) camera.codes_per_metre = said.codes_per_metre;
    join_frames(said);
    if (said.codes_per_metre == 0 && said.cameras.size() == 1)
        said.codes_per_metre = said.cameras.front().codes_per_metre;
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
    if (camera.fx == 0 && (camera.fov_x > 0 || camera.fov_y > 0)) return true;
    const auto is_length = [](double value) { return std::isfinite(value) && value > 0 && value < 1e6; };
    return is_length(camera.fx) && is_length(camera.fy);
}

bool is_no_camera(const CameraFile& file) {
    const Intrinsics& camera = file.intrinsics;
    return !has_focal_lengths(camera) || !std::isfinite(camera.cx.value_or(0)) ||
           !std::isfinite(camera.cy.value_or(0));
}

}  // namespace

CameraFile median_camera_file(std::span<const CameraFile> cameras) {
    CameraFile median = cameras.front();
    // Of those that have it.
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
        "matrix K, intrinsic_matrix or camera_matrix (likewise), fov_x in degrees, 3x3 numbers, or be "
        "COLMAP's cameras.txt, "
        "Kalibr's camchain.yaml, Middlebury's calib.txt or ARKitScenes' .pincam (width height fx fy cx cy)");
}

Result<Intrinsics> read_intrinsics(const std::filesystem::path& file) {
    TRY_ASSIGN(const auto read, read_camera_file(file));
    return read.intrinsics;
}

CameraText cameras_in_arrays(std::span<const SmallArray> arrays) {
    constexpr std::size_t of_matrix = 9;
    CameraText said;
    Json numbers = Json::object();
    for (const SmallArray& array : arrays) {
        const auto& shape = array.shape;
        if (array.numbers.size() == 1) numbers.emplace(array.name, array.numbers.front());
        const std::size_t sides = shape.size();
        const bool is_matrices = sides >= 2 && shape[sides - 1] == 3 && shape[sides - 2] == 3;
        const bool is_quads = sides >= 1 && shape[sides - 1] == 4 && !(sides > 1 && shape[sides - 2] == 4);
        const std::size_t each = is_matrices ? of_matrix : is_quads ? 4 : 0;
        if (each == 0 || array.numbers.size() % each != 0) continue;
        const std::size_t count = array.numbers.size() / each;
        std::vector<CameraFile> cameras;
        for (std::size_t n = 0; n < std::min(count, most_cameras); ++n) {
            const auto first =
                array.numbers.begin() +
                static_cast<std::ptrdiff_t>(each * (n * count / std::min(count, most_cameras)));
            Json object = Json::object();
            object[array.name] = std::vector<double>(first, first + static_cast<std::ptrdiff_t>(each));
            if (const auto found = intrinsics_of(object)) cameras.push_back({.intrinsics = *found});
        }
        std::erase_if(cameras, is_no_camera);
        if (!cameras.empty() && said.cameras.empty()) {
            said.cameras.push_back(median_camera_file(cameras));
            said.cameras.back().name = array.name.substr(0, longest_name);
        }
    }
    if (said.cameras.empty()) find_cameras(numbers, said.cameras);
    std::erase_if(said.cameras, is_no_camera);
    said.codes_per_metre = codes_per_metre_of(numbers);
    said.frames_per_second = rate_of_members(numbers);
    return said;
}

std::optional<Intrinsics> intrinsics_in_json(const std::string& text) {
    const CameraText said = cameras_in_text(text);
    return said.cameras.empty() ? std::nullopt : std::optional(said.cameras.front().intrinsics);
}

}  // namespace touchable
