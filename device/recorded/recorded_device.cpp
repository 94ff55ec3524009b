#include "device/recorded/recorded_device.hpp"

#include <array>

#include "device/hand_options.hpp"

namespace touchable {
namespace {

constexpr std::array<HandKey, 2> recorded_keys{{
    {"force", "N", 0.1, 1000, 10},
    {"stiffness", "N/mm", 0.01, 1000, 3},
}};

}  // namespace

Result<std::unique_ptr<ReplayDriver>> read_recorded_device(std::string_view text,
                                                           std::unique_ptr<ReplayClock> clock) {
    // A file's name may have colons; keys have an equals sign after the last one.
    const std::size_t colon = text.rfind(':');
    const bool keys = colon != text.npos && text.find('=', colon) != text.npos;
    const std::string file(keys ? text.substr(0, colon) : text);
    if (file.empty())
        return usage_error(
            "device 'recorded': no file is given; right would be recorded:FILE with a device's log");
    const auto given = HandOptions::parse("device 'recorded'",
                                          keys ? text.substr(colon + 1) : std::string_view(), recorded_keys);
    if (!given.ok()) return given.error();
    auto log = DeviceLog::read(file);
    if (!log.ok()) return log.error();
    const DeviceLimits limits{given->number("force"), given->number("stiffness") * 1000};
    return std::make_unique<ReplayDriver>(file, std::move(*log), limits, std::move(clock));
}

Result<std::unique_ptr<HapticDevice>> make_recorded_device(std::string_view text,
                                                           const DrivenSettings& driven) {
    auto driver = read_recorded_device(text, steady_replay_clock());
    if (!driver.ok()) return driver.error();
    return std::unique_ptr<HapticDevice>(std::make_unique<DrivenDevice>(std::move(*driver), driven));
}

}  // namespace touchable
