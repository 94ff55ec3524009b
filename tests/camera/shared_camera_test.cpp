// A camera that stays open from run to run.
#include "engine/camera/camera.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "tests/camera/fake_video.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

TEST(SharedCamera, IsHandedOverFromRunToRun) {
    const auto video = std::make_shared<FakeVideo>();
    add_depth_node(*video, "/dev/video0", 16, 8).period_ns = 2'000'000;
    V4l2Choice choice{"/dev/video0"};
    choice.system = video;
    const SourceDescription known{{}, 60, 0.001, {}, {}, {}};
    {
        const auto shared = std::make_shared<SharedCamera>();
        auto before = shared->open(choice, known);
        ASSERT_EQ(message(before), "");
        for (int n = 0; n < 2; ++n) EXPECT_EQ((*(*before)->next())->number, n);
        std::int64_t number = 0;  // of the newest frame of the run that is made ready
        for (int change = 0; change < 3; ++change) {
            ASSERT_EQ(message((*before)->begin(steady_clock::now() - milliseconds(1))), "");
            Result<std::optional<RawFrame>> last = std::optional<RawFrame>();
            std::stop_source over;
            std::thread reader([&] {
                const StopScope until(over.get_token());
                do last = (*before)->next();
                while (last);
            });
            // While that runs, another is made ready with frames of it.
            auto next = shared->open(choice, known);
            EXPECT_EQ(message(next), "");
            const auto first = (*next)->next();
            EXPECT_EQ(message(first), "");
            EXPECT_EQ((*first)->number, 0);
            auto second = (*next)->next();
            // The same once more, where the reader takes none in 100 ms.
            for (number = 1; number < 600 && (*second)->storage == (*first)->storage; ++number)
                second = (*next)->next();
            EXPECT_EQ((*second)->number, number);
            EXPECT_LT((*first)->time_ns, (*second)->time_ns);
            EXPECT_NE((*first)->storage, (*second)->storage);
            over.request_stop();
            reader.join();
            EXPECT_EQ(last.error().kind, ErrorKind::interrupted);
            before = std::move(next);
        }
        ASSERT_EQ(message((*before)->begin(steady_clock::now() - milliseconds(1))), "");
        const auto frame = (*before)->next();
        ASSERT_EQ(message(frame), "");
        EXPECT_EQ((*frame)->number, number + 1) << "what was taken between two runs is no gap";
        EXPECT_GT((*frame)->time_ns, ns_before_a_run);
        EXPECT_EQ(video->left_over().size(), 6u) << "one stream: the node, that it streams, four buffers";
    }
    EXPECT_EQ(video->left_over(), std::vector<std::string>());
    EXPECT_EQ(video->misuse(), std::vector<std::string>());
}

}  // namespace
}  // namespace touchable::test
