#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <utility>

#include "player/window/opened_clip.hpp"
#include "tests/player/in_process.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {

/// A clip as a window has it, in sessions that come and go.
class OpenedClipTest : public ::testing::Test {
protected:
    /// Chooses a globe of 64x48 that is made for this.
    void make_globe(int frames) {
        choice_.file = folder_ / "globe.mkv";
        const SceneOptions globe{.width = 64, .height = 48, .properties = true};
        ASSERT_TRUE(write_generated_clip("globe", choice_.file, globe, frames));
    }
    /// Opens the chosen clip; nothing where that fails.
    std::unique_ptr<OpenedClip> opened(const ClipChoice& choice, const SessionSettings& settings = {}) {
        options_.session.builder.name = "cpu";
        auto made = OpenedClip::open(options_, choice, settings, *sound_);
        EXPECT_TRUE(made) << made.error().message;
        return made ? std::move(*made) : nullptr;
    }
    void begin() {
        clip_ = opened(choice_);
        ASSERT_TRUE(clip_ && clip_->begin());
    }
    Result<void> change_to(const SessionSettings& settings,
                           const std::shared_ptr<const PaintedSegments>& painted = nullptr) {
        auto change = clip_->prepare(settings, painted);
        if (!change) return change.error();
        EXPECT_TRUE(comes_true([&] { return clip_->has_come_to(*change); }));
        return clip_->take(std::move(*change));
    }
    Result<void> change(const char* name, const char* value) {
        SessionSettings settings = clip_->settings();
        if (auto set = settings.set(name, value); !set) return set;
        return change_to(settings);
    }
    /// Presses the pointer's finger at a pixel of the clip.
    void press(int x, int y) {
        ASSERT_TRUE(comes_true([this] { return clip_->session().look() != nullptr; }));
        const HeightField field(clip_->scene(), clip_->session().look()->held.pair);
        clip_->fingers().set_pointer(glm::dvec2(x, y));
        clip_->fingers().press(true);
        clip_->fingers().intend(field, clip_->view().camera(field.width(), field.height()));
    }
    /// The first finger as it was watched last.
    WatchedTick::Finger felt() {
        const WatchedMoment* const moment = clip_->session().look();
        return moment && !moment->felt.fingers.empty() ? moment->felt.fingers[0] : WatchedTick::Finger();
    }

    const TemporaryFolder folder_;
    ClipChoice choice_;
    PlayOptions options_;
    std::unique_ptr<WindowSound> sound_ = std::move(*WindowSound::create(false, {}, Existing::keep));
    std::unique_ptr<OpenedClip> clip_;
};

}  // namespace touchable::test
