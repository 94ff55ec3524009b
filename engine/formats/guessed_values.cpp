// SPDX-License-Identifier: Apache-2.0
// Guesses what depth's values mean: as stated, by preset, by names and files, by the numbers themselves.

#include <cmath>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/scene_draft.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr double most_of_lengths = 1.05;  // lower third of a picture over the upper

double itself(double value) {
    return value;
}

class ValuesGuess {
public:
    ValuesGuess(const StoredImage& depth, DepthEvidence& evidence, SceneDraft& draft)
        : depth_(depth), evidence_(evidence), draft_(draft), values_(estimate_values(depth)) {}

    Result<void> find() {
        if (stop_requested()) return interrupted_error();
        const auto &near = evidence_.known.near, &far = evidence_.known.far;
        if (near.has_value() != far.has_value() || (near && *near >= *far))
            return usage_error("near and far need each other, and near is less than far",
                               {{Setting::near}, {Setting::far}});
        if (values_.are_shares || values_.bits == 8 || values_.is_normalised)
            empty_ = empty_background(depth_);
        if (empty_ && empty_->value != static_cast<std::uint16_t>(empty_->value)) empty_.reset();
        TRY(find_unit());
        scene_.stored.packed = depth_.packing;
        doubt_unit();
        set_invalid();
        find_semantics();
        return {};
    }

private:
    std::uint16_t largest_code() const { return scene_.depth_bits == 8 ? 255 : 65535; }

    /// Sets the unit: as stated, by preset, by names or files beside depth, or by the size of the values.
    Result<void> find_unit() {
        if (!values_.any)
            return input_error(
                values_.has_background
                    ? "has no depth: all values are 0 or a renderer's background (1e9 and beyond, 65504)"
                    : "has no depth: all values are 0 or 65535, or none is finite");
        const CameraBeside& beside = evidence_.beside;
        const auto& [codes, scale_file] = beside.codes_per_metre;
        const auto& [metres, unit_file] = beside.metres_per_value;
        const bool are_codes = !values_.is_float && values_.bits > 8;  // 8 bits are hardly ever lengths
        const auto& named = evidence_.unit;
        const auto*& preset = evidence_.preset;
        if (!evidence_.has_unit() && evidence_.says_disparity && codes == 0 && !take_named_disparities())
            return {};
        const SourceDescription& known = evidence_.known;
        if (const auto& stated = known.metres_per_code) {
            set_metric(*stated);
        } else if (known.near && preset == nullptr && may_have_planes()) {
            set_planes(*known.near, *known.far);
        } else if (preset && preset->stored.kind == StoredDepth::Kind::disparity) {
            return set_disparities(*preset);
        } else if (preset && preset->stored.kind == StoredDepth::Kind::relative) {
            set_relative(true, true);
        } else if (preset && preset->metres_per_code > 0) {
            scene_.stored = preset->stored;
            set_metric(preset->metres_per_code);
        } else if (codes > 0 && are_codes) {
            take_unit(1 / codes, "a code is " + short_number(1000 / codes) + " mm", scale_file);
        } else if (named &&
                   (values_.is_float || (are_codes && named->metres < 1))) {  // integers are no metres
            take_unit(named->metres, std::string("values are ") + named->words, {});
        } else if (metres > 0 && values_.is_float) {
            take_unit(metres, "a value of 1 is " + short_number(1000 * metres) + " mm", unit_file);
        } else {
            guess_unit();
            is_unit_guessed_ = true;
        }
        if (!known.near || has_planes_ || scene_.depth.kind != DepthCodingKind::metric) return {};
        return usage_error(
            "near and far are planes of depth from 0 to 1, or without a scale; these are lengths",
            {{Setting::near}, {Setting::far}});
    }

    double largest() const { return values_.is_float ? 1 : largest_code(); }
    /// Whether large values are far, as seen from an empty background. A depth buffer's are seldom near 0
    /// then, as most of the range is before the first thing.
    bool near_is_low() const { return empty_ ? !empty_->near_is_high : values_.median > 0.5 * largest(); }
    /// Whether integers are as near the far plane's as a depth buffer's, and no lengths.
    bool is_deep() const {
        return !values_.is_float && std::min(values_.lower, values_.upper) > 0.75 * largest();
    }
    /// Whether values may go from one plane to another: all of 8 bits, floats from 0 to 1, and words that are
    /// large, as most of a depth buffer are, or no lengths.
    bool may_have_planes() const {
        return values_.are_shares || values_.bits == 8 || values_.is_normalised ||
               (holds_words(depth_) &&
                (near_is_low() || PlaneVotes(depth_, itself, reciprocal).are_for_first()));
    }
    /// 1/depth of values that go evenly from plane to plane.
    PlaneVotes::Reading evenly(double near, double far, bool is_high_near) const {
        return [=, all = largest()](double value) {
            return 1 / (near + (is_high_near ? 1 - value / all : value / all) * (far - near));
        };
    }

