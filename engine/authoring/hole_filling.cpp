#include "engine/authoring/hole_filling.hpp"

#include <cstdlib>

namespace touchable {

namespace {

constexpr double share_of_depth = 1.0 / 64;
constexpr std::int32_t least_tolerance = 2, most_of_codes = 8;

std::int32_t tolerance_of(const DepthCoding& coding, std::uint16_t code) {
    if (coding.valid_min == coding.valid_max) return least_tolerance;
    const auto beside = static_cast<std::uint16_t>(code < coding.valid_max ? code + 1 : code - 1);
    const double depth = coding.depth(code), step = depth - coding.depth(beside);
    const double size = step < 0 ? -step : step;
    const std::int32_t most = std::max<std::int32_t>(least_tolerance, coding.code_max / most_of_codes);
    if (!(size * most > share_of_depth * depth)) return most;
    return std::clamp(static_cast<std::int32_t>(share_of_depth * depth / size), least_tolerance, most);
}

constexpr std::int64_t least_elsewhere = 48;
constexpr std::int32_t same_level = 5 * CellPicture::per_level / 2,
                       much_other_level = 24 * CellPicture::per_level;
/// Of so many cells with depth one must be textured to tell of the camera.
constexpr std::size_t texture_share = 6;
constexpr std::int32_t times_much = 16;

/// Brightness that all cells gained: a camera's exposure.
std::int32_t exposure_change(const CellPicture& then, const CellPicture& now) {
    std::vector<std::int32_t> gained;
    for (std::size_t k = 0; k < now.cells.size(); ++k)
        gained.push_back(now.cells[k].luma - then.cells[k].luma);
    const auto middle = gained.begin() + static_cast<std::ptrdiff_t>(gained.size() / 2);
    std::ranges::nth_element(gained, middle);
    return *middle;
}

constexpr std::int32_t colour_tolerance = 16;  // of 255, in each channel
constexpr std::int32_t code_parts = 256, colour_parts = 16;
constexpr std::int32_t longest_mean = 64, most_counted = 65535;  // frames
/// A mode that tells was seen so often, and in such a share of the frames.
constexpr std::int32_t least_seen = 3, share_with_colour = 16, share_without = 4;

Rgb colour_of(const std::array<std::uint16_t, 3>& mean) {
    Rgb rgb{};
    for (std::size_t k = 0; k < 3; ++k)
        rgb[k] = static_cast<std::uint8_t>((mean[k] + colour_parts / 2) / colour_parts);
    return rgb;
}

/// A shadow of a depth camera is a narrow strip: at most this share of the picture's width.
constexpr int narrow_share = 16, least_narrow = 8;
constexpr std::size_t most_nearer = 4;
/// Without colour: a hole that is narrow in parts only is no shadow. Those parts touch the rest in less than
/// this share of the places in which they touch what is behind.
constexpr std::size_t left_share = 4;
/// Of a registered recording of a person 16 % look like what is behind, of hands whose colour lies 24 pixels
/// beside them 40 to 100 %. So few pixels say nothing.
constexpr double most_alike = 0.25;
constexpr std::int64_t least_nearer = 100;

Rgb colour_at(const PlaneView& colour, int x, int y) {
    const std::uint8_t* rgb = colour.row(y) + std::ptrdiff_t{3} * x;
    return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace

CodedDepth::CodedDepth(const DepthCoding& coding)
    : coding_(coding), deeper_is_higher_(coding.deeper_is_higher()), tolerance_(65536) {
    for (std::int32_t code = coding.valid_min; code <= coding.valid_max; ++code) {
        const auto word = static_cast<std::uint16_t>(code);
        if (coding.is_valid(word)) tolerance_[word] = tolerance_of(coding, word);
    }
    if (coding.kind != DepthCodingKind::hue) return;
    hue_of_.resize(DepthCoding::hue_circle);
    is_known_.resize(DepthCoding::hue_circle);
}

PlaneView CodedDepth::codes_of(const RawFrame& frame, std::vector<std::uint16_t>& codes) const {
    if (coding_.kind != DepthCodingKind::hue) return frame.depth;
    const PlaneView& depth = frame.depth;
    codes.resize(pixel_count(depth.width, depth.height));
    std::uint16_t* to = codes.data();
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) *to++ = stored_code(depth, coding_, x, y);
    return {reinterpret_cast<const std::uint8_t*>(codes.data()),
            std::ptrdiff_t{2} * depth.width,
            depth.width,
            depth.height,
            2,
            1};
}

void CodedDepth::remember(const RawFrame& frame, const PlaneView& codes) {
    if (coding_.kind != DepthCodingKind::hue) return;
    for (int y = 0; y < codes.height; ++y) {
        const std::uint8_t* rgb = frame.depth.row(y);
        for (int x = 0; x < codes.width; ++x, rgb += 3) {
            const std::uint16_t code = codes.sample(x, y);
            if (code == no_hue || is_known_[code]) continue;
            is_known_[code] = true;
            hue_of_[code] = {rgb[0], rgb[1], rgb[2]};
        }
    }
}

void CodedDepth::put(std::uint16_t code, std::uint8_t* row, int x, int bytes_per_sample) const {
    if (coding_.kind == DepthCodingKind::hue)
        std::memcpy(row + std::ptrdiff_t{3} * x, hue_of_[code].data(), 3);
    else if (bytes_per_sample == 1)
        row[x] = static_cast<std::uint8_t>(code);
    else
        std::memcpy(row + std::ptrdiff_t{2} * x, &code, 2);
}

bool Rest::is_long_enough() const {
    return count >= (begins_with_cut && ends_with_cut ? least_between_cuts : least_elsewhere);
}

CameraRest::Changes CameraRest::changes(const CellPicture& then, const CellPicture& now) const {
    Changes changes;
    const bool has_colour = then.has_colour && now.has_colour;
    const std::int32_t gain = has_colour ? exposure_change(then, now) : 0;
    for (std::size_t k = 0; k < now.cells.size(); ++k) {
        const CellPicture::Cell &was = then.cells[k], &is = now.cells[k];
        ++changes.all;
        const std::int32_t level = has_colour ? std::abs(is.luma - was.luma - gain) : 0;
        changes.textured += was.is_textured;
        changes.luma += was.is_textured && level > same_level;
        changes.much_luma += level > much_other_level;
        if (was.depth == CellPicture::none || is.depth == CellPicture::none) continue;
        ++changes.known;
        // A quarter of the tolerance of a pixel and half a code, as a cell is the mean of many.
        const auto code = static_cast<std::uint16_t>(was.depth / CellPicture::per_code);
        const std::int32_t tolerance = (depth_.tolerance(code) + 2) * CellPicture::per_code / 4;
        changes.depth += std::abs(is.depth - was.depth) > tolerance;
        changes.much_depth += std::abs(is.depth - was.depth) > times_much * tolerance;
    }
    return changes;
}

bool CameraRest::ends_with(CellPicture picture) {
    const std::int64_t frame = current_.first + current_.count;
    if (frame == 0 || before_.cells.size() != picture.cells.size()) {
        first_ = before_ = std::move(picture);
        ended_ = std::exchange(current_, {frame, 1, true, true});
        return frame > 0;
    }
    const Changes since_first = changes(first_, picture);
    const bool has_moved = 2 * since_first.depth > since_first.known ||
                           (texture_share * since_first.textured >= since_first.known &&
                            2 * since_first.luma > since_first.textured);
    if (has_moved) {
        const Changes at_once = changes(before_, picture);
        const bool is_cut = 2 * at_once.much_luma > at_once.all || 2 * at_once.much_depth > at_once.known;
        current_.ends_with_cut = is_cut;
        ended_ = std::exchange(current_, {frame, 1, is_cut, true});
        first_ = picture;
    } else {
        ++current_.count;
        for (std::size_t k = 0; k < first_.cells.size(); ++k)
            if (first_.cells[k].depth == CellPicture::none) first_.cells[k].depth = picture.cells[k].depth;
    }
    before_ = std::move(picture);
    return has_moved;
}

bool agree(const Rgb& a, const Rgb& b) {
    for (std::size_t k = 0; k < 3; ++k)
        if (std::abs(a[k] - b[k]) > colour_tolerance) return false;
    return true;
}

void BackgroundModel::begin() {
    std::fill(pixels_.begin(), pixels_.end(), Modes{});
    frames_ = 0;
}

/// The mode that it belongs to, by depth and colour, is moved towards it; what belongs to none replaces the
/// one seen least. (A hand that rests on a table is nearly as deep, and must not draw the table to it.)
void BackgroundModel::see(Modes& modes, std::uint16_t code, const std::uint8_t* rgb) const {
    const std::int32_t exact = code * code_parts, tolerance = depth_.tolerance(code) * code_parts;
    const auto may_be = [&](const Mode& mode) {
        return mode.count > 0 && std::abs(exact - mode.mean) <= tolerance &&
               (!rgb || agree({rgb[0], rgb[1], rgb[2]}, colour_of(mode.colour)));
    };
    Mode* nearest = nullptr;
    for (Mode& mode : modes)
        if (may_be(mode) && (!nearest || std::abs(exact - mode.mean) < std::abs(exact - nearest->mean)))
            nearest = &mode;
    if (!nearest) {
        nearest = &*std::ranges::min_element(modes, {}, &Mode::count);
        *nearest = {exact, code, 0, {}};
    }
    Mode& mode = *nearest;
    if (mode.count < most_counted) ++mode.count;
    const std::int32_t frames = std::min<std::int32_t>(mode.count, longest_mean);
    mode.mean += (exact - mode.mean) / frames;
    if (std::abs(exact - mode.mean) <= std::abs(mode.code * code_parts - mode.mean)) mode.code = code;
    if (!rgb) return;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t now = rgb[k] * colour_parts, mean = mode.colour[k];
        mode.colour[k] = static_cast<std::uint16_t>(mean + (now - mean) / frames);
    }
}

void BackgroundModel::add_rows(const PlaneView& codes, const PlaneView& colour, const RowBand& band) {
    for (int y = band.first; y < band.last; ++y) {
        Modes* modes = pixels_.data() + std::ptrdiff_t{y} * width_;
        const std::uint8_t* rgb = colour.empty() ? nullptr : colour.row(y);
        for (int x = 0; x < width_; ++x, ++modes) {
            const std::uint16_t code = codes.sample(x, y);
            if (depth_.is_valid(code)) see(*modes, code, rgb ? rgb + std::ptrdiff_t{3} * x : nullptr);
        }
    }
}

void BackgroundModel::add(const PlaneView& codes, const PlaneView& colour, RowBands& bands) {
    ++frames_;
    bands.for_each_band(codes.height, 1, [&](const RowBand& band) { add_rows(codes, colour, band); });
}

BackgroundPixel BackgroundModel::behind(const Modes& modes, std::int32_t least, bool has_colour) const {
    const Mode* chosen = nullptr;
    for (const Mode& mode : modes)
        if (mode.count >= least && (!chosen || depth_.deeper_by(mode.code, chosen->code) > 0)) chosen = &mode;
    if (!chosen) return {};
    // Noise and shades may have made several modes of one surface: then it is as it mostly was.
    const Mode deepest = *chosen;
    const auto is_apart = [&](const Mode& mode) {
        return std::abs(mode.code - deepest.code) > 2 * depth_.tolerance(deepest.code);
    };
    for (const Mode& mode : modes)
        if (mode.count > chosen->count && !is_apart(mode)) chosen = &mode;
    BackgroundPixel pixel{chosen->code, true, false, colour_of(chosen->colour)};
    for (const Mode& mode : modes)
        if (has_colour && mode.count >= least_seen && is_apart(mode) &&
            agree(colour_of(mode.colour), pixel.colour))
            pixel.is_ambiguous = true;
    return pixel;
}

Background BackgroundModel::finish(bool has_colour) {
    const std::int32_t least =
        std::clamp(frames_ / (has_colour ? share_with_colour : share_without), least_seen, most_counted);
    Background background;
    background.reserve(pixels_.size());
    for (const Modes& modes : pixels_) background.push_back(behind(modes, least, has_colour));
    begin();
    return background;
}

/// `colour` may be empty.
void HolesFromMotion::find_places(const PlaneView& codes, const PlaneView& colour,
                                  const Background& background) {
    width_ = codes.width;
    height_ = codes.height;
    places_.resize(background.size());
    holes_.clear();
    std::size_t pixel = 0;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x, ++pixel) {
            const std::uint16_t code = codes.sample(x, y);
            if (!depth_.is_valid(code)) {
                places_[pixel] = Place::hole;
                holes_.push_back(pixel);
                continue;
            }
            const BackgroundPixel& behind = background[pixel];
            const std::int32_t deeper = depth_.deeper_by(code, behind.code);
            const std::int32_t apart = 2 * depth_.tolerance(code);
            places_[pixel] = !behind.is_known || deeper > apart ? Place::other
                             : deeper < -apart                  ? Place::nearer
                                                                : Place::behind;
            if (places_[pixel] != Place::nearer || colour.empty() || behind.is_ambiguous) continue;
            ++nearer_;
            nearer_but_alike_ += agree(colour_at(colour, x, y), behind.colour);
        }
}

