// SPDX-License-Identifier: Apache-2.0
// Names, lists and opens cameras; one camera for several runs.
#include "engine/camera/camera.hpp"

#include <nlohmann/json.hpp>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {
namespace {

constexpr std::size_t most_modes = 8;  // listed of a format

bool has_depth(const NodeFacts& facts) {
    return std::ranges::any_of(facts.formats, is_depth_format, &NodeFormat::code);
}
bool has_colour(const NodeFacts& facts) {
    return !has_depth(facts) && std::ranges::any_of(facts.formats, is_colour_format, &NodeFormat::code);
}

std::string format_line(const NodeFormat& format) {
    std::string line = "    " + format_text(format.code);
    line.resize(std::max<std::size_t>(line.size() + 2, 12), ' ');
    for (std::size_t k = 0; k < std::min(format.modes.size(), most_modes); ++k)
        line += (k == 0 ? "" : "; ") + mode_text(format.modes[k]);
    if (format.modes.size() > most_modes)
        line += "; and " + std::to_string(format.modes.size() - most_modes) + " more sizes";
    if (format.modes.empty()) line += "its driver does not say which sizes";
    if (format.any_size) line += "; and sizes between";
    return line + '\n';
}

/// How to touch a node, with the same camera's colour if it has any.
std::string touch_line(const NodeFacts& facts, const std::vector<NodeFacts>& all, const HowToTouch& how) {
    const auto beside = std::ranges::find_if(all, [&](const NodeFacts& other) {
        return has_colour(other) && !other.bus.empty() && other.bus == facts.bus;
    });
    const std::string camera = "v4l2:" + facts.node;
    return how(camera, beside == all.end() ? "" : camera + ",colour=" + beside->node);
}

std::string node_lines(const NodeFacts& facts, const std::vector<NodeFacts>& all, const HowToTouch& how) {
    std::string words = facts.node + "  " + printable(facts.card) + " (" + printable(facts.driver) +
                        (facts.bus.empty() ? "" : ", " + printable(facts.bus)) + ")\n";
    for (const NodeFormat& format : facts.formats) words += format_line(format);
    if (has_depth(facts)) return words + touch_line(facts, all, how);
    if (!facts.captures) return words + "    gives no pictures: a node of metadata or of another kind\n";
    return words + (has_colour(facts) ? "    colour alone: there is nothing to touch\n"
                                      : "    nothing that can be touched (Z16, Y16) or shown\n");
}

/// A hint for cameras that have depth, but no node of it here.
std::string missing_depth(const std::vector<NodeFacts>& all) {
    const auto gives_depth = [](const NodeFacts& facts) { return facts.is_realsense() && has_depth(facts); };
    if (std::ranges::none_of(all, &NodeFacts::is_realsense) || std::ranges::any_of(all, gives_depth))
        return {};
    return "The RealSense has no node of depth (Z16): the driver uvcvideo of this kernel may not know its "
           "formats. Intel's librealsense has the patches for it "
           "(scripts/patch-realsense-ubuntu-lts-hwe.sh), "
           "and the rules for its permissions (scripts/setup_udev_rules.sh).\n";
}

Result<std::unique_ptr<ClipReader>> open_stream(const StreamSource& source, const SourceDescription& known,
                                                const std::optional<std::filesystem::path>& scene_file) {
    if (known != SourceDescription())
        return usage_error(
            source.url.name() + ": is a stream, which has its scene in it: leave camera, unit, preset and kind of depth out",
            {{Setting::intrinsics}, {Setting::depth_unit}, {Setting::preset}});
    if (!scene_file) return open_live_stream(source);
    TRY_ASSIGN(const auto described, read_scene_file(*scene_file));
    auto reader = open_live_stream(source, described);
    if (reader) (*reader)->add_input(*scene_file);
    return reader;
}

}  // namespace

std::string cameras_in_words(VideoSystem& system, const HowToTouch& how) {
    const std::vector<std::string> nodes = system.nodes();
    if (nodes.empty())
        return "No camera is there (no /dev/video*): plug one in. If one is plugged in, load its driver: "
               "sudo modprobe uvcvideo (USB cameras)\n";
    std::vector<NodeFacts> all;
    std::string closed, words;
    for (const std::string& node : nodes) {
        auto facts = look_at_node(system, node);
        if (facts)
            all.push_back(std::move(*facts));
        else
            closed += facts.error().message + '\n';
    }
    for (const NodeFacts& facts : all) words += node_lines(facts, all, how);
    words += closed + missing_depth(all);
    if (closed.empty() && std::ranges::none_of(all, has_depth))
        words += "None of them gives depth (Z16, or Y16) that can be touched.\n";
    return words;
}