    /// Takes values between 0 and the largest for depth between planes: evenly in depth, from either plane or
    /// from 0 on, if flat places say so; otherwise a depth buffer, which is affine in 1/depth. Those of 8
    /// bits that are not all near the far plane's are no buffer's.
    void set_planes(double near, double far) {
        DepthCoding& depth = scene_.depth;
        const PlaneVotes lengths(depth_, itself, reciprocal);
        bool is_even = false, is_seen = is_buffer_ || is_deep() || lengths.are_for_first();
        has_planes_ = true;
        depth.near_is_high = !near_is_low();
        if (lengths.are_for_second() && std::min(values_.lower, values_.upper) * far > near * largest() &&
            !PlaneVotes(depth_, evenly(near, far, false), reciprocal).are_for_first()) {
            draft_.tell("values are shares of the far plane, as flat places are flat so");
            return set_metric(far / largest());
        }
        for (const bool is_high : {false, true}) {
            if (!PlaneVotes(depth_, itself, evenly(near, far, is_high)).are_for_second()) continue;
            depth.near_is_high = is_high;
            is_even = is_seen = true;
        }
        is_buffer_ = !is_even && (values_.bits != 8 || is_deep() || is_seen);
        if (!is_seen && !is_buffer_ && !empty_) depth.near_is_high = values_.lower >= values_.upper;
        const bool is_inverse = is_buffer_ || (!is_even && depth.near_is_high);
        depth.kind = is_inverse ? DepthCodingKind::inverse : DepthCodingKind::linear;
        depth.code_max = largest_code();
        depth.near = near;
        depth.far = far;
        if (is_buffer_ && values_.is_float) {  // its codes would be coarse beyond the first thing
            StoredDepth& stored = scene_.stored;
            stored.kind = StoredDepth::Kind::disparity;
            stored.baseline = 1 / scene_.camera.fx;
            stored.scale = (1 / near - 1 / far) * (depth.near_is_high ? 1 : -1);
            stored.offset = 1 / (depth.near_is_high ? far : near);
        }
        const std::string what = std::string("values go from plane to plane evenly in ") +
                                 (is_inverse ? "1/depth, " : "depth, ") +
                                 (depth.near_is_high ? "large" : "small") + " ones near";
        const auto nearness = [&](double value) { return depth.near_is_high ? value : largest() - value; };
        if (!empty_ && nearness(values_.upper) > most_of_lengths * nearness(values_.lower)) say_bottom_up();
        if (is_seen)
            draft_.tell(what + ", as flat places are flat so");
        else
            draft_.say(what, {}, RemarkKind::storage);
    }

    /// Takes values for depth between planes, if flat places are flat by them, or planes are stated beside
    /// them: a depth buffer, perhaps of unknown planes. Floats that no place decides are lengths;
    /// `may_be_buffer_` says that.
    bool take_depth_buffer() {
        const StatedNumber &near = evidence_.beside.near, &far = evidence_.beside.far;
        const bool are_stated = near.value > 0 && near.value < far.value;
        const bool may_be = values_.is_float ? values_.are_shares : is_deep() || near_is_low() || are_stated;
        if (!may_be || (values_.is_normalised && !are_stated) || values_.divisor > 1) return false;
        LatticeSearch steps;
        const std::size_t every = depth_.values.size() / 8192 | 1U;
        for (std::size_t k = 0; k < depth_.values.size(); k += every)
            if (depth_.values[k] > 0) steps.add(depth_.values[k]);
        const auto even = steps.of_lengths(1);
        const double tenths = even && even->first == 0 ? even->step / 1e-4 : 0.5;  // of a millimetre
        if (std::abs(tenths - std::round(tenths)) < 1e-6) return false;            // a sensor's lengths
        const PlaneVotes votes(depth_, itself, reciprocal);
        is_buffer_ = votes.are_for_first() || (is_deep() && !votes.are_for_second());
        may_be_buffer_ = near_is_low() && !votes.are_for_second();
        const bool is_even =
            are_stated &&
            PlaneVotes(depth_, evenly(near.value, far.value, false), reciprocal).are_for_first();
        const std::string what =
            std::string("depth is a renderer's depth buffer, as ") +
            (is_deep() ? "all values are near the largest" : "flat places are flat by its values");
        if (are_stated && (is_buffer_ || is_even || values_.bits == 8)) {
            set_planes(near.value, far.value);
            draft_.add_input(near.file);
            draft_.tell((is_buffer_ ? what + ", from " : "depth goes from ") + short_number(near.value) +
                            " to " + short_number(far.value) + " m, as " +
                            printable(near.file.filename().string()) + " says",
                        {{Setting::near}, {Setting::far}});
        } else if (is_buffer_) {
            set_relative(
                true, !near_is_low(),
                Remark{is_deep() ? what : what + " and not by their reciprocals",
                       true,
                       "its planes give it its shape, or the unit, if values are lengths",
                       {{Setting::near}, {Setting::far}, {Setting::depth_unit, values_.is_float ? "1" : ""}},
                       RemarkKind::planes});
        }
        return has_planes_ || is_buffer_;
    }

