// SPDX-License-Identifier: Apache-2.0
#include "engine/authoring/materials.hpp"

#include "engine/authoring/segment_parts.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {

namespace {

/// Classes by the largest channel and the one between.
enum class Hue { grey, red, orange, green, blue, violet, any };

struct Seen {
    Hue hue;
    int brightness;  // 0.30 R + 0.59 G + 0.11 B
    int chroma;      // largest less least channel
    int contrast;    // 1/16 levels
    int permille;    // of the picture
};

Hue hue_of(int red, int green, int blue, int chroma) {
    const int largest = std::max({red, green, blue});
    if (chroma < 16 || chroma * 6 < largest) return Hue::grey;
    if (green == largest) return Hue::green;
    if (blue == largest) return red > green ? Hue::violet : Hue::blue;
    if (blue > green) return Hue::violet;
    return (green - blue) * 4 < chroma ? Hue::red : Hue::orange;
}

struct Span {
    int least, most;
    bool holds(int number) const { return least <= number && number <= most; }
};
constexpr Span any_number{0, 4080};
constexpr int smooth = 32, rough = 96;  // contrast: 2 and 6 levels

/// The first rule that holds applies.
struct Rule {
    Hue hue;
    Span brightness, chroma, contrast, permille;
    std::string_view material;
};
constexpr Rule rules[] = {
    // Grey: by brightness and roughness. Few kinds: shading makes greys of one surface darker and brighter.
    {Hue::grey, any_number, any_number, {rough, 4080}, any_number, "stone"},
    {Hue::grey, {200, 255}, any_number, any_number, any_number, "paper"},
    {Hue::grey, {60, 255}, any_number, {0, smooth}, {80, 1000}, "plastic"},  // like paint on a wall
    {Hue::grey, {110, 255}, any_number, {0, smooth}, any_number, "metal"},
    {Hue::grey, {0, 32}, any_number, {0, smooth / 2}, any_number, "rubber"},
    {Hue::grey, any_number, any_number, {smooth, 4080}, {150, 1000}, "carpet"},
    {Hue::grey, any_number, any_number, any_number, any_number, "cloth"},
    // Brown, from skin to bark.
    {Hue::orange, {140, 230}, {45, 110}, {0, smooth}, {0, 250}, "skin"},
    {Hue::orange, any_number, {150, 255}, {0, smooth}, any_number, "plastic"},
    {Hue::orange, {0, 80}, any_number, {0, rough}, {0, 60}, "leather"},
    {Hue::orange, {170, 255}, {0, 90}, any_number, any_number, "cardboard"},
    {Hue::orange, any_number, any_number, any_number, any_number, "wood"},
    {Hue::red, any_number, {50, 255}, {smooth, 4080}, {20, 1000}, "brick"},
    {Hue::green, any_number, any_number, {smooth, 4080}, any_number, "grass"},
    {Hue::blue, {60, 255}, {40, 255}, {0, smooth}, {300, 1000}, "water"},
    // Other colours: smooth, like paint on something, or woven.
    {Hue::any, any_number, {90, 255}, {0, smooth}, any_number, "plastic"},
    {Hue::any, any_number, any_number, any_number, {250, 1000}, "carpet"},
    {Hue::any, any_number, any_number, any_number, any_number, "cloth"},
};

/// Segments that no colour camera saw feel much as a clip does without materials.
constexpr std::string_view of_unseen = "cloth";

constexpr int level_height = 128, top_height = 255;

void widen_to(PropertyRange& range, double value) {
    range.min = std::min(range.min, value);
    range.max = std::max(range.max, value);
}

/// Paints each pixel as its segment feels. Pixels without a segment, which are holes, get the nearest one's
/// values: a hole's rim is as hard as its surroundings, and so is depth that filters put there.
class HapticPainter {
public:
    /// A picture without segments feels as the scene does by default.
    explicit HapticPainter(const Scene& scene) : ranges_(scene.haptic), codes_(65536), reliefs_(65536) {
        set(0, {scene.default_properties, 100});
    }

    /// Sets the touch of segments with this label.
    void set(std::uint16_t label, const Feel& feel) {
        codes_[label] = haptic_code(feel.properties, ranges_);
        reliefs_[label] = feel.relief;
    }

    /// Paints labels that were set, row by row; 0: no segment.
    Image haptic(const std::vector<std::uint16_t>& labels, int width, int height) {
        labels_ = labels;
        nearest_.fill(labels_, width, height);
        Image image{width, height, 1, 3, {}};
        image.samples.resize(3 * labels_.size());
        std::uint8_t* to = image.samples.data();
        for (const std::uint16_t label : labels_) {
            std::memcpy(to, codes_[label].data(), 3);
            to += 3;
        }
        return image;
    }