bool HolesFromMotion::is_misled_by_colour() const {
    return nearer_ >= least_nearer &&
           static_cast<double>(nearer_but_alike_) > most_alike * static_cast<double>(nearer_);
}

/// Along a row or a column (`step`), in which the pixel has this place of so many.
bool HolesFromMotion::has_end_behind(std::size_t pixel, std::ptrdiff_t step, int place, int places) const {
    const int most = std::max(least_narrow, width_ / narrow_share);
    int length = 1;
    bool any = false;
    const auto go = [&](std::ptrdiff_t by, int left) {
        for (auto at = static_cast<std::ptrdiff_t>(pixel) + by; left > 0 && length <= most;
             --left, at += by) {
            const Place there = places_[static_cast<std::size_t>(at)];
            if (there != Place::hole && there != Place::candidate) {
                any = any || there == Place::behind;
                return;
            }
            ++length;
        }
    };
    go(-step, place);
    go(step, places - 1 - place);
    return any && length <= most;
}

bool HolesFromMotion::is_beside_what_is_behind(std::size_t pixel) const {
    const auto columns = static_cast<std::size_t>(width_);
    return has_end_behind(pixel, 1, static_cast<int>(pixel % columns), width_) ||
           has_end_behind(pixel, width_, static_cast<int>(pixel / columns), height_);
}

