#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "engine/scene/frames.hpp"
#include "tests/frame/marked_frame.hpp"
#include "tests/frame/random.hpp"

namespace touchable {
namespace {

using test::fill;
using test::holds;

/// What a timeline must do, told by all frames ever published.
struct Model {
    struct Published {
        std::int64_t number, time, content;
    };
    int slots;
    std::vector<Published> all;
    std::size_t oldest = 0;
    bool acquired = false;

    std::size_t held() const { return all.size() - oldest; }
    std::size_t capacity() const { return static_cast<std::size_t>(slots) * 4; }
    std::size_t contents_held() const {
        std::set<std::int64_t> contents;
        for (std::size_t k = oldest; k < all.size(); ++k) contents.insert(all[k].content);
        return contents.size();
    }
    bool may_acquire() const {
        return acquired || (contents_held() < static_cast<std::size_t>(slots) && held() < capacity());
    }
    bool may_republish() const { return held() + 1 < capacity(); }
    bool is_later(std::int64_t time) const { return all.empty() || time > all.back().time; }
    void look(std::int64_t time) {
        while (oldest + 1 < all.size() && all[oldest + 1].time <= time) ++oldest;
    }
};

/// Both sides of a timeline driven at random beside the model; every answer is compared.
class ModelCheck {
public:
    ModelCheck(int slots, std::uint64_t seed)
        : timeline_(slots), model_{slots, {}, 0, false}, random_(seed) {}

    void step() {
        switch (random_.below(4)) {
            case 0:
                acquire();
                break;
            case 1:
                publish();
                break;
            case 2:
                republish();
                break;
            default:
                look();
        }
        if (looked_) check_contents();
    }
    std::size_t published() const { return model_.all.size(); }

private:
    std::int64_t some_time() { return time_ + random_.below(8) - 2; }

    void acquire() {
        SurfaceFrame* slot = timeline_.acquire();
        ASSERT_EQ(slot != nullptr, model_.may_acquire());
        if (slot == nullptr) return;
        model_.acquired = true;
        fill(*slot, ++content_);
    }
    void publish() {
        const std::int64_t time = some_time();
        const bool expected = model_.acquired && model_.is_later(time);
        ASSERT_EQ(bool(timeline_.publish(number_, time)), expected);
        if (!expected) return;
        model_.acquired = false;
        record(time, content_);
    }
    void republish() {
        const std::int64_t time = some_time();
        const Result<bool> done = timeline_.republish(number_, time);
        ASSERT_EQ(bool(done), !model_.all.empty() && model_.is_later(time));
        if (!done) return;
        ASSERT_EQ(*done, model_.may_republish());
        if (*done) record(time, model_.all.back().content);
    }
    void record(std::int64_t time, std::int64_t content) {
        model_.all.push_back({number_++, time, content});
        time_ = time;
        ASSERT_EQ(timeline_.newest_time(), time);
    }
    /// Mostly among the frames held, now and then before or beyond.
    void look() {
        const std::int64_t begin = model_.all.empty() ? 0 : model_.all[model_.oldest].time;
        const std::int64_t time = begin - 2 + random_.below(static_cast<int>(time_ - begin) / 2 + 6);
        FramePair pair;
        ASSERT_EQ(timeline_.pair_at(time, pair), !model_.all.empty());
        if (model_.all.empty()) return;
        looked_ = true;
        pair_ = pair;
        model_.look(time);
        prev_ = model_.all[model_.oldest];
        const bool between = time >= prev_.time && model_.held() > 1;
        next_ = between ? model_.all[model_.oldest + 1] : prev_;
        ASSERT_EQ(pair.prev.number, prev_.number);
        ASSERT_EQ(pair.prev.time_ns, prev_.time);
        ASSERT_EQ(pair.next.number, next_.number);
        ASSERT_EQ(pair.next.time_ns, next_.time);
        const double blend =
            between ? static_cast<double>(time - prev_.time) / static_cast<double>(next_.time - prev_.time)
                    : 0.0;
        ASSERT_EQ(pair.blend, blend);
    }
    /// The pair in hand stays whole whatever the writer has done since.
    void check_contents() {
        ASSERT_TRUE(holds(*pair_.prev.frame, prev_.content));
        ASSERT_TRUE(holds(*pair_.next.frame, next_.content));
    }

    SurfaceTimeline timeline_;
    Model model_;
    test::Random random_;
    std::int64_t number_ = 0, time_ = 0, content_ = 0;
    bool looked_ = false;
    FramePair pair_;
    Model::Published prev_{}, next_{};
};

TEST(SurfaceTimeline, AgreesWithAListOfAllFramesUnderRandomUse) {
    for (int slots : {3, 4, 6})
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE("slots " + std::to_string(slots) + ", seed " + std::to_string(seed));
            ModelCheck check(slots, seed);
            for (int k = 0; k < 2000 && !testing::Test::HasFatalFailure(); ++k) check.step();
            ASSERT_FALSE(testing::Test::HasFatalFailure());
            EXPECT_GT(check.published(), 200U);  // many times round the ring
        }
}

}  // namespace
}  // namespace touchable
