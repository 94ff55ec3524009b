// What a Novint Falcon sends: its reports, and what it says while its firmware is loaded.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <memory>
#include <span>

#include "device/drivers/falcon_device.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// What a report leads to, up to the motors.
void require_bearable(const FalconReport& report) {
    require(report.buttons < 16, "a grip has more than four buttons");
    FalconAngles angles{};
    for (std::size_t arm = 0; arm < 3; ++arm) angles[arm] = falcon_angle(report.counts[arm]);
    const auto pose = falcon_pose(angles);
    if (!pose) return;
    require(glm::length(pose->place) <= falcon_edge + 1e-9, "a grip is beyond its reach");
    for (const glm::dvec3 force : {glm::dvec3(0, 0, 9), glm::dvec3(1e6, -1e6, 1e-6)})
        for (const std::int16_t word : falcon_motor_words(*pose, force))
            require(std::abs(word) <= falcon_largest_word, "a motor gets more than it may");
}

bool parse_falcon_reports(std::string_view bytes) {
    FalconReader reader;
    std::size_t reports = 0;
    for (const std::byte byte : std::as_bytes(std::span(bytes)))
        if (const auto report = reader.take(byte)) {
            ++reports;
            require_bearable(*report);
        }
    const auto begins = std::count(bytes.begin(), bytes.end(), '<');
    require(std::cmp_less_equal(reports, std::min(begins, std::count(bytes.begin(), bytes.end(), '>'))),
            "more reports than begin and end");
    require(reader.damaged() >= 0 && reader.damaged() <= std::ssize(bytes), "more is damaged than came");
    return reports > 0;
}

/// A converter whose packets are an input's, each with its length before it. Nobody waits: the clock goes on
/// where it has none.
class ToldPort final : public UsbPort {
public:
    ToldPort(std::string_view told, std::int64_t& now_ns) : told_(told), now_ns_(now_ns) {}
    Result<void> command(const FtdiCommand&) override { return {}; }
    Result<void> write(std::span<const std::byte>) override { return {}; }
    Result<std::size_t> read(std::span<std::byte> room, std::chrono::microseconds patience) override {
        now_ns_ += 1000;
        // What is thrown away unread would be lost to the conversation.
        if (patience.count() <= 0 || told_.rest().empty()) {
            now_ns_ += std::chrono::nanoseconds(patience).count();
            return std::size_t{0};
        }
        const std::size_t size = std::min<std::size_t>(told_.byte(), std::min(room.size(), packet_bytes));
        for (std::size_t k = 0; k < size; ++k) room[k] = static_cast<std::byte>(told_.byte());
        return size;
    }

private:
    Taken told_;
    std::int64_t& now_ns_;
};

constexpr const char* other_size = "a firmware of another size than it has";

bool parse_falcon_loading(std::string_view bytes) {
    const auto image = read_falcon_firmware(file_of(bytes, "firmware.bin").string());
    if (is_taken(image)) require(image->size() == bytes.size(), other_size);
    std::int64_t now_ns = 0;
    FtdiTransport transport(std::make_unique<ToldPort>(bytes, now_ns), [&now_ns] { return now_ns; });
    std::array<std::byte, 70> firmware;  // two blocks
    for (std::size_t k = 0; k < firmware.size(); ++k) firmware[k] = static_cast<std::byte>(k);
    const auto loaded = load_falcon_firmware(transport, firmware, {});
    require(loaded || loaded.error().kind == ErrorKind::device, "what a device says is no device's error");
    return is_taken(loaded);
}

const Registered falcon_report_target{
    {.name = "falcon_report", .parse = parse_falcon_reports, .most_bytes = 256, .most_live_mebibytes = 1}};
const Registered falcon_loading_target{{.name = "falcon_loading",
                                        .parse = parse_falcon_loading,
                                        .cuts_are_refused = true,
                                        .most_bytes = 2048,
                                        .most_live_mebibytes = 1}};

}  // namespace
}  // namespace touchable::fuzz