    /// Takes values for disparities: Middlebury's, if a file has their baseline; otherwise without a scale,
    /// which is settled then: false.
    bool take_named_disparities() {
        const std::string guess = "depth is disparities, as the name says";
        const CameraBeside& beside = evidence_.beside;
        if (beside.camera && beside.camera->baseline > 0) {
            evidence_.preset = preset_named("middlebury");
            draft_.say(guess + "; baseline and focal length are those of " +
                           printable(beside.file.filename().string()),
                       {{Setting::preset}, {Setting::depth_unit}}, RemarkKind::storage);
            return true;
        }
        draft_.say(guess + ", and no calib.txt beside it has their baseline",
                   {{Setting::preset, "middlebury"}, {Setting::depth_unit}}, RemarkKind::storage,
                   "with a calib.txt that has it they have a scale");
        set_relative(true, true);
        scene_.depth.invalid_code_count = 1;  // 0 is infinitely far
        return false;
    }

    Result<void> set_disparities(const SourceDescription::Preset& preset) {
        StoredDepth& stored = scene_.stored = preset.stored;
        if (stored.baseline == 0) {
            const auto& camera = evidence_.beside.camera;
            if (!camera || camera->baseline == 0)
                return input_error(
                    "preset " + std::string(preset.name) + " needs the calib.txt of the pictures beside them",
                    {{Setting::preset}});
            stored.baseline = camera->baseline;
            stored.offset = camera->offset * scene_.camera.fx / camera->intrinsics.fx;
            if (!values_.is_float && values_.median > 3 * scene_.width) {
                stored.scale = 1.0 / 256;
                draft_.say("a code is 1/256 of a pixel (KITTI), as whole ones are wider than the picture",
                           {{Setting::depth_unit}}, RemarkKind::unit);
            }
            draft_.add_input(evidence_.beside.file);
        } else if (preset.intrinsics.fx > 0) {  // baseline x fx is what is known
            stored.baseline *= preset.intrinsics.fx / scene_.camera.fx;
        }
        scene_.depth.kind = DepthCodingKind::inverse;
        scene_.depth.code_max = largest_code();
        scene_.depth.near = scene_.camera.fx * stored.baseline / 65536;
        scene_.depth.far = scene_.camera.fx * stored.baseline;
        return {};
    }

    /// Takes the unit that a file states, or depth's name if that is empty.
    void take_unit(double metres, const std::string& fact, const fs::path& file) {
        set_metric(metres);
        if (!file.empty()) draft_.add_input(file);
        draft_.tell(
            fact + ", as " + (file.empty() ? "the name" : printable(file.filename().string())) + " says",
            {{Setting::depth_unit}});
    }

    void set_metric(double metres_per_code) {
        DepthCoding& depth = scene_.depth;
        depth.kind = DepthCodingKind::metric;
        depth.scale = metres_per_code;
        depth.code_max = largest_code();
        depth.far = depth.scale * depth.code_max;
        draft_.unstated.far = true;
    }

