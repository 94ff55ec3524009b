// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs of the program that make and touch, and what they leave: reports, forces, recordings.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/player/program.hpp"

namespace touchable::test {

/// Makes a clip of a generated scene, over an earlier one; fails the test where that goes wrong.
void make_clip(const std::string& scene, const std::string& file, const Words& more);
/// A clip's scene file.
nlohmann::json scene_of(const std::string& clip);
/// Writes a motion of 1 s that zigzags over the picture, in and out of what is there, and gives the hand that
/// repeats it. It knows nothing of the ground, so that it meets walls as well.
std::string zigzag_hand(const std::string& file);

/// True where the machine stood still, or had other work, for a quarter of a live run and more: forces are
/// missing. Nothing is to be learned of such a run, and it is run again.
inline bool stood_still(const nlohmann::json& report) {
    if (!report.is_object() || !report.contains("skipped_ticks")) return false;
    return report["skipped_ticks"].get<double>() > 0.25 * report["ticks"].get<double>();
}

/// So many standstills in a row are no chance any more: the last run counts.
inline constexpr int most_standstills = 8;

/// Runs `touchable touch` with these words and --overwrite, which must succeed, and gives what --json wrote.
nlohmann::json touch(const Words& words);
/// Its force_hash.
std::string force_hash(const Words& words);

/// A row of --forces, read by its column names alone.
struct ForcesRow {
    std::vector<double> cells;
    double operator[](const std::string& column) const;
    std::array<double, 3> vector(const std::string& name) const;  ///< name_x, name_y, name_z
};
/// Columns in the order that is promised.
const std::vector<std::string>& forces_columns();
/// Fails the test where the header or a row is not as promised.
std::vector<ForcesRow> read_forces(const std::string& file);

double length(const std::array<double, 3>& v);

/// A camera that the program touches live, and its recording.
class TouchedCamera : public ::testing::Test {
protected:
    /// The run's report; again where the machine stood still.
    nlohmann::json touch(Words words) const {
        words.insert(words.begin(), "touch");
        words.insert(words.end(), {"--overwrite", "--verbose", "--json", report});
        nlohmann::json read;
        for (int go = 0; go == 0 || (stood_still(read) && go < most_standstills); ++go) {
            const Outcome outcome = run_touchable(words);
            EXPECT_EQ(outcome.code, 0) << outcome.err;
            said = outcome.out;
            read = nlohmann::json::parse(file_contents(report), nullptr, false);
        }
        return read;
    }

    const TemporaryFolder folder;
    const std::string record = folder / "live.rec", report = folder / "r.json";
    mutable std::string said;
};

/// A recording's bytes to look into and to change, by the layout of docs/touch.md and not by the code
/// under test. Offsets are from the file's beginning.
class RecordingBytes {
public:
    explicit RecordingBytes(std::string bytes) : bytes_(std::move(bytes)) {}
    const std::string& bytes() const { return bytes_; }

    std::size_t fingers() const { return integer(12, 4); }
    std::size_t ticks() const { return integer(bytes_.size() - 16, 8); }
    std::size_t time_at(std::size_t tick) const { return 16 + tick * (head_size() + 52 * fingers()); }
    std::size_t blend_at(std::size_t tick) const { return time_at(tick) + 24; }
    /// Not in format 1, as the commands.
    std::size_t epoch_at(std::size_t tick) const { return time_at(tick) + 32; }
    std::size_t goal_at(std::size_t tick, std::size_t finger) const {
        return time_at(tick) + head_size() + 52 * finger;
    }
    std::size_t command_at(std::size_t command) const { return time_at(ticks()) + 28 * command; }
    std::size_t force_at(std::size_t tick, std::size_t finger) const { return goal_at(tick, finger) + 24; }
    std::size_t guard_at(std::size_t tick, std::size_t finger) const { return goal_at(tick, finger) + 48; }

    std::uint64_t integer(std::size_t at, std::size_t size) const;
    double real(std::size_t at) const;
    nlohmann::ordered_json facts() const;

    // Each leaves a recording whose hash is right.
    void set_integer(std::size_t at, std::size_t size, std::uint64_t value);
    void set_real(std::size_t at, double value);
    void set_facts(const std::string& text);
    /// The first `count` ticks alone.
    void keep_ticks(std::size_t count);

private:
    /// Size of a tick's head, before its fingers.
    std::size_t head_size() const { return integer(8, 4) == 1 ? 32 : 40; }
    void put(std::size_t at, std::size_t size, std::uint64_t value);
    void seal();
    std::string bytes_;
};

}  // namespace touchable::test
