#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/player/program.hpp"
#include "tests/player/standstill.hpp"

namespace touchable::test {

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
