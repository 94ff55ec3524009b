#include "player/run/forces_file.hpp"

#include "engine/base/try.hpp"
#include "player/run/csv_row.hpp"

namespace touchable {

Result<std::unique_ptr<ForcesFile>> ForcesFile::create(const std::filesystem::path& file, Existing existing,
                                                       Pace pace, std::string name) {
    TRY_ASSIGN(auto out, OutputFile::create(std::move(name), file, existing, pace));
    constexpr std::string_view header =
        "tick,time_s,finger,goal_x,goal_y,goal_z,proxy_x,proxy_y,proxy_z,force_x,force_y,force_z,contact,"
        "pixel_x,pixel_y,stiffness,mu_static,mu_dynamic,frame_prev,frame_next,blend,guard,S,capped,share\n";
    TRY(out->write(header));
    return std::unique_ptr<ForcesFile>(new ForcesFile(std::move(out)));
}

Result<void> ForcesFile::write(const TouchTick& tick) {
    rows_.clear();
    for (std::size_t k = 0; k < tick.contacts.size(); ++k) {
        const Contact& contact = tick.contacts[k];
        CsvRow row(rows_);
        row << tick.tick << static_cast<double>(tick.time_ns) / 1e9 << static_cast<std::int64_t>(k)
            << contact.goal << contact.proxy << tick.sent(k) << std::int64_t{contact.touching}
            << contact.pixel_x << contact.pixel_y << contact.properties.stiffness
            << contact.properties.static_friction << contact.properties.dynamic_friction
            << tick.pair.prev.number << tick.pair.next.number << tick.blend
            << std::int64_t{tick.forces[k].reasons} << tick.metres_per_scene_unit
            << std::int64_t{contact.counts.capped} << tick.share(k);
        row.end();
    }
    return file_->write(rows_);
}

}  // namespace touchable
