#include "device/inverse3_protocol.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/printable.hpp"

namespace touchable {
namespace {

using nlohmann::json;

constexpr std::size_t longest_id = 64;

Error no_inverse3_message(const std::string& what) {
    return Error{ErrorKind::device, "the Haply service sent " + what + "; right would be a state in JSON"};
}

/// A member of an object; null where there is none.
const json& inverse3_member(const json& of, const char* name) {
    static const json nothing;
    if (!of.is_object()) return nothing;
    const auto found = of.find(name);
    return found == of.end() ? nothing : *found;
}

std::optional<double> inverse3_number(const json& value) {
    if (!value.is_number()) return std::nullopt;
    const double number = value.get<double>();
    return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

std::optional<bool> inverse3_flag(const json& value) {
    return value.is_boolean() ? std::optional(value.get<bool>()) : std::nullopt;
}

/// Right, forward, up to right, up, towards the person.
std::optional<glm::dvec3> inverse3_vector(const json& value) {
    const auto x = inverse3_number(inverse3_member(value, "x"));
    const auto y = inverse3_number(inverse3_member(value, "y"));
    const auto z = inverse3_number(inverse3_member(value, "z"));
    if (!x || !y || !z) return std::nullopt;
    return glm::dvec3(*x, *z, -*y);
}

Inverse3Settings inverse3_settings(const json& config) {
    const json& filters = inverse3_member(config, "filters");
    const json& gravity = inverse3_member(config, "gravity_compensation");
    const json& basis = inverse3_member(inverse3_member(config, "basis"), "permutation");
    Inverse3Settings settings;
    settings.damping = inverse3_number(inverse3_member(inverse3_member(filters, "damping"), "scalar"));
    settings.force_gate = inverse3_number(inverse3_member(inverse3_member(filters, "force_gate"), "gain"));
    settings.gravity_compensation = inverse3_flag(inverse3_member(gravity, "enabled"));
    settings.gravity_scale = inverse3_number(inverse3_member(gravity, "scaling_factor"));
    settings.torque_scaling =
        inverse3_flag(inverse3_member(inverse3_member(config, "torque_scaling"), "enabled"));
    if (basis.is_string()) settings.basis = basis.get_ref<const std::string&>();
    return settings;
}

bool is_inverse3_id(const std::string& id) {
    return !id.empty() && id.size() <= longest_id &&
           std::all_of(id.begin(), id.end(), [](char c) { return c > ' ' && c < 0x7f; });
}

std::optional<Inverse3Arm> inverse3_arm(const json& entry) {
    const json& id = inverse3_member(entry, "device_id");
    if (!id.is_string() || !is_inverse3_id(id.get_ref<const std::string&>())) return std::nullopt;
    const json& status = inverse3_member(entry, "status");
    Inverse3Arm arm;
    arm.id = id.get<std::string>();
    arm.place = inverse3_vector(inverse3_member(inverse3_member(entry, "state"), "cursor_position"));
    arm.powered = inverse3_flag(inverse3_member(status, "power_supply"));
    arm.calibrated = inverse3_flag(inverse3_member(status, "calibrated"));
    arm.ready = inverse3_flag(inverse3_member(status, "ready"));
    if (const json& config = inverse3_member(entry, "config"); config.is_object())
        arm.settings = inverse3_settings(config);
    return arm;
}

std::uint32_t inverse3_buttons(const json& message) {
    std::uint32_t pressed = 0;
    const json& wireless = inverse3_member(message, "wireless_verse_grip");
    if (wireless.is_array() && !wireless.empty()) {
        const json& buttons = inverse3_member(inverse3_member(wireless.front(), "state"), "buttons");
        const char* const names[] = {"a", "b", "c"};
        for (std::uint32_t bit = 0; bit < 3; ++bit)
            if (inverse3_flag(inverse3_member(buttons, names[bit])).value_or(false)) pressed |= 1u << bit;
    }
    const json& wired = inverse3_member(message, "verse_grip");
    if (wired.is_array() && !wired.empty() &&
        inverse3_flag(inverse3_member(inverse3_member(wired.front(), "state"), "button")).value_or(false))
        pressed |= 1;
    return pressed;
}

/// What an answer over HTTP carries: since 3.5 within {"ok": true, "data": ...}.
const json& inverse3_payload(const json& answer) {
    const json& data = inverse3_member(answer, "data");
    return data.is_null() ? answer : data;
}

std::string shortest_number(double value) {
    return nlohmann::json(value).dump();
}

}  // namespace

Result<Inverse3Version> parse_inverse3_version(std::string_view words) {
    Inverse3Version version;
    const char* const end = words.data() + words.size();
    const auto major = std::from_chars(words.data(), end, version.major);
    if (major.ec == std::errc() && major.ptr != end && *major.ptr == '.') {
        const auto minor = std::from_chars(major.ptr + 1, end, version.minor);
        if (minor.ec == std::errc() && version.major >= 0 && version.minor >= 0 &&
            (minor.ptr == end || *minor.ptr == '.' || *minor.ptr == '-'))
            return version;
    }
    return Error{ErrorKind::device, in_quotes(words) + " is no version of the Haply service; one is \"3.5\""};
}

Result<Inverse3Version> decode_inverse3_version(std::string_view answer) {
    const json parsed = json::parse(answer, nullptr, false);
    const json& said = inverse3_payload(parsed);
    for (const char* name : {"project_version", "git_tag"}) {
        const json& words = inverse3_member(said, name);
        if (!words.is_string()) continue;
        if (auto version = parse_inverse3_version(words.get_ref<const std::string&>()); version.ok())
            return version;
    }
    return Error{ErrorKind::device, "the Haply service answered GET /version with " +
                                        in_quotes(answer.substr(0, 80)) + ", which names no version"};
}

Result<Inverse3Dialect> inverse3_dialect(const Inverse3Version& version) {
    if (version.major == 3 && version.minor >= 5) return Inverse3Dialect::vector;
    if (version.major == 3 && version.minor >= 1) return Inverse3Dialect::values;
    return Error{ErrorKind::device, "Haply Inverse Service " + std::to_string(version.major) + "." +
                                        std::to_string(version.minor) +
                                        " is not known here; right would be 3.1 to any other 3.x"};
}

Result<Inverse3Message> decode_inverse3_message(std::string_view text) {
    const json parsed = json::parse(text, nullptr, false);
    if (parsed.is_discarded()) return no_inverse3_message(in_quotes(text.substr(0, 80)));
    if (!parsed.is_object()) return no_inverse3_message("JSON that is no object");
    Inverse3Message message;
    if (const json& arms = inverse3_member(parsed, "inverse3"); arms.is_array())
        for (const json& entry : arms)
            if (auto arm = inverse3_arm(entry)) message.arms.push_back(std::move(*arm));
    message.buttons = inverse3_buttons(parsed);
    return message;
}

/// The page on settings says that one can be read alone, but not as what: a number, or with others beside it.
std::optional<double> decode_force_scale(std::string_view answer) {
    const json parsed = json::parse(answer, nullptr, false);
    const json& said = inverse3_payload(parsed);
    if (const auto number = inverse3_number(said)) return number;
    for (const char* name : {"value", "devices/force_scale", "force_scale"})
        if (const auto number = inverse3_number(inverse3_member(said, name))) return number;
    return std::nullopt;
}

std::string encode_inverse3_force(Inverse3Dialect dialect, const std::string& id, const glm::dvec3& newtons) {
    const char* const how = dialect == Inverse3Dialect::vector ? "vector" : "values";
    using Ordered = nlohmann::ordered_json;
    // Without the sums zeros could go out as -0.0.
    const Ordered force = {{"x", newtons.x + 0.0}, {"y", -newtons.z + 0.0}, {"z", newtons.y + 0.0}};
    Ordered arm = Ordered::object();
    arm["device_id"] = id;
    arm["commands"]["set_cursor_force"][how] = force;
    Ordered message = Ordered::object();
    message["inverse3"] = Ordered::array({std::move(arm)});
    return message.dump(-1, ' ', false, Ordered::error_handler_t::replace);
}

std::string encode_inverse3_full_state_request() {
    return R"({"session":{"force_render_full_state":{}}})";
}

std::string in_words(const Inverse3Settings& settings) {
    std::string words;
    const auto tell = [&words](const std::string& what) { words += (words.empty() ? "" : ", ") + what; };
    if (settings.damping) tell("damping " + shortest_number(*settings.damping));
    if (settings.force_gate) tell("force gate " + shortest_number(*settings.force_gate));
    if (settings.force_scale) tell("force scale " + shortest_number(*settings.force_scale));
    if (settings.gravity_compensation) {
        std::string gravity =
            std::string("gravity compensation ") + (*settings.gravity_compensation ? "on" : "off");
        if (*settings.gravity_compensation && settings.gravity_scale)
            gravity += " (times " + shortest_number(*settings.gravity_scale) + ")";
        tell(gravity);
    }
    if (settings.torque_scaling)
        tell(std::string("torque scaling ") + (*settings.torque_scaling ? "on" : "off"));
    return words;
}

std::string altered_forces(const Inverse3Settings& settings) {
    std::string words;
    if (settings.force_scale && *settings.force_scale != 1)
        words = "multiplies forces by " + shortest_number(*settings.force_scale);
    if (settings.damping && *settings.damping != 0)
        words +=
            (words.empty() ? "" : " and ") + std::string("damps with ") + shortest_number(*settings.damping);
    return words;
}

std::vector<std::byte> web_socket_frame(std::string_view text, std::uint32_t mask) {
    const auto byte = [](std::size_t value) { return static_cast<std::byte>(value & 0xff); };
    const bool is_long = text.size() > 125;
    const std::array<std::byte, 4> key{byte(mask >> 24), byte(mask >> 16), byte(mask >> 8), byte(mask)};
    std::vector<std::byte> frame;
    frame.reserve(8 + text.size());
    frame.push_back(byte(0x81));  // final, text
    frame.push_back(byte(0x80 | (is_long ? 126 : text.size())));
    if (is_long) {
        frame.push_back(byte(text.size() >> 8));
        frame.push_back(byte(text.size()));
    }
    for (const std::byte each : key) frame.push_back(each);
    for (std::size_t at = 0; at < text.size(); ++at)
        frame.push_back(byte(static_cast<unsigned char>(text[at])) ^ key[at % 4]);
    return frame;
}

}  // namespace touchable