    /// The heights, 8 bits, of the picture that was painted last, scaled around level (128) by relief.
    Image scaled(const PlaneView& height) const {
        Image image{height.width, height.height, 1, 1, {}};
        image.samples.reserve(labels_.size());
        std::size_t k = 0;
        for (int y = 0; y < height.height; ++y)
            for (int x = 0; x < height.width; ++x, ++k) {
                const int above = (height.sample(x, y) - level_height) * reliefs_[labels_[k]] / 100;
                image.samples.push_back(
                    static_cast<std::uint8_t>(std::clamp(level_height + above, 0, top_height)));
            }
        return image;
    }

private:
    HapticRanges ranges_;
    std::vector<std::array<std::uint8_t, 3>> codes_;  // by label
    std::vector<int> reliefs_;
    std::vector<std::uint16_t> labels_;  // of all pixels
    NearestLabel nearest_;
};

/// A clip whose haptic pictures are replaced by ones of these ranges, which a derived class paints.
class HapticTrackReader : public ChangedClip {
protected:
    /// `scene`: the clip's, with other ranges; must be valid (validate).
    HapticTrackReader(std::unique_ptr<ClipReader> clip, const Scene& scene)
        : ChangedClip(std::move(clip), scene), painter_(scene) {
        replace_track(PlaneRole::haptic,
                      {"", "materials of segments", "rgb24", scene_.width, scene_.height, true});
    }

    HapticPainter painter_;
};

class PaintedReader final : public HapticTrackReader {
public:
    PaintedReader(std::unique_ptr<ClipReader> clip, const Scene& scene,
                  std::shared_ptr<const PaintedSegments> painted)
        : HapticTrackReader(std::move(clip), scene), painted_(std::move(painted)) {
        for (const auto& [label, paint] : painted_->by_label) painter_.set(label, paint.feel);
    }

    Result<void> change(RawFrame& raw) override {
        const SegmentStore& segments = *painted_->segments;
        if (raw.number >= segments.frames())
            return input_error(inner().name() + ": frame " + std::to_string(raw.number) +
                               " was not there when the clip's " + std::to_string(segments.frames()) +
                               " frames were divided into segments");
        segments.read_labels(raw.number, labels_);
        add_plane(raw, PlaneRole::haptic,
                  plane_from(painter_.haptic(labels_, segments.width(), segments.height())));
        return {};
    }

private:
    const std::shared_ptr<const PaintedSegments> painted_;
    std::vector<std::uint16_t> labels_;
};

constexpr std::size_t most_segment_bytes = std::size_t{1} << 30;

/// Guesses need colour.
Result<void> check_colour(const RawFrame& frame, const ClipReader& clip) {
    if (!frame.colour.empty()) return {};
    return input_error(clip.name() + ": frame " + std::to_string(frame.number) +
                       " has no colour, by which materials are guessed; say what all segments are that are "
                       "not named");
}

/// Heights can be scaled if they have 8 bits.
Result<void> check_heights(const RawFrame& frame, const ClipReader& clip) {
    const auto refuse = [&](const char* why) {
        return input_error(clip.name() + ": frame " + std::to_string(frame.number) + why);
    };
    if (frame.height.empty()) return refuse(" has no heights to be scaled; touchable relief makes some");
    if (frame.height.bytes_per_sample != 1 || clip.scene().height_coding.code_max != 255)
        return refuse(" has heights of more than 8 bits; those of touchable relief can be scaled");
    return {};
}

struct Materials {
    LabelNames named;
    const PaletteMaterial* otherwise = nullptr;  // null: a guess for each
    bool scale_relief = false;
};

class MaterialReader final : public HapticTrackReader {
public:
    MaterialReader(std::unique_ptr<ClipReader> clip, const Scene& scene, Materials materials,
                   BeginSegments begin, std::shared_ptr<MaterialReport> report)
        : HapticTrackReader(std::move(clip), scene),
          materials_(std::move(materials)),
          begin_(std::move(begin)),
          report_(std::move(report)) {
        start();
    }

    Result<void> change(RawFrame& raw) override {
        if (materials_.otherwise == nullptr) TRY(check_colour(raw, inner()));
        if (materials_.scale_relief) TRY(check_heights(raw, inner()));
        const auto begun = std::chrono::steady_clock::now();
        const bool follows = before_ && before_->is_before(raw) && raw.number == before_->number + 1;
        const Segmentation& segmentation = segments_of_(raw, follows);
        for (const Segment& segment : segmentation.segments)
            if (!met_[segment.label]) meet(segment, raw.number);
        if (follows) count_changes(segmentation);
        labels_before_ = segmentation.labels;
        before_.emplace(raw);
        Image haptic = painter_.haptic(segmentation.labels, scene().width, scene().height);
        if (materials_.scale_relief)
            add_plane(raw, PlaneRole::height, plane_from(painter_.scaled(raw.height), 8));
        add_plane(raw, PlaneRole::haptic, plane_from(std::move(haptic)));
        ++report_->frames;
        report_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        return {};
    }

