// SPDX-License-Identifier: Apache-2.0
// A network hand over real sockets of this machine.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>
#include <glm/geometric.hpp>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "device/drivers/device_catalog.hpp"
#include "device/drivers/driven_device.hpp"
#include "device/drivers/network_device.hpp"
#include "device/point_motion.hpp"
#include "tests/device/fault_sessions.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

using std::chrono::milliseconds;

/// A hand of a test's own, with a socket made by other means than the driver's.
class Peer {
public:
    explicit Peer(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
        const sockaddr_in to = loopback(port);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    }
    ~Peer() { ::close(socket_); }
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;

    /// A port without a listener shows as an error of the next call.
    void say(const std::vector<std::byte>& bytes) const {
        const auto whole = static_cast<ssize_t>(bytes.size());
        if (::send(socket_, bytes.data(), bytes.size(), 0) != whole) {
            EXPECT_EQ(errno, ECONNREFUSED);
            EXPECT_EQ(::send(socket_, bytes.data(), bytes.size(), 0), whole);
        }
    }
    void say(std::uint32_t sequence, const glm::dvec3& place, bool last = false, int fingers = 1) const {
        NetworkPacket packet;
        packet.sequence = sequence;
        packet.time_ns = 1000 + sequence;
        packet.fingers = fingers;
        packet.last = last;
        packet.vectors[0] = place;
        say(encode(packet));
    }
    /// Every answer that has come.
    std::vector<NetworkPacket> hear_all(int patience_ms = 1000) const {
        std::vector<NetworkPacket> all;
        pollfd waited_for{socket_, POLLIN, 0};
        std::byte room[1024];
        for (; poll(&waited_for, 1, patience_ms) == 1; patience_ms = 0) {
            const auto came = recv(socket_, room, sizeof room, 0);
            if (came < 0) break;
            const auto packet = decode_network_packet(std::span(room).first(static_cast<std::size_t>(came)));
            EXPECT_TRUE(packet);
            if (packet) all.push_back(*packet);
        }
        return all;
    }
    /// The newest; kind `places` where none has come.
    NetworkPacket hear() const {
        const auto all = hear_all();
        return all.empty() ? NetworkPacket() : all.back();
    }

private:
    int socket_;
};

class NetworkHand : public testing::Test {
protected:
    NetworkHand() {
        auto connected = driver.connect();
        EXPECT_TRUE(connected) << connected.error().message;
    }
    bool hears(const glm::dvec3& place, int patience_ms = 1000) {
        DeviceSample sample;
        const auto came = driver.receive(sample, milliseconds(patience_ms));
        return came && *came && sample.metres[0] == place;
    }
    bool hears_nothing(int patience_ms = 20) {
        DeviceSample sample;
        const auto came = driver.receive(sample, milliseconds(patience_ms));
        return came && !*came;
    }
    void pass(std::int64_t ms) { now += ms * 1'000'000; }
    /// After how many milliseconds a peer is heard that goes on sending, while the device's thread goes on
    /// speaking; -1: never.
    int comes_to_be_heard_after(const Peer& peer) {
        for (int ms = 0; ms < 5000; ms += 5) {
            peer.say(static_cast<std::uint32_t>(ms + 2), {0.09, 0, 0});
            if (hears({0.09, 0, 0}, 0)) return ms;
            exert({0, 0, 0});
            pass(5);
        }
        return -1;
    }
    void exert(const glm::dvec3& newtons) { EXPECT_TRUE(driver.send(std::span(&newtons, 1))); }

    NetworkSettings settings{
        .listen = "127.0.0.1", .port = unused_port(), .fingers = 1, .limits = {10, 3000}};
    std::int64_t now = 1;  // ns; passes only where a test says so
    NetworkDriver driver{settings, std::make_unique<UdpSocket>(), [this] { return now; }};
};

