// What a hand got of the energy that the guard's books have.
#include "player/session/run_record.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "haptics_cpu/force_guard.hpp"

namespace touchable::test {
namespace {

/// A finger that goes into a wall at 0, 1 N/mm, and out of it again; scene units are metres.
class SentBooks : public ::testing::Test {
protected:
    SentBooks() {
        settings_.ramp_in_ticks = 0;
        guard_.emplace(settings_, 1.0);
    }
    /// The tick's force, newtons; `share` of it is sent.
    double press(double depth, double share) {
        Contact contact;
        contact.goal = {0, 0, -depth};
        contact.touching = depth > 0;
        contact.proxy = contact.touching ? glm::dvec3(0) : contact.goal;
        contact.carried = contact.proxy;
        if (was_touching_) contact.carried_stiffness = 1000;
        contact.properties.stiffness = contact.touching ? 1000 : 0;
        contact.force = 1000.0 * (contact.proxy - contact.goal);
        was_touching_ = contact.touching;
        const glm::dvec3 step = contact.goal - goal_;
        goal_ = contact.goal;
        work_ += glm::dot(held_, step);
        const GuardedForce out = guard_->guard(contact);
        held_ = share * out.force;
        guarded_ = out.energy;
        sent_.take(out.energy, share);
        return out.force.z;
    }
    /// In and out once, 5 mm deep, in steps of 0.1 mm; `share_of` each tick.
    template <class Share>
    void stroke(const Share& share_of) {
        for (int k = 0; k <= 120; ++k) press(0.0001 * (60 - std::abs(60 - k)) - 0.001, share_of(k));
    }

    GuardSettings settings_;
    std::optional<ForceGuard> guard_;
    bool was_touching_ = false;
    glm::dvec3 goal_{0, 0, 0.001}, held_{0};
    double work_ = 0;  // that the sent forces did
    EnergyFigures guarded_;
    TouchFigures::SentEnergy sent_;
};

TEST_F(SentBooks, AllOfItIsTheGuardsToTheBit) {
    stroke([](int) { return 1.0; });
    ASSERT_GT(guarded_.bound, 0);
    const EnergyFigures& sent = sent_.figures();
    for (const auto figure : {&EnergyFigures::work, &EnergyFigures::surface, &EnergyFigures::stored,
                              &EnergyFigures::created, &EnergyFigures::bound})
        EXPECT_EQ(sent.*figure, guarded_.*figure);
}

TEST_F(SentBooks, NothingOfItIsNothing) {
    stroke([](int) { return 0.0; });
    ASSERT_GT(guarded_.created, 0);
    const EnergyFigures& sent = sent_.figures();
    EXPECT_NEAR(sent.work, 0, 1e-15);
    EXPECT_NEAR(sent.created, 0, 1e-15);
    EXPECT_NEAR(sent.bound, 0, 1e-15);
    EXPECT_NEAR(sent.surface, 0, 1e-15);
}

TEST_F(SentBooks, WorkIsThatOfTheForcesThatWereSent) {
    stroke([](int k) { return k < 40 ? 0.0 : std::min(1.0, (k - 40) / 50.0); });
    const EnergyFigures& sent = sent_.figures();
    EXPECT_NEAR(sent.work, work_, 1e-12);
    EXPECT_GT(std::abs(sent.work - guarded_.work), 0.001);
    // The share rose under a finger that was pressed in: as a ramp does, that put energy into the spring.
    EXPECT_GT(sent.surface, 0.001);
    EXPECT_LE(sent.created, sent.bound * (1 + 1e-9));
    EXPECT_LT(sent.bound, guarded_.bound);
}

}  // namespace
}  // namespace touchable::test
