// What places of a clip are called: read, found, and said where a finger rests.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "player/window/kiosk.hpp"

namespace touchable::test {
namespace {

Result<TouchLabels> read(const std::string& labels) {
    return parse_touch_labels("{\"touchable_labels\": 1, \"labels\": [" + labels + "]}", "l.json",
                              "/exhibit");
}

std::string refusal(const std::string& labels) {
    const auto parsed = read(labels);
    return parsed ? "" : parsed.error().message;
}

TEST(TouchLabels, AreFoundByPlaceFrameAndSegmentAndTheFirstCounts) {
    const auto labels = read(R"(
        {"caption": "early", "rectangle": [10, 20, 30, 40], "frames": [0, 9]},
        {"caption": "late", "rectangle": [10, 20, 30, 40], "frames": [10, 19]},
        {"caption": "triangle", "polygon": [[0, 0], [50, 0], [0, 50]]},
        {"caption": "bell", "segment": "bell"})");
    ASSERT_TRUE(labels) << labels.error().message;
    const auto at = [&](double x, double y, std::int64_t frame, const char* segment = "") {
        return static_cast<int>(labels->at({x, y}, frame, segment).value_or(99));
    };
    EXPECT_EQ(at(20, 30, 9), 0);
    EXPECT_EQ(at(20, 30, 10), 1);
    EXPECT_EQ(at(20, 29, 20), 2) << "later than both, and in the triangle";
    EXPECT_EQ(at(10, 20, 0), 0) << "the corner is inside";
    EXPECT_EQ(at(30.4, 30, 0), 0) << "and half a pixel around it";
    EXPECT_EQ(at(30, 40.6, 0), 99);
    EXPECT_EQ(at(26, 26, 20), 99) << "beyond the triangle's long side";
    EXPECT_EQ(at(100, 100, 0, "bell"), 3);
    EXPECT_EQ(at(100, 100, 0, "bel"), 99);
    EXPECT_EQ(at(5, 5, 0, "bell"), 2);
}

TEST(TouchLabels, AreSaidInTheLanguageThatIsAskedForOrInOneThatThereIs) {
    const auto labels = read(R"(
        {"caption": {"de": "Afrika", "en": "Africa"}, "sound": {"de": "afrika.wav"}, "segment": "a"},
        {"caption": "Etna", "sound": "/sounds/etna.wav", "segment": "b"},
        {"caption": {"fr": "cloche"}, "segment": "c"})");
    ASSERT_TRUE(labels) << labels.error().message;
    const auto caption = [&](std::size_t k, const char* language) {
        return *said_in(labels->labels[k].captions, language);
    };
    EXPECT_EQ(caption(0, "de"), "Afrika");
    EXPECT_EQ(caption(0, "fr"), "Africa");
    EXPECT_EQ(caption(1, "de"), "Etna");
    EXPECT_EQ(caption(2, "de"), "cloche");
    EXPECT_EQ(*said_in(labels->labels[0].sounds, "en"), "/exhibit/afrika.wav") << "beside the file of labels";
    EXPECT_EQ(*said_in(labels->labels[1].sounds, "en"), "/sounds/etna.wav");
    EXPECT_EQ(said_in(labels->labels[2].sounds, "en"), nullptr);
}

TEST(TouchLabels, ThatCannotBeAreRefusedWithWhatWouldBeRight) {
    EXPECT_NE(refusal("").find("1 to 1000 labels"), std::string::npos);
    EXPECT_NE(refusal(R"({"caption": "a"})").find("rectangle, polygon or segment"), std::string::npos);
    EXPECT_NE(refusal(R"({"caption": "a", "segment": "a", "rectangle": [0, 0, 1, 1]})").find("one place"),
              std::string::npos);
    EXPECT_NE(refusal(R"({"segment": "a"})").find("labels[0].caption is missing"), std::string::npos);
    EXPECT_NE(refusal(R"({"caption": "", "segment": "a"})").find("labels[0].caption"), std::string::npos);
    EXPECT_NE(refusal(R"({"caption": {"Deutsch": "a"}, "segment": "a"})").find("\"de\""), std::string::npos);
    EXPECT_NE(refusal(R"({"caption": "a", "rectangle": [5, 0, 4, 1]})").find("left"), std::string::npos);
    EXPECT_NE(refusal(R"({"caption": "a", "rectangle": [-1, 0, 4, 1]})").find("rectangle[0]"),
              std::string::npos);
    EXPECT_NE(refusal(R"({"caption": "a", "polygon": [[0, 0], [1, 1]]})").find("3 to 1000"),
              std::string::npos);
    EXPECT_NE(refusal(R"({"caption": "a", "segment": "a", "frames": [3, 2]})").find("labels[0].frames"),
              std::string::npos);
    EXPECT_NE(refusal(R"({"caption": "a", "segment": "a", "colour": 1})").find("colour"), std::string::npos);
    EXPECT_EQ(refusal("[").find("l.json: "), 0U);
}

TEST(TouchLabels, MustGoWithTheClipAndItsSegments) {
    const auto labels = read(R"({"caption": "a", "rectangle": [0, 0, 63, 47], "frames": [9, 20]},
                                {"caption": "b", "segment": "bell"})");
    ASSERT_TRUE(labels);
    EXPECT_TRUE(labels->fits(64, 48, 10));
    EXPECT_TRUE(labels->fits(64, 48, 0)) << "a stream";
    EXPECT_FALSE(labels->fits(63, 48, 10));
    EXPECT_NE(labels->fits(64, 47, 10).error().message.find("l.json: labels[0]"), std::string::npos);
    EXPECT_NE(labels->fits(64, 48, 9).error().message.find("frame 9"), std::string::npos);
    EXPECT_TRUE(labels->has_segments({"wall", "bell"}));
    EXPECT_NE(labels->has_segments({"wall"}).error().message.find("labels[1]"), std::string::npos);
}

/// Fingers at their times.
class Rest : public ::testing::Test {
protected:
    std::optional<std::size_t> look(double now_s, std::optional<std::size_t> label, double x = 10) {
        const LabelledFinger finger{{x, 10}, label};
        return fingers_.take(std::span(&finger, 1), now_s);
    }
    RestingFingers fingers_{3};
};

TEST_F(Rest, IsSaidAfterHalfASecondAndOnce) {
    EXPECT_FALSE(look(1.0, 4));
    EXPECT_FALSE(look(1.4, 4));
    EXPECT_FALSE(fingers_.shown());
    EXPECT_EQ(look(1.6, 4), 4U);
    EXPECT_EQ(fingers_.shown(), 4U);
    for (double at = 1.7; at < 9; at += 0.1) EXPECT_FALSE(look(at, 4)) << "it is said already";
    EXPECT_EQ(fingers_.shown(), 4U) << "as long as the finger is there";
    EXPECT_FALSE(look(9.5, {}));
    EXPECT_FALSE(look(12, {}));
    EXPECT_FALSE(fingers_.shown());
    EXPECT_FALSE(look(13, 4));
    EXPECT_EQ(look(13.6, 4), 4U) << "it was left, and is met again";
}

TEST_F(Rest, IsNoneWhileTheFingerGoesOn) {
    for (double at = 1; at < 4; at += 0.1) EXPECT_FALSE(look(at, 4, 10 * at)) << at;
    EXPECT_FALSE(look(4.2, 4, 40));
    EXPECT_EQ(look(4.8, 4, 41), 4U);
}

TEST_F(Rest, GoesOnThroughAMomentAway) {
    EXPECT_FALSE(look(1.0, 4));
    EXPECT_FALSE(look(1.3, 4));
    EXPECT_FALSE(look(1.4, {}));
    EXPECT_EQ(look(1.5, 4), 4U);
    EXPECT_FALSE(look(1.9, 4));
    EXPECT_FALSE(look(2.0, {}));
    EXPECT_FALSE(look(2.1, 4));
    EXPECT_FALSE(look(2.7, 4)) << "it never left";
}

TEST_F(Rest, OnAnotherPlaceIsThatOnes) {
    EXPECT_FALSE(look(1.0, 4));
    EXPECT_EQ(look(1.5, 4), 4U);
    EXPECT_FALSE(look(1.8, 5));
    EXPECT_FALSE(look(2.2, 5));
    EXPECT_EQ(look(2.4, 5), 5U);
    EXPECT_EQ(fingers_.shown(), 5U);
}

TEST(RestOfSeveral, EachFingerHasItsOwn) {
    RestingFingers resting(3);
    const LabelledFinger both[] = {{{10, 10}, 0U}, {{50, 10}, 1U}};
    EXPECT_FALSE(resting.take(std::span(both, 1), 1.0));
    EXPECT_FALSE(resting.take(both, 1.3));
    EXPECT_EQ(resting.take(both, 1.6), 0U);
    EXPECT_EQ(resting.take(both, 1.9), 1U);
}

}  // namespace
}  // namespace touchable::test
