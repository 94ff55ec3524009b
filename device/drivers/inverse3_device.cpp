// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/inverse3_device.hpp"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- Messages

using nlohmann::json;

constexpr std::size_t longest_inverse3_id = 64;

Error no_inverse3_message(const std::string& what) {
    return device_error("the Haply service sent " + what + "; expected a state in JSON");
}

/// Member of an object; null if missing.
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

/// The service's x, y, z (right, forward, up) as right, up, towards the person.
std::optional<glm::dvec3> inverse3_vector(const json& value) {
    const auto x = inverse3_number(inverse3_member(value, "x"));
    const auto y = inverse3_number(inverse3_member(value, "y"));
    const auto z = inverse3_number(inverse3_member(value, "z"));
    if (!x || !y || !z) return std::nullopt;
    return glm::dvec3(*x, *z, -*y);
}

constexpr double inverse3_rounding = 1e-6;  // of floats, on their way

/// A setting of the service for an arm.
struct Inverse3Rule {
    json::json_pointer place;
    std::function<bool(const json& value)> is_usable;
    const char* right;
    json unsaid;  ///< another value is said; null: none is
};

/// What changes lengths, axes or the sign of forces is refused, as is what cannot be read; positions are
/// taken into account.
const std::vector<Inverse3Rule> inverse3_rules = [] {
    const auto is_any = [](const auto&... right) {
        return [=](const json& value) { return ((value == right) || ...) || sizeof...(right) == 0; };
    };
    const auto is_near = [](const glm::dvec3& right, double within) {
        return [=](const json& value) {
            const auto vector = inverse3_vector(value);
            return vector && glm::length(*vector - right) < within;
        };
    };
    const auto is_up_to = [](double most) {
        return [=](const json& value) {
            const auto number = inverse3_number(value);
            return number && *number >= 0 && *number <= most;
        };
    };
    std::vector<Inverse3Rule> rules{
        {"/config/basis/permutation"_json_pointer, is_any("XYZ", "+X+Y+Z"), "XYZ", {}},
        {"/config/preset"_json_pointer, is_any("defaults", "custom", "arm_front", "arm_front_centered"),
         "defaults", "defaults"},
        {"/config/filters/force_gate/gain"_json_pointer, is_up_to(1), "0 to 1", 0},
        {"/config/filters/damping/scalar"_json_pointer, is_up_to(1e9), "0 or more", 0},
        {"/config/torque_scaling/enabled"_json_pointer, is_any(), "", false},
        {"/config/gravity_compensation/enabled"_json_pointer, is_any(), "", true},
        {"/config/gravity_compensation/scaling_factor"_json_pointer, is_any(), "", 1},
        {"/config/handedness"_json_pointer, is_any(), "", "right"},
        {"/config/home_return/enabled"_json_pointer, is_any(), "", false}};
    for (const char* axis : {"x", "y", "z"})
        rules.push_back(
            {"/config/filters/damping/vector"_json_pointer / axis, is_up_to(1e9), "0 or more", 0});
    // The service reports as mount what it is given as mount.transform.
    for (const char* transform : {"/config/mount", "/config/mount/transform", "/state/transform"}) {
        const json::json_pointer place(transform);
        rules.push_back({place / "scale", is_near({1, 1, -1}, inverse3_rounding), "1 along x, y and z", {}});
        rules.push_back({place / "rotation", is_near({0, 0, 0}, inverse3_rounding), "none", {}});
        rules.push_back({place / "position", is_near({0, 0, 0}, 1e3), "x, y and z in metres", {}});
    }
    return rules;
}();

void add_inverse3_settings(const json& entry, Inverse3Arm& arm) {
    for (const auto& [place, is_usable, right, unsaid] : inverse3_rules) {
        if (!entry.contains(place) || entry.at(place).is_null()) continue;
        const json& value = entry.at(place);
        const auto words = [&, name = place.to_string()] {
            return name.substr(name.find('/', 1) + 1) + ' ' + printable(value.dump());
        };
        if (!is_usable(value) && arm.unusable.empty()) arm.unusable = words() + "; must be " + right;
        if (!unsaid.is_null() && value != unsaid)
            arm.settings += (arm.settings.empty() ? "" : ", ") + words();
    }
    const auto position = [&entry](const char* name) {
        const json::json_pointer place(name);
        return entry.contains(place) ? inverse3_vector(entry.at(place)).value_or(glm::dvec3(0))
                                     : glm::dvec3(0);
    };
    if (entry.contains("/config/mount"_json_pointer))
        arm.base = position("/config/mount/position") + position("/config/mount/transform/position");
    if (const json& preset = inverse3_member(inverse3_member(entry, "config"), "preset"); preset.is_string())
        arm.preset = preset.get<std::string>();
    if (arm.place && arm.unusable.empty()) *arm.place -= position("/state/transform/position");
}

