#include "player/commands/globe_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "player/commands/file_option.hpp"
#include "player/commands/number_option.hpp"

namespace touchable {
namespace {

GlobeMap map_of(const StoredImage& picture) {
    const Image& image = picture.image;
    if (!picture.values.empty()) return {{}, picture.values, image.width, image.height, 1};
    return {image.view(), {}, image.width, image.height, image.channels, (1 << picture.bits) - 1};
}

/// A grey picture may be stored as one of colour.
void make_grey(Image& image) {
    if (image.channels == 1) return;
    if (auto grey = as_grey(image)) image = std::move(*grey);
}

enum class MapKind { as_stored, grey };

/// The map in a file; none where there is no file. It lies in `picture`.
Result<GlobeMap> read_map(const std::filesystem::path& file, MapKind kind, StoredImage& picture) {
    if (file.empty()) return GlobeMap{};
    if (stop_requested()) return interrupted_error();
    TRY_ASSIGN(auto read, read_stored_image(SourceFile(file)));
    picture = std::move(read);
    if (kind == MapKind::grey) make_grey(picture.image);
    return map_of(picture);
}

double least_of(const GlobeMap& elevation) {
    double least = HUGE_VAL;
    for (int y = 0; y < elevation.height; ++y)
        for (int x = 0; x < elevation.width; ++x)
            if (const double here = elevation.at(x, y, 0); std::isfinite(here)) least = std::min(least, here);
    return least;
}

/// White where the map of heights is above this level.
StoredImage mask_of(const GlobeMap& elevation, double level) {
    StoredImage mask{};
    mask.image = {elevation.width, elevation.height, 1, 1, {}};
    for (int y = 0; y < elevation.height; ++y)
        for (int x = 0; x < elevation.width; ++x)
            mask.image.samples.push_back(elevation.at(x, y, 0) > level ? 255 : 0);
    return mask;
}

std::string shore_in_words(const Shore& shore, bool told, bool has_mask) {
    const std::string level = formatted("sea level %.9g", shore.sea_level);
    if (!has_mask)
        return level +
               (told ? ", as told" : ", the least of the elevation map (--sea-level VALUE says otherwise)") +
               "; --mask FILE would say which is land";
    return level + (told ? ", as told" : " of the elevation map") + "; land is " +
           (shore.bright_is_land ? "bright" : "dark") +
           formatted(" in the mask; the two agree on %.1f %% of the globe", 100 * shore.agreement) +
           (told ? "" : " (--sea-level VALUE says otherwise)");
}

}  // namespace

std::vector<NamedFile> GlobeMapFiles::files() const {
    std::vector<NamedFile> named;
    const std::pair<const char*, const std::filesystem::path*> all[] = {
        {"--colour", &colour}, {"--elevation", &elevation}, {"--mask", &mask}, {"--haptic", &haptic}};
    for (const auto& [name, path] : all)
        if (!path->empty()) named.push_back({name, *path});
    return named;
}

void add_globe_options(CLI::App& make, GlobeWords& words) {
    GlobeMapFiles& maps = words.maps;
    add_file_option(
        make, "--colour", maps.colour,
        "globe of maps: a picture of all of it, longitude -180 to 180 from left to right, north up");
    add_file_option(make, "--elevation", maps.elevation, "globe of maps: the same of heights, in any unit");
    add_file_option(make, "--mask", maps.mask,
                    "globe of maps: land and ocean, black and white or white and black (default: ocean is "
                    "where elevation is least, or up to --sea-level)");
    add_file_option(
        make, "--haptic", maps.haptic,
        "globe of maps: RGB, the codes of stiffness (0.1 to 2 N/mm), static and dynamic friction (0 "
        "to 1), in place of land and ocean");
    add_number_option(
        make, "--sea-level", maps.sea_level,
        "globe of maps: value of the elevation map up to which it is sea (default: where the mask "
        "says so; without a mask the least value)");
    add_number_option(make, "--relief", maps.relief_percent,
                      "globe of maps: how far the highest place rises, percent of the radius (default 3)",
                      0.01, 10);
    add_number_option(
        make, "--smoothing", maps.smoothing_degrees,
        "globe of maps: mountains narrower than some degrees are in the height plane, wider ones in "
        "the depth (default 1; 0: all in the depth)",
        0, 10);
    add_number_option(make, "--turn", words.seconds_per_turn, "globe: seconds for a turn (default 12)", 0.1,
                      1e9);
    add_number_option(make, "--axial-tilt", words.axial_tilt,
                      "globe: degrees from upright, of the pole, to the right (default 26; of maps 23.4)",
                      -90, 90);
    add_number_option(make, "--longitude", words.longitude,
                      "globe: degrees east that face the camera at first (default -72; of maps 80)", -180,
                      180);
}

Result<void> check_globe_words(const GlobeWords& words, const std::string& scene, bool plain) {
    const GlobeMapFiles& maps = words.maps;
    const bool turns = scene == "globe" && !plain;
    const auto only = [&](bool given, const char* option, bool fits, const char* whose) -> Result<void> {
        if (!given || fits) return {};
        return usage_error(std::string(option) + " does nothing for '" + scene + (plain ? "' --plain" : "'") +
                           "; it belongs to " + whose);
    };
    const char* const turning = "a globe that turns";
    const char* const of_maps = "a globe of maps (--colour and --elevation)";
    for (const Result<void>& checked :
         {only(!maps.colour.empty(), "--colour", turns, turning),
          only(!maps.elevation.empty(), "--elevation", turns, turning),
          only(!maps.mask.empty(), "--mask", turns, turning),
          only(words.seconds_per_turn.has_value(), "--turn", turns, turning),
          only(words.axial_tilt.has_value(), "--axial-tilt", turns, turning),
          only(words.longitude.has_value(), "--longitude", turns, turning),
          only(!maps.haptic.empty(), "--haptic", maps.any(), of_maps),
          only(maps.sea_level.has_value(), "--sea-level", maps.any(), of_maps),
          only(maps.relief_percent.has_value(), "--relief", maps.any(), of_maps),
          only(maps.smoothing_degrees.has_value(), "--smoothing", maps.any(), of_maps)})
        if (!checked.ok()) return checked;
    if (!maps.any()) return {};
    for (const auto& [option, file] : {std::pair{"--colour", &maps.colour}, {"--elevation", &maps.elevation}})
        if (file->empty())
            return usage_error(std::string(option) +
                               " is missing; a globe of maps needs --colour and --elevation");
    return {};
}

void take_motion(const GlobeWords& words, SceneOptions& options) {
    if (words.seconds_per_turn) options.seconds_per_turn = *words.seconds_per_turn;
    options.axial_tilt_degrees = words.axial_tilt;
    options.first_longitude_degrees = words.longitude;
    if (!words.maps.any()) return;
    constexpr double tilt_of_the_earth = 23.4, himalaya = 80;
    options.axial_tilt_degrees = words.axial_tilt.value_or(tilt_of_the_earth);
    options.first_longitude_degrees = words.longitude.value_or(himalaya);
}

Result<std::unique_ptr<const ReadGlobeMaps>> read_globe_maps(const GlobeMapFiles& files) {
    auto read = std::make_unique<ReadGlobeMaps>();
    GlobeMaps& maps = read->maps;
    for (const auto& [file, kind, picture, map] :
         {std::tuple{&files.colour, MapKind::as_stored, &read->colour, &maps.colour},
          {&files.elevation, MapKind::grey, &read->elevation, &maps.elevation},
          {&files.mask, MapKind::grey, &read->mask, &maps.mask},
          {&files.haptic, MapKind::as_stored, &read->haptic, &maps.haptic}}) {
        TRY_ASSIGN(auto found, read_map(*file, kind, *picture));
        *map = found;
    }
    std::optional<double> sea_level = files.sea_level;
    if (files.mask.empty() && !maps.elevation.empty() && maps.elevation.channels == 1) {
        if (!sea_level) sea_level = least_of(maps.elevation);
        read->mask = mask_of(maps.elevation, *sea_level);
        maps.mask = map_of(read->mask);
        const auto& mask = read->mask.image.samples;
        if (std::find(mask.begin(), mask.end(), mask.front() ^ 255) == mask.end())
            return input_error(files.sea_level
                                   ? "--sea-level leaves only land, or only sea, in the elevation map"
                                   : "the elevation map is level everywhere");
    }
    if (files.relief_percent) maps.relief = *files.relief_percent / 100;
    if (files.smoothing_degrees) maps.smoothing_degrees = *files.smoothing_degrees;
    TRY(check_globe_maps(maps));
    TRY_ASSIGN(auto shore, find_shore(maps.elevation, maps.mask, sea_level));
    maps.shore = shore;
    read->remark = shore_in_words(shore, files.sea_level.has_value(), !files.mask.empty());
    return std::unique_ptr<const ReadGlobeMaps>(std::move(read));
}

}  // namespace touchable
