// Our binary form against GPAC's own encoder, where that is installed (docs/mpeg4.md): MP4Box on the PATH.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>

#include "engine/base/files.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "tests/mpeg4/example_scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::mpeg4 {
namespace {

constexpr std::string_view head = R"(
InitialObjectDescriptor { objectDescriptorID 1 esDescr [ ES_Descriptor { ES_ID 1 decConfigDescr DecoderConfigDescriptor {
  objectTypeIndication 2 streamType 3
  decSpecificInfo BIFSv2Config { isCommandStream true pixelMetric true pixelWidth 64 pixelHeight 48 } } } ] }
)";

/// The scene stream of what GPAC makes of a text; nothing where it makes nothing.
std::optional<SceneStream> by_gpac(const std::string& text) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "scene.bt") << head << text;
    const std::string made = (folder / "scene.mp4").string();
    const std::string command =
        "MP4Box -mp4 -def '" + (folder / "scene.bt").string() + "' -out '" + made + "' >/dev/null 2>&1";
    if (std::system(command.c_str()) != 0) return std::nullopt;
    const auto file = bytes_of_file(SourceFile(made));
    const auto movie = file ? movie_head_of(**file) : Result<Bytes>(file.error());
    const auto read =
        movie ? read_scene_stream(*movie, [&](std::uint64_t at,
                                              std::uint64_t count) { return bytes_at(**file, at, count); })
              : Result<std::optional<SceneStream>>(movie.error());
    return read ? *read : std::nullopt;
}

TEST(Gpac, EncodesTheSameBytes) {
    if (std::system("command -v MP4Box >/dev/null") != 0) GTEST_SKIP() << "GPAC is not installed";
    const auto paper = clip_nodes_of(scene_from(still_scene));
    ASSERT_TRUE(paper);
    for (const std::string& text :
         {std::string(prototype_scene), std::string(depth_image_scene), still_scene,
          std::string(depth_image_still_scene), scene_text(scene_of(*paper, 64, 48))}) {
        const auto gpac = by_gpac(text);
        ASSERT_TRUE(gpac) << text;
        const SceneTree scene = scene_from(text);
        const auto ours = encode_scene(scene, config_for(scene, 64, 48));
        ASSERT_TRUE(ours) << ours.error().message;
        EXPECT_EQ(hex(gpac->scene), hex(*ours)) << text;
    }
}

}  // namespace
}  // namespace touchable::mpeg4
