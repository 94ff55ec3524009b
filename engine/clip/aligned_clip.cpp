// SPDX-License-Identifier: Apache-2.0
// Brings depth to one scale for all frames: detects pumping, maps codes by the lines of ShotAlignment, and
// measures what a resting finger feels of it before and after.
#include <cmath>
#include <cstring>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/clip/shot_alignment.hpp"
#include "engine/scene/filter_codes.hpp"

namespace touchable {
namespace {

constexpr std::uint16_t no_aligned_depth = 65535;
/// New code_max: codes_of_few for a clip of at most few_codes, so terrace removal has room between codes.
constexpr std::uint16_t few_codes = 4095, codes_of_few = 8190, codes_of_many = 65534;
constexpr int line_fraction_bits = 24;
/// Frames sampled to detect pumping: this many in a row, at this many places.
constexpr std::int64_t frames_in_a_row = 4, places_of_clip = 8;
/// Least pumping from frame to frame: share of the range of codes, and multiple of the unexplained motion.
constexpr double least_pumping = 1.0 / 1000, times_unexplained = 2;

/// Code = scale x stored + shift, in fixed point.
struct CodeLine {
    std::int64_t scale = 0, shift = 0;
    std::int64_t largest = 0;
    std::uint16_t at(std::uint16_t stored) const {
        const std::int64_t code = (scale * stored + shift) >> line_fraction_bits;
        return static_cast<std::uint16_t>(std::clamp<std::int64_t>(code, 0, largest));
    }
};

class AlignedReader final : public ChangedClip {
public:
    AlignedReader(std::unique_ptr<ClipReader> clip, Scene scene, std::vector<CodeLine> lines,
                  std::string note)
        : ChangedClip(std::move(clip), std::move(scene), std::move(note)), lines_(std::move(lines)) {}
    Result<void> change(RawFrame& raw) override {
        const DepthCoding& stored = inner().scene().depth;
        const CodeLine& line = lines_[std::min(static_cast<std::size_t>(raw.number), lines_.size() - 1)];
        std::vector<std::uint16_t> codes(65536, no_aligned_depth);
        for (int code = stored.valid_min; code <= stored.valid_max; ++code) {
            const auto word = static_cast<std::uint16_t>(code);
            if (stored.is_valid(word)) codes[word] = line.at(word);
        }
        Image image = blank_image(scene_.width, scene_.height, 2, 1);
        std::uint8_t* to = image.samples.data();
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x, to += 2) std::memcpy(to, &codes[raw.depth.sample(x, y)], 2);
        raw.depth = {};
        add_plane(raw, PlaneRole::depth, plane_from(std::move(image), 16));
        return {};
    }

private:
    std::vector<CodeLine> lines_;  // by frame; the last also serves frames that could not be read before
};

/// Results of a pass over frames.
struct Looked {
    ShotAlignment alignment;
    CellPicture first;
    std::vector<std::pair<std::uint16_t, std::uint16_t>> ranges;  // least and greatest code, by frame
};

/// Stops at a damaged frame without an error: playback reports it.
Result<void> look_at_cells(ClipReader& clip, std::int64_t from, std::int64_t count, Looked& looked) {
    TRY(clip.seek(from));
    for (std::int64_t n = 0; n < count; ++n) {
        if (stop_requested()) return interrupted_error();
        auto frame = clip.next();
        if (!frame && frame.error().kind == ErrorKind::interrupted) return frame.error();
        if (!frame || !*frame) return {};
        CellPicture cells = cell_picture(**frame, clip.scene().depth);
        looked.ranges.emplace_back(cells.least, cells.most);
        if (looked.ranges.size() == 1) looked.first = cells;
        looked.alignment.add(std::move(cells));
    }
    return {};
}

/// Decides by a few frames.
Result<bool> does_pump(ClipReader& clip, std::int64_t count) {
    double moved = 0, unexplained = 0;
    const std::int64_t apart = std::max<std::int64_t>(frames_in_a_row, count / places_of_clip);
    for (std::int64_t from = 0; from + 1 < count; from += apart) {
        Looked looked;
        TRY(look_at_cells(clip, from, frames_in_a_row, looked));
        moved += looked.alignment.pumping() * looked.alignment.pumping();
        unexplained += looked.alignment.unexplained() * looked.alignment.unexplained();
    }
    const double groups = static_cast<double>((count + apart - 1) / apart);
    return moved > groups * least_pumping * least_pumping &&
           moved > times_unexplained * times_unexplained * unexplained;
}

/// Range of the aligned codes of all frames, in sixteenths; at least that of the stored codes.
struct CodeSpan {
    double least = 0, most = 0;
};
CodeSpan span_of(const std::vector<Line>& lines, const Looked& looked, std::uint16_t code_max) {
    CodeSpan span{0, static_cast<double>(code_max) * CellPicture::per_code};
    for (std::size_t n = 0; n < lines.size(); ++n) {
        const auto& [low, high] = looked.ranges[n];
        span.least = std::min(span.least, lines[n].at(static_cast<double>(low) * CellPicture::per_code));
        span.most = std::max(span.most, lines[n].at(static_cast<double>(high) * CellPicture::per_code));
    }
    return span;
}

/// The line in whole codes, fixed point; the added half makes truncation round to nearest.
CodeLine fixed_point(const Line& line, std::uint16_t largest) {
    constexpr double one = std::int64_t{1} << line_fraction_bits;
    return {static_cast<std::int64_t>(line.scale * one),
            static_cast<std::int64_t>((line.shift / CellPicture::per_code + 0.5) * one), largest};
}

/// Near and far become those of the span. If there were few codes, or terraces are to be removed, the old
/// code step becomes the filter's level, and the new codes are finer.
Scene aligned_scene(Scene scene, const CodeSpan& span) {
    DepthCoding& depth = scene.depth;
    const bool were_few = depth.code_max <= few_codes;
    const bool need_room = scene.filter.terraces == TerraceRemoval::on;
    const double codes = (span.most - span.least) / CellPicture::per_code;
    if ((were_few || need_room) && scene.filter.levels == DepthLength{}) {
        if (depth.kind == DepthCodingKind::inverse)
            scene.filter.levels.quadratic = (1 / depth.near - 1 / depth.far) / codes;
        else
            scene.filter.levels.constant = (depth.far - depth.near) / codes;
    }
    scene.depth_bits = 16;
    depth.invalid_code_count = 0;
    depth.invalid_codes = {};
    depth.code_max = static_cast<std::uint16_t>(were_few ? codes_of_few : codes_of_many);
    derive_valid_range(depth);
    return scene;
}

constexpr double picture_width = 0.16;  // metres of the device (docs/conventions.md, Units)

/// What a finger resting on a still surface feels of depth that changes from frame to frame.
struct RestingPulse {
    double hand_metres = 0;  ///< root mean square over cells and frames, of the device
    double newtons = 0;      ///< hand_metres times the scene's default stiffness
};

/// DepthCoding::depth of a fractional code.
double depth_at(const DepthCoding& coding, double code) {
    const double share =
        std::clamp((coding.near_is_high ? code : coding.code_max - code) / coding.code_max, 0.0, 1.0);
    return coding.kind == DepthCodingKind::inverse
               ? 1 / (1 / coding.far + (1 / coding.near - 1 / coding.far) * share)
               : coding.far + (coding.near - coding.far) * share;
}

double hand_metres_per_unit(const Scene& scene, const Line& line, const CellPicture& first) {
    if (scene.device_metres_per_unit) return *scene.device_metres_per_unit;
    std::vector<double> depths;
    for (const CellPicture::Cell& cell : first.cells)
        if (cell.depth != CellPicture::none)
            depths.push_back(depth_at(scene.depth, line.at(cell.depth) / CellPicture::per_code));
    if (depths.empty()) return 0;
    return picture_width * scene.camera.fx / (scene.width * sorted_element(depths, depths.size() / 2));
}

/// `lines` take the frames' cells to sixteenths of the scene's codes. The hand's scale is the scene's;
/// without one, the picture is 0.16 m wide at the median depth of frame 0.
RestingPulse resting_pulse(const std::vector<RestingCells>& resting, const std::vector<Line>& lines,
                           const Scene& scene, const CellPicture& first) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t n = 1; n < std::min(lines.size(), resting.size()); ++n)
        for (const auto& [then, now] : resting[n]) {
            const double moved = depth_at(scene.depth, lines[n].at(now) / CellPicture::per_code) -
                                 depth_at(scene.depth, lines[n - 1].at(then) / CellPicture::per_code);
            sum += moved * moved;
            ++count;
        }
    if (count == 0 || lines.empty()) return {};
    const double metres =
        hand_metres_per_unit(scene, lines.front(), first) * std::sqrt(sum / static_cast<double>(count));
    return {metres, metres * scene.default_properties.stiffness};
}