    Result<void> seek(std::int64_t frame) override {
        const auto count = frame_count();
        if (count && frame > *count) return inner().seek(frame);  // an error
        TRY(inner().seek(0));
        start();
        for (std::int64_t number = 0; number < frame; ++number) {
            if (stop_requested()) return interrupted_error();
            TRY_ASSIGN(const auto passed, next());
            if (!passed) break;
        }
        return {};
    }

    std::int64_t access_point(std::int64_t) const override { return 0; }
    /// Segments need colour.
    void leave_out_colour() override {}

private:
    /// Resets to before the first frame.
    void start() {
        segments_of_ = begin_(scene());
        painter_ = HapticPainter(scene());
        met_.assign(65536, false);
        before_.reset();
        *report_ = {};
    }

    void meet(const Segment& segment, std::int64_t frame) {
        PaintedSegments::Paint paint =
            paint_of(segment, scene().width * scene().height, materials_.named, materials_.otherwise);
        painter_.set(segment.label, paint.feel);
        met_[segment.label] = true;
        report_->segments.push_back(
            {segment.label, {segment.x, segment.y, frame}, segment.pixels, segment.colour, std::move(paint)});
    }

    void count_changes(const Segmentation& segmentation) {
        for (std::size_t k = 0; k < labels_before_.size(); ++k) {
            const std::uint16_t now = segmentation.labels[k], earlier = labels_before_[k];
            report_->compared += now != 0 && earlier != 0;
            report_->changed += now != 0 && earlier != 0 && now != earlier;
        }
    }

    const Materials materials_;
    const BeginSegments begin_;
    const std::shared_ptr<MaterialReport> report_;

    SegmentFrames segments_of_;
    std::vector<bool> met_;  // by label
    std::vector<std::uint16_t> labels_before_;
    std::optional<RawFrame::Place> before_;
};

Result<std::unique_ptr<ClipReader>> begin_reading(std::unique_ptr<ClipReader> clip,
                                                  const MaterialSettings& settings, LabelNames named,
                                                  const BeginSegments& begin,
                                                  std::shared_ptr<MaterialReport> report) {
    std::vector<Feel> others;
    for (const NamedSegment& name : settings.names.segments) others.push_back(name.feel);
    Scene scene = clip->scene();
    scene.haptic = settings.ranges.value_or(ranges_of_palette(scene, others));
    TRY(validate(scene));
    Materials materials{std::move(named), find_material(settings.names.otherwise), settings.scale_relief};
    return std::make_unique<MaterialReader>(std::move(clip), scene, std::move(materials), begin,
                                            std::move(report));
}

/// Cuts are followed both ways through time, so all frames are read before.
Result<std::unique_ptr<ClipReader>> with_cut_materials(std::unique_ptr<ClipReader> clip,
                                                       const MaterialSettings& settings,
                                                       const BeginSegments& begin,
                                                       std::shared_ptr<MaterialReport> report) {
    TRY_ASSIGN(auto read, read_segments(*clip, begin, {}));
    TRY_ASSIGN(auto cut, with_cuts(std::move(read), settings.names));
    TRY_ASSIGN(auto named, find_named_segments(cut, settings.names, settings.map));
    TRY(clip->rewind());
    const auto known = std::make_shared<const SegmentStore>(std::move(cut));
    return begin_reading(
        std::move(clip), settings, std::move(named),
        [known](const Scene&) {
            return [known, now = Segmentation()](const RawFrame& frame, bool) mutable -> const Segmentation& {
                return now = known->segmentation(frame.number);
            };
        },
        std::move(report));
}

}  // namespace

const PaletteMaterial& guess_material(const Segment& segment, std::int32_t of_pixels) {
    const int red = segment.colour[0], green = segment.colour[1], blue = segment.colour[2];
    const int chroma = std::max({red, green, blue}) - std::min({red, green, blue});
    if (is_unseen_colour(segment.colour.data())) return *find_material(of_unseen);
    const auto permille =
        static_cast<int>(std::int64_t{segment.pixels} * 1000 / std::max<std::int64_t>(of_pixels, 1));
    const Seen seen{hue_of(red, green, blue, chroma), (30 * red + 59 * green + 11 * blue) / 100, chroma,
                    std::clamp(segment.contrast, 0, 4080), permille};
    const auto* const rule = std::ranges::find_if(rules, [&](const Rule& each) {
        return (each.hue == Hue::any || each.hue == seen.hue) && each.brightness.holds(seen.brightness) &&
               each.chroma.holds(seen.chroma) && each.contrast.holds(seen.contrast) &&
               each.permille.holds(seen.permille);
    });
    return *find_material(rule->material);
}

