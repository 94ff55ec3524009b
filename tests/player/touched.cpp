// SPDX-License-Identifier: Apache-2.0
#include "tests/player/touched.hpp"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/player/program.hpp"

namespace touchable::test {

void make_clip(const std::string& scene, const std::string& file, const Words& more) {
    succeed(plus({"make", scene, file, "--overwrite"}, more));
}

nlohmann::json scene_of(const std::string& clip) {
    const TemporaryFolder folder;
    succeed({"export", clip, "--frame", "0", "--out", folder / "out"});
    return json_in(folder / "out/scene.json");
}

std::string zigzag_hand(const std::string& file) {
    std::ofstream rows(file);  // tenths of a millimetre, 50 rows/s
    for (int k = 0; k <= 50; ++k)
        rows << std::abs(70 * k % 1000 - 500) << ',' << std::abs((30 * k + 200) % 600 - 300) << ','
             << std::abs(11 * k % 40 - 20) << '\n';
    return "csv:" + file + ":columns=1+2+3,rate=50,scale=0.0001,contact=0.8";
}

nlohmann::json touch(const Words& more) {
    const TemporaryFolder folder;
    Words words = plus({"touch", "--overwrite", "--json", folder / "report.json"}, more);
    nlohmann::json report;
    for (int go = 0; go == 0 || (stood_still(report) && go < most_standstills); ++go) {
        succeed(words);
        report = json_in(folder / "report.json");
    }
    return report;
}

std::string force_hash(const Words& words) {
    return touch(words).value("force_hash", "none");
}

double ForcesRow::operator[](const std::string& column) const {
    const auto& columns = forces_columns();
    const auto found = std::find(columns.begin(), columns.end(), column);
    return cells.at(static_cast<std::size_t>(found - columns.begin()));
}

std::array<double, 3> ForcesRow::vector(const std::string& name) const {
    return {(*this)[name + "_x"], (*this)[name + "_y"], (*this)[name + "_z"]};
}

const std::vector<std::string>& forces_columns() {
    static const std::vector<std::string> columns{
        "tick",    "time_s",    "finger",    "goal_x",     "goal_y",     "goal_z",        "proxy_x",
        "proxy_y", "proxy_z",   "force_x",   "force_y",    "force_z",    "contact",       "pixel_x",
        "pixel_y", "stiffness", "mu_static", "mu_dynamic", "frame_prev", "frame_next",    "blend",
        "guard",   "S",         "capped",    "share",      "hop",        "error_degrees", "error_newtons"};
    return columns;
}

std::vector<ForcesRow> read_forces(const std::string& file) {
    std::istringstream in(file_contents(file));
    std::string line, promised;
    for (const std::string& column : forces_columns()) promised += (promised.empty() ? "" : ",") + column;
    std::getline(in, line);
    EXPECT_EQ(line.substr(0, promised.size()), promised) << "columns may only be added";
    const auto columns = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
    std::vector<ForcesRow> rows;
    while (std::getline(in, line) && !::testing::Test::HasFailure()) {
        ForcesRow& row = rows.emplace_back();
        const char* at = line.c_str();
        for (std::size_t k = 0; k < columns; ++k) {
            char* end = nullptr;
            row.cells.push_back(std::strtod(at, &end));
            EXPECT_NE(end, at) << "no number in: " << line;
            EXPECT_EQ(*end, k + 1 < columns ? ',' : '\0') << line;
            at = *end ? end + 1 : end;
        }
    }
    return rows;
}

double length(const std::array<double, 3>& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

std::uint64_t RecordingBytes::integer(std::size_t at, std::size_t size) const {
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < size; ++k)
        value |= std::uint64_t{static_cast<std::uint8_t>(bytes_.at(at + k))} << (8 * k);
    return value;
}

double RecordingBytes::real(std::size_t at) const {
    return std::bit_cast<double>(integer(at, 8));
}

nlohmann::ordered_json RecordingBytes::facts() const {
    const std::size_t size = integer(bytes_.size() - 24, 8);
    return nlohmann::ordered_json::parse(bytes_.substr(bytes_.size() - 24 - size, size), nullptr, false);
}

void RecordingBytes::put(std::size_t at, std::size_t size, std::uint64_t value) {
    for (std::size_t k = 0; k < size; ++k) bytes_.at(at + k) = static_cast<char>(value >> (8 * k));
}

void RecordingBytes::seal() {
    put(bytes_.size() - 8, 8, XXH64(bytes_.data(), bytes_.size() - 8, 0));
}

void RecordingBytes::set_integer(std::size_t at, std::size_t size, std::uint64_t value) {
    put(at, size, value);
    seal();
}

void RecordingBytes::set_real(std::size_t at, double value) {
    set_integer(at, 8, std::bit_cast<std::uint64_t>(value));
}

void RecordingBytes::set_facts(const std::string& text) {
    const std::size_t size = integer(bytes_.size() - 24, 8);
    bytes_.replace(bytes_.size() - 24 - size, size, text);
    put(bytes_.size() - 24, 8, text.size());
    seal();
}

void RecordingBytes::keep_ticks(std::size_t count) {
    bytes_.erase(time_at(count), time_at(ticks()) - time_at(count));
    put(bytes_.size() - 16, 8, count);
    seal();
}

}  // namespace touchable::test