std::string pulse_words(const RestingPulse& pulse) {
    return short_number(1000 * pulse.hand_metres, 3) + " mm of the hand, " + short_number(pulse.newtons, 3) +
           " N";
}

std::string aligned_note(const Looked& looked, const RestingPulse& before, const RestingPulse& after,
                         const Scene& scene) {
    const ShotAlignment& alignment = looked.alignment;
    std::string said = "depth is aligned, as each frame had a scale of its own: under a finger at rest, of " +
                       short_number(scene.default_properties.stiffness / 1000, 3) +
                       " N/mm, what stands still moved from frame to frame by " + pulse_words(before) +
                       " (root mean square), and now by " + pulse_words(after);
    if (alignment.still_shots() < alignment.shots())
        said += "; in " + std::to_string(alignment.shots() - alignment.still_shots()) + " of " +
                std::to_string(alignment.shots()) +
                " shots too little stands still, and only what is faster than a second is taken out";
    return said;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> with_aligned_depth(std::unique_ptr<ClipReader> clip,
                                                       DepthAlignment wanted) {
    const DepthCoding& depth = clip->scene().depth;
    const bool is_even = (depth.kind == DepthCodingKind::linear || depth.kind == DepthCodingKind::inverse) &&
                         depth.shift == 0;
    if (wanted == DepthAlignment::on && !is_even)
        return usage_error(
            clip->name() +
            ": has depth with a scale, metric, log or hue: only depth without one can be aligned");
    const auto count = clip->frame_count();
    if (wanted == DepthAlignment::off || !is_even || clip->is_live() || !count || *count < 2) return clip;
    if (wanted == DepthAlignment::automatic) {
        TRY_ASSIGN(const auto pumps, does_pump(*clip, *count));
        if (!pumps) {
            TRY(clip->rewind());
            return clip;
        }
    }
    Looked looked;
    TRY(look_at_cells(*clip, 0, *count, looked));
    TRY(clip->rewind());
    const std::vector<Line> lines = looked.alignment.finish();
    if (lines.empty()) return clip;
    const CodeSpan span = span_of(lines, looked, depth.code_max);
    Scene scene = aligned_scene(clip->scene(), span);
    const double per_value =
        static_cast<double>(scene.depth.code_max) * CellPicture::per_code / (span.most - span.least);
    std::vector<Line> into;
    for (const Line& line : lines) into.push_back(line.then({per_value, -span.least * per_value}));
    TRY(validate(scene));
    const auto& resting = looked.alignment.resting();
    std::string note = aligned_note(
        looked, resting_pulse(resting, std::vector<Line>(lines.size()), clip->scene(), looked.first),
        resting_pulse(resting, into, scene, looked.first), scene);
    std::vector<CodeLine> codes;
    for (const Line& line : into) codes.push_back(fixed_point(line, scene.depth.code_max));
    return std::make_unique<AlignedReader>(std::move(clip), std::move(scene), std::move(codes),
                                           std::move(note));
}

}  // namespace touchable