    /// Values that are larger for near pixels are 1/depth, as most networks guess it; others are depth. A
    /// depth buffer is affine in 1/depth either way.
    void set_relative(bool is_inverse, bool near_is_high, std::optional<Remark> guess = {}) {
        DepthCoding& depth = scene_.depth;
        const SourceDescription& known = evidence_.known;
        scene_.stored.kind = StoredDepth::Kind::relative;
        depth.kind = is_inverse ? DepthCodingKind::inverse : DepthCodingKind::linear;
        depth.near_is_high = near_is_high;
        depth.near = known.near.value_or(assumed_near);
        depth.far = known.far.value_or(assumed_far);
        depth.code_max = largest_code();
        if (known.near) return;
        if (!guess)
            guess =
                Remark{"depth has no scale",
                       true,
                       "a scene file says otherwise, touchable init-scene writes one to begin with; where "
                       "values are lengths, their unit",
                       {{Setting::depth_unit}},
                       RemarkKind::scale};
        guess->what += ": its nearest is taken for " + short_number(assumed_near) +
                       " m and its farthest for " + short_number(assumed_far) + " m, " +
                       (near_is_high ? "large" : "small") + " values near";
        add_remark(scene_.remarks, std::move(*guess));
    }

    void guess_unit() {
        const Hints otherwise{{Setting::depth_unit}};
        const bool is_signed = values_.negative > 0.01;
        if (values_.is_of_bytes())
            draft_.say(
                "values are 8 bits stored as 16, as all are multiples of " + std::to_string(values_.divisor),
                otherwise, RemarkKind::unit);
        if (take_depth_buffer()) return;
        if (evidence_.are_heights) {
            set_relative(false, true,
                         Remark{"values are heights, as the name says",
                                true,
                                "the unit says that they are lengths",
                                {{Setting::depth_unit}},
                                RemarkKind::scale});
        } else if (values_.bits == 8 || values_.is_of_bytes() || values_.is_normalised || is_signed ||
                   is_of_shares(depth_.packing) || (empty_ && empty_->near_is_high)) {
            const bool is_inverse =
                empty_ ? empty_->near_is_high : is_signed || values_.lower >= values_.upper;
            set_relative(is_inverse, is_inverse);
        } else if (values_.is_float) {
            constexpr double most_metres = 30, least_millimetres = 600;
            const bool metres = values_.median < most_metres;
            const bool may_be_centimetres = !metres && values_.median < least_millimetres;
            const double unit = metres ? 1 : 0.001;
            set_metric(unit);
            draft_.say(std::string("values are ") + (metres ? "metres" : "millimetres") + median_words(unit),
                       may_be_centimetres ? Hints{{Setting::depth_unit, "0.01"}}
                       : may_be_buffer_   ? plane_hints()
                                          : otherwise,
                       may_be_centimetres || may_be_buffer_ ? RemarkKind::unclear_unit : RemarkKind::unit,
                       may_be_centimetres
                           ? short_number(0.01 * values_.median, 3) + " m if they are centimetres"
                       : may_be_buffer_ ? "a renderer's depth buffer has such values too, between two planes"
                                        : "");
            // The lower part of a picture is mostly nearer.
            if (values_.lower > most_of_lengths * values_.upper && !evidence_.are_points &&
                values_.usable > 0.5)
                say_direction();
        } else if (!evidence_.list.empty()) {
            set_metric(1.0 / 5000);
            draft_.say("a code is 0.2 mm, as recordings with a " + evidence_.list + " have it (TUM RGB-D)",
                       otherwise, RemarkKind::unit);
        } else if (!guess_unit_of_multiples()) {
            const bool fine = values_.median > 12000 && evidence_.usual_unit == 0,
                       coarse = values_.median < 100;
            const double unit = fine ? 1.0 / 5000 : coarse ? 0.01 : 0.001;
            set_metric(unit);
            say_unit(unit);
        }
    }

    /// The planes stated beside depth, if any.
    Hints plane_hints() const {
        const double near = evidence_.beside.near.value, far = evidence_.beside.far.value;
        return {{Setting::near, near > 0 ? short_number(near) : ""},
                {Setting::far, far > 0 ? short_number(far) : ""}};
    }
    void say_bottom_up() {
        draft_.say(
            "the upper third of the picture is nearer than the lower one: its rows may go from the bottom "
            "up, as OpenGL's do (numpy.flipud turns them)",
            {}, RemarkKind::storage);
    }
    void say_direction() {
        if (PlaneVotes(depth_, itself, reciprocal).are_for_second())
            say_bottom_up();
        else
            draft_.say(
                "values are lengths, though they are larger in the lower third of the picture, as 1/depth of "
                "networks is",
                {{Setting::preset, "relative-inverse"}}, RemarkKind::direction);
    }