PaintedSegments::Paint paint_of(const Segment& segment, std::int32_t of_pixels, const LabelNames& named,
                                const PaletteMaterial* otherwise) {
    if (const auto known = named.find(segment.label); known != named.end()) {
        const NamedSegment& name = known->second;
        return {name.name, name.material, name.feel, name.is_guess};
    }
    const PaletteMaterial* const material =
        otherwise != nullptr ? otherwise : &guess_material(segment, of_pixels);
    return {"", std::string(material->name), material->feel(), otherwise == nullptr};
}

HapticRanges ranges_of_palette(const Scene& scene, const std::vector<Feel>& others) {
    PropertyRange stiffness{as_stiff_as_the_device, as_stiff_as_the_device}, friction{0, 0};
    const auto hold = [&](const HapticProperties& properties) {
        widen_to(stiffness, properties.stiffness / 1000);
        widen_to(friction, properties.static_friction);
        widen_to(friction, properties.dynamic_friction);
    };
    for (const PaletteMaterial& material : palette()) hold(material.feel().properties);
    hold(scene.default_properties);
    for (const Feel& feel : others) hold(feel.properties);
    return {stiffness, friction, friction};
}

std::array<std::uint8_t, 3> haptic_code(const HapticProperties& properties, const HapticRanges& ranges) {
    return {ranges.stiffness.nearest(properties.stiffness / 1000),
            ranges.static_friction.nearest(properties.static_friction),
            ranges.dynamic_friction.nearest(properties.dynamic_friction)};
}

Result<std::unique_ptr<ClipReader>> with_painted_segments(std::unique_ptr<ClipReader> clip,
                                                          std::shared_ptr<const PaintedSegments> painted) {
    if (clip->is_live())
        return usage_error("materials are of clips, whose frames are all known; this is a camera");
    Scene scene = clip->scene();
    const SegmentStore& segments = *painted->segments;
    if (segments.width() != scene.width || segments.height() != scene.height)
        return usage_error("the segments are of pictures of " +
                           size_text(segments.width(), segments.height()) + ", and the clip's depth has " +
                           size_text(scene.width, scene.height));
    std::vector<Feel> feels;
    for (const auto& [label, paint] : painted->by_label) feels.push_back(paint.feel);
    scene.haptic = ranges_of_palette(scene, feels);
    TRY(validate(scene));
    return std::make_unique<PaintedReader>(std::move(clip), scene, std::move(painted));
}

Result<SegmentStore> read_segments(ClipReader& clip, const BeginSegments& begin,
                                   const std::function<void(std::int64_t frame)>& progress) {
    const Scene& scene = clip.scene();
    SegmentStore segments(scene.width, scene.height);
    const SegmentFrames segments_of = begin(scene);
    for (;;) {
        if (stop_requested()) return interrupted_error();
        TRY_ASSIGN(const auto frame, clip.next());
        if (!frame) break;
        if (frame->number != segments.frames())
            return input_error(clip.name() + ": frame " + std::to_string(frame->number) +
                               " comes after frame " + std::to_string(segments.frames() - 1) +
                               "; must be the next one");
        if (progress) progress(frame->number);
        segments.add(segments_of(*frame, segments.frames() > 0));
        if (segments.bytes() > most_segment_bytes)
            return input_error(
                clip.name() + ": its first " + std::to_string(segments.frames()) +
                " frames have segments of 1 GiB, as many as are kept; a shorter clip would do");
    }
    if (segments.frames() == 0) return input_error(clip.name() + ": has no frames");
    return segments;
}

Result<std::unique_ptr<ClipReader>> with_materials(std::unique_ptr<ClipReader> clip,
                                                   const MaterialSettings& settings,
                                                   const BeginSegments& begin,
                                                   std::shared_ptr<MaterialReport> report) {
    if (!settings.names.cuts.empty()) return with_cut_materials(std::move(clip), settings, begin, report);
    Prefetch ahead(std::move(clip));
    TRY_ASSIGN(auto named, find_named_segments(ahead, settings.names, settings.map, begin));
    TRY_ASSIGN(auto again, ahead.finish());
    return begin_reading(std::move(again), settings, std::move(named), begin, std::move(report));
}

}  // namespace touchable