std::string cameras_in_json(VideoSystem& system) {
    auto cameras = nlohmann::ordered_json::array();
    for (const std::string& node : system.nodes()) {
        const auto facts = look_at_node(system, node);
        auto& camera = cameras.emplace_back(nlohmann::ordered_json{{"node", node}});
        if (!facts) camera["why_not"] = facts.error().message;
        if (!facts) continue;
        camera.update({{"card", facts->card}, {"driver", facts->driver}, {"bus", facts->bus}});
        auto& formats = camera["formats"] = nlohmann::ordered_json::array();
        for (const NodeFormat& format : facts->formats) {
            auto modes = nlohmann::ordered_json::array();
            for (const NodeMode& mode : format.modes) modes.push_back(mode_text(mode));
            formats.push_back({{"code", format_text(format.code)},
                               {"is_depth", is_depth_format(format.code)},
                               {"modes", std::move(modes)}});
        }
    }
    return nlohmann::ordered_json{{"touchable_cameras", 1}, {"cameras", std::move(cameras)}}.dump(
        2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string name_of(const PluggedChoice& choice) {
    if (const auto* sender = std::get_if<FramesetChoice>(&choice)) return sender->name();
    if (const auto* stream = std::get_if<StreamSource>(&choice)) return stream->url.name();
    return std::get<V4l2Choice>(choice).node;
}

Result<std::unique_ptr<ClipReader>> open_plugged_camera(
    const PluggedChoice& choice, const SourceDescription& known,
    const std::optional<std::filesystem::path>& scene_file) {
    if (const auto* sender = std::get_if<FramesetChoice>(&choice))
        return open_frameset_camera(*sender, known, scene_file);
    if (const auto* stream = std::get_if<StreamSource>(&choice))
        return open_stream(*stream, known, scene_file);
    return open_v4l2_camera(std::get<V4l2Choice>(choice), known, scene_file);
}

class SharedCamera::Reader final : public ReaderAround {
public:
    Reader(std::shared_ptr<SharedCamera> shared, bool is_first)
        : ReaderAround(std::shared_ptr<ClipReader>(shared, shared->camera_.get())),
          shared_(std::move(shared)),
          reads_(is_first) {}
    /// Frames before the run are numbered and timed as a camera's: one by one, `ns_before_a_run` apart.
    Result<std::optional<RawFrame>> next() override {
        if (reads_) {
            auto frame = shared_->read();
            if (frame && *frame) (*frame)->number += further_;
            return frame;
        }
        TRY_ASSIGN(auto frame, shared_->newest());
        frame.number = next_number_++;
        frame.time_ns = frame.number * ns_before_a_run;
        return std::optional(std::move(frame));
    }
    Result<void> seek(std::int64_t frame) override {
        if (reads_) return inner().seek(frame);
        next_number_ = frame;
        return {};
    }
    void leave_out_colour() override {}  // another run may show it
    Result<void> begin(std::chrono::steady_clock::time_point zero) override {
        if (auto begun = inner().begin(zero); !begun || reads_) return begun;
        further_ = next_number_ - shared_->next_number_;
        reads_ = true;
        return {};
    }

private:
    const std::shared_ptr<SharedCamera> shared_;
    bool reads_;                    // from the camera, not another run's frames
    std::int64_t next_number_ = 0;  // before the run
    std::int64_t further_ = 0;      // the run's numbers less the camera's
};

Result<std::optional<RawFrame>> SharedCamera::read() {
    auto frame = camera_->next();
    if (!frame || !*frame) return frame;
    next_number_ = (*frame)->number + 1;
    const std::lock_guard lock(mutex_);
    newest_ = **frame;
    came_.notify_all();
    return frame;
}

/// The next frame if it comes soon, so that two calls give two frames; otherwise the newest so far.
Result<RawFrame> SharedCamera::newest() {
    constexpr std::chrono::milliseconds soon(100);
    const StopScope in_time(std::chrono::steady_clock::now() + soon);
    std::unique_lock lock(mutex_);
    if (!newest_) return input_error("the camera has given no frame yet");
    const void* const before = newest_->storage.get();
    (void)wait_unless_stopped(came_, lock, [&] { return newest_->storage.get() != before; });
    return *newest_;
}

Result<std::unique_ptr<ClipReader>> SharedCamera::open(
    const PluggedChoice& choice, const SourceDescription& known,
    const std::optional<std::filesystem::path>& scene_file) {
    const bool is_first = !camera_;
    if (is_first) TRY(assign(camera_, open_plugged_camera(choice, known, scene_file)));
    return std::unique_ptr<ClipReader>(std::make_unique<Reader>(shared_from_this(), is_first));
}

}  // namespace touchable
