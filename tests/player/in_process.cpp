// SPDX-License-Identifier: Apache-2.0
#include "tests/player/in_process.hpp"

#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "player/run/run_files.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable::test {

Result<void> write_generated_clip(const std::string& scene, const std::filesystem::path& file,
                                  const SceneOptions& options, int frames) {
    const auto source = make_scene(scene, options);
    if (!source) return source.error();
    SceneDescription described((*source)->scene());
    described.unstated.filters = all_unstated;
    auto writer = create_clip(file, described, {}, Existing::replace);
    if (!writer) return writer.error();
    for (int n = 0; n < frames; ++n)
        if (auto written = (*writer)->write((*source)->frame(n)); !written) return written;
    return (*writer)->finish();
}

Result<void> replay_in_process(const std::filesystem::path& file) {
    const auto recording = read_recording(file);
    if (!recording) return recording.error();
    std::vector<ReplayCheck::Outcome> replayed;
    TouchFigures of_all;
    for (const RecordedPart& part : *recording) {
        auto setup = setup_from_recording(part, {});
        if (!setup) return setup.error();
        TouchSetup& s = **setup;
        ReplayCheck check(part);
        TouchFigures figures;
        TouchSink* const sinks[] = {&check, &figures, &of_all};
        const auto ran = TouchSession(*s.feed, *s.hand, *s.solver, s.options).run(sinks);
        if (!ran) return ran;
        of_all.end_part();
        replayed.push_back(check.outcome(figures.force_hash(), has_other_frames(part, s)));
    }
    const auto same = judge_replay(replayed, of_all.force_hash());
    return same ? Result<void>() : same.error();
}

}  // namespace touchable::test
