// How forces are told beside fingers, and on the bar.
#include <gtest/gtest.h>

#include <vector>

#include "player/window/finger_halos.hpp"
#include "player/window/force_scale.hpp"

namespace touchable::test {
namespace {

TEST(ForceScale, RisesAtOnceAndFallsOnceItWasNotNeededForAWhile) {
    ForceScale scale;
    const auto at = [&scale](double now_s, std::vector<double> forces) {
        return scale.most_newtons(forces, now_s);
    };
    EXPECT_EQ(at(0, {}), 2);
    EXPECT_EQ(at(1, {0.5, 2.1}), 5);
    EXPECT_EQ(at(2, {9}), 10);
    EXPECT_EQ(at(3, {11}), 20);
    EXPECT_EQ(at(7.9, {0.1}), 20);
    EXPECT_EQ(at(8.1, {3}), 5);
    EXPECT_EQ(at(12, {1}), 5);
    EXPECT_EQ(at(13.2, {1}), 2);
}

TEST(FingerHalos, LabelsStandBesideFingersThatAreCloseAndNeverOnEachOther) {
    std::vector<LabelBox> taken{{{90, 90}, {110, 110}}, {{115, 90}, {135, 110}}};  // two rings
    const glm::dvec2 size(40, 16);
    const auto place = [&](const glm::dvec2& at) {
        const auto free = place_label(at, 15, size, taken);
        if (free) taken.push_back({*free, *free + size});
        return free;
    };
    EXPECT_EQ(place({100, 100}), glm::dvec2(45, 92)) << "to the left: the other finger is to the right";
    EXPECT_EQ(place({125, 100}), glm::dvec2(140, 92));
    EXPECT_EQ(place({100, 100}), glm::dvec2(80, 69)) << "above";
    EXPECT_EQ(place({100, 100}), glm::dvec2(80, 115)) << "below";
    EXPECT_FALSE(place({100, 100}));
}

}  // namespace
}  // namespace touchable::test