/// The pixel itself, and more of the 3x3 around it than not: a single one may look alike by chance, and at
/// the edge of a nearer thing some are that thing's.
bool HolesFromMotion::is_coloured_as_behind(const PlaneView& colour, const Background& background,
                                            std::size_t pixel) const {
    const int x = static_cast<int>(pixel) % width_, y = static_cast<int>(pixel) / width_;
    const auto agrees = [&](int u, int v) {
        return agree(colour_at(colour, u, v), background[static_cast<std::size_t>(v * width_ + u)].colour);
    };
    if (!agrees(x, y)) return false;
    int alike = 0, other = 0;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u)
            if (background[static_cast<std::size_t>(v * width_ + u)].is_known)
                ++(agrees(u, v) ? alike : other);
    return alike > other;
}

void HolesFromMotion::find_candidates(const PlaneView& colour, const Background& background) {
    for (const std::size_t pixel : holes_) {
        const BackgroundPixel& behind = background[pixel];
        if (!behind.is_known) continue;
        const bool has_its_colour = colour.empty() || is_coloured_as_behind(colour, background, pixel);
        const bool colour_tells = !colour.empty() && !behind.is_ambiguous;
        if (has_its_colour && (colour_tells || is_beside_what_is_behind(pixel)))
            places_[pixel] = Place::candidate;
    }
}

