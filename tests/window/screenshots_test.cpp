#include "player/window/window_files.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <thread>

#include "engine/base/threads.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

Image grey_image(std::uint8_t value) {
    Image image;
    image.width = 2;
    image.height = 1;
    image.samples = {value, value};
    return image;
}

TEST(Screenshots, DiskThatDoesNotAnswerHoldsNobody) {
    std::promise<void> answer;
    std::vector<std::string> begun;
    Screenshots screenshots([&, answers = answer.get_future().share()](
                                const Image&, const std::filesystem::path& name) -> Result<void> {
        answers.wait();
        begun.push_back(name.string());
        if (name == "b") return input_error("b: the disk is full");
        return {};
    });
    for (const char* const name : {"a", "b", "c", "d"})
        ASSERT_TRUE(screenshots.keep(grey_image(7), name)) << name;
    EXPECT_FALSE(screenshots.keep(grey_image(7), "e")) << "pictures pile up";
    EXPECT_TRUE(screenshots.take().empty());

    answer.set_value();
    screenshots.finish();
    EXPECT_EQ(begun, (std::vector<std::string>{"a", "b", "c", "d"}));
    const auto written = screenshots.take();
    ASSERT_EQ(written.size(), 4u);
    EXPECT_TRUE(written[0] && *written[0] == "a");
    EXPECT_FALSE(written[1]);
    EXPECT_TRUE(written[3] && *written[3] == "d");
}

TEST(Screenshots, AreNotWaitedForWhereTheDiskHangs) {
    struct Disk {
        std::promise<void> asked, answer;
        int written = 0;
    };
    const auto disk = std::make_shared<Disk>();
    Screenshots screenshots([disk](const Image&, const std::filesystem::path&) -> Result<void> {
        disk->asked.set_value();
        disk->answer.get_future().wait();
        ++disk->written;
        return {};
    });
    for (const char* const name : {"", "b"}) ASSERT_TRUE(screenshots.keep(grey_image(7), name));
    disk->asked.get_future().wait();
    screenshots.finish(std::chrono::milliseconds(1));
    const auto left = screenshots.take();
    ASSERT_EQ(left.size(), 2u);
    ASSERT_FALSE(left[0] || left[1]);
    const std::string& of_free_name = left[0].error().message;
    EXPECT_EQ(of_free_name.rfind("touchable-", 0), 0U) << of_free_name;
    EXPECT_NE(of_free_name.find(".png: not finished: its disk does not answer"), std::string::npos)
        << of_free_name;
    EXPECT_EQ(left[1].error().message, "b: not finished: its disk does not answer");
    EXPECT_EQ(abandoned_threads, 1);
    disk->answer.set_value();
    while (abandoned_threads > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(disk->written, 1) << "what nobody waits for is not begun";
    EXPECT_TRUE(screenshots.take().empty()) << "each is told of once";
}

TEST(Screenshots, AreFilesThatReplaceNoOther) {
    const TemporaryFolder folder;
    Screenshots screenshots(Existing::keep);
    ASSERT_TRUE(screenshots.keep(grey_image(9), folder / "a.png"));
    screenshots.finish();
    ASSERT_TRUE(screenshots.keep(grey_image(5), folder / "a.png")) << "after an end, too";
    screenshots.finish();
    const auto written = screenshots.take();
    ASSERT_EQ(written.size(), 2u);
    EXPECT_TRUE(written[0]) << written[0].error().message;
    EXPECT_FALSE(written[1]);
    const auto image = read_image(folder / "a.png");
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->samples, grey_image(9).samples);
}

}  // namespace
}  // namespace touchable::test
