#include "player/commands/make_run.hpp"

#include <future>
#include <iostream>
#include <memory>

#include "engine/base/try.hpp"
#include "engine/clip/mp4_writer.hpp"
#include "player/commands/outputs.hpp"
#include "player/run/interrupt.hpp"
#include "player/run/progress.hpp"

namespace touchable {
namespace {

Result<void> write_frames(const AnalyticScene& source, std::int64_t frames, ClipWriter& writer) {
    Progress progress("making frame", frames, Progress::InALog::lines);
    // A frame is made while the one before is encoded; where no thread is to be had for that, in between.
    const auto make = [&source](std::int64_t n) {
        return std::async([&source, n] { return source.frame(n); });
    };
    std::future<RawFrame> made = make(0);
    for (std::int64_t n = 0; n < frames; ++n) {
        if (interrupted()) return interrupted_error();
        progress.at(n + 1);
        const RawFrame frame = made.get();
        if (n + 1 < frames) made = make(n + 1);
        TRY(writer.write(frame));
    }
    return {};
}

/// The scene, and what there is to say of its maps.
Result<std::unique_ptr<AnalyticScene>> make_source(const MakeOptions& options, std::string& remark) {
    if (!options.maps.any()) return make_scene(options.scene, options.generator);
    StatusLine line;
    if (line.is_on_terminal()) line.show("reading the maps");
    TRY_ASSIGN(const auto read, read_globe_maps(options.maps));
    remark = read->remark;
    SceneOptions generator = options.generator;
    generator.maps = &read->maps;
    return make_scene(options.scene, generator);
}

}  // namespace

Result<void> run_make(const MakeOptions& options) {
    if (auto apart = check_outputs(Outputs{{{"OUT", options.out}}, options.existing}, options.maps.files());
        !apart.ok())
        return apart;
    std::string remark;
    TRY_ASSIGN(const auto scene, make_source(options, remark));
    const AnalyticScene& source = *scene;
    SceneDescription described(source.scene());
    described.unstated.filters = all_unstated;  // what its frames ask for
    TRY_ASSIGN(auto writer, create_named_clip(options.out, described, options.storage, options.existing));
    if (auto written = write_frames(source, options.frames, *writer); !written.ok()) return written;
    if (auto finished = writer->finish(); !finished.ok()) return finished;

    const Scene& made = source.scene();
    std::cout << options.out.string() << ": " << options.frames << " frames of " << options.scene << ", "
              << made.width << 'x' << made.height << ", " << made.depth_bits << " bits\n";
    if (!remark.empty()) std::cout << remark << '\n';
    return {};
}

}  // namespace touchable
