// SPDX-License-Identifier: Apache-2.0
#include "tests/verify/verify_forces.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <sstream>

#include "tests/temporary_files.hpp"
#include "tests/verify/synthetic.hpp"

namespace touchable::verify {
namespace {

/// Rows that the report counts under a check.
int violations(const Outcome& outcome, Check check) {
    const std::string& out = outcome.out;
    const std::size_t at = out.find(name_of(check), out.find("violations"));
    return at == std::string::npos ? -1 : std::stoi(out.substr(at + name_of(check).size()));
}

/// Two moving fingers on two rough frames with everything a clip can have: heights, haptics, a hole, time
/// between.
class VerifyForces : public testing::Test {
protected:
    void SetUp() override {
        fill_frames();
        fill_rows();
    }

    void fill_frames() {
        for (ExportedFrame& frame : frames_) {
            frame.meaning.largest_height = 2;
            frame.haptic.resize(3 * frame.codes.size());
            for (auto& code : frame.codes) code = static_cast<std::uint16_t>(30000 + random_.next() % 3000);
            for (auto& value : frame.haptic) value = static_cast<std::uint8_t>(random_.next());
            for (std::size_t k = 0; k < frame.codes.size(); ++k)
                frame.heights.push_back(static_cast<std::uint16_t>(random_.next() % 256));
        }
        frames_[0].valid[40] = frames_[1].valid[41] = 0;
    }

    void fill_rows() {
        rows_.clear();
        for (int tick = 0; tick < 60; ++tick)
            for (int finger = 0; finger < 2; ++finger) rows_.push_back(make_row(tick, finger));
        write_frame(folder_.path() / "7", frames_[0]);
        write_frame(folder_.path() / "8", frames_[1]);
    }

    Surface surface(double blend) const { return {frames_[0], frames_[1], blend}; }

    Row make_row(int tick, int finger) {
        const double blend = tick / 60.0;
        const Surface now = surface(blend);
        const ImagePosition at{3 + 0.1 * tick, 3 + 3 * finger + 0.01 * tick};
        const real above = tick % 5 == 0 ? -2 : 3;
        const Vec3 goal = rounded((1 / now.q_at(at) + above) * now.ray(at.x, at.y));
        Row row = contact_row(now, above < 0 ? goal : closest_point(now, goal), goal);
        row.tick = tick;
        row.finger = finger;
        row.contact = above > 0;
        row.prev = 7;
        row.next = 8;
        row.blend = blend;
        if (!row.contact) row.force = {};
        return row;
    }

    Outcome run(const std::vector<Row>& rows, const std::vector<std::string>& more = {}) const {
        return verify(folder_.path(), rows, more);
    }

    /// Every row in contact, one at a time, must be caught once it is spoilt.
    void expect_caught(Check check, const std::function<void(Row&)>& spoil) {
        for (std::size_t k = 14; k < rows_.size(); k += 20) {
            std::vector<Row> rows = rows_;
            ASSERT_TRUE(rows[k].contact);
            spoil(rows[k]);
            const Outcome outcome = run(rows);
            EXPECT_EQ(outcome.code, 6);
            EXPECT_EQ(violations(outcome, check), 1) << "row " << k << '\n' << outcome.out;
        }
    }

    /// The proxy elsewhere, with the force and the pixel that it would have there.
    static void move(Row& row, const Surface& now, const Vec3& proxy) {
        Row moved = contact_row(now, proxy, row.goal);
        row.proxy = moved.proxy;
        row.pixel = moved.pixel;
        row.touch = moved.touch;
        row.force = moved.force;
    }

    /// A ten-thousandth of a pixel off the minimum.
    void slide(Row& row) const {
        const Surface now = surface(row.blend);
        const ImagePosition at{row.pixel.x + 1e-4L, row.pixel.y - 0.5e-4L};
        move(row, now, (1 / now.q_at(at)) * now.ray(at.x, at.y));
    }

