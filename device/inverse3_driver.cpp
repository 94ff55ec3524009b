#include "device/inverse3_driver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr milliseconds connecting{2000}, first_word{500}, last_answer{50};
constexpr std::uint32_t last_mask = 0x746f7563;  // any will do: it hides nothing from this machine

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text));
}

std::string version_in_words(const Inverse3Version& version) {
    return std::to_string(version.major) + "." + std::to_string(version.minor);
}

std::string listed(const std::vector<Inverse3Arm>& arms) {
    std::string ids;
    for (const Inverse3Arm& arm : arms) ids += (ids.empty() ? "" : ", ") + arm.id;
    return ids;
}

}  // namespace

Inverse3Driver::Inverse3Driver(Inverse3Choice choice, std::unique_ptr<HaplyService> service,
                               DriverClock clock)
    : choice_(std::move(choice)),
      service_(std::move(service)),
      clock_(std::move(clock)),
      room_(LocalHaplyService::longest_message) {}

/// The reach is that of the sphere in which the service's tutorial on positions keeps its targets.
DeviceCapabilities Inverse3Driver::capabilities() const {
    return {.axes_sensed = 3,
            .axes_driven = 3,
            .reach = glm::dvec3(0.1),
            .rate_hz = 1e6 / static_cast<double>(shortest_turn.count()),
            .buttons = 3,
            .own_watchdog = false,
            .answers = true};
}

Result<void> Inverse3Driver::connect(const GivenUp& given_up) {
    transport_.reset();
    id_.clear();
    trouble_.clear();
    settings_ = {};
    unanswered_ = nonsense_ = 0;
    pushed_ = false;
    if (auto learnt = learn_version(given_up); !learnt.ok()) return learnt;
    TRY_ASSIGN(auto connected, service_->connect(connecting, given_up));
    transport_ = std::move(connected);
    // The first message comes by itself and has the arms' configurations.
    answered_ns_ = said_ns_ = clock_();
    TRY_ASSIGN(const auto inventory, await([](const Inverse3Message&) { return true; }, given_up));
    if (auto chosen = choose(inventory.arms); !chosen.ok()) return chosen;
    if (auto unpowered = send_text(zero()); !unpowered.ok()) return unpowered;
    const auto unpowered =
        await([](const Inverse3Message& message) { return !message.arms.empty(); }, given_up);
    return unpowered.ok() ? Result<void>{} : unpowered.error();
}

/// A force scale belongs to 3.5 and later, and a service that does not tell of it is none the worse.
Result<void> Inverse3Driver::learn_version(const GivenUp& given_up) {
    if (choice_.version) {
        version_ = *choice_.version;
    } else {
        TRY_ASSIGN(const auto answer, service_->get("/version", connecting, given_up));
        const auto version = decode_inverse3_version(answer);
        if (!version.ok())
            return Error{ErrorKind::device,
                         service_->address() +
                             " does not say which version it is (GET /version); right would be "
                             "a Haply Inverse Service from 3.1 on, or its version, as "
                             "inverse3:service=3.4"};
        version_ = *version;
    }
    TRY_ASSIGN(const auto dialect, inverse3_dialect(version_));
    dialect_ = dialect;
    if (dialect_ == Inverse3Dialect::vector) {
        const auto scale = service_->get("/settings/devices/force_scale", first_word, given_up);
        if (scale.ok()) settings_.force_scale = decode_force_scale(*scale);
    }
    return {};
}

/// The first message that is enough. Where none comes, the service is asked for one.
Result<Inverse3Message> Inverse3Driver::await(bool (*enough)(const Inverse3Message&),
                                              const GivenUp& given_up) {
    const std::int64_t since = clock_();
    for (bool asked = false;;) {
        if (given_up && given_up()) return Error{ErrorKind::interrupted, "stopped while it was connecting"};
        TRY_ASSIGN(auto received, receive_message(milliseconds(20)));
        if (received && enough(*received)) return std::move(*received);
        const nanoseconds waited(ns_since(since));
        if (waited > connecting)
            return Error{ErrorKind::device, "the Haply service at " + service_->address() +
                                                " does not tell the state of its devices; restart it"};
        if (waited > first_word && !std::exchange(asked, true))
            TRY(send_text(encode_inverse3_full_state_request()));
    }
}

Result<void> Inverse3Driver::choose(const std::vector<Inverse3Arm>& arms) {
    const auto found = choice_.id.empty()
                           ? arms.begin()
                           : std::find_if(arms.begin(), arms.end(),
                                          [this](const Inverse3Arm& arm) { return arm.id == choice_.id; });
    if (arms.empty())
        return Error{ErrorKind::device,
                     "the Haply service knows of no Inverse3; plug it in and switch it on"};
    if (choice_.id.empty() && arms.size() > 1)
        return Error{ErrorKind::device,
                     "there are several Inverse3, " + listed(arms) + ": choose one",
                     {{Setting::device, "inverse3:id=" + arms.front().id}}};
    if (found == arms.end())
        return Error{ErrorKind::device,
                     "there is no Inverse3 '" + choice_.id + "'; the Haply service knows of " + listed(arms)};
    if (found->settings) {
        const auto scale = settings_.force_scale;
        settings_ = *found->settings;
        settings_.force_scale = scale;
    }
    if (!settings_.basis.empty() && settings_.basis != "XYZ" && settings_.basis != "+X+Y+Z")
        return Error{ErrorKind::device, "the Haply service turns the axes of " + found->id + " (basis " +
                                            settings_.basis.substr(0, 12) +
                                            "); right would be XYZ, set in Haply Hub"};
    id_ = found->id;
    return {};
}

