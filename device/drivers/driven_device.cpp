// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/driven_device.hpp"

#include <poll.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "device/force_gate.h"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;

constexpr microseconds a_tick{1000};
constexpr microseconds slowest_bus{5000};  // longest time for an answer of a driver that waits itself
// Interval of zeros while no force is requested; also the most that a late turn counts in a ceiling's rise.
constexpr std::int64_t sent_again_ns = 5'000'000;

/// Age in s; infinite for a moment of 0 (never).
double age_of(std::int64_t moment_ns, std::int64_t now) {
    if (moment_ns == 0) return std::numeric_limits<double>::infinity();
    return static_cast<double>(now - moment_ns) * 1e-9;
}

/// An exception of the driver counts as a failure that it returned.
template <class Call>
auto answer_of(const std::string& name, Call&& call) -> decltype(call()) {
    try {
        return call();
    } catch (const std::exception& thrown) {
        return device_error(name + ": " + thrown.what());
    } catch (...) {
        return device_error(name + ": failed for an unknown reason");
    }
}

}  // namespace

DrivenDevice::DrivenDevice(std::unique_ptr<DeviceDriver> driver, DrivenSettings settings)
    : driver_(std::move(driver)),
      settings_(std::move(settings)),
      name_(driver_->name()),
      fingers_(driver_->fingers()),
      limits_(driver_->limits()),
      capabilities_(driver_->capabilities()),
      age_s_(std::numeric_limits<double>::infinity()) {
    assert(fingers_ >= 1 && fingers_ <= static_cast<int>(DeviceSample::most_fingers));
}

Result<void> DrivenDevice::open() {
    close();
    if (wake_.descriptor() < 0) return internal_error("no eventfd can be had for the " + name_);
    wake_.forget();
    stopping_ = std::stop_source();
    misuse_ = nullptr;
    latest_.write({});
    asked_.write({});
    lost_ = over_ = false;
    auto held = take_hold();
    if (held && settings_.own_thread)
        held = start_thread(thread_, "device", "of the device", [this] { drive(); });
    if (!held) {
        driver_->disconnect();
        return held;
    }
    open_ = true;
    return {};
}

void DrivenDevice::close() {
    open_ = false;
    stopping_.request_stop();
    wake_.wake();
    if (thread_.joinable()) thread_.join();
    if (!settings_.own_thread) driver_->disconnect();
    kept_.reset();
}

bool DrivenDevice::read_positions(std::span<glm::dvec3> device_metres) {
    if (!open_.load(std::memory_order_acquire) || lost_.load(std::memory_order_acquire) || misuse_.load())
        return false;
    assert(device_metres.size() == static_cast<std::size_t>(fingers_));
    const Received& latest = latest_.read();
    const std::int64_t now = settings_.clock();
    received_ns_ = latest.time_ns;
    age_s_ = age_of(latest.time_ns, now);
    buttons_ = age_s_ <= oldest_s ? latest.sample.buttons : 0;
    for (std::size_t finger = 0; finger < device_metres.size(); ++finger)
        device_metres[finger] =
            age_of(latest.place_ns[finger], now) <= oldest_s ? latest.sample.metres[finger] : no_place;
    return true;
}

bool DrivenDevice::write_forces(std::span<const glm::dvec3> newtons) {
    if (!open_.load(std::memory_order_acquire) || lost_.load(std::memory_order_acquire) || misuse_.load())
        return false;
    assert(newtons.size() == static_cast<std::size_t>(fingers_));
    Asked asked;
    for (std::size_t finger = 0; finger < newtons.size(); ++finger) {
        if (!std::isfinite(glm::length(newtons[finger]))) {
            misuse_ = "was given a force that is not finite";
            wake_.wake();
            return false;
        }
        asked.newtons[finger] = newtons[finger];
    }
    asked.time_ns = settings_.clock();
    asked.received_ns = received_ns_;
    asked_.write(asked);
    wake_.wake();
    return true;
}

// ---- The device's thread.

/// Reopened hardware starts anew: positions received before do not count.
Result<void> DrivenDevice::take_hold() {
    auto held = answer_of(name_, [this] { return driver_->connect(); });
    const auto packet = held && settings_.watchdog ? driver_->zero_force_packet() : std::nullopt;
    if (packet && !kept_) {
        TRY_ASSIGN(kept_, SafetyWatchdog::keep(settings_.watchdog));
    }
    if (packet) held = kept_->set_packet(*packet);
    if (!held) return held;
    for (PlausibleMotion& motion : motions_) motion.forget();
    received_ = {};
    rises_ = {};
    held_ = true;
    set_words(std::nullopt, driver_->prompt());
    return {};
}

bool DrivenDevice::turn() {
    if (!held_) return look_for_it();
    const auto served = answer_of(name_, [this] { return serve(); });
    if (served) return true;
    let_go(served.error());
    const auto kept = settings_.watchdog ? settings_.watchdog->health() : Result<void>{};
    if (kept) return true;
    set_words(Error{kept.error().kind, name_ + ": " + kept.error().message}, {});
    lost_.store(true, std::memory_order_release);
    return false;
}

/// Hardware that answers requests is polled as fast as it answers. From hardware that sends by itself, data
/// is read at once, and each new force goes out at once.
Result<void> DrivenDevice::serve() {
    const int descriptor = driver_->descriptor();
    if (descriptor < 0) {
        TRY(send());
        return receive(slowest_bus);
    }
    pollfd waited_for[] = {{wake_.descriptor(), POLLIN, 0}, {descriptor, POLLIN, 0}};
    const timespec patience{0, settings_.own_thread ? std::chrono::nanoseconds(a_tick).count() : 0};
    ppoll(waited_for, 2, &patience, nullptr);
    if (waited_for[1].revents != 0) TRY(receive(microseconds(0)));
    const bool asked = waited_for[0].revents != 0;
    if (asked) wake_.forget();
    // A force for an older position is skipped: one for the newest position follows.
    const bool answers = asked && asked_.read().received_ns >= received_.time_ns;
    return answers || settings_.clock() - sent_ns_ >= sent_again_ns ? send() : Result<void>{};
}

