// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::test {

constexpr int wide = 160, high = 120;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Metres of a pixel of frame n, or another unit; NaN: there is no depth.
using Depth = std::function<double(int n, int x, int y)>;

/// A wall that leans, a floor that comes near below, a box before them that moves; a hole in a corner.
/// Metres.
double room(int n, int x, int y);
/// The same as whole codes, of which a metre has so many (0: none), and what these mean.
std::uint16_t room_code(double codes_per_metre, int n, int x, int y);
Depth room_in(double codes_per_metre);
Depth millimetres(const Depth& metres);

/// Frame n, row by row, with `of_none` where there is no depth.
std::vector<float> floats_of(const Depth& depth, double of_none, int n = 0);
/// The shape of a NumPy array: "120, 160" with more axes before and behind.
std::string shape_of_room(const std::string& before = "", const std::string& after = "");
/// "000012".
std::string six_digits(int n);

/// Channels of floats, by name.
void write_exr(const std::filesystem::path& file, const std::map<std::string, std::vector<float>>& channels);
void write_tiff(const std::filesystem::path& file, std::vector<float> values);
void write_pfm(const std::filesystem::path& file, const std::vector<float>& values);
/// 16 bits, high byte first, as the format has it, or low byte first, as libfreenect's `record` writes.
void write_pgm(const std::filesystem::path& file, bool low_first,
               const std::function<std::uint16_t(int x, int y)>& code);
/// A video of colour, H.264.
void write_film(const std::filesystem::path& file, int frames, AVRational rate = {30, 1});

/// Writes into a folder, under the source's own names or under others.
class Writer {
public:
    Writer(std::filesystem::path folder, bool renames) : folder_(std::move(folder)), renames_(renames) {}

    /// The source's own name, or the other one, where files may be called anything.
    std::string name(const std::string& own, const std::string& other) {
        has_other_names_ = true;
        return renames_ ? other : own;
    }
    bool has_other_names() const { return has_other_names_; }

    /// Makes the folder that it is in.
    std::filesystem::path operator/(const std::string& name) const;
    const std::filesystem::path& folder() const { return folder_; }
    void text(const std::string& name, const std::string& words) const;
    /// PNG of 16 bits.
    void png16(const std::string& name, const std::function<int(int x, int y)>& code, int width = wide,
               int height = high) const;
    /// The same of the room that all sources see, of which a metre has so many codes.
    void room16(const std::string& name, double codes_per_metre, int n = 0) const;
    /// PNG of 8 bits.
    void grey(const std::string& name, const std::function<int(int x, int y)>& code) const;
    /// PNG, or JPEG where the name says so.
    void colour(const std::string& name, int width = wide, int height = high) const;

private:
    std::filesystem::path folder_;
    bool renames_;
    bool has_other_names_ = false;
};

/// The file of a source, and the clip that it has to give.
struct Made {
    std::filesystem::path file;  ///< what is typed
    Depth metres{};              ///< as stored
    Camera camera{};
    int frames = 1;
    double rate = 30;         ///< frames a second
    bool has_colour = false;  ///< found, whichever that is
    int width = wide, height = high;
    int lost_codes = 0;  ///< at most, by the source's own codec
    DepthSemantics semantics = DepthSemantics::planar;
};

/// Of a camera that sees so many degrees across.
inline Camera seen(double degrees) {
    const double f = 0.5 * wide / std::tan(degrees * M_PI / 360);
    return {f, f, 0.5 * (wide - 1), 0.5 * (high - 1)};
}

inline Made made(const std::filesystem::path& file, Depth metres, const Camera& camera, int frames = 1,
                 double rate = 30, bool has_colour = false, int width = wide, int height = high) {
    return {file, std::move(metres), camera, frames, rate, has_colour, width, height};
}

constexpr Camera measured{140.5, 140.7, 79.9, 60.1};

/// Depth without a scale, as networks guess it: 1/depth, or depth, from 0 to `top`. The nearest is taken for
/// 0.5 m and the farthest for 1.5 m.
struct RelativeDepth {
    double top;
    bool is_inverse = true, is_rounded = true;

    double number(int n, int x, int y) const {
        const double z = room(n, std::max(x, 4), y);
        return is_inverse ? 1 / z : z;
    }
    std::pair<double, double> ends() const {
        double least = 1e9, most = 0;
        for (int k = 0; k < wide * high; ++k) {
            least = std::min(least, number(0, k % wide, k / wide));
            most = std::max(most, number(0, k % wide, k / wide));
        }
        return {least, most};
    }
    Depth values() const {
        const auto [least, most] = ends();
        return [*this, least = least, most = most](int n, int x, int y) {
            const double value = top * (number(n, x, y) - least) / (most - least);
            return is_rounded ? std::round(value) : value;
        };
    }
    Depth metres() const {
        return [*this, value = values()](int n, int x, int y) {
            const double share = value(n, x, y) / top;
            return is_inverse ? 1 / (1 / 1.5 + share * (1 / 0.5 - 1 / 1.5)) : 0.5 + share;
        };
    }
};

using SourceMaker = Made (*)(Writer&);
/// By the names of rows (DepthSource); of networks and data sets.
const std::map<std::string, SourceMaker>& source_makers();
std::map<std::string, SourceMaker> data_set_makers();

}  // namespace touchable::test