    std::string median_words(double unit) const {
        return ": their median, " + short_number(values_.median) + ", would be " +
               short_number(values_.median * unit, 3) + " m";
    }

    /// Tells the guessed unit of 16-bit values and others that fit, with the scene's size in each.
    void say_unit(double unit) {
        constexpr double near_for_a_camera = 1000, far_for_a_room = 3000;  // of a median, millimetres
        constexpr double most_of_lidar = 0.5, least_sky = 0.01;            // shares of the pixels
        struct Reading {
            bool is_possible;
            const char* unit;
            const char* when;
        };
        const bool is_millimetre = unit == 0.001, is_far = values_.median > far_for_a_room;
        const Reading readings[] = {
            {is_millimetre && values_.largest > least_sky && values_.zeros == 0, "0.01",
             "if they are centimetres and 65535 is the sky (Virtual KITTI)"},
            {is_millimetre && (values_.median < near_for_a_camera || is_far || values_.zeros > most_of_lidar),
             "0.00390625", "if 256 codes are a metre (KITTI, VOID, ZoeDepth)"},
            {is_millimetre && values_.median < near_for_a_camera, "0.001953125",
             "if 512 codes are a metre (Taskonomy)"},
            {is_millimetre && values_.median < near_for_a_camera, "0.01525902",
             "if 65535 is 1 km (PointOdyssey)"},
            {is_millimetre && is_far, "0.00025", "if 4000 codes are a metre (Matterport3D)"},
            {is_millimetre && is_far, "0.0002", "if 5000 codes are a metre (TUM)"},
            {!is_millimetre, "0.001", "if they are millimetres"},
            {unit < 0.001 || (is_millimetre && (is_far || evidence_.usual_unit > 0)), "0.0001",
             "if they are tenths of a millimetre"}};
        const auto size = [&](double metres) { return short_number(values_.median * metres, 3) + " m"; };
        std::string others;
        Hints hints;
        for (const auto& [is_possible, other, when] : readings) {
            if (!is_possible) continue;
            others += (others.empty() ? "" : "; ") + size(*parsed_number(other)) + ' ' + when;
            // The preset knows that the sky is no depth.
            if (std::string_view(other) == "0.01")
                hints.push_back({Setting::preset, "vkitti"});
            else
                hints.push_back({Setting::depth_unit, other});
        }
        if (holds_words(depth_) && values_.median > 0x2c00 && values_.median < 0x5400) {
            others += (others.empty() ? "" : "; ") + short_number(half_value(values_.median), 3) +
                      " m if they are the bits of halves";
            hints.push_back({Setting::preset, "half"});
        }
        if (unit < 0.001) {
            const double below = 0.001 * (static_cast<int>(values_.median) & 0x1fff);
            others += "; " + short_number(below, 3) + " m if the 3 highest bits are a confidence (DEPTH16)";
            hints.push_back({Setting::preset, "depth16"});
        }
        if (hints.empty()) hints = {{Setting::depth_unit}};
        const RemarkKind kind = others.empty() ? RemarkKind::unit : RemarkKind::unclear_unit;
        draft_.say("depth codes are " + (is_millimetre ? "millimetres" : short_number(1000 * unit) + " mm") +
                       median_words(unit),
                   std::move(hints), kind, std::move(others));
    }

    /// Guesses the unit by the values' divisor: cameras measure whole millimetres, and files may have these
    /// times 5, 10 or 100. False if that does not settle it.
    bool guess_unit_of_multiples() {
        constexpr double nearest = 250, deepest = 12'000;  // millimetres, of a median
        const int divisor = values_.divisor;
        if (divisor == 1) return false;
        const std::string multiples = "all values are multiples of " + std::to_string(divisor);
        const double median = values_.median / divisor;
        const bool is_usual = divisor == 5 || divisor == 10 || divisor == 100;
        if (!is_usual || median < nearest || median > deepest) {
            draft_.say(multiples + ", which tells nothing of their unit", {{Setting::depth_unit}});
            return false;
        }
        set_metric(0.001 / divisor);
        draft_.say("a code is " + short_number(1.0 / divisor) + " mm, as " + multiples +
                       " and their median is then " + short_number(median) + " mm",
                   {{Setting::depth_unit, values_.median <= deepest ? "0.001" : ""}}, RemarkKind::unit);
        return true;
    }

