// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/recorded_device.hpp"

#include <cmath>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- Logs

enum LogColumn { log_time, log_finger, log_x, log_y, log_z, log_buttons };
constexpr std::array<const char*, 6> log_columns{"time_s", "finger", "x", "y", "z", "buttons"};

using LogValues = std::array<std::vector<double>, log_columns.size()>;

Error log_fault(const CsvTable& table, std::size_t row, LogColumn column, const std::string& what) {
    return input_error(table.place(row) + ", column '" + log_columns[column] + "' " + what);
}

Result<LogValues> log_values(const CsvTable& table) {
    LogValues values;
    for (std::size_t at = 0; at < log_columns.size(); ++at) {
        if (!table.names(log_columns[at]))
            return input_error(table.file() + ": line 1 names no column '" + log_columns[at] +
                               "'; a device's log has time_s, finger, x, y, z, buttons");
        TRY_ASSIGN(const auto column, table.column(log_columns[at]));
        const bool a_place = at == log_x || at == log_y || at == log_z;
        TRY_ASSIGN(values[at], table.numbers(column, a_place));
    }
    return values;
}

/// Fingers of a tick: the rows with the first row's time.
Result<int> log_fingers(const CsvTable& table, const LogValues& values) {
    std::size_t fingers = 1;
    while (fingers < table.rows() && values[log_time][fingers] == values[log_time][0]) ++fingers;
    if (fingers <= DeviceSample::most_fingers) return static_cast<int>(fingers);
    return log_fault(table, DeviceSample::most_fingers, log_time, "has the same time in more than ten rows");
}

Result<void> check_log_row(const CsvTable& table, const LogValues& values, std::size_t row,
                           std::size_t fingers) {
    const std::size_t finger = row % fingers;
    if (values[log_finger][row] != static_cast<double>(finger))
        return log_fault(table, row, log_finger,
                         "is " + trimmed_number(values[log_finger][row]) + "; must be " +
                             std::to_string(finger) + ", as each tick has " + std::to_string(fingers));
    const double time = values[log_time][row];
    if (finger > 0 && time != values[log_time][row - 1])
        return log_fault(table, row, log_time, "has another time than the tick's first finger");
    if (finger == 0 && row > 0 && !(time > values[log_time][row - 1]))
        return log_fault(table, row, log_time, "is not later than the tick before");
    if (time - values[log_time][0] > 1e6)
        return log_fault(table, row, log_time, "is more than a million seconds after the first");
    const double buttons = values[log_buttons][row];
    if (!(buttons >= 0 && buttons <= std::numeric_limits<std::uint32_t>::max()) ||
        std::floor(buttons) != buttons)
        return log_fault(table, row, log_buttons, "is no whole number from 0 to 4294967295");
    const bool empty = std::isnan(values[log_x][row]);
    for (const LogColumn column : {log_y, log_z})
        if (std::isnan(values[column][row]) != empty)
            return log_fault(
                table, row, column,
                std::string(empty ? "is not empty while others are" : "is empty while others are not") +
                    "; a place has x, y and z or none");
    return {};
}

// ---- Replay

using std::chrono::nanoseconds;

/// The machine's monotonic clock.
class SteadyReplayClock final : public ReplayClock {
public:
    nanoseconds now() override { return std::chrono::steady_clock::now().time_since_epoch(); }
    void wait_until(nanoseconds moment) override {
        std::this_thread::sleep_until(std::chrono::steady_clock::time_point(moment));
    }
};

constexpr std::array<KeyedValues::Key, 2> recorded_keys{{
    {"force", "N", 0.1, 1000, 10},
    {"stiffness", "N/mm", 0.01, 1000, 3},
}};

}  // namespace

// ---- Logs

Result<DeviceLog> DeviceLog::read(const std::string& file) {
    TRY_ASSIGN(const auto table, CsvTable::read(file));
    TRY_ASSIGN(const auto values, log_values(table));
    TRY_ASSIGN(const auto fingers, log_fingers(table, values));
    const auto each = static_cast<std::size_t>(fingers);
    for (std::size_t row = 0; row < table.rows(); ++row) TRY(check_log_row(table, values, row, each));
    if (table.rows() % each != 0)
        return log_fault(table, table.rows() - 1, log_finger, "is the last; its tick lacks fingers");
    DeviceLog log;
    log.fingers_ = fingers;
    for (std::size_t row = 0; row < table.rows(); ++row) {
        log.metres_.emplace_back(values[log_x][row], values[log_y][row], values[log_z][row]);
        if (row % each != 0) continue;
        log.seconds_.push_back(values[log_time][row] - values[log_time][0]);
        log.buttons_.push_back(static_cast<std::uint32_t>(values[log_buttons][row]));
    }
    return log;
}

// ---- Replay

/// Takes the newest tick whose time has come; missed ticks are skipped, as with a device.
Result<bool> ReplayDriver::receive(DeviceSample& sample, std::chrono::microseconds patience) {
    if (!connected_) return device_error("the replay of " + printable(file_) + " is closed");
    const nanoseconds until = clock_->now() + patience;
    if (next_ == log_.ticks()) {
        // The last tick's positions stay valid for 1 ms, until another tick would have come.
        if (over_) {
            clock_->wait_until(until);
            return false;
        }
        const nanoseconds end = time_of(next_ - 1) + std::chrono::milliseconds(1);
        clock_->wait_until(std::min(until, end));
        if (clock_->now() < end) return false;
        over_ = true;
        sample.metres.fill(no_place);
        sample.buttons = 0;
        return true;
    }
    if (time_of(next_) > clock_->now()) clock_->wait_until(std::min(until, time_of(next_)));
    const nanoseconds now = clock_->now();
    if (time_of(next_) > now) return false;
    while (next_ + 1 < log_.ticks() && time_of(next_ + 1) <= now) ++next_;
    sample = log_.sample(next_++);
    return true;
}

Result<std::unique_ptr<ReplayDriver>> read_recorded_device(std::string_view text,
                                                           std::unique_ptr<ReplayClock> clock) {
    const auto [name, pairs] = KeyedValues::file_and_pairs(text);
    const std::string file(name);
    if (file.empty())
        return usage_error("device 'recorded': no file is given; must be recorded:FILE with a device's log");
    TRY_ASSIGN(const auto given, KeyedValues::parse("device 'recorded'", pairs, recorded_keys));
    TRY_ASSIGN(auto log, DeviceLog::read(file));
    const DeviceLimits limits{given.number("force"), given.number("stiffness") * 1000};
    return std::make_unique<ReplayDriver>(file, std::move(log), limits, std::move(clock));
}

Result<std::unique_ptr<DeviceDriver>> make_recorded_driver(std::string_view text) {
    TRY_ASSIGN(auto driver, read_recorded_device(text, std::make_unique<SteadyReplayClock>()));
    return driver;
}

}  // namespace touchable