TEST_F(NetworkHand, ExchangesPositionsAndForces) {
    const Peer peer(driver.port());
    EXPECT_NE(driver.prompt().find("waiting for a hand at UDP 127.0.0.1:"), std::string::npos);
    peer.say(1, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    EXPECT_EQ(driver.prompt(), "");
    exert({0, 0, 2.5});
    const auto answer = peer.hear();
    EXPECT_EQ(answer.kind, NetworkPacket::Kind::forces);
    EXPECT_EQ(answer.vectors[0], glm::dvec3(0, 0, 2.5));
    EXPECT_EQ(answer.sequence, 1U);
    EXPECT_EQ(answer.time_ns, 1001U) << "its own clock, so that it can tell the round trip";
}

/// Hears a packet from this machine.
bool takes_one_from_here(NetworkDriver& driver) {
    const Peer peer(driver.port());
    peer.say(1, {0.01, 0, 0});
    DeviceSample sample;
    const auto came = driver.receive(sample, milliseconds(200));
    return came && *came;
}

TEST(NetworkAccess, AcceptsOnlyNamedAddress) {
    NetworkSettings settings{.listen = "0.0.0.0", .port = unused_port()};
    for (const auto& [from, counts] : {std::pair{"127.0.0.1", true}, std::pair{"192.0.2.7", false}}) {
        settings.from = from;
        NetworkDriver driver(settings);
        ASSERT_TRUE(driver.connect());
        EXPECT_NE(driver.prompt().find(std::string(", from ") + from + " alone"), std::string::npos)
            << driver.prompt();
        EXPECT_EQ(takes_one_from_here(driver), counts) << from;
        EXPECT_EQ(driver.left_out(), counts ? 0 : 1);
        EXPECT_EQ(driver.prompt().find("not from 192.0.2.7") != std::string::npos, !counts)
            << driver.prompt();
    }
}

TEST(NetworkAccess, WarnsWhenAnyoneMayConnect) {
    for (const auto& [listen, anybody] :
         {std::pair{"0.0.0.0", true}, std::pair{"::", true}, std::pair{"127.0.0.1", false},
          std::pair{"127.0.0.2", false}, std::pair{"::1", false}}) {
        NetworkDriver driver({.listen = listen, .port = unused_port()});
        if (!driver.connect()) continue;  // a machine without IPv6
        EXPECT_EQ(driver.prompt().find("ANY machine") != std::string::npos, anybody) << driver.prompt();
    }
}

TEST(NetworkAccess, RejectsInvalidAddress) {
    const auto settings = read_network_settings("from=my-robot");
    ASSERT_FALSE(settings);
    EXPECT_EQ(settings.error().kind, ErrorKind::usage);
    EXPECT_NE(settings.error().message.find("from=my-robot"), std::string::npos) << settings.error().message;
    NetworkDriver driver({.listen = "127.0.0.1", .port = unused_port(), .from = "my-robot"});
    EXPECT_FALSE(driver.connect()) << "and admits no hand";
}

/// While this process stood still.
TEST_F(NetworkHand, ForgetsQueuedPositionsButAnswers) {
    const Peer peer(driver.port());
    peer.say(1, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    for (std::uint32_t sequence = 2; sequence < 150; ++sequence) peer.say(sequence, {0.02, 0, 0});
    ASSERT_TRUE(driver.forget_what_came());
    EXPECT_TRUE(hears_nothing(0));
    exert({0, 0, 0});
    EXPECT_EQ(peer.hear().sequence, 149U);
    peer.say(150, {0.03, 0, 0}, true);
    ASSERT_TRUE(driver.forget_what_came());
    EXPECT_NE(driver.prompt(), "") << "it has said that it ends";
}

TEST_F(NetworkHand, TakesNewestOfReorderedPackets) {
    const Peer peer(driver.port());
    peer.say(1, {0.01, 0, 0});
    peer.say(4, {0.04, 0, 0});
    peer.say(2, {0.02, 0, 0});
    peer.say(4, {0.05, 0, 0});
    ASSERT_TRUE(hears({0.04, 0, 0}));
    EXPECT_EQ(driver.left_out(), 2);
    peer.say(0xffffffff, {0.01, 0, 0});
    EXPECT_TRUE(hears_nothing()) << "older than 4";
}

TEST_F(NetworkHand, SequenceCounterWrapsAround) {
    const Peer peer(driver.port());
    peer.say(0xfffffffe, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    peer.say(1, {0.02, 0, 0});
    EXPECT_TRUE(hears({0.02, 0, 0}));
}

TEST_F(NetworkHand, SkipsAndNamesGarbage) {
    const Peer peer(driver.port());
    peer.say(std::vector<std::byte>(100, std::byte{7}));
    EXPECT_TRUE(hears_nothing());
    EXPECT_NE(driver.prompt().find("does not begin with TCHD"), std::string::npos) << driver.prompt();
    peer.say(1, {0, 0, 0}, false, 2);
    EXPECT_TRUE(hears_nothing());
    EXPECT_NE(driver.prompt().find("network:fingers=2"), std::string::npos) << driver.prompt();
    peer.say(2, {0.01, 0, 0});
    EXPECT_TRUE(hears({0.01, 0, 0}));
    peer.say(std::vector<std::byte>(0));
    peer.say(std::vector<std::byte>(2000, std::byte{0}));
    EXPECT_TRUE(hears_nothing());
    EXPECT_EQ(driver.left_out(), 4);
}

TEST_F(NetworkHand, RejectsForcePackets) {
    const Peer peer(driver.port());
    NetworkPacket packet;
    packet.kind = NetworkPacket::Kind::forces;
    packet.sequence = 1;
    peer.say(encode(packet));
    EXPECT_TRUE(hears_nothing());
    EXPECT_NE(driver.prompt().find("kind 1"), std::string::npos) << driver.prompt();
}

TEST_F(NetworkHand, CountsRejectedPackets) {
    EXPECT_EQ(driver.why_no_position(),
              "no hand ever came to UDP 127.0.0.1:" + std::to_string(driver.port()));
    const Peer peer(driver.port());
    for (std::uint32_t sequence = 1; sequence <= 3; ++sequence) peer.say(sequence, {0, 0, 0}, false, 2);
    EXPECT_TRUE(hears_nothing());
    EXPECT_NE(driver.prompt().find("; packets with 2 fingers came and 1 is expected: network:fingers=2 "
                                   "(from 127.0.0.1:"),
              std::string::npos)
        << driver.prompt();
    NetworkPacket newer;
    auto bytes = encode(newer);
    bytes[4] = std::byte{9};
    peer.say(bytes);
    bytes = encode(newer);
    bytes.back() ^= std::byte{1};
    peer.say(bytes);
    EXPECT_TRUE(hears_nothing());
    const std::string words = driver.why_no_position();
    for (const char* part : {"packets with 2 fingers came and 1 is expected: network:fingers=2 (3 packets)",
                             "version 9; this program speaks version 1 (1 packet)", "CRC-32"})
        EXPECT_NE(words.find(part), std::string::npos) << part << " in " << words;
    for (int size = 1; size < 40; ++size) peer.say(std::vector<std::byte>(static_cast<std::size_t>(size)));
    EXPECT_TRUE(hears_nothing());
    EXPECT_NE(driver.why_no_position().find("and others ("), std::string::npos) << driver.why_no_position();
    EXPECT_LT(driver.why_no_position().size(), 1500u) << "for any packets";
    EXPECT_EQ(driver.left_out(), 44);
    peer.say(4, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    EXPECT_EQ(driver.why_no_position(), "");
}

TEST_F(NetworkHand, AcceptsNextPeerAfterEnd) {
    const Peer first(driver.port()), second(driver.port());
    first.say(1, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    second.say(100, {0.09, 0, 0});
    EXPECT_TRUE(hears_nothing());
    first.say(2, {0.02, 0, 0});
    ASSERT_TRUE(hears({0.02, 0, 0}));
    exert({0, 0, 1});
    first.say(3, {0.02, 0, 0}, true);
    EXPECT_TRUE(hears_nothing());
    const auto last = first.hear();
    EXPECT_TRUE(last.last);
    EXPECT_EQ(last.vectors[0], glm::dvec3(0));
    second.say(1, {0.09, 0, 0});
    EXPECT_TRUE(hears_nothing()) << "forces may still be on";
    EXPECT_EQ(comes_to_be_heard_after(second), 1200);
    EXPECT_EQ(driver.prompt(), "");
}

TEST_F(NetworkHand, IgnoresPositionsBeforeImmediateEnd) {
    const Peer peer(driver.port());
    peer.say(1, {0.01, 0, 0});
    peer.say(2, {0.02, 0, 0}, true);
    EXPECT_TRUE(hears_nothing());
    EXPECT_NE(driver.prompt().find("waiting for a hand"), std::string::npos);
}

TEST_F(NetworkHand, IgnoresSecondPeer) {
    const Peer first(driver.port());
    const Peer second(driver.port());
    first.say(1, {0.01, 0, 0});
    second.say(2, {0.02, 0, 0});  // before the system keeps it away
    EXPECT_TRUE(hears({0.01, 0, 0}));
    EXPECT_EQ(driver.left_out(), 1);
}

TEST_F(NetworkHand, UnpowersAndReplacesSilentPeer) {
    const Peer first(driver.port()), second(driver.port());
    first.say(1, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    pass(1000);
    exert({0, 0, 0});
    EXPECT_EQ(driver.prompt(), "") << "it may still speak";
    first.hear_all();
    pass(1);
    exert({0, 0, 5});
    const auto last = first.hear();
    EXPECT_TRUE(last.last);
    EXPECT_EQ(last.vectors[0], glm::dvec3(0));
    EXPECT_NE(driver.prompt().find("waiting for a hand"), std::string::npos);
    EXPECT_EQ(comes_to_be_heard_after(second), 1200);
}

/// A hand that falls silent gets zeros.
TEST_F(NetworkHand, AnswersEachPacketOnce) {
    const Peer peer(driver.port());
    peer.say(1, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    exert({0, 0, 2});
    for (int tick = 0; tick < 30; ++tick) exert({0, 0, 3});
    const auto answers = peer.hear_all();
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].vectors[0], glm::dvec3(0, 0, 2));
    for (int tick = 0; tick < 30; ++tick) exert({0, 0, 0});
    const auto zeros = peer.hear_all();
    EXPECT_EQ(zeros.size(), 20U) << "some may be lost on the way, not all";
    for (const NetworkPacket& zero : zeros) EXPECT_EQ(zero.vectors[0], glm::dvec3(0));
    peer.say(2, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    for (int tick = 0; tick < 30; ++tick) exert({0, 0, 0});
    EXPECT_EQ(peer.hear_all().size(), 21U) << "an answer, and as many anew";
}

TEST_F(NetworkHand, ReplacesClosedPeer) {
    {
        const Peer first(driver.port());
        first.say(1, {0.01, 0, 0});
        ASSERT_TRUE(hears({0.01, 0, 0}));
    }
    for (int zeros = 0; zeros < 2; ++zeros)
        exert({0, 0, 0});  // the peer is gone, which the second send reports
    const Peer second(driver.port());
    EXPECT_EQ(comes_to_be_heard_after(second), 1200) << "long before a second of silence";
}

TEST_F(NetworkHand, DisconnectSendsZeroForces) {
    const Peer peer(driver.port());
    peer.say(1, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    exert({0, 0, 5});
    ASSERT_EQ(peer.hear().vectors[0], glm::dvec3(0, 0, 5));
    driver.disconnect();
    const auto zero_force_packets = peer.hear_all();
    EXPECT_EQ(zero_force_packets.size(), 3U) << "one may be lost on the way, and one refused";
    for (const NetworkPacket& last : zero_force_packets) {
        EXPECT_TRUE(last.last);
        EXPECT_EQ(last.vectors[0], glm::dvec3(0));
    }
}

TEST_F(NetworkHand, ZeroForcePacketReachesPeer) {
    const Peer peer(driver.port());
    peer.say(1, {0.01, 0, 0});
    ASSERT_TRUE(hears({0.01, 0, 0}));
    exert({0, 0, 5});
    const auto word = driver.zero_force_packet();
    ASSERT_TRUE(word);
    ASSERT_EQ(::write(word->descriptor, word->bytes.data(), word->bytes.size()),
              static_cast<ssize_t>(word->bytes.size()));
    const auto last = peer.hear();
    EXPECT_TRUE(last.last);
    EXPECT_EQ(last.vectors[0], glm::dvec3(0));
}

TEST(NetworkDevice, ReadsItsKeys) {
    const auto settings = read_network_settings("port=6000,fingers=3,listen=0.0.0.0,force=4,stiffness=1.5");
    ASSERT_TRUE(settings) << settings.error().message;
    EXPECT_EQ(settings->port, 6000);
    EXPECT_EQ(settings->fingers, 3);
    EXPECT_EQ(settings->listen, "0.0.0.0");
    EXPECT_EQ(settings->limits.max_force, 4);
    EXPECT_EQ(settings->limits.max_stiffness, 1500);
    EXPECT_EQ(read_network_settings("").value().listen, "127.0.0.1")
        << "this machine alone, unless asked for";
    EXPECT_EQ(read_network_settings("fingers=11").error().kind, ErrorKind::usage);
    EXPECT_EQ(read_network_settings("adress=1").error().kind, ErrorKind::usage);
}

TEST(NetworkDevice, RejectsForeignListenAddress) {
    auto device = make_device("network:listen=192.0.2.1,port=5999", {});
    ASSERT_TRUE(device);
    const auto opened = (*device)->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().message,
              "UDP 192.0.2.1:5999: Cannot assign requested address: must be an address that this "
              "machine has");
    device = make_device("network:listen=here", {});
    ASSERT_TRUE(device);
    EXPECT_NE((*device)->open().error().message.find("127.0.0.1, 0.0.0.0 or ::1"), std::string::npos);
}

UdpAddress hand_at(std::uint16_t port) {
    UdpAddress address;
    address.words.sin6_family = AF_INET6;
    address.words.sin6_port = port;
    return address;
}

/// A program that sends places a thousand times a second, over a network that does everything that networks
/// do. Now and then another program comes between, or it ends and begins anew.
class FaultyNetwork final : public FaultyDevice {
public:
    FaultyNetwork()
        : FaultyDevice("network hand", {.answers_after_ns = 200'000,
                                        .has_checksum = true,
                                        .reorders = true,
                                        .longest_force = 10.0 + 1e-9}) {
        // A fault that UDP cannot have.
        std::erase(faults, Fault::refuses);
    }

    std::unique_ptr<DeviceDriver> driver() override {
        return std::make_unique<NetworkDriver>(NetworkSettings{}, std::make_unique<Socket>(*this),
                                               [this] { return time.now_ns(); });
    }
    void live(double angle) override {
        NetworkPacket packet;
        packet.sequence = ++sequence_;
        packet.time_ns = static_cast<std::uint64_t>(time.now_ns());
        packet.last = std::exchange(ends_, false);
        packet.vectors[0] = 0.02 * glm::dvec3(std::cos(angle), std::sin(angle), 0);
        const glm::dvec3 none(std::nan(""));
        line.tell(encode(packet), packet.last ? none : packet.vectors[0]);
        if (!std::exchange(intrudes_, false)) return;
        packet.sequence += 1000;
        packet.vectors[0] = glm::dvec3(0.1);
        intruders_ = encode(packet);
    }
    void suffer_its_own() override {
        (chance() % 2 == 0 ? ends_ : intrudes_) = true;
        if (chance() % 4 == 0) line.begin(Fault::refuses, VirtualTime::ms);
    }

private:
    class Socket final : public DatagramSocket {
    public:
        explicit Socket(FaultyNetwork& network) : network_(network), descriptor_(eventfd(1, EFD_CLOEXEC)) {}
        ~Socket() override { ::close(descriptor_); }
        Result<void> bind(const std::string&, std::uint16_t) override {
            open_ = true;
            return {};
        }
        void close() override { open_ = false; }
        int descriptor() const override { return open_ ? descriptor_ : -1; }
        std::uint16_t port() const override { return 5710; }
        std::optional<std::size_t> receive(std::span<std::byte> room, UdpAddress& from) override {
            std::optional<FaultyLine::Message> came = std::exchange(network_.intruders_, std::nullopt);
            from = hand_at(came ? 2 : 1);
            if (came && settled_) came.reset();  // the system keeps it away
            if (!came) {
                came = network_.line.next(std::chrono::microseconds(0));
                from = hand_at(1);
            }
            if (!came) return std::nullopt;
            const std::size_t bytes = std::min(room.size(), came->size());
            std::copy_n(came->begin(), bytes, room.begin());
            return bytes;
        }
        /// A network that is cut says nothing of it.
        bool send(std::span<const std::byte> datagram) override {
            const auto packet = decode_network_packet(datagram);
            EXPECT_TRUE(packet);
            if (!network_.line.passes()) return network_.line.fault() == Fault::unplugged;
            network_.line.went_out(packet ? glm::length(packet->vectors[0]) : 1e9);
            return true;
        }
        Result<void> settle(const std::optional<UdpAddress>& peer) override {
            settled_ = peer.has_value();
            return {};
        }

    private:
        FaultyNetwork& network_;
        const int descriptor_;  // readable always
        bool open_ = false, settled_ = false;
    };

    std::uint32_t sequence_ = 0xffffff00;  // comes round soon
    bool ends_ = false, intrudes_ = false;
    std::optional<FaultyLine::Message> intruders_;
};

TEST(NetworkFaults, NeverCauseUnsafeForce) {
    FaultyNetwork network;
    run_fault_sessions(network);
}

TEST(NetworkFaults, ForceReturnsAfterShortSilence) {
    FaultyNetwork network;
    expect_force_after_silence(network);
}

// A hand in closed loop through real sockets, in virtual time: it rests up to the stiffness that theory says
// of its delay (docs/measurements.md), and shakes beyond.

constexpr double period_s = 0.001;

/// A handle in a hand behind a socket: tells where it is, and is pushed by the newest force that has come.
class FarHand {
public:
    FarHand(std::uint16_t port, const HandleDynamics& dynamics)
        : handle_(dynamics, period_s), socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
        const sockaddr_in to = loopback(port);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    }
    ~FarHand() { ::close(socket_); }
    FarHand(const FarHand&) = delete;
    FarHand& operator=(const FarHand&) = delete;

    HeldHandle& handle() { return handle_; }
    void tell() {
        NetworkPacket packet;
        packet.sequence = ++sequence_;
        packet.vectors[0] = handle_.reading();
        const auto bytes = encode(packet);
        ASSERT_EQ(::send(socket_, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    }
    /// The force that answers what was told last.
    glm::dvec3 hear() {
        std::byte room[1024];
        for (pollfd waited_for{socket_, POLLIN, 0}; poll(&waited_for, 1, 2000) == 1;) {
            const auto came = recv(socket_, room, sizeof room, 0);
            const auto packet = decode_network_packet(std::span(room).first(static_cast<std::size_t>(came)));
            if (packet && packet->sequence == sequence_) force_ = packet->vectors[0];
            if (packet && packet->sequence == sequence_ && poll(&waited_for, 1, 0) == 0) return force_;
        }
        ADD_FAILURE() << "no answer";
        return force_;
    }

private:
    HeldHandle handle_;
    int socket_;
    std::uint32_t sequence_ = 0;
    glm::dvec3 force_{0.0};
};

class NetworkLoop : public testing::Test {
protected:
    /// The ratio of its swings in the last tenth of a second to those after the nudge.
    double growth(double stiffness, std::size_t delay_ticks) {
        const std::uint16_t port = unused_port();
        std::int64_t now = 1;
        DrivenDevice device(std::make_unique<NetworkDriver>(NetworkSettings{
                                .listen = "127.0.0.1", .port = port, .fingers = 1, .limits = {1e6, 1e6}}),
                            {.clock = [&] { return now; }, .own_thread = false});
        EXPECT_TRUE(device.open());
        FarHand hand(port, {.mass = 0.5, .damping = 5, .friction = 0, .quantum = 0, .hand_stiffness = 300});
        const double rest = -3 / stiffness;  // deep where the wall pushes back with 3 N
        hand.handle().put({0, 0, rest}, {0, 0, -0.0005});
        hand.handle().intend({0, 0, rest - 3.0 / 300});
        std::deque<glm::dvec3> under_way(delay_ticks, glm::dvec3(0, 0, 3));
        double early = 0, late = 0;
        // The force rises first; the handle is held meanwhile.
        for (int tick = -120; tick < 400; ++tick) {
            now += 1'000'000;
            hand.tell();
            for (int tries = 0; tries < 1000 && device.facts().samples == tick + 120; ++tries) {
                if (tries > 0) usleep(1000);  // what was told comes a moment later where the machine is busy
                device.turn();
            }
            glm::dvec3 place;
            EXPECT_TRUE(device.read_positions(std::span(&place, 1)));
            EXPECT_TRUE(std::isfinite(place.z)) << "tick " << tick;
            const glm::dvec3 wall(0, 0, std::max(0.0, -place.z * stiffness));
            EXPECT_TRUE(device.write_forces(std::span(&wall, 1)));
            device.turn();  // it speaks
            under_way.push_back(hand.hear());
            if (tick >= 0) hand.handle().advance(under_way.front());
            under_way.pop_front();
            if (tick < 0) continue;
            const double away = std::abs(hand.handle().place().z - rest);
            (tick < 100 ? early : late) =
                std::max(tick < 100 || tick >= 300 ? away : 0.0, tick < 100 ? early : late);
            if (HasFatalFailure()) return 0;
        }
        device.close();
        return late / early;
    }
};

TEST_F(NetworkLoop, ShakesOnlyBeyondTheoreticalBoundary) {
    for (const std::size_t delay : {0U, 1U, 2U}) {
        const double boundary =
            5 / (period_s / 2 + static_cast<double>(delay) * period_s);  // Gil et al. 2009
        EXPECT_LT(growth(0.8 * boundary, delay), 0.9) << delay << " ticks late, " << 0.8 * boundary << " N/m";
        EXPECT_GT(growth(1.2 * boundary, delay), 1.2) << delay << " ticks late, " << 1.2 * boundary << " N/m";
    }
}

std::vector<std::byte> bytes_of(std::string_view hex) {
    std::vector<std::byte> bytes;
    for (std::size_t at = 0; at + 1 < hex.size(); at += 2)
        bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(at, 2)), nullptr, 16)));
    return bytes;
}

// By Python: struct.pack("<4sBBBBIIQ3d", b"TCHD", 1, 1, 1, 0, 0x01020304, 5, 0x1122334455667788, 0.5, -0.25,
// 0.125) and zlib.crc32 of it, "<I"; the second one with two fingers, kind 2, flags 1.
const auto places = bytes_of(
    "544348440101010004030201050000008877665544332211000000000000e03f000000000000d0bf000000000000c03f"
    "9d2bdd51");
const auto forces = bytes_of(
    "544348440102020107000000000000000900000000000000000000000000f03f00000000000000400000000000000840"
    "00000000000010c000000000000000009a9999999999b93fe59c275e");

TEST(NetworkPacket, EncodesKnownBytes) {
    NetworkPacket packet;
    packet.sequence = 0x01020304;
    packet.buttons = 5;
    packet.time_ns = 0x1122334455667788;
    packet.vectors[0] = {0.5, -0.25, 0.125};
    EXPECT_EQ(encode(packet), places);
    packet = {.kind = NetworkPacket::Kind::forces,
              .sequence = 7,
              .buttons = 0,
              .time_ns = 9,
              .last = true,
              .fingers = 2,
              .vectors = {}};
    packet.vectors[0] = {1, 2, 3};
    packet.vectors[1] = {-4, 0, 0.1};
    EXPECT_EQ(encode(packet), forces);
}

TEST(NetworkPacket, DecodesKnownBytes) {
    const auto packet = decode_network_packet(places);
    ASSERT_TRUE(packet) << packet.error().message;
    EXPECT_EQ(packet->kind, NetworkPacket::Kind::places);
    EXPECT_EQ(packet->sequence, 0x01020304U);
    EXPECT_EQ(packet->buttons, 5U);
    EXPECT_EQ(packet->time_ns, 0x1122334455667788U);
    EXPECT_FALSE(packet->last);
    EXPECT_EQ(packet->fingers, 1);
    EXPECT_EQ(packet->vectors[0], glm::dvec3(0.5, -0.25, 0.125));
    const auto last = decode_network_packet(forces);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->kind, NetworkPacket::Kind::forces);
    EXPECT_TRUE(last->last);
    EXPECT_EQ(last->vectors[1], glm::dvec3(-4, 0, 0.1));
}

TEST(NetworkPacket, RejectsCutsAndBitFlips) {
    for (const auto& whole : {places, forces}) {
        for (std::size_t length = 0; length < whole.size(); ++length)
            EXPECT_FALSE(decode_network_packet(std::span(whole).first(length))) << length;
        auto longer = whole;
        longer.push_back(std::byte{0});
        EXPECT_FALSE(decode_network_packet(longer));
        for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
            auto changed = whole;
            changed[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
            EXPECT_FALSE(decode_network_packet(changed)) << "bit " << bit;
        }
    }
}

TEST(NetworkPacket, RejectsOtherVersionByName) {
    auto newer = places;
    newer[4] = std::byte{2};
    EXPECT_NE(decode_network_packet(newer).error().message.find("version 2"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