/// Group by group of candidates that touch.
void HolesFromMotion::leave_those_of_nearer_things(bool colour_tells) {
    const auto columns = static_cast<std::size_t>(width_);
    fills_.clear();
    for (const std::size_t first : holes_) {
        if (places_[first] != Place::candidate) continue;
        std::size_t behind = 0, nearer = 0, left = 0;
        group_.assign(1, first);
        places_[first] = Place::looked_at;
        const auto look = [&](std::size_t pixel) {
            Place& place = places_[pixel];
            behind += place == Place::behind;
            nearer += place == Place::nearer;
            left += place == Place::hole;
            if (place != Place::candidate) return;
            place = Place::looked_at;
            group_.push_back(pixel);
        };
        for (std::size_t k = 0; k < group_.size(); ++k) {
            const std::size_t pixel = group_[k], x = pixel % columns;
            if (x > 0) look(pixel - 1);
            if (x + 1 < columns) look(pixel + 1);
            if (pixel >= columns) look(pixel - columns);
            if (pixel + columns < places_.size()) look(pixel + columns);
        }
        const bool is_whole = colour_tells || left_share * left <= behind;
        if (behind > 0 && nearer <= most_nearer * behind && is_whole)
            fills_.insert(fills_.end(), group_.begin(), group_.end());
    }
}

