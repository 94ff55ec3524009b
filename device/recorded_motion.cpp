#include "device/recorded_motion.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>

#include "device/csv_table.hpp"
#include "device/principal_axes.hpp"

namespace touchable {
namespace {

constexpr double ticks_per_second = 1000;
constexpr double longest_s = 3600;
constexpr double farthest = 10;  // device metres

/// Seconds of every row.
Result<std::vector<double>> row_times(const CsvTable& table, const MotionSettings& settings) {
    std::vector<double> times;
    if (settings.rate) {
        for (std::size_t row = 0; row < table.rows(); ++row) {
            times.push_back(static_cast<double>(row) / *settings.rate);
        }
    } else {
        if (!settings.time && !table.names("t_s")) {
            return input_error(table.file() +
                               ": has no column 't_s'; name the column of seconds by time=NAME, or "
                               "give rate=HZ");
        }
        const Result<std::size_t> column = table.column(settings.time.value_or("t_s"));
        if (!column) return column.error();
        Result<std::vector<double>> read = table.numbers(*column);
        if (!read) return read.error();
        times = std::move(*read);
    }
    if (times.size() < 2)
        return input_error(table.file() + ": has one row of data; a motion needs at least two");
    for (std::size_t row = 1; row < times.size(); ++row) {
        if (times[row] > times[row - 1]) continue;
        return input_error(table.place(row) +
                           ": time does not increase; expected seconds that grow from row to row");
    }
    if (!(times.back() - times.front() <= longest_s)) {
        return input_error(table.file() + ": lasts more than an hour; are its times in seconds?");
    }
    return times;
}

/// The named columns, row by row: one column in .z, three in .x .y .z.
Result<std::vector<glm::dvec3>> row_values(const CsvTable& table, const std::vector<std::string>& names) {
    std::vector<glm::dvec3> rows(table.rows(), glm::dvec3(0));
    for (std::size_t n = 0; n < names.size(); ++n) {
        const Result<std::size_t> column = table.column(names[n]);
        if (!column) return column.error();
        const Result<std::vector<double>> values = table.numbers(*column);
        if (!values) return values.error();
        const int axis = names.size() == 1 ? 2 : static_cast<int>(n);
        for (std::size_t row = 0; row < rows.size(); ++row) {
            if (std::fabs((*values)[row]) > 1e9) {
                return input_error(table.place(row) + ", column '" + names[n] +
                                   "': is beyond 1e9; expected a motion");
            }
            rows[row][axis] = (*values)[row];
        }
    }
    return rows;
}

std::vector<glm::dvec3> resample(const std::vector<double>& times, const std::vector<glm::dvec3>& rows) {
    // A last row that rounding puts a hair before its tick still counts as on it.
    const double ticks = std::floor((times.back() - times.front()) * ticks_per_second + 1e-6) + 1;
    std::vector<glm::dvec3> positions(static_cast<std::size_t>(ticks));
    std::size_t row = 0;
    for (std::size_t tick = 0; tick < positions.size(); ++tick) {
        const double time = times.front() + static_cast<double>(tick) / ticks_per_second;
        while (row + 2 < times.size() && times[row + 1] <= time) ++row;
        const double share = std::min(1.0, (time - times[row]) / (times[row + 1] - times[row]));
        positions[tick] = rows[row] + (rows[row + 1] - rows[row]) * share;
    }
    return positions;
}

glm::dvec3 extents(const std::vector<glm::dvec3>& positions, glm::dvec3& centre) {
    glm::dvec3 least = positions.front(), greatest = positions.front();
    for (const glm::dvec3& p : positions) {
        least = glm::min(least, p);
        greatest = glm::max(greatest, p);
    }
    centre = 0.5 * (least + greatest);
    return greatest - least;
}

/// Lays a motion in space flat before the person. Returns its larger in-plane extent.
double lay_flat(std::vector<glm::dvec3>& positions) {
    const glm::dmat3 rotation = principal_rotation(positions);
    for (glm::dvec3& p : positions) p = rotation * p;
    glm::dvec3 centre;
    const glm::dvec3 size = extents(positions, centre);
    for (glm::dvec3& p : positions) p -= centre;
    return std::max(size.x, size.y);
}

}  // namespace

Result<std::vector<glm::dvec3>> read_motion(const std::string& file, const MotionSettings& settings) {
    const Result<CsvTable> table = CsvTable::read(file);
    if (!table) return table.error();
    const Result<std::vector<glm::dvec3>> rows = row_values(*table, settings.columns);
    if (!rows) return rows.error();
    const Result<std::vector<double>> times = row_times(*table, settings);
    if (!times) return times.error();

    std::vector<glm::dvec3> positions = resample(*times, *rows);
    if (settings.in_scene) return positions;
    double scale = settings.scale;
    if (settings.columns.size() == 1) {
        scale = -scale;  // in is away from the person
    } else {
        const double in_plane = lay_flat(positions);
        if (settings.extent && !(in_plane > 0)) {
            return input_error(file +
                               ": does not move, so that extent= has nothing to scale; give scale= instead");
        }
        if (settings.extent) scale = *settings.extent / in_plane;
    }
    for (glm::dvec3& p : positions) {
        p *= scale;
        if (std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}) <= farthest) continue;
        return input_error(file + ": moves more than 10 m; give scale= as metres per unit of the columns");
    }
    return positions;
}

}  // namespace touchable
