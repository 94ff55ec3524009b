// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/network_device.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <zlib.h>

#include <bit>
#include <cerrno>
#include <iterator>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- Packets

// "TCHD", version, kind, fingers, flags, sequence, buttons, time; then vectors and the CRC of all before.
constexpr std::array<std::byte, 4> packet_magic{std::byte{'T'}, std::byte{'C'}, std::byte{'H'},
                                                std::byte{'D'}};
constexpr std::size_t head_bytes = 24;
constexpr std::size_t vector_bytes = 24;
constexpr std::size_t crc_bytes = 4;
constexpr std::uint8_t last_flag = 1, still_flag = 2;

std::size_t packet_bytes(std::size_t fingers) {
    return head_bytes + fingers * vector_bytes + crc_bytes;
}

std::uint32_t packet_crc(std::span<const std::byte> bytes) {
    return static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

void put_number(std::vector<std::byte>& out, std::unsigned_integral auto number) {
    for (std::size_t byte = 0; byte < sizeof number; ++byte)
        out.push_back(static_cast<std::byte>(number >> (8 * byte) & 0xff));
}

template <class Number>
Number take_number(std::span<const std::byte>& in) {
    const auto* const bytes = reinterpret_cast<const char*>(in.data());
    in = in.subspan(sizeof(Number));
    return static_cast<Number>(number_in_bytes({bytes, sizeof(Number)}, false));
}

Result<void> check_packet(std::span<const std::byte> bytes) {
    if (bytes.size() < packet_bytes(1) ||
        !std::equal(packet_magic.begin(), packet_magic.end(), bytes.begin()))
        return input_error(
            "a packet of " + std::to_string(bytes.size()) +
            " bytes does not begin with TCHD and a whole head; must be as docs/devices.md says");
    if (const auto version = std::to_integer<int>(bytes[4]); version != NetworkPacket::version)
        return input_error("a packet is of version " + std::to_string(version) +
                           "; this program speaks version " + std::to_string(NetworkPacket::version));
    const auto fingers = std::to_integer<std::size_t>(bytes[6]);
    if (fingers < 1 || fingers > NetworkPacket::most_fingers || bytes.size() != packet_bytes(fingers))
        return input_error("a packet of " + std::to_string(bytes.size()) + " bytes says it has " +
                           std::to_string(fingers) + " fingers; must be 1 to 10, and 28 + 24 bytes for each");
    auto crc = bytes.last(crc_bytes);
    if (take_number<std::uint32_t>(crc) != packet_crc(bytes.first(bytes.size() - crc_bytes)))
        return input_error(
            "a packet's CRC-32 does not fit its bytes; it was damaged on the way, or it is not the CRC of "
            "all bytes before it");
    return {};
}

// ---- Sockets

Error socket_error(const std::string& where) {
    return device_error(where + ": " + std::strerror(errno));
}

// ---- The driver

constexpr std::size_t most_reasons = 8;  // a peer may send anything
constexpr int most_zeros = 20;           // repeated, because single datagrams may be lost

/// Counters of 32 bits wrap around.
bool is_newer(std::uint32_t sequence, std::uint32_t than) {
    return static_cast<std::int32_t>(sequence - than) > 0;
}

// ---- Keys

const NetworkSettings standard_hand;
const std::array<KeyedValues::Key, 6> network_keys{{
    {"listen", "an address in figures, such as 0.0.0.0", 0, 0, 0, KeyedValues::Key::Kind::words},
    {"from", "an address in figures, such as 192.168.1.7", 0, 0, 0, KeyedValues::Key::Kind::words},
    {"port", "", 1, 65535, static_cast<double>(standard_hand.port), KeyedValues::Key::Kind::whole},
    {"fingers", "", 1, NetworkPacket::most_fingers, static_cast<double>(standard_hand.fingers),
     KeyedValues::Key::Kind::whole},
    {"force", "N", 0.1, 1000, standard_hand.limits.max_force},
    {"stiffness", "N/mm", 0.01, 1000, standard_hand.limits.max_stiffness / 1000},
}};

}  // namespace

// ---- Packets

std::vector<std::byte> encode(const NetworkPacket& packet) {
    assert(packet.fingers >= 1 && packet.fingers <= static_cast<int>(NetworkPacket::most_fingers));
    std::vector<std::byte> bytes(packet_magic.begin(), packet_magic.end());
    bytes.reserve(NetworkPacket::most_bytes);
    const int flags = (packet.last ? last_flag : 0) | (packet.stands_still ? still_flag : 0);
    for (const int byte : {int{NetworkPacket::version}, static_cast<int>(packet.kind), packet.fingers, flags})
        bytes.push_back(static_cast<std::byte>(byte));
    put_number(bytes, packet.sequence);
    put_number(bytes, packet.buttons);
    put_number(bytes, packet.time_ns);
    for (std::size_t finger = 0; finger < static_cast<std::size_t>(packet.fingers); ++finger)
        for (int axis = 0; axis < 3; ++axis)
            put_number(bytes, std::bit_cast<std::uint64_t>(packet.vectors[finger][axis]));
    put_number(bytes, packet_crc(bytes));
    return bytes;
}

