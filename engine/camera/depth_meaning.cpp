// SPDX-License-Identifier: Apache-2.0
// What a camera's depth means: by what is known of it and its first pictures, or by a scene file.
#include "engine/camera/v4l2_camera.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/open_clip.hpp"

namespace touchable {
namespace {

StoredImage picture_of(const PlaneView& depth) {
    StoredImage picture;
    picture.image = {depth.width, depth.height, 2, 1, {}};
    picture.bits = 16;
    picture.image.samples.resize(2 * pixel_count(depth.width, depth.height));
    depth.copy_rows(picture.image.samples.data(), depth.row_bytes());
    return picture;
}

/// The picture with most depth, the later of equal ones: cameras need some frames until they see.
const PlaneView& fullest(std::span<const RawFrame> frames) {
    const PlaneView* best = nullptr;
    std::int64_t most = -1;
    for (const RawFrame& frame : frames) {
        const PlaneView& picture = frame.depth;
        std::int64_t seen = 0;
        for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x) seen += picture.sample(x, y) != 0;
        if (seen < most) continue;
        most = seen;
        best = &picture;
    }
    return *best;
}

/// The code that a thousandth of the valid codes reach or exceed: single wrong pixels may lie far behind.
std::optional<std::uint16_t> deep_code(std::span<const RawFrame> frames, const DepthCoding& coding) {
    std::vector<std::int64_t> counts(65536);
    std::int64_t all = 0;
    for (const RawFrame& frame : frames)
        for (int y = 0; y < frame.depth.height; ++y)
            for (int x = 0; x < frame.depth.width; ++x) {
                const std::uint16_t code = frame.depth.sample(x, y);
                if (!coding.is_valid(code)) continue;
                ++counts[code];
                ++all;
            }
    if (all == 0) return std::nullopt;
    std::int64_t deeper = 0;
    for (std::size_t code = counts.size(); code-- > 0;) {
        deeper += counts[code];
        if (deeper * 1000 >= all) return static_cast<std::uint16_t>(code);
    }
    return std::nullopt;
}

/// Twice as far as the first frames show: a hand that goes away may uncover what was behind it.
Result<double> far_beyond(std::span<const RawFrame> first, const DepthCoding& depth) {
    const auto deep = deep_code(first, depth);
    if (!deep)
        return input_error(
            "sees no depth in its first frames; is it pointed at something that is near and far enough for "
            "it?");
    return std::min(2 * depth.depth(*deep), depth.scale * depth.code_max);
}

/// Sets an unstated far plane well beyond what the first pictures show.
Result<LiveReader::Meaning> settled(const SceneDescription& described,
                                    std::vector<std::filesystem::path> inputs,
                                    std::span<const RawFrame> first, const std::string& node) {
    SceneDescription::FoundInClip found;
    if (described.unstated.far)
        TRY(assign(found.far, error_at(node, far_beyond(first, described.scene.depth))));
    TRY_ASSIGN(auto scene, error_at(node, settle(described, found)));
    if (found.far)
        add_remark(scene.remarks,
                   {formatted("deeper than %.3g m is no depth: twice what the first frames show",
                              *found.far * scene.metres_per_unit),
                    true, "a scene file's depth.far says otherwise"});
    return LiveReader::Meaning{std::move(scene), described.unstated.filters, std::move(inputs)};
}

/// Fills in what is not known by what the driver tells of the camera.
SourceDescription with_card(const NodeFacts& facts, std::uint32_t format, SourceDescription known,
                            std::vector<Remark>& remarks) {
    if (facts.is_realsense() && known.preset.empty()) {
        known.preset = "realsense";
        add_remark(remarks, {"it is as preset realsense has it, of 1 mm a code",
                             true,
                             "a code is 0.0001 m of a D405, 0.00025 m of an L515",
                             {{Setting::depth_unit}},
                             RemarkKind::unit});
    }
    const SourceDescription::Preset* preset = known.preset.empty() ? nullptr : preset_named(known.preset);
    const bool has_unit = known.metres_per_code || preset != nullptr;
    if (format == V4L2_PIX_FMT_Z16 && !has_unit) {
        known.metres_per_code = 0.001;
        add_remark(remarks, {"a code is 1 mm, as most cameras of Z16 have it",
                             true,
                             {},
                             {{Setting::depth_unit}},
                             RemarkKind::unit});
    }
    if (format != V4L2_PIX_FMT_Z16)
        add_remark(remarks,
                   {"Y16 is grey of 16 bits, here taken for depth: of an infrared or a heat camera it is "
                    "none"});
    return known;
}

/// The meaning by a scene file, whose size must be that of the pictures.
Result<LiveReader::Meaning> meaning_in_file(const std::string& node, std::span<const RawFrame> first,
                                            const std::filesystem::path& scene_file) {
    TRY_ASSIGN(auto described, read_scene_file(scene_file));
    Scene& made = described.scene;
    made.folder.reset();
    made.video.reset();
    const std::string of_file = scene_file.string() + ": ";
    if (!made.stored.is_plain() || made.depth.kind == DepthCodingKind::hue || made.depth_bits != 16)
        return input_error(of_file +
                           "a camera gives codes of 16 bits: depth.bits must be 16, and its coding "
                           "metric, linear or inverse");
    if (described.unstated.camera)
        return input_error(of_file + "camera is missing: must be given, as folder.cameras are of pictures");
    const PlaneView& picture = first.front().depth;
    if (made.width != picture.width || made.height != picture.height)
        return input_error(of_file + "is of " + size_text(made.width, made.height) + ", the camera gives " +
                           size_text(picture.width, picture.height) + " (size=)");
    if (made.lens.any() || made.colour_camera)
        return input_error(of_file +
                           "camera.distortion and colour_camera are of recordings: of a camera that is "
                           "plugged in must be left out");
    return settled(described, {scene_file}, first, node);
}

}  // namespace

Result<LiveReader::Meaning> meaning_of_depth(const NodeFacts& facts, std::uint32_t format,
                                             std::span<const RawFrame> first, const SourceDescription& known,
                                             const std::optional<std::filesystem::path>& scene_file) {
    if (scene_file) return meaning_in_file(facts.node, first, *scene_file);
    std::vector<Remark> remarks;
    const SourceDescription all = with_card(facts, format, known, remarks);
    std::vector<std::filesystem::path> inputs;
    TRY_ASSIGN(auto guessed, error_at(facts.node, guess_camera(picture_of(fullest(first)), all, inputs)));
    Scene& scene = guessed.scene;
    if (!scene.stored.is_plain() || scene.depth.kind != DepthCodingKind::metric)
        return usage_error(facts.node +
                               ": a camera's codes are lengths: say how many metres a stored 1 stands for" +
                               (all.preset.empty() ? "" : "; preset " + all.preset + " is of other pictures"),
                           {{Setting::depth_unit, "0.001"}});
    scene.remarks = joined_remarks(std::move(remarks), scene.remarks);
    scene.name = facts.card;
    return settled(guessed, std::move(inputs), first, facts.node);
}

}  // namespace touchable
