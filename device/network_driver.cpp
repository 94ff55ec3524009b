#include "device/network_driver.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::size_t most_reasons = 8;  // one may send whatever it likes
constexpr int most_zeros = 20;           // one may be lost on the way, not all

/// Counters of 32 bits come round.
bool is_newer(std::uint32_t sequence, std::uint32_t than) {
    return static_cast<std::int32_t>(sequence - than) > 0;
}

}  // namespace

DeviceCapabilities NetworkDriver::capabilities() const {
    return {.axes_sensed = 3,
            .axes_driven = 3,
            .reach = glm::dvec3(0),
            .rate_hz = 0,
            .buttons = 32,
            .own_watchdog = false,
            .first_button = "the device's first button (bit 0 of its buttons)"};
}

Result<void> NetworkDriver::connect(const GivenUp&) {
    peer_.reset();
    if (!settings_.from.empty() && !from_)
        return Error{ErrorKind::device, "network:from=" + settings_.from +
                                            ": is no address in figures; right would be such as 192.168.1.7"};
    if (auto bound = socket_->bind(settings_.listen, settings_.port); !bound.ok()) return bound;
    const std::lock_guard lock(words_mutex_);
    listens_at_ = "UDP " + settings_.listen + ":" + std::to_string(socket_->port());
    return {};
}

void NetworkDriver::disconnect() noexcept {
    if (socket_->descriptor() < 0) return;
    try {
        part();
    } catch (...) {
    }
    socket_->close();
}

/// Whoever is there hears that nothing more comes, and that its forces are zero.
void NetworkDriver::part() {
    if (!peer_) return;
    const std::array<glm::dvec3, NetworkPacket::most_fingers> zeros{};
    const auto last =
        encode(answer(std::span(zeros).first(static_cast<std::size_t>(settings_.fingers)), true));
    // One may be lost on the way, and one meets only the news that an earlier one did not arrive.
    for (int again = 0; again < 3; ++again) socket_->send(last);
    peer_.reset();
    parted_ns_ = clock_();
    [[maybe_unused]] const auto free = socket_->settle(std::nullopt);
}

NetworkPacket NetworkDriver::answer(std::span<const glm::dvec3> newtons, bool last) const {
    NetworkPacket packet;
    packet.kind = NetworkPacket::Kind::forces;
    packet.last = last;
    packet.fingers = settings_.fingers;
    if (peer_) {
        packet.sequence = peer_->sequence;
        packet.time_ns = peer_->time_ns;
    }
    std::copy(newtons.begin(), newtons.end(), packet.vectors.begin());
    return packet;
}

/// One answer for each packet with places, so that nobody who sends slowly has to read many; and zeros, a few
/// times, for whoever is silent.
Result<void> NetworkDriver::send(std::span<const glm::dvec3> newtons) {
    if (!peer_) return {};
    const bool zeros = std::all_of(newtons.begin(), newtons.end(),
                                   [](const glm::dvec3& force) { return force == glm::dvec3(0); });
    const bool is_gone = static_cast<double>(clock_() - peer_->received_ns) * 1e-9 > peer_gone_s;
    if (is_gone) {
        part();
        return {};
    }
    zeros_ = is_answer_due_ || !zeros ? 0 : zeros_ + 1;
    if (!std::exchange(is_answer_due_, false) && (!zeros || zeros_ > most_zeros)) return {};
    if (!socket_->send(encode(answer(newtons, false)))) part();
    return {};
}

/// All that has come by now; the newest places count.
Result<bool> NetworkDriver::receive(DeviceSample& sample, std::chrono::microseconds patience) {
    if (patience.count() > 0) {
        pollfd waited_for{socket_->descriptor(), POLLIN, 0};
        poll(&waited_for, 1, static_cast<int>((patience.count() + 999) / 1000));
    }
    std::array<std::byte, NetworkPacket::most_bytes + 1> room;  // one more, so that a longer one is known
    UdpAddress from;
    bool any = false;
    for (int most = 64; most > 0; --most) {
        const auto bytes = socket_->receive(room, from);
        if (!bytes) break;
        auto packet = decode_network_packet(std::span(room).first(*bytes));
        if (!packet.ok()) {
            leave_out(packet.error().message, from);
        } else if (take(*packet, from) && peer_) {
            std::copy_n(packet->vectors.begin(), settings_.fingers, sample.metres.begin());
            sample.buttons = packet->buttons;
            any = true;
        } else if (!peer_) {
            any = false;
        }
    }
    return any;
}