Result<NetworkPacket> decode_network_packet(std::span<const std::byte> bytes) {
    TRY(check_packet(bytes));
    auto in = bytes.subspan(packet_magic.size() + 1);
    NetworkPacket packet;
    const auto kind = take_number<std::uint8_t>(in);
    if (kind != 1 && kind != 2)
        return input_error("a packet is of kind " + std::to_string(kind) +
                           "; must be 1 (places) or 2 (forces)");
    packet.kind = static_cast<NetworkPacket::Kind>(kind);
    packet.fingers = take_number<std::uint8_t>(in);
    const auto flags = take_number<std::uint8_t>(in);
    packet.last = (flags & last_flag) != 0;
    packet.stands_still = (flags & still_flag) != 0;
    packet.sequence = take_number<std::uint32_t>(in);
    packet.buttons = take_number<std::uint32_t>(in);
    packet.time_ns = take_number<std::uint64_t>(in);
    for (std::size_t finger = 0; finger < static_cast<std::size_t>(packet.fingers); ++finger)
        for (int axis = 0; axis < 3; ++axis)
            packet.vectors[finger][axis] = std::bit_cast<double>(take_number<std::uint64_t>(in));
    return packet;
}

// ---- Sockets

std::optional<UdpAddress> read_udp_address(const std::string& figures) {
    UdpAddress address;
    address.words.sin6_family = AF_INET6;
    for (const std::string& as_ipv6 : {figures, "::ffff:" + figures})
        if (inet_pton(AF_INET6, as_ipv6.c_str(), &address.words.sin6_addr) == 1) return address;
    return std::nullopt;
}

std::string UdpAddress::in_words() const {
    char figures[INET6_ADDRSTRLEN] = "";
    inet_ntop(AF_INET6, &words.sin6_addr, figures, sizeof figures);
    const std::string text = figures, mapped = "::ffff:";
    std::string said = text.starts_with(mapped) ? text.substr(mapped.size()) : std::string("[").append(text);
    if (!text.starts_with(mapped)) said += ']';
    return said.append(":").append(std::to_string(ntohs(words.sin6_port)));
}

