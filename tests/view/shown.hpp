#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/view.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/view/plain_surface.hpp"

namespace touchable::test {

/// Two frames of a clip, built.
struct Shown {
    Scene scene;
    RawFrame raw_prev, raw_next;
    SurfaceFrame prev, next;

    FramePair pair(double blend = 0) const { return {{0, 0, &prev}, {1, 33'000'000, &next}, blend}; }
    HeightField field(double blend = 0) const { return {scene, pair(blend)}; }
    void build() {
        const auto builder = make_cpu_builder(scene);
        ASSERT_TRUE(builder->build(raw_prev, prev));
        ASSERT_TRUE(builder->build(raw_next, next));
    }
};

inline std::unique_ptr<Shown> shown_scene(const char* name, int width, int height) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    options.properties = std::string(name) == "globe";
    auto made = make_scene(name, options);
    EXPECT_TRUE(made) << made.error().message;
    auto shown = std::make_unique<Shown>();
    shown->scene = (*made)->scene();
    shown->raw_prev = (*made)->frame(0);
    shown->raw_next = (*made)->frame(1);
    shown->build();
    return shown;
}

inline std::unique_ptr<Shown> shown_clip(const std::filesystem::path& folder,
                                         const std::filesystem::path& scene) {
    auto reader = open_clip(folder, scene);
    EXPECT_TRUE(reader) << reader.error().message;
    if (!reader) return nullptr;
    auto shown = std::make_unique<Shown>();
    shown->scene = (*reader)->scene();
    shown->raw_prev = **(*reader)->next();
    shown->raw_next = **(*reader)->next();
    shown->build();
    return shown;
}

inline std::unique_ptr<Shown> shown_recording(const char* name, const char* folder) {
    return shown_clip(real_data(folder), std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes" /
                                             (std::string(name) + ".json"));
}

inline std::unique_ptr<Shown> shown_stand_in(const char* name) {
    const TemporaryFolder folder;
    return shown_clip(folder.path(), write_stand_in(folder.path(), stand_in(name)));
}

}  // namespace touchable::test
