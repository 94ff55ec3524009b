#include "player/run/force_table.hpp"

#include <algorithm>
#include <array>

#include "device/csv_table.hpp"
#include "engine/base/try.hpp"

namespace touchable {

namespace {

struct Column {
    enum { tick, finger, goal_x, goal_y, goal_z, force_x, force_y, force_z, contact, count };
};
constexpr std::array<const char*, Column::count> column_names{
    "tick", "finger", "goal_x", "goal_y", "goal_z", "force_x", "force_y", "force_z", "contact"};
constexpr double fingers_of_a_hand = 256;

using Columns = std::array<std::vector<double>, Column::count>;

Result<Columns> read_columns(const CsvTable& table) {
    Columns columns;
    for (std::size_t c = 0; c < Column::count; ++c) {
        if (!table.names(column_names[c]))
            return input_error(table.file() + ": has no column " + column_names[c] +
                                   "; right would be a file of forces that a run wrote",
                               {{Setting::forces}});
        TRY_ASSIGN(const auto at, table.column(column_names[c]));
        TRY_ASSIGN(auto values, table.numbers(at));
        columns[c] = std::move(values);
    }
    return columns;
}

}  // namespace

Result<ForceTable> read_force_table(const std::string& file) {
    TRY_ASSIGN(const auto table, CsvTable::read(file));
    TRY_ASSIGN(const auto columns, read_columns(table));
    const Columns& c = columns;
    ForceTable out;
    const double last_finger = *std::max_element(c[Column::finger].begin(), c[Column::finger].end());
    if (!(last_finger >= 0 && last_finger < fingers_of_a_hand))
        return input_error(file + ": its column finger goes to " + std::to_string(last_finger) +
                           "; right would be 0 to 255");
    out.fingers = static_cast<int>(last_finger) + 1;
    const std::size_t rows = table.rows(), fingers = static_cast<std::size_t>(out.fingers);
    out.samples.reserve(rows);
    for (std::size_t row = 0; row < rows; ++row) {
        const auto wanted_tick = static_cast<double>(row / fingers),
                   wanted_finger = static_cast<double>(row % fingers);
        if (c[Column::tick][row] != wanted_tick || c[Column::finger][row] != wanted_finger)
            return input_error(table.place(row) + ": is not finger " + std::to_string(row % fingers) +
                               " of tick " + std::to_string(row / fingers) +
                               "; right would be every finger of every tick, in order");
        out.samples.push_back({{c[Column::goal_x][row], c[Column::goal_y][row], c[Column::goal_z][row]},
                               {c[Column::force_x][row], c[Column::force_y][row], c[Column::force_z][row]},
                               c[Column::contact][row] != 0});
    }
    if (rows % fingers != 0)
        return input_error(file + ": its last tick lacks fingers; right would be " +
                           std::to_string(out.fingers));
    return out;
}

}  // namespace touchable