Result<void> UdpSocket::bind(const std::string& address, std::uint16_t port) {
    close();
    const std::string where = "UDP " + address + ":" + std::to_string(port);
    auto own = read_udp_address(address);
    if (!own) return device_error(where + ": is no address in figures; use 127.0.0.1, 0.0.0.0 or ::1");
    descriptor_ = Descriptor(socket(AF_INET6, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (descriptor_.get() < 0) return socket_error(where);
    const int off = 0;
    setsockopt(descriptor_.get(), IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
    own->words.sin6_port = htons(port);
    if (::bind(descriptor_.get(), reinterpret_cast<const sockaddr*>(&own->words), sizeof own->words) == 0)
        return {};
    Error error = socket_error(where);
    if (errno == EADDRINUSE) {
        error.message += ": another program listens there; take another port";
        error.hints = {{Setting::device, "network:port=N"}};
    }
    if (errno == EADDRNOTAVAIL) error.message += ": must be an address that this machine has";
    close();
    return error;
}

std::uint16_t UdpSocket::port() const {
    sockaddr_in6 own{};
    socklen_t size = sizeof own;
    getsockname(descriptor_.get(), reinterpret_cast<sockaddr*>(&own), &size);
    return ntohs(own.sin6_port);
}

std::optional<std::size_t> UdpSocket::receive(std::span<std::byte> room, UdpAddress& from) {
    // A peer that has gone is reported once, as an error instead of a datagram: try again.
    for (int again = 0; again < 2; ++again) {
        socklen_t size = sizeof from.words;
        const auto came = recvfrom(descriptor_.get(), room.data(), room.size(), 0,
                                   reinterpret_cast<sockaddr*>(&from.words), &size);
        if (came >= 0) return static_cast<std::size_t>(came);
        if (errno != ECONNREFUSED && errno != EINTR) break;
    }
    return std::nullopt;
}

bool UdpSocket::send(std::span<const std::byte> datagram) {
    const auto sent = ::send(descriptor_.get(), datagram.data(), datagram.size(), MSG_NOSIGNAL);
    return sent >= 0 || errno == EAGAIN || errno == ENOBUFS;
}

Result<void> UdpSocket::settle(const std::optional<UdpAddress>& peer) {
    sockaddr any_peer{};
    any_peer.sa_family = AF_UNSPEC;
    const int settled =
        peer ? connect(descriptor_.get(), reinterpret_cast<const sockaddr*>(&peer->words), sizeof peer->words)
             : connect(descriptor_.get(), &any_peer, sizeof any_peer);
    if (settled == 0) return {};
    return socket_error("UDP " + (peer ? peer->in_words() : std::string("without a peer")));
}

// ---- The driver

Result<void> NetworkDriver::connect() {
    peer_.reset();
    if (!settings_.from.empty() && !from_)
        return device_error("network:from=" + settings_.from +
                            ": is no address in figures; must be like 192.168.1.7");
    TRY(socket_->bind(settings_.listen, settings_.port));
    const std::lock_guard lock(words_mutex_);
    listens_at_ = "UDP " + settings_.listen + ":" + std::to_string(socket_->port());
    return {};
}

/// Tells the peer that nothing more comes, and that its forces are zero.
void NetworkDriver::part() {
    if (!peer_) return;
    const auto last = encode(answer({}, true));
    // Datagrams may be lost, and a send may only report that an earlier one was refused.
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

/// Sends one answer for each packet with positions, so that a slow peer need not read many, and a few zeros
/// to a silent peer.
Result<void> NetworkDriver::send(std::span<const glm::dvec3> newtons) {
    if (!peer_) return {};
    const bool zeros =
        std::ranges::all_of(newtons, [](const glm::dvec3& force) { return force == glm::dvec3(0); });
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

/// Reads all packets that have come; the newest positions count.
Result<bool> NetworkDriver::receive(DeviceSample& sample, std::chrono::microseconds patience) {
    if (patience.count() > 0) {
        pollfd waited_for{socket_->descriptor(), POLLIN, 0};
        poll(&waited_for, 1, static_cast<int>((patience.count() + 999) / 1000));
    }
    std::array<std::byte, NetworkPacket::most_bytes + 1> room;  // one more than the longest packet
    UdpAddress from;
    bool any = false;
    for (int most = 64; most > 0; --most) {
        const auto bytes = socket_->receive(room, from);
        if (!bytes) break;
        auto packet = decode_network_packet(std::span(room).first(*bytes));
        if (!packet) {
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

/// Drops positions that waited. A peer that said meanwhile that it ends is still parted with.
Result<void> NetworkDriver::forget_what_came() {
    DeviceSample old;
    for (int most = 64; most > 0; --most) {  // a peer that sends without end must not hold the thread
        TRY_ASSIGN(const auto came, receive(old, std::chrono::microseconds(0)));
        if (!came) break;
    }
    return {};
}

/// Why a packet is left out; empty: it is accepted.
std::string NetworkDriver::why_not(const NetworkPacket& packet, const UdpAddress& from) const {
    if (from_ && !from_->is_of_host(from))
        return "packets came that are not from " + settings_.from + ", as network:from says";
    if (packet.kind != NetworkPacket::Kind::places)
        return "packets with forces came and places are expected: kind 1";
    if (packet.fingers != settings_.fingers)
        return "packets with " + std::to_string(packet.fingers) + " fingers came and " +
               counted(settings_.fingers, "is", "are") +
               " expected: network:fingers=" + std::to_string(packet.fingers);
    if (!peer_) return {};
    if (peer_->address != from) return "a second hand came while another was there";
    return is_newer(packet.sequence, peer_->sequence) ? "" : "packets came that are not newer than the last";
}

void NetworkDriver::leave_out(const std::string& why, const UdpAddress& from) {
    ++left_out_;
    if (peer_) return;  // no prompt while a hand is there
    trouble_ = why + " (from " + from.in_words() + ")";
    const std::lock_guard lock(words_mutex_);
    if (any_peer_) return;
    const auto same = [&why](const LeftOut& each) { return each.why == why; };
    auto known = std::ranges::find_if(left_out_why_, same);
    if (known == left_out_why_.end()) {
        if (left_out_why_.size() < most_reasons) left_out_why_.push_back({why, 0});
        known = std::prev(left_out_why_.end());
        if (known->why != why) known->why = "and others";
    }
    ++known->packets;
}

/// Whether the packet counts. A last packet parts with its peer.
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
        // A new hand must not get the forces of the last one, which has to be away for long enough.
        if (parted_ns_ != 0 && static_cast<double>(clock_() - parted_ns_) * 1e-9 < between_peers_s)
            return false;
        if (!socket_->settle(from)) return false;
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

std::string NetworkDriver::why_no_position() const {
    const std::lock_guard lock(words_mutex_);
    if (any_peer_) return {};
    std::string words = "no hand ever came to " + listens_at_;
    for (const LeftOut& each : left_out_why_)
        words += "; " + each.why + " (" + counted(each.packets, "packet") + ')';
    return words;
}

// ---- Keys

Result<NetworkSettings> read_network_settings(std::string_view keys) {
    TRY_ASSIGN(const auto given, KeyedValues::parse("device 'network'", keys, network_keys));
    NetworkSettings settings;
    if (given.given("listen")) settings.listen = given.words("listen");
    if (given.given("from")) settings.from = given.words("from");
    if (!settings.from.empty() && !read_udp_address(settings.from))
        return usage_error("device 'network': from=" + settings.from +
                           " is no address in figures; must be like 192.168.1.7");
    settings.port = static_cast<std::uint16_t>(given.number("port"));
    settings.fingers = static_cast<int>(given.number("fingers"));
    settings.limits = {given.number("force"), given.number("stiffness") * 1000};
    return settings;
}

Result<std::unique_ptr<DeviceDriver>> make_network_driver(std::string_view keys) {
    TRY_ASSIGN(const auto settings, read_network_settings(keys));
    return std::make_unique<NetworkDriver>(settings);
}

}  // namespace touchable
