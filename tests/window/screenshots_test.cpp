#include "player/window/screenshots.hpp"

#include <gtest/gtest.h>

#include <future>

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
    Screenshots screenshots(
        [&, answers = answer.get_future().share()](
            const Image&, const std::filesystem::path& name) -> Result<std::filesystem::path> {
            answers.wait();
            begun.push_back(name.string());
            if (name == "b") return input_error("b: the disk is full");
            return name;
        });
    for (const char* const name : {"a", "b", "c", "d"})
        ASSERT_TRUE(screenshots.keep(grey_image(7), name).ok()) << name;
    EXPECT_FALSE(screenshots.keep(grey_image(7), "e").ok()) << "pictures pile up";
    EXPECT_TRUE(screenshots.take().empty());

    answer.set_value();
    screenshots.finish();
    EXPECT_EQ(begun, (std::vector<std::string>{"a", "b", "c", "d"}));
    const auto written = screenshots.take();
    ASSERT_EQ(written.size(), 4u);
    EXPECT_TRUE(written[0].ok() && *written[0] == "a");
    EXPECT_FALSE(written[1].ok());
    EXPECT_TRUE(written[3].ok() && *written[3] == "d");
}

TEST(Screenshots, AreFilesThatReplaceNoOther) {
    const TemporaryFolder folder;
    Screenshots screenshots(Existing::keep);
    ASSERT_TRUE(screenshots.keep(grey_image(9), folder / "a.png").ok());
    screenshots.finish();
    ASSERT_TRUE(screenshots.keep(grey_image(5), folder / "a.png").ok()) << "after an end, too";
    screenshots.finish();
    const auto written = screenshots.take();
    ASSERT_EQ(written.size(), 2u);
    EXPECT_TRUE(written[0].ok()) << written[0].error().message;
    EXPECT_FALSE(written[1].ok());
    const auto image = read_image(folder / "a.png");
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ(image->samples, grey_image(9).samples);
}

}  // namespace
}  // namespace touchable::test
