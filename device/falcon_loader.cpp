#include "device/falcon_loader.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>

#include "engine/base/given_file.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

// 3 MHz over 312.5, 21 and 2.
constexpr std::uint16_t divisor_9600 = 0x4138, divisor_140000 = 0x15, divisor_1500000 = 2;
constexpr std::size_t block_bytes = 62;  // with the converter's two they fill a packet on the way back
constexpr std::size_t least_firmware = 1024, most_firmware = 65536;

constexpr std::array<std::byte, 3> greeting{std::byte{0x0a}, std::byte{0x43}, std::byte{0x0d}};
constexpr std::array<std::byte, 4> welcome{std::byte{0x0a}, std::byte{0x44}, std::byte{0x2c},
                                           std::byte{0x0d}};
constexpr std::array<std::byte, 1> begin_mark{std::byte{'A'}};

Error load_error(const std::string& what) {
    return {ErrorKind::device, "Novint Falcon: loading its firmware: " + what};
}

Result<void> command_all(FtdiTransport& transport, std::initializer_list<FtdiCommand> commands) {
    for (const FtdiCommand& each : commands)
        if (auto done = transport.command(each); !done.ok()) return done;
    return {};
}

/// Up to `room` bytes that come within `patience`; fewer where they do not.
Result<std::size_t> gather(FtdiTransport& transport, std::span<std::byte> room, milliseconds patience,
                           const GivenUp& given_up) {
    const std::int64_t until = transport.now_ns() + std::chrono::nanoseconds(patience).count();
    std::size_t filled = 0;
    while (filled < room.size()) {
        if (given_up()) return Error{ErrorKind::interrupted, "loading the Falcon's firmware was given up"};
        const microseconds left((until - transport.now_ns()) / 1000);
        if (left.count() <= 0) break;
        TRY_ASSIGN(const auto came,
                   transport.receive(room.subspan(filled), std::min<microseconds>(left, milliseconds(30))));
        filled += came;
    }
    return filled;
}

/// It may put a zero before its answer, and may not hear the first greetings.
Result<void> greet(FtdiTransport& transport, milliseconds patience, const GivenUp& given_up) {
    constexpr int most_greetings = 30;
    for (int greetings = 0; greetings < most_greetings; ++greetings) {
        if (auto sent = transport.send(greeting); !sent.ok()) return sent;
        std::array<std::byte, 16> room;
        std::size_t filled = 0;
        for (bool more = true; more && filled < room.size();) {
            TRY_ASSIGN(const auto came,
                       gather(transport, std::span(room).subspan(filled, 1), patience, given_up));
            more = came > 0;
            filled += came;
            const auto received = std::span(room).first(filled);
            if (std::search(received.begin(), received.end(), welcome.begin(), welcome.end()) !=
                received.end())
                return {};
        }
    }
    return load_error("it does not answer; pull its power plug, wait ten seconds and put it in again");
}

Result<void> send_and_compare(FtdiTransport& transport, std::span<const std::byte> bytes,
                              const std::string& what, milliseconds patience, const GivenUp& given_up) {
    if (auto sent = transport.send(bytes); !sent.ok()) return sent;
    std::array<std::byte, block_bytes> room;
    const auto echo = std::span(room).first(bytes.size());
    TRY_ASSIGN(const auto came, gather(transport, echo, patience, given_up));
    if (came < bytes.size())
        return load_error(what + ": " + std::to_string(came) + " of " + std::to_string(bytes.size()) +
                          " bytes came back");
    if (!std::ranges::equal(bytes, echo)) return load_error(what + " came back changed");
    return {};
}

}  // namespace

Result<std::vector<std::byte>> read_falcon_firmware(const std::string& path) {
    const std::string named = "the Falcon's firmware " + printable(path);
    constexpr const char* right = "the image, which docs/devices.md says where an owner finds";
    TRY_ASSIGN(auto file, GivenFile::open(path, named, right));
    if (file.size() < least_firmware || file.size() > most_firmware)
        return input_error(named + ": has " + std::to_string(file.size()) +
                           " bytes; right would be the image, of 7 to 9 thousand");
    std::vector<std::byte> bytes(static_cast<std::size_t>(file.size()));
    if (auto read = file.read(0, reinterpret_cast<char*>(bytes.data()), bytes.size()); !read)
        return error_at(named, read.error());
    return bytes;
}

Result<void> load_falcon_firmware(FtdiTransport& transport, std::span<const std::byte> firmware,
                                  const FalconPatience& patience, const GivenUp& given_up) {
    if (auto purged = transport.purge(); !purged.ok()) return purged;
    // Packets must not be cut by a short latency here, or greetings fail.
    auto begun =
        command_all(transport, {ftdi_latency(milliseconds(16)), ftdi_divisor(divisor_9600), ftdi_eight_bits(),
                                ftdi_no_flow_control(), ftdi_rts(false), ftdi_dtr(false), ftdi_dtr(true)});
    if (!begun.ok()) return begun;
    if (auto greeted = greet(transport, patience.greeting, given_up); !greeted.ok()) return greeted;
    begun = command_all(transport, {ftdi_dtr(false), ftdi_divisor(divisor_140000)});
    if (!begun.ok()) return begun;
    // A greeting that was answered late has a second answer on its way.
    if (auto purged = transport.purge(); !purged.ok()) return purged;
    if (auto marked =
            send_and_compare(transport, begin_mark, "the mark that begins it", patience.echo, given_up);
        !marked.ok())
        return marked;
    const std::size_t blocks = (firmware.size() + block_bytes - 1) / block_bytes;
    for (std::size_t block = 0; block < blocks; ++block) {
        const auto rest = firmware.subspan(block * block_bytes);
        const std::string what = "block " + std::to_string(block + 1) + " of " + std::to_string(blocks);
        auto sent = send_and_compare(transport, rest.first(std::min(rest.size(), block_bytes)), what,
                                     patience.echo, given_up);
        if (!sent.ok()) return sent;
    }
    return {};
}

Result<void> begin_falcon_run(FtdiTransport& transport) {
    auto begun = command_all(transport, {ftdi_latency(milliseconds(1)), ftdi_divisor(divisor_1500000)});
    if (!begun.ok()) return begun;
    return transport.purge();
}

}  // namespace touchable