/// Places that waited are old. Whoever has said meanwhile that it ends has ended.
Result<void> NetworkDriver::forget_what_came() {
    DeviceSample old;
    for (int most = 64; most > 0; --most) {  // whoever sends without end must not hold the thread
        TRY_ASSIGN(const auto came, receive(old, std::chrono::microseconds(0)));
        if (!came) break;
    }
    return {};
}

/// What nobody has to be told of a device that only this machine's programs reach.
std::string NetworkDriver::who_may_touch() const {
    if (from_) return ", from " + settings_.from + " alone";
    const auto own = read_udp_address(settings_.listen);
    if (own && own->is_own_machine()) return {};
    return ", from ANY machine that reaches it: whoever sends first moves the fingers and gets the forces "
           "(the device network:from=ADDRESS lets one)";
}

/// Empty: nothing is wrong with it.
std::string NetworkDriver::why_not(const NetworkPacket& packet, const UdpAddress& from) const {
    if (from_ && !from_->is_of_host(from))
        return "packets came that are not from " + settings_.from + ", as network:from says";
    if (packet.kind != NetworkPacket::Kind::places)
        return "packets with forces came and places are expected: kind 1";
    if (packet.fingers != settings_.fingers)
        return "packets with " + std::to_string(packet.fingers) + " fingers came and " +
               std::to_string(settings_.fingers) + (settings_.fingers == 1 ? " is" : " are") +
               " expected: network:fingers=" + std::to_string(packet.fingers);
    if (!peer_) return {};
    if (peer_->address != from) return "a second hand came while another was there";
    return is_newer(packet.sequence, peer_->sequence) ? "" : "packets came that are not newer than the last";
}

void NetworkDriver::leave_out(const std::string& why, const UdpAddress& from) {
    ++left_out_;
    if (peer_) return;  // with a hand there, nobody has to be told
    trouble_ = why + " (from " + from.in_words() + ")";
    const std::lock_guard lock(words_mutex_);
    if (any_peer_) return;
    const auto same = [&why](const LeftOut& each) { return each.why == why; };
    auto known = std::find_if(left_out_why_.begin(), left_out_why_.end(), same);
    if (known == left_out_why_.end()) {
        if (left_out_why_.size() < most_reasons) left_out_why_.push_back({why, 0});
        known = std::prev(left_out_why_.end());
        if (known->why != why) known->why = "and others";
    }
    ++known->packets;
}

/// Whether it counts. One that ends parts with its peer.
bool NetworkDriver::take(const NetworkPacket& packet, const UdpAddress& from) {
    if (const std::string why = why_not(packet, from); !why.empty()) {
        leave_out(why, from);
        return false;
    }
    if (packet.last) {
        part();
        return true;
    }
    if (!peer_) {
        // Another hand does not inherit what the last one asked for: it has been away for long enough by
        // then.
        if (parted_ns_ != 0 && static_cast<double>(clock_() - parted_ns_) * 1e-9 < between_peers_s)
            return false;
        if (!socket_->settle(from).ok()) return false;
        peer_ = Peer{from, 0, 0, 0};
        trouble_.clear();
        const std::lock_guard lock(words_mutex_);
        any_peer_ = true;
    }
    is_answer_due_ = true;
    peer_->sequence = packet.sequence;
    peer_->time_ns = packet.time_ns;
    peer_->received_ns = clock_();
    return true;
}

std::optional<ZeroForcePacket> NetworkDriver::zero_force_packet() const {
    NetworkPacket last, meanwhile;
    last.kind = meanwhile.kind = NetworkPacket::Kind::forces;
    last.fingers = meanwhile.fingers = settings_.fingers;
    last.last = meanwhile.stands_still = true;
    return ZeroForcePacket{socket_->descriptor(), encode(last), {}, encode(meanwhile)};
}

std::string NetworkDriver::prompt() const {
    if (peer_) return {};
    const std::string waits = "waiting for a hand at " + listens_at_ + who_may_touch();
    return trouble_.empty() ? waits : waits + "; " + trouble_;
}

std::string NetworkDriver::why_no_position() const {
    const std::lock_guard lock(words_mutex_);
    if (any_peer_) return {};
    std::string words = "no hand ever came to " + listens_at_;
    for (const LeftOut& each : left_out_why_)
        words += "; " + each.why + " (" + std::to_string(each.packets) +
                 (each.packets == 1 ? " packet)" : " packets)");
    return words;
}

}  // namespace touchable