bool is_inverse3_id(const std::string& id) {
    return !id.empty() && id.size() <= longest_inverse3_id &&
           std::ranges::all_of(id, [](char c) { return c > ' ' && c < 0x7f; });
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
    add_inverse3_settings(entry, arm);
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

/// Payload of an answer over HTTP: since 3.5 within {"ok": true, "data": ...}.
const json& inverse3_payload(const json& answer) {
    const json& data = inverse3_member(answer, "data");
    return data.is_null() ? answer : data;
}

// ---- The driver

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr milliseconds connecting_patience{2000}, first_word{500}, last_answer{50};
constexpr std::uint32_t last_mask = 0x746f7563;  // any value works: a mask hides nothing on this machine

// ---- Keys

const Inverse3Choice standard_arm;
constexpr std::string_view of_inverse3 = "device 'inverse3'";
const std::array<KeyedValues::Key, 8> inverse3_keys{{
    {"id", "what the service calls the arm, such as 049D", 0, 0, 0, KeyedValues::Key::Kind::words},
    {"port", "", 1, 65535, 10001, KeyedValues::Key::Kind::whole},
    {"service", "the version of the service, such as 3.4", 0, 0, 0, KeyedValues::Key::Kind::words},
    {"right", "m", -1, 1, standard_arm.centre.x},
    {"up", "m", -1, 1, standard_arm.centre.y},
    {"towards", "m", -1, 1, standard_arm.centre.z},
    {"force", "N", 0.1, 20, standard_arm.limits.max_force},
    {"stiffness", "N/mm", 0.01, 10, standard_arm.limits.max_stiffness / 1000},
}};

}  // namespace

// ---- Messages

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
    return device_error(in_quotes(words) + " is no version of the Haply service; one is \"3.5\"");
}

Result<Inverse3Version> decode_inverse3_version(std::string_view answer) {
    const json parsed = json::parse(answer, nullptr, false);
    const json& said = inverse3_payload(parsed);
    for (const char* name : {"project_version", "git_tag"}) {
        const json& words = inverse3_member(said, name);
        if (!words.is_string()) continue;
        if (auto version = parse_inverse3_version(words.get_ref<const std::string&>()); version)
            return version;
    }
    return device_error("the Haply service answered GET /version with " + in_quotes(answer.substr(0, 80)) +
                        ", which names no version");
}