    test::TemporaryFolder folder_;
    Random random_{21};
    ExportedFrame frames_[2] = {blank_frame(14, 11), blank_frame(14, 11)};
    std::vector<Row> rows_;
};

TEST_F(VerifyForces, PassesRightForces) {
    const Outcome outcome = run(rows_);
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find("contact share 0.8,"), std::string::npos) << outcome.out;
}

TEST_F(VerifyForces, RequiresEnoughContact) {
    EXPECT_EQ(run(rows_, {"--min-contact", "0.8"}).code, 0);
    EXPECT_EQ(run(rows_, {"--min-contact", "0.81"}).code, 6);
}

TEST_F(VerifyForces, CatchesMisplacedProxy) {
    expect_caught(Check::behind, [&](Row& r) { move(r, surface(r.blend), (1 + 1e-6L) * r.proxy); });
    expect_caught(Check::off_surface, [&](Row& r) { move(r, surface(r.blend), (1 - 1e-6L) * r.proxy); });
    expect_caught(Check::minimum, [&](Row& r) { slide(r); });
}

TEST_F(VerifyForces, CappedProxyMayMissMinimum) {
    std::vector<Row> rows = rows_;
    slide(rows[14]);
    rows[14].capped = 1;
    EXPECT_EQ(run(rows).code, 0);
    rows[14].proxy = (1 + 1e-6L) * rows[14].proxy;
    EXPECT_EQ(run(rows).code, 6);
}

TEST_F(VerifyForces, CatchesWrongFields) {
    expect_caught(Check::force, [](Row& r) { r.force = 1.001L * r.force; });
    expect_caught(Check::force, [](Row& r) { r.force.x += 1e-8L * length(r.force); });
    expect_caught(Check::properties, [](Row& r) {
        r.touch.stiffness *= 1.001L;
        r.force = 1.001L * r.force;
    });
    expect_caught(Check::properties, [](Row& r) { r.touch.mu_static += 1e-6L; });
    expect_caught(Check::properties, [](Row& r) { r.touch.mu_dynamic += 1e-6L; });
    expect_caught(Check::pixel, [](Row& r) { r.pixel.x += 1e-4L; });
    expect_caught(Check::finite, [](Row& r) { r.goal.y = std::nanl(""); });
    expect_caught(Check::finite, [](Row& r) { r.force.z = HUGE_VALL; });
    expect_caught(Check::free, [](Row& r) { r.contact = false; });
}

TEST_F(VerifyForces, ChecksPaintedFriction) {
    for (ExportedFrame& frame : frames_) frame.meaning.high = {10000, 0.8L, 0.6L};
    fill_rows();  // each at a minimum, wherever it was before
    const Outcome right = run(rows_, {"--no-slip"});
    EXPECT_EQ(right.code, 0) << right.out << right.err;
    EXPECT_GT(rows_[14].touch.mu_static, 0);
    for (real Touch::*member : {&Touch::mu_static, &Touch::mu_dynamic}) {
        std::vector<Row> rows = rows_;
        rows[14].touch.*member *= 1 + 1e-6L;
        EXPECT_EQ(violations(run(rows, {"--no-slip"}), Check::properties), 1);
    }
}

TEST_F(VerifyForces, CatchesWrongMoment) {
    for (const double shift : {-1e-4, 1e-4}) {
        std::vector<Row> rows = rows_;
        rows[38].blend += shift;
        const Outcome outcome = run(rows);
        EXPECT_EQ(outcome.code, 6);
        EXPECT_EQ(violations(outcome, Check::behind) + violations(outcome, Check::off_surface), 1);
    }
}

TEST_F(VerifyForces, CatchesFreeFingerBehind) {
    std::vector<Row> rows = rows_;
    Row& through = rows[14];
    through.contact = false;
    through.proxy = through.goal;
    through.force = {};
    const Outcome outcome = run(rows);
    EXPECT_EQ(violations(outcome, Check::free), 0);
    EXPECT_EQ(violations(outcome, Check::behind), 1);
}

TEST_F(VerifyForces, GuardMayOnlyReduce) {
    std::vector<Row> rows = rows_;
    rows[14].guard = 1;
    rows[14].force = 0.5L * rows[14].force;
    EXPECT_EQ(run(rows).code, 0);
    rows[14].force = 2.1L * rows[14].force;
    EXPECT_EQ(violations(run(rows), Check::force), 1);
    rows[14].guard = 1 + 32;  // a damper adds what no spring explains
    EXPECT_EQ(run(rows).code, 0);
}

TEST_F(VerifyForces, AppliesSentShare) {
    std::vector<Row> rows = rows_;
    rows[14].share = 0.25;
    rows[14].force = 0.25L * rows[14].force;
    EXPECT_EQ(run(rows).code, 0);
    rows[14].share = 0.5;
    EXPECT_EQ(violations(run(rows), Check::force), 1);
}

TEST_F(VerifyForces, CatchesMissingRowsAndScale) {
    std::vector<Row> rows = rows_;
    rows.erase(rows.begin() + 14);
    EXPECT_EQ(violations(run(rows), Check::order), 1);
    rows = rows_;
    rows.pop_back();
    EXPECT_EQ(violations(run(rows), Check::order), 1);
    rows = rows_;
    rows[14].metres_per_unit = 0.002;
    rows[14].force = 2 * rows[14].force;
    EXPECT_EQ(violations(run(rows), Check::order), 1);
}

TEST_F(VerifyForces, RejectsBadInput) {
    auto refused = [&](const Outcome& outcome, const std::string& word) {
        EXPECT_EQ(outcome.code, 3);
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    };
    std::vector<Row> rows = rows_;
    rows[3].next = 9;
    refused(run(rows), "scene.json");
    refused(run({}), "no rows");
    rows = rows_;
    rows[3].blend = 1.5;
    refused(run(rows), "line 5");
    frames_[1].meaning.fx += 1;
    write_frame(folder_.path() / "8", frames_[1]);
    refused(run(rows_), "same clip");
    std::filesystem::remove(folder_.path() / "7" / "valid.png");
    refused(run(rows_), "valid.png");
    std::ofstream(folder_.path() / "7" / "scene.json") << "{\"width\": 14";
    refused(run(rows_), "scene.json");
    std::ofstream(folder_.path() / "7" / "scene.json") << "{\"width\": 14}";
    refused(run(rows_), "height");
}

TEST_F(VerifyForces, RejectsBrokenForcesFiles) {
    const std::string file = (folder_.path() / "broken.csv").string();
    auto run_text = [&](const std::string& text) {
        std::ofstream(file) << text;
        std::ostringstream out, err;
        EXPECT_EQ(verify_forces({"--forces", file, "--frames", folder_.path().string()}, out, err), 3);
        return err.str();
    };
    EXPECT_NE(run_text("").find("cannot be read"), std::string::npos);
    EXPECT_NE(run_text("tick,time_s\n").find("no column finger"), std::string::npos);
    run(rows_);
    std::ifstream stream(folder_.path() / "forces.csv");
    std::string header, row;
    std::getline(stream, header);
    std::getline(stream, row);
    EXPECT_NE(run_text(header + "\n" + row + "\n" + row.substr(0, row.size() / 2)).find("line 3"),
              std::string::npos);
    EXPECT_NE(run_text(header + "\nten" + row.substr(1)).find("tick is \"ten\""), std::string::npos);
}

TEST(VerifyForcesUsage, ErrorExitsWithTwo) {
    std::ostringstream out, err;
    EXPECT_EQ(verify_forces({}, out, err), 2);
    EXPECT_EQ(verify_forces({"--forces", "a", "--frames", "b", "--min-contact", "2"}, out, err), 2);
    EXPECT_EQ(verify_forces({"--forces", "a", "--frames"}, out, err), 2);
    EXPECT_EQ(verify_forces({"--fast"}, out, err), 2);
}

}  // namespace
}  // namespace touchable::verify