Result<void> DrivenDevice::receive(microseconds patience) {
    DeviceSample sample;
    sample.metres.fill(no_place);
    const auto came = driver_->receive(sample, patience);
    left_out_.store(driver_->left_out(), std::memory_order_relaxed);
    if (!came) return came.error();
    over_.store(driver_->is_over(), std::memory_order_release);
    pass_on_prompt();
    // Data that waited while this thread stood still is older than its time says: drop it.
    if (!*came || (kept_ && kept_->was_made_unpowered())) return {};
    received_.time_ns = settings_.clock() - sample.kept_ns;
    received_.sample.buttons = sample.buttons;
    for (std::size_t finger = 0; finger < static_cast<std::size_t>(fingers_); ++finger) {
        std::int64_t& place_ns = received_.place_ns[finger];
        if (std::isnan(sample.metres[finger].x)) {
            place_ns = 0;
            continue;
        }
        const auto place = motions_[finger].believe(sample.metres[finger], received_.time_ns);
        if (!place) {
            ++implausible_;
            continue;
        }
        if (age_of(place_ns, received_.time_ns) > oldest_s) found_ns_[finger] = received_.time_ns;
        received_.sample.metres[finger] = *place;
        place_ns = received_.time_ns;
    }
    ++samples_;
    latest_.write(received_);
    if (settings_.on_received) settings_.on_received(received_.time_ns);
    return {};
}

/// Requested forces that may be sent now; 0 for a finger without a recent request and position.
DrivenDevice::Forces DrivenDevice::due_forces(std::int64_t now) {
    const Asked& asked = asked_.read();
    const bool lives =
        !misuse_.load() && !stopping_.stop_requested() && age_of(asked.time_ns, now) <= silence_s;
    Forces newtons{};
    for (std::size_t finger = 0; finger < static_cast<std::size_t>(fingers_); ++finger) {
        Rise& rise = rises_[finger];
        if (!lives || age_of(received_.place_ns[finger], now) > oldest_s ||
            asked.time_ns < found_ns_[finger]) {
            rise = {};
            continue;
        }
        if (rise.since_ns == 0) rise = {.since_ns = now};
        newtons[finger] = std::min(1.0, age_of(rise.since_ns, now) / rise_s) * asked.newtons[finger];
    }
    return newtons;
}

/// Announces to the watchdog that this thread is about to send. If the watchdog took it for stalled, the
/// forces rise anew and the driver forgets earlier answers.
Result<void> DrivenDevice::beat() {
    if (!kept_) return {};
    TRY_ASSIGN(const auto beat, kept_->beat());
    if (beat) return {};
    rises_ = {};
    return driver_->forget_what_came();
}

Result<void> DrivenDevice::send() {
    TRY(beat());
    const std::int64_t now = settings_.clock();
    Forces newtons = due_forces(now);
    const double ramp =
        limits_.max_force * static_cast<double>(std::min(now - sent_ns_, sent_again_ns)) * 1e-9 / rise_s;
    for (std::size_t finger = 0; finger < static_cast<std::size_t>(fingers_); ++finger)
        rises_[finger].ceiling =
            force_gate(glm::value_ptr(newtons[finger]), rises_[finger].ceiling, limits_.max_force, ramp);
    sent_ns_ = now;
    ++sent_;
    auto sent = driver_->send(std::span(newtons).first(static_cast<std::size_t>(fingers_)));
    if (settings_.on_sent) settings_.on_sent(settings_.clock());
    // Also needed for hardware that sends nothing.
    if (sent) pass_on_prompt();
    return sent;
}

/// Closes failed hardware: it has no force and no position any more.
void DrivenDevice::let_go(const Error& why) {
    driver_->disconnect();
    kept_.reset();
    held_ = false;
    ++losses_;
    gone_ns_ = looked_ns_ = settings_.clock();
    latest_.write({});
    lost_why_ = why;
    set_words(why, "looking for the " + name_ + " again");
}

/// Tries to reopen lost hardware. False: it was gone for too long and is given up.
bool DrivenDevice::look_for_it() {
    const std::int64_t now = settings_.clock();
    if (age_of(looked_ns_, now) < settings_.look_again_s) return true;
    looked_ns_ = now;
    const auto held = take_hold();
    if (held) return true;
    driver_->disconnect();
    kept_.reset();  // it may hold a descriptor that the next try needs
    if (held.error().kind == ErrorKind::interrupted) return true;
    // The present obstacle may be one that a person can remove.
    const std::string& why = held.error().message;
    const std::string now_why = why == lost_why_.message ? std::string() : why;
    const std::string also = now_why.empty() ? std::string() : ": " + now_why;
    Error lost = lost_why_;
    lost.hints.insert(lost.hints.end(), held.error().hints.begin(), held.error().hints.end());
    if (age_of(gone_ns_, now) < settings_.away_s) {
        if (!now_why.empty()) lost.message += "; now " + now_why;
        set_words(std::move(lost), "looking for the " + name_ + " again" + also);
        return true;
    }
    lost.message += "; it did not come back" + also;
    set_words(std::move(lost), {});
    lost_.store(true, std::memory_order_release);
    return false;
}

}  // namespace touchable
