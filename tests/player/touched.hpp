#pragma once

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/player/program.hpp"
#include "tests/player/standstill.hpp"

namespace touchable::test {

/// Makes a clip of a generated scene, over an earlier one; fails the test where that goes wrong.
void make_clip(const std::string& scene, const std::string& file, const std::vector<std::string>& more);
/// A clip's scene file.
nlohmann::json scene_of(const std::string& clip);
/// Writes a motion of 1 s that zigzags over the picture, in and out of what is there, and gives the hand that
/// repeats it. It knows nothing of the ground, so that it meets walls as well.
std::string zigzag_hand(const std::string& file);

/// Runs `touchable touch` with these words and --overwrite, which must succeed, and gives what --json wrote.
nlohmann::json touch(const std::vector<std::string>& words);
/// Its force_hash.
std::string force_hash(const std::vector<std::string>& words);

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

using Words = std::vector<std::string>;

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

}  // namespace touchable::test