    /// Adds a remark if the unit is doubtful, with one by which the values are in a hand's reach, if any.
    void doubt_unit() {
        if (scene_.depth.kind != DepthCodingKind::metric || !scene_.stored.is_plain()) return;
        std::string otherwise = "a unit is the metres that a stored 1 stands for, such as 0.001";
        Hint hint{Setting::depth_unit};
        constexpr std::pair<const char*, const char*> usual[] = {
            {"0.0001", "tenths of a millimetre"}, {"1", "metres"}, {"0.001", "millimetres"}};
        for (const auto& [unit, name] : usual) {
            const double median = values_.median * *parsed_number(unit);
            if (median < 0.1 || median > 10) continue;
            otherwise = short_number(median) + " m if values are " + name;
            hint.value = unit;
        }
        if (auto doubt =
                unit_doubt(values_.median * scene_.depth.scale, std::move(otherwise), {std::move(hint)}))
            add_remark(scene_.remarks, std::move(*doubt));
    }

    /// Sets the codes that are no depth: cameras write 0. Depth without a scale has none.
    void set_invalid() {
        DepthCoding& coding = scene_.depth;
        // What no surface covers has the far plane's number.
        const bool is_relative = scene_.stored.kind == StoredDepth::Kind::relative;
        if (is_buffer_ || (empty_ && (is_relative || has_planes_))) {
            coding.invalid_codes[0] = static_cast<std::uint16_t>(empty_                ? empty_->value
                                                                 : coding.near_is_high ? 0
                                                                                       : largest());
            coding.invalid_code_count = 1;
        }
        if (is_relative || (has_planes_ && coding.kind != DepthCodingKind::metric)) return;
        const bool is_told = evidence_.has_unit() || evidence_.usual_unit > 0;
        const auto* const preset = evidence_.preset;
        const bool may_be_full = holds_words(depth_) && (!is_told || values_.largest > 0);
        const int other = preset                       ? preset->invalid
                          : has_planes_ || may_be_full ? static_cast<int>(largest())
                                                       : 0;
        const int above = evidence_.has_values() ? 0 : none_above_all(depth_).value_or(0);
        for (const int code : {0, other, above})
            if (coding.invalid_code_count == 0 || (code > 0 && code <= coding.code_max))
                coding.invalid_codes[static_cast<std::size_t>(coding.invalid_code_count++)] =
                    static_cast<std::uint16_t>(code);
        if (above > 0)
            draft_.say(std::to_string(above) +
                       " is no depth, as many pixels have it and no other comes near it");
        if (!is_told || (other > 0 && !evidence_.has_values()))
            draft_.say(other > 0                   ? "0 and 65535 are no depth"
                       : values_.has_negative_none ? "0 and what is below it are no depth"
                                                   : "0 is no depth");
    }

    /// Decides whether lengths go along each pixel's ray, as the name may say, or along the camera's axis, as
    /// depth cameras record them. Floats in files may be either, as a renderer or a laser has them.
    void find_semantics() {
        if (evidence_.known.semantics || scene_.depth.kind != DepthCodingKind::metric) return;
        if (evidence_.says_range) {
            scene_.depth.semantics = DepthSemantics::range;
            draft_.say("depth goes along each pixel's ray, as the name says",
                       {{Setting::depth_kind, "planar"}}, RemarkKind::axis);
            return;
        }
        const bool is_open = values_.is_float || (is_unit_guessed_ && !evidence_.has_camera());
        if (!evidence_.is_named || evidence_.has_values() || !is_open) return;
        const double nearer = 100 * (1 - 1 / scene_.camera.longest_ray(scene_.width, scene_.height));
        constexpr double least_felt = 5;  // per cent
        if (nearer < least_felt) return;
        draft_.say(
            "depth goes along the camera's axis (planar); if it goes along each pixel's ray, the corners "
            "are " +
                short_number(nearer, 2) + " % nearer",
            {{Setting::depth_kind, "range"}}, RemarkKind::axis);
    }

    const StoredImage& depth_;
    DepthEvidence& evidence_;  // gets the preset that names and files show together
    SceneDraft& draft_;
    Scene& scene_ = draft_.scene;
    const EstimatedValues values_;
    std::optional<EmptyBackground> empty_{};  // of values that may have no scale
    bool is_unit_guessed_ = false, is_buffer_ = false, may_be_buffer_ = false, has_planes_ = false;
};

}  // namespace

Result<void> guess_values(const StoredImage& depth, DepthEvidence& evidence, SceneDraft& draft) {
    return ValuesGuess(depth, evidence, draft).find();
}

}  // namespace touchable
