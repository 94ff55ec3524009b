#include "tests/verify/forces_csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

namespace touchable::verify {
namespace {

constexpr std::array<std::string_view, 23> names = {
    "tick",       "finger",     "goal_x",     "goal_y",  "goal_z",  "proxy_x", "proxy_y",   "proxy_z",
    "force_x",    "force_y",    "force_z",    "contact", "pixel_x", "pixel_y", "stiffness", "mu_static",
    "mu_dynamic", "frame_prev", "frame_next", "blend",   "guard",   "S",       "capped"};

std::vector<std::string_view> split(std::string_view line) {
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    std::vector<std::string_view> cells;
    for (std::size_t start = 0;;) {
        const std::size_t comma = line.find(',', start);
        cells.push_back(line.substr(start, comma - start));
        if (comma == std::string_view::npos) return cells;
        start = comma + 1;
    }
}

}  // namespace

Error ForcesReader::fault(const std::string& what) const {
    return input_error(name_ + ": line " + std::to_string(line_) + ": " + what);
}

Result<ForcesReader> ForcesReader::open(const std::filesystem::path& file) {
    ForcesReader reader;
    reader.name_ = file.string();
    reader.stream_.open(file);
    std::string line;
    reader.line_ = 1;
    if (!reader.stream_ || !std::getline(reader.stream_, line))
        return input_error(reader.name_ + ": cannot be read: must be a file written by touch --forces");
    const auto header = split(line);
    reader.width_ = header.size();
    for (std::size_t k = 0; k < names.size(); ++k) {
        const auto found = std::find(header.begin(), header.end(), names[k]);
        if (found == header.end()) return reader.fault("there is no column " + std::string(names[k]));
        reader.position_[k] = static_cast<std::size_t>(found - header.begin());
    }
    const auto share = std::find(header.begin(), header.end(), "share");
    if (share != header.end()) reader.share_ = static_cast<std::size_t>(share - header.begin());
    return reader;
}

Result<bool> ForcesReader::next(ForceRow& row) {
    std::string line;
    if (!std::getline(stream_, line)) return false;
    ++line_;
    const auto cells = split(line);
    if (cells.size() != width_)
        return fault("has " + std::to_string(cells.size()) + " columns, the header " +
                     std::to_string(width_));
    const auto is_number = [](std::string_view cell, double& value) {
        const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
        return status == std::errc() && end == cell.data() + cell.size();
    };
    std::array<double, column_count> v{};
    for (std::size_t k = 0; k < column_count; ++k)
        if (const std::string_view cell = cells[position_[k]]; !is_number(cell, v[k]))
            return fault(std::string(names[k]) + " is \"" + std::string(cell) + "\": must be a number");
    double share = 1;
    if (share_ && !(is_number(cells[*share_], share) && share >= 0 && share <= 1))
        return fault("share must be between 0 and 1");
    auto whole = [&](std::size_t k, double most) {
        return v[k] >= 0 && v[k] <= most && v[k] == std::floor(v[k]);
    };
    for (const auto& [k, most] :
         {std::pair<std::size_t, double>{0, 1e15}, {1, 1e6}, {17, 1e15}, {18, 1e15}, {20, 4294967295.0}})
        if (!whole(k, most)) return fault(std::string(names[k]) + " must be a whole number, 0 or more");
    if (!(v[11] == 0 || v[11] == 1)) return fault("contact must be 0 or 1");
    if (!(v[22] == 0 || v[22] == 1)) return fault("capped must be 0 or 1");
    if (!(v[19] >= 0 && v[19] <= 1)) return fault("blend must be between 0 and 1");
    row = {line_,
           static_cast<std::int64_t>(v[0]),
           static_cast<int>(v[1]),
           {v[2], v[3], v[4]},
           {v[5], v[6], v[7]},
           {v[8], v[9], v[10]},
           v[11] != 0,
           v[12],
           v[13],
           v[14],
           v[15],
           v[16],
           static_cast<std::int64_t>(v[17]),
           static_cast<std::int64_t>(v[18]),
           v[19],
           v[20] != 0,
           (static_cast<std::uint32_t>(v[20]) & 96U) != 0,
           v[21],
           share,
           v[22] != 0};
    return true;
}

}  // namespace touchable::verify
