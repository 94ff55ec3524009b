#include "bench/beside/places.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>

#include "bench/touch/noisy_scene.hpp"
#include "engine/base/files.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/content/families.hpp"

namespace touchable {
namespace {

constexpr double metre = 1000;  // of the scene's units

/// The fields of a line between commas or blanks.
std::vector<std::string_view> fields_of(std::string_view line) {
    std::vector<std::string_view> fields;
    while (!(line = trimmed(line, " \t\r,")).empty()) {
        fields.push_back(line.substr(0, line.find_first_of(" \t\r,")));
        line.remove_prefix(fields.back().size());
    }
    return fields;
}

Result<void> write_text(const std::filesystem::path& path, const std::string& text) {
    NewFile file(path);
    std::ofstream(file.path()) << text;
    return file.commit();
}

/// A line "x,y,z,nx,ny,nz", then a place a line.
std::string places_csv(const std::vector<BesidePlace>& places) {
    std::string text = "x,y,z,nx,ny,nz\n";
    for (const auto& [tip, outward] : places)
        text += formatted("%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n", tip.x, tip.y, tip.z, outward.x, outward.y,
                          outward.z);
    return text;
}

/// The forces (newtons) of another program: a line "x y z fx fy fz", then a line for each place, in order;
/// commas or blanks. 0 0 0: no contact. An error names the file and the line.
Result<std::vector<glm::dvec3>> read_forces(const std::filesystem::path& file,
                                            const std::vector<BesidePlace>& places) {
    constexpr double same_place = 1e-6;  // metres
    TRY_ASSIGN(const auto text, read_given_file(file, file.string(), "lines of x y z fx fy fz", 1 << 24));
    const auto refuse = [&](std::size_t line, const std::string& what) {
        return input_error(file.string() + ": line " + std::to_string(line) + " " + what);
    };
    std::string_view rest = text;
    if (!std::ranges::equal(fields_of(cut_line(rest)), std::array{"x", "y", "z", "fx", "fy", "fz"}))
        return refuse(1, "must be x y z fx fy fz: metres, newtons");
    std::vector<glm::dvec3> forces;
    for (std::size_t line = 2; !trimmed(rest, " \t\r\n").empty(); ++line) {
        std::vector<double> numbers;
        for (const std::string_view field : fields_of(cut_line(rest)))
            numbers.push_back(parsed_number(field).value_or(std::nan("")));
        if (numbers.size() != 6 || !std::ranges::all_of(numbers, [](double n) { return std::isfinite(n); }))
            return refuse(line, "must be six numbers");
        if (forces.size() == places.size() ||
            glm::distance(places[forces.size()].tip, {numbers[0], numbers[1], numbers[2]}) > same_place)
            return refuse(line, "is not of the place of that line in the places' file");
        forces.emplace_back(numbers[3], numbers[4], numbers[5]);
    }
    if (forces.size() == places.size()) return forces;
    return input_error(file.string() + ": has " + std::to_string(forces.size()) + " places: must have " +
                       std::to_string(places.size()));
}

}  // namespace

std::vector<BesidePlace> beside_places() {
    constexpr int side = 40;
    constexpr double reach = 60, deep = 0.5;
    std::vector<BesidePlace> places;
    for (int k = 0; k < side * side; ++k) {
        // The rows are shifted, so that no place repeats a grid's phase.
        const int column = k % side, row = k / side;
        const double x = reach * (2 * (column + 0.37 * (row % 3)) / side - 1),
                     y = reach * (2.0 * row / side - 1);
        const ReliefPoint s = relief_at(Relief::bumps, x, y, 0);
        const glm::dvec3 outward = glm::normalize(glm::dvec3(-s.zx, -s.zy, 1));
        places.push_back({(glm::dvec3(x, y, s.z) - deep * outward) / metre, outward});
    }
    return places;
}

void add_angles(const std::vector<BesidePlace>& places, const std::vector<glm::dvec3>& forces,
                const std::string& suffix, Figures& figures) {
    double squares = 0, touching = 0;
    for (std::size_t k = 0; k < places.size(); ++k) {
        if (glm::length(forces[k]) == 0) continue;
        const double angle = degrees_between(forces[k], places[k].outward);
        squares += angle * angle;
        ++touching;
    }
    figures.push_back(
        {"force_angle_deg_rms" + suffix, touching > 0 ? std::sqrt(squares / touching) : 180, "deg"});
    figures.push_back(
        {"contact_lost_pct" + suffix, 100 * (1 - touching / static_cast<double>(places.size())), "%"});
}

Result<void> write_exchange(const std::filesystem::path& folder, const std::string& name, int side,
                            double noise_mm) {
    constexpr double reach = 100;
    SplitMix64 random(mix64(static_cast<std::uint64_t>(side)));
    std::string heights =
        "columns,rows,left,right,bottom,top\n" + formatted("%d,%d,%g,%g,%g,%g\n", side, side, -reach / metre,
                                                           reach / metre, -reach / metre, reach / metre);
    const auto at = [&](int k) { return reach * (2.0 * k / (side - 1) - 1); };
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const double z = relief_at(Relief::bumps, at(column), at(row), 0).z +
                             (noise_mm > 0 ? noise_mm * normal(random) : 0);
            heights += formatted("%.9g%c", z / metre, column + 1 < side ? ',' : '\n');
        }
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    TRY(write_text(folder / (name + ".places.csv"), places_csv(beside_places())));
    return write_text(folder / (name + ".heights.csv"), heights);
}

Result<void> add_columns(const std::filesystem::path& folder, const std::string& name, Figures& figures) {
    const std::string begin = name + '.', end = ".forces.csv";
    std::vector<std::filesystem::path> files;
    std::error_code failure;
    for (const auto& entry : std::filesystem::directory_iterator(folder, failure)) {
        const std::string file = entry.path().filename().string();
        if (file.starts_with(begin) && file.ends_with(end) && file.size() > begin.size() + end.size())
            files.push_back(entry.path());
    }
    std::ranges::sort(files);
    const auto places = beside_places();
    for (const auto& file : files) {
        const std::string all = file.filename().string(),
                          program = all.substr(begin.size(), all.size() - begin.size() - end.size());
        TRY_ASSIGN(const auto forces, read_forces(file, places));
        add_angles(places, forces, '_' + program, figures);
    }
    return {};
}

}  // namespace touchable