void Inverse3Driver::disconnect() noexcept {
    try {
        if (transport_ && !id_.empty()) {
            [[maybe_unused]] const auto sent = send_text(zero());
            // A connection that is closed with something unread may lose what was written last.
            const std::int64_t since = clock_();
            while (unanswered_ > 0 && nanoseconds(ns_since(since)) < last_answer)
                if (!receive_message(milliseconds(5)).ok()) break;
        }
        transport_.reset();
    } catch (...) {
        transport_.reset();
    }
    id_.clear();
}

Result<void> Inverse3Driver::send(std::span<const glm::dvec3> newtons) {
    if (!transport_) return Error{ErrorKind::device, "the Inverse3 is not connected"};
    const bool pushes = newtons[0] != glm::dvec3(0);
    if (unanswered_ >= most_unanswered && !(pushed_ && !pushes)) return {};
    std::this_thread::sleep_for(shortest_turn - nanoseconds(ns_since(said_ns_)));
    // A service that makes every force longer is given shorter ones: no force is longer than the limit says.
    const double longer = std::max(1.0, settings_.force_scale.value_or(1));
    auto sent = send_text(encode_inverse3_force(dialect_, id_, newtons[0] / longer));
    pushed_ = pushes;
    return sent;
}

Result<void> Inverse3Driver::send_text(const std::string& text) {
    if (auto sent = transport_->send(bytes_of(text)); !sent.ok()) return sent;
    said_ns_ = clock_();
    if (unanswered_++ == 0) answered_ns_ = said_ns_;
    return {};
}

/// One message, if one comes. What cannot be read is an answer all the same.
Result<std::optional<Inverse3Message>> Inverse3Driver::receive_message(microseconds patience) {
    TRY_ASSIGN(const auto count, transport_->receive(room_, patience));
    if (count == 0) return std::optional<Inverse3Message>();
    unanswered_ = std::max(unanswered_ - 1, 0);
    answered_ns_ = clock_();
    auto message = decode_inverse3_message({reinterpret_cast<const char*>(room_.data()), count});
    if (message.ok()) {
        nonsense_ = 0;
        return std::optional(std::move(*message));
    }
    if (++nonsense_ >= most_nonsense) return message.error();
    return std::optional<Inverse3Message>();
}

/// The newest of what has come. Nonsense does not prolong the wait for it.
Result<bool> Inverse3Driver::receive(DeviceSample& sample, microseconds patience) {
    if (!transport_) return Error{ErrorKind::device, "the Inverse3 is not connected"};
    bool any = false;
    const std::int64_t since = clock_();
    for (int most = 64; most > 0; --most) {
        const int nonsense = nonsense_;
        const auto left = std::chrono::floor<microseconds>(patience - nanoseconds(ns_since(since)));
        TRY_ASSIGN(const auto received,
                   receive_message(any ? microseconds(0) : std::max(left, microseconds(0))));
        if (!received && nonsense_ == nonsense) break;
        if (!received) continue;
        const auto taken = take(*received, sample);
        if (!taken.ok()) return taken;
        any = any || *taken;
    }
    if (unanswered_ > 0 && nanoseconds(ns_since(answered_ns_)) > longest_answer)
        return Error{ErrorKind::device, "the Haply service at " + service_->address() +
                                            " has not answered for half a second; restart it"};
    return any;
}

Result<void> Inverse3Driver::forget_what_came() {
    unanswered_ = 0;
    return transport_->drop_what_came(room_);
}

Result<bool> Inverse3Driver::take(const Inverse3Message& message, DeviceSample& sample) {
    const auto arm = std::find_if(message.arms.begin(), message.arms.end(),
                                  [this](const Inverse3Arm& each) { return each.id == id_; });
    if (arm == message.arms.end())
        return Error{ErrorKind::device,
                     "Inverse3 " + id_ + " is gone from the Haply service; plug it in again"};
    trouble_.clear();
    if (arm->powered == false) trouble_ = "has no power: plug in its power supply";
    if (arm->ready == false) trouble_ = "is not ready: look at it in Haply Hub";
    if (arm->calibrated == false) trouble_ = "is not calibrated: calibrate it as its manual says";
    if (!arm->place) return false;
    const glm::dvec3 nowhere(std::numeric_limits<double>::quiet_NaN());
    sample.metres[0] = arm->calibrated == false ? nowhere : *arm->place - choice_.centre;
    sample.buttons = message.buttons;
    return true;
}

std::string Inverse3Driver::zero() const {
    return encode_inverse3_force(dialect_, id_, glm::dvec3(0));
}

std::optional<ZeroForcePacket> Inverse3Driver::zero_force_packet() const {
    if (!transport_ || id_.empty() || transport_->descriptor() < 0) return std::nullopt;
    return ZeroForcePacket{transport_->descriptor(), web_socket_frame(zero(), last_mask), {}, {}};
}

std::string Inverse3Driver::prompt() const {
    if (id_.empty()) return {};
    if (!trouble_.empty()) return "Inverse3 " + id_ + " " + trouble_;
    const std::string altered = altered_forces(settings_);
    return altered.empty() ? altered
                           : "the Haply service " + altered + "; change it in Haply Hub if that is not meant";
}

std::string Inverse3Driver::service_in_words() const {
    if (id_.empty()) return {};
    const std::string settings = in_words(settings_);
    return "Inverse3 " + id_ + ", Haply Inverse Service " + version_in_words(version_) +
           (settings.empty() ? "" : ": " + settings);
}

}  // namespace touchable
