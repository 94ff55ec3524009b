#include "player/run/device_tick_log.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/try.hpp"
#include "player/run/csv_row.hpp"
#include "player/run/live_session.hpp"

namespace touchable {

DeviceTickLog::DeviceTickLog(int ticks, int fingers) : ring_(slots_for(ticks, fingers)) {}

std::vector<DeviceTickLog::Slot> DeviceTickLog::slots_for(int ticks, int fingers) {
    std::vector<Slot> slots(static_cast<std::size_t>(ticks));
    for (Slot& slot : slots) {
        slot.places.resize(static_cast<std::size_t>(fingers));
        slot.newtons.resize(static_cast<std::size_t>(fingers));
    }
    return slots;
}

void DeviceTickLog::push(const DeviceTick& tick) {
    const bool has_room = ring_.push([&tick](Slot& slot) {
        slot.tick = tick;
        std::copy(tick.places.begin(), tick.places.end(), slot.places.begin());
        std::copy(tick.newtons.begin(), tick.newtons.end(), slot.newtons.begin());
        slot.tick.places = slot.places;
        slot.tick.newtons = slot.newtons;
    });
    if (!has_room) lost_.fetch_add(1, std::memory_order_relaxed);
}

Result<std::unique_ptr<DeviceLogFile>> DeviceLogFile::create(const std::filesystem::path& file,
                                                             Existing existing, DeviceTickLog& log,
                                                             std::string name) {
    TRY_ASSIGN(auto out, OutputFile::create(std::move(name), file, existing, Pace::wall_clock));
    TRY(out->write("time_s,finger,x,y,z,buttons,age_ms,fx,fy,fz,force_on\n"));
    return std::unique_ptr<DeviceLogFile>(new DeviceLogFile(std::move(out), log));
}

Result<void> DeviceLogFile::write(const TouchTick&) {
    Result<void> written;
    const auto add = [this, &written](const DeviceTick& tick) {
        rows_.clear();
        for (std::size_t finger = 0; finger < tick.places.size(); ++finger) {
            CsvRow row(rows_);
            row << static_cast<double>(tick.tick) / 1000 << static_cast<std::int64_t>(finger);
            if (const glm::dvec3& place = tick.places[finger]; std::isfinite(place.x + place.y + place.z))
                row << place;
            else
                row.empty().empty().empty();
            row << std::int64_t{tick.buttons};
            if (std::isfinite(tick.age_s))
                row << tick.age_s * 1000;
            else
                row.empty();
            row << tick.newtons[finger] << std::int64_t{tick.exerts};
            row.end();
        }
        if (written.ok()) written = file_->write(rows_);
    };
    while (log_.pop(add)) {
    }
    return written;
}

Result<void> DeviceLogFile::finish() {
    if (!is_faulty())
        if (auto rest = take({}); !rest.ok()) return rest;
    if (!is_faulty() && log_.lost() > 0) return fell_behind_error(file_->name(), log_.lost());
    return file_->finish();
}

}  // namespace touchable