Result<Inverse3Dialect> inverse3_dialect(const Inverse3Version& version) {
    if (version.major == 3 && version.minor >= 5) return Inverse3Dialect::vector;
    if (version.major == 3 && version.minor >= 1) return Inverse3Dialect::values;
    return device_error("Haply Inverse Service " + std::to_string(version.major) + "." +
                        std::to_string(version.minor) + " is not known here; must be 3.1 to any other 3.x");
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

/// The settings documentation leaves open how one setting is returned: as a number, or with others beside it.
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
    // Without the sums, zeros could go out as -0.0.
    const Ordered force = {{"x", newtons.x + 0.0}, {"y", -newtons.z + 0.0}, {"z", newtons.y + 0.0}};
    Ordered arm = Ordered::object();
    arm["device_id"] = id;
    arm["commands"]["set_cursor_force"][how] = force;
    Ordered message = Ordered::object();
    message["inverse3"] = Ordered::array({std::move(arm)});
    return message.dump(-1, ' ', false, Ordered::error_handler_t::replace);
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

// ---- The driver

Result<void> Inverse3Driver::connect() {
    transport_.reset();
    id_.clear();
    trouble_.clear();
    force_scale_ = 1;
    unanswered_ = nonsense_ = 0;
    pushed_ = false;
    TRY(learn_version());
    TRY_ASSIGN(transport_, service_->connect(connecting_patience));
    // The first message comes by itself and has the arms' configurations.
    answered_ns_ = said_ns_ = clock_();
    TRY_ASSIGN(const auto inventory, await([](const Inverse3Message&) { return true; }));
    TRY(choose(inventory.arms));
    TRY(send_text(zero()));
    TRY(await([](const Inverse3Message& message) { return !message.arms.empty(); }));
    return {};
}

/// The force scale exists since 3.5. A service that does not report it is accepted.
Result<void> Inverse3Driver::learn_version() {
    std::optional<Inverse3Version> version = choice_.version;
    if (!version) {
        TRY_ASSIGN(const auto answer, service_->get("/version", connecting_patience));
        const auto stated = decode_inverse3_version(answer);
        if (!stated)
            return device_error(service_->address() +
                                " does not say which version it is (GET /version); use a Haply Inverse "
                                "Service from 3.1 on, or give its version, as inverse3:service=3.4");
        version = *stated;
    }
    TRY_ASSIGN(dialect_, inverse3_dialect(*version));
    if (dialect_ == Inverse3Dialect::vector) {
        const auto scale = service_->get("/settings/devices/force_scale", first_word);
        if (scale) force_scale_ = decode_force_scale(*scale).value_or(1);
    }
    return {};
}

/// The first message for which `enough` is true. If none comes for a while, the state is requested.
Result<Inverse3Message> Inverse3Driver::await(bool (*enough)(const Inverse3Message&)) {
    const std::int64_t since = clock_();
    for (bool asked = false;;) {
        if (stop_requested()) return interrupted_error();
        TRY_ASSIGN(auto received, receive_message(milliseconds(20)));
        if (received && enough(*received)) return std::move(*received);
        const nanoseconds waited(ns_since(since));
        if (waited > connecting_patience)
            return device_error("the Haply service at " + service_->address() +
                                " does not tell the state of its devices; restart it");
        if (waited > first_word && !std::exchange(asked, true))
            TRY(send_text(R"({"session":{"force_render_full_state":{}}})"));  // a message with configurations
    }
}

Result<void> Inverse3Driver::choose(const std::vector<Inverse3Arm>& arms) {
    const auto found =
        choice_.id.empty() ? arms.begin() : std::ranges::find(arms, choice_.id, &Inverse3Arm::id);
    if (arms.empty())
        return device_error("the Haply service knows of no Inverse3; plug it in and switch it on");
    if (choice_.id.empty() && arms.size() > 1)
        return device_error("there are several Inverse3, " + listed(arms, &Inverse3Arm::id) + ": choose one",
                            {{Setting::device, "inverse3:id=" + arms.front().id}});
    if (found == arms.end())
        return device_error("there is no Inverse3 '" + choice_.id + "'; the Haply service knows of " +
                            listed(arms, &Inverse3Arm::id));
    TRY(check(*found));
    if (force_scale_ < 0)
        return device_error("the Haply service has force_scale " + exact_number(force_scale_) +
                            "; must be 0 or more, set in Haply Hub");
    settings_ = force_scale_ == 1 ? std::string() : "force_scale " + exact_number(force_scale_);
    if (!found->settings.empty()) settings_ += (settings_.empty() ? "" : ", ") + found->settings;
    base_ = found->base.value_or(glm::dvec3(0));
    preset_ = found->preset.value_or("defaults");
    id_ = found->id;
    return {};
}

Result<void> Inverse3Driver::check(const Inverse3Arm& arm) const {
    if (arm.unusable.empty()) return {};
    return device_error("the Haply service has for " + arm.id + " " + arm.unusable + ", set in Haply Hub");
}

void Inverse3Driver::disconnect() noexcept {
    try {
        if (transport_ && !id_.empty()) {
            [[maybe_unused]] const auto sent = send_text(zero());
            // Closing a connection with unread data may lose what was written last.
            const std::int64_t since = clock_();
            while (unanswered_ > 0 && nanoseconds(ns_since(since)) < last_answer)
                if (!receive_message(milliseconds(5))) break;
        }
        transport_.reset();
    } catch (...) {
        transport_.reset();
    }
    id_.clear();
}

Result<void> Inverse3Driver::send(std::span<const glm::dvec3> newtons) {
    if (!transport_) return device_error("the Inverse3 is not connected");
    const bool pushes = newtons[0] != glm::dvec3(0);
    if (unanswered_ >= most_unanswered && !(pushed_ && !pushes)) return {};
    std::this_thread::sleep_for(shortest_turn - nanoseconds(ns_since(said_ns_)));
    // If the service scales forces up, send smaller ones: no force may exceed the limit.
    const double longer = std::max(1.0, force_scale_);
    auto sent = send_text(encode_inverse3_force(dialect_, id_, newtons[0] / longer));
    pushed_ = pushes;
    return sent;
}

Result<void> Inverse3Driver::send_text(const std::string& text) {
    TRY(transport_->send(std::as_bytes(std::span(text))));
    said_ns_ = clock_();
    if (unanswered_++ == 0) answered_ns_ = said_ns_;
    return {};
}

/// Receives one message, if one comes. An unreadable message counts as an answer.
Result<std::optional<Inverse3Message>> Inverse3Driver::receive_message(microseconds patience) {
    TRY_ASSIGN(const auto count, transport_->receive(room_, patience));
    if (count == 0) return std::optional<Inverse3Message>();
    unanswered_ = std::max(unanswered_ - 1, 0);
    answered_ns_ = clock_();
    auto message = decode_inverse3_message({reinterpret_cast<const char*>(room_.data()), count});
    if (message) {
        nonsense_ = 0;
        return std::optional(std::move(*message));
    }
    if (++nonsense_ >= most_nonsense) return message.error();
    return std::optional<Inverse3Message>();
}

/// Takes the newest message that has come. Unreadable messages do not prolong the wait.
Result<bool> Inverse3Driver::receive(DeviceSample& sample, microseconds patience) {
    if (!transport_) return device_error("the Inverse3 is not connected");
    bool any = false;
    const std::int64_t since = clock_();
    for (int most = 64; most > 0; --most) {
        const int nonsense = nonsense_;
        const auto left = std::chrono::floor<microseconds>(patience - nanoseconds(ns_since(since)));
        TRY_ASSIGN(const auto received,
                   receive_message(any ? microseconds(0) : std::max(left, microseconds(0))));
        if (!received && nonsense_ == nonsense) break;
        if (!received) continue;
        TRY_ASSIGN(const auto taken, take(*received, sample));
        any = any || taken;
    }
    if (unanswered_ > 0 && nanoseconds(ns_since(answered_ns_)) > longest_answer)
        return device_error("the Haply service at " + service_->address() +
                            " has not answered for half a second; restart it");
    return any;
}

Result<bool> Inverse3Driver::take(const Inverse3Message& message, DeviceSample& sample) {
    const auto arm = std::ranges::find(message.arms, id_, &Inverse3Arm::id);
    if (arm == message.arms.end())
        return device_error("Inverse3 " + id_ + " is gone from the Haply service; plug it in again");
    TRY(check(*arm));
    const bool is_moved = glm::distance(arm->base.value_or(base_), base_) > inverse3_rounding;
    if (is_moved || arm->preset.value_or(preset_) != preset_)
        return device_error("the Haply service has another " + std::string(is_moved ? "mount" : "preset") +
                            " for " + id_ + " than when it was opened; must stay the same while it is held");
    trouble_.clear();
    if (arm->powered == false) trouble_ = "has no power: plug in its power supply";
    if (arm->ready == false) trouble_ = "is not ready: look at it in Haply Hub";
    if (arm->calibrated == false) trouble_ = "is not calibrated: calibrate it as its manual says";
    if (!arm->place) return false;
    sample.metres[0] = arm->calibrated == false ? no_place : *arm->place - base_ - choice_.centre;
    sample.buttons = message.buttons;
    return true;
}

std::optional<ZeroForcePacket> Inverse3Driver::zero_force_packet() const {
    if (!transport_ || id_.empty() || transport_->descriptor() < 0) return std::nullopt;
    return ZeroForcePacket{transport_->descriptor(), web_socket_frame(zero(), last_mask), {}, {}};
}

// ---- Keys

Result<Inverse3Choice> read_inverse3_choice(std::string_view keys) {
    TRY_ASSIGN(const auto given, KeyedValues::parse(of_inverse3, keys, inverse3_keys));
    Inverse3Choice choice;
    choice.id = given.words("id");
    choice.port = static_cast<std::uint16_t>(given.number("port"));
    if (given.given("service")) {
        const auto version = parse_inverse3_version(given.words("service"));
        if (!version) return usage_error(std::string(of_inverse3) + ": " + version.error().message);
        if (const auto known = inverse3_dialect(*version); !known)
            return usage_error(std::string(of_inverse3) + ": " + known.error().message);
        choice.version = *version;
    }
    choice.centre = {given.number("right"), given.number("up"), given.number("towards")};
    choice.limits = {given.number("force"), given.number("stiffness") * 1000};
    return choice;
}

Result<std::unique_ptr<DeviceDriver>> make_inverse3_driver(std::string_view keys) {
    TRY_ASSIGN(auto choice, read_inverse3_choice(keys));
    auto service = std::make_unique<LocalHaplyService>(choice.port);
    return std::make_unique<Inverse3Driver>(std::move(choice), std::move(service));
}

}  // namespace touchable
