#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/formats/formats_written.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {

inline Result<void> write_gltf(const std::filesystem::path& file, const SceneDescription& described,
                               int frames, const Planes& planes, Existing existing = Existing::keep) {
    auto writer = create_gltf_clip(file, described, frames == 1, exact_clip, existing);
    if (!writer) return writer.error();
    for (int n = 0; n < frames; ++n)
        if (auto written = (*writer)->write(test_frame(described.scene, n, planes)); !written) return written;
    return (*writer)->finish();
}

inline nlohmann::json json_of(const std::filesystem::path& file) {
    return nlohmann::json::parse(read_bytes(file));
}

/// A clip of small pictures as glTF, of which a test changes the text.
class GltfClipTest : public ::testing::Test {
protected:
    void write(int frames, int depth_bits = 8, const Planes& planes = all_planes) {
        scene = small_scene(24, 16, depth_bits);
        scene.height_coding.max_height = 1.5;
        scene.haptic.stiffness = {0.25, 1.5};
        ASSERT_EQ(message(write_gltf(file, scene, frames, planes)), "");
        gltf = json_of(file);
    }
    /// As it is now.
    Result<std::unique_ptr<ClipReader>> open() const {
        write_bytes(file, gltf.dump());
        return open_clip(file);
    }
    void expect_refused(const std::string& words) const {
        const auto clip = open();
        ASSERT_FALSE(clip) << words;
        EXPECT_NE(clip.error().message.find(words), std::string::npos) << clip.error().message;
        EXPECT_EQ(clip.error().message.find('\n'), std::string::npos);
        EXPECT_EQ(clip.error().message.find(file.string()), 0U) << clip.error().message;
    }
    TemporaryFolder folder;
    std::filesystem::path file = folder / "clip.gltf";
    Scene scene;
    nlohmann::json gltf;
};

}  // namespace touchable::test
