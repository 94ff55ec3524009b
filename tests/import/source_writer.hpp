#pragma once

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

using SourceMaker = Made (*)(Writer&);
/// By the names of rows (DepthSource).
const std::map<std::string, SourceMaker>& source_makers();

}  // namespace touchable::test