void HolesFromMotion::write(RawFrame& frame, const Background& background) {
    const PlaneView stored = frame.depth;
    Image image{stored.width, stored.height, stored.bytes_per_sample, stored.channels, {}};
    const auto row_bytes = static_cast<std::size_t>(stored.width * stored.channels * stored.bytes_per_sample);
    const auto columns = static_cast<std::size_t>(stored.width);
    image.samples.resize(row_bytes * static_cast<std::size_t>(stored.height));
    for (int y = 0; y < stored.height; ++y)
        std::memcpy(image.samples.data() + static_cast<std::size_t>(y) * row_bytes, stored.row(y), row_bytes);
    const std::size_t words = (columns + 31) / 32;
    auto filled =
        std::make_shared<std::vector<std::uint32_t>>(words * static_cast<std::size_t>(stored.height));
    for (const std::size_t pixel : fills_) {
        const std::size_t x = pixel % columns, y = pixel / columns;
        depth_.put(background[pixel].code, image.samples.data() + y * row_bytes, static_cast<int>(x),
                   stored.bytes_per_sample);
        (*filled)[y * words + x / 32] |= 1U << (x % 32);
    }
    add_plane(frame, PlaneRole::depth, plane_from(std::move(image)));
    frame.filled = std::move(filled);
}

void HolesFromMotion::fill(RawFrame& frame, const Background& background, bool uses_colour) {
    filled_ = 0;
    const bool has_colour =
        frame.colour.width == frame.depth.width && frame.colour.height == frame.depth.height;
    const PlaneView colour = uses_colour && has_colour ? frame.colour : PlaneView{};
    find_places(depth_.codes_of(frame, hue_codes_), colour, background);
    if (holes_.empty()) return;
    find_candidates(colour, background);
    leave_those_of_nearer_things(!colour.empty());
    filled_ = static_cast<std::int64_t>(fills_.size());
    if (filled_ > 0) write(frame, background);
}

}  // namespace touchable
