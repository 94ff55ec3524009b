#pragma once

// Pictures in memory, and pictures in files.
//
// An Image owns packed rows of grey (8 or 16 bits) or RGB; a PlaneView (engine/scene) shows one.
// read_stored_image reads a picture of any kind that its first bytes tell (PNG, JPEG, TIFF, OpenEXR, PGM,
// PPM, PFM, NumPy) as it is stored: a StoredImage is integers as the file has them, or floats, and says how
// it was stored, so that depth is never squeezed through a conversion. decode_* are the same of bytes in
// memory, of one kind. An ImageStack reads those of a NumPy file (.npy, .npz), of HDF5 or of a TIFF one by
// one. write_png and png_bytes write PNG, lossless. Pictures of videos are in decoding.hpp.
//
// What a file claims (sizes, expansion) is checked before memory is taken for it. Errors begin with `where`
// or the file's name (ErrorKind::input); a stop is obeyed within milliseconds. Functions may be called by any
// thread; an ImageStack is one thread's.

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// A picture with its own memory, rows packed.
struct Image {
    int width = 0, height = 0;
    int bytes_per_sample = 1;  ///< 1 or 2 (host order)
    int channels = 1;          ///< 1 or 3
    std::vector<std::uint8_t> samples;

    PlaneView view() const {
        return {samples.data(),
                static_cast<std::ptrdiff_t>(width) * channels * bytes_per_sample,
                width,
                height,
                bytes_per_sample,
                channels};
    }
};

/// Gives memory that is not read again back to the system before its owner is destroyed, as far as it is
/// whole pages: so a picture that is made of another one, row by row, is held once and not twice.
void give_back(void* memory, std::size_t bytes);

/// A picture as stored: grey of 8 or 16 bits, or RGB of 8; palettes become RGB, alpha is dropped.
Result<Image> read_image(const std::filesystem::path& file);
/// Whether red, green and blue are the same everywhere; false where it is asked to stop before it is known.
bool is_grey(const Image& image);
/// Grey, or grey that is stored as RGB: red, green and blue the same everywhere. Nothing of colour.
std::optional<Image> as_grey(const Image& image);
/// How 8-bit RGB is stored: as it is, or, where a picture has at most 256 colours, as indices into a palette
/// of them, which takes fewer bytes where they lie in areas, as materials do. Both keep every value.
enum class PngColours { rgb, indexed_if_few };
/// Lossless. Grey of 8 or 16 bits, or RGB of 8. The owner of `file` commits it.
Result<void> write_png(NewFile& file, const PlaneView& image, PngColours colours = PngColours::rgb);
/// Quick: half the time, for 5 % more bytes of a photograph and fewer of smooth depth.
enum class PngEffort { quick, thorough };
/// The same into a file of whatever name; messages speak of `name`.
Result<void> write_png_to(const std::filesystem::path& path, const PlaneView& image,
                          const std::filesystem::path& name, PngEffort effort,
                          PngColours colours = PngColours::rgb);
/// The same, and gives it its name, over an earlier file.
Result<void> write_png(const std::filesystem::path& file, const PlaneView& image);

/// Pixels of a picture's width or height, at most.
inline constexpr int largest_picture_side = 16384;

struct BesideDepth;

/// An image with how it was stored.
struct StoredImage {
    Image image;               ///< of a picture of floats its size, and no samples
    std::string codec;         ///< "png", "mjpeg", "pgm", "ppm", "pfm", "npy", "hdf5", "tiff", "exr"
    std::string pixel_format;  ///< as FFmpeg names it: "gray16be", "grayf32le"
    /// Of a sample as stored: of grey PNG also 1, 2 and 4, of PGM those its greatest value needs; 16 where
    /// larger integers all fit.
    int bits = 8;
    bool interlaced = false;  ///< then a picture that lacks data is not found out
    /// Of a picture of floats: width * height, row by row; also NaN and infinity.
    std::vector<float> values{};
    /// What a rendering has beside its depth, where that was wanted and is there; null otherwise.
    std::shared_ptr<BesideDepth> beside{};
};

/// Of a picture with more channels than depth: other pictures of an OpenEXR rendering, of the same pixels as
/// its depth, and which channel depth is.
struct BesideDepth {
    struct Wanted {
        bool colour = false, materials = false;
    };
    std::optional<StoredImage> colour{};     ///< sRGB of 8 bits
    std::optional<StoredImage> materials{};  ///< indices: integers, or floats that are whole
    // What the file calls them, for messages.
    std::string depth_name{}, colour_name{}, materials_name{};
    int depths = 1;  ///< of how many this is the first (that has colour)
};

/// All of a picture's file, up to 257 MiB: 8192x8192 floats fit.
Result<std::string> read_picture_bytes(const SourceFile& file);

/// What a picture's first bytes say that it is: "PNG", "PGM" ...; empty for what no reader here knows.
std::string_view picture_kind(std::string_view begin);

/// A picture of any kind that its first bytes tell.
Result<StoredImage> read_stored_image(const SourceFile& file);
/// The same of a file's bytes; messages begin with `where`.
Result<StoredImage> decode_stored_image(std::string bytes, const std::string& where);

/// Makes a picture of the bytes of its file; messages begin with `where`.
using DecodePicture = std::function<Result<StoredImage>(std::string_view bytes, const std::string& where)>;
/// What `decode` makes of these bytes. It may take as long as it does: a stop is obeyed meanwhile.
Result<StoredImage> decode_unless_stopped(std::string bytes, const std::string& where, DecodePicture decode);

/// Refuses pictures of more than 64 MiB in files of less than a 4096th of that, before memory is taken for
/// them.
Result<void> check_expansion(std::uint64_t unpacked, std::uint64_t packed, const std::string& where);
/// Refuses sides of 0 and beyond `largest_picture_side`.
Result<void> check_picture_size(std::int64_t width, std::int64_t height, const std::string& where);

/// PNG and JPEG, by FFmpeg's decoders: grey of 2 to 16 bits, colour of 8. Of colour of 16 bits the channel
/// that holds numbers, where the others are the same or masks of few values; otherwise it is refused.
Result<StoredImage> decode_coded_image(std::string_view bytes, const std::string& where);

/// The indices of a PNG with a palette, whatever colours they stand for, or the values of a grey one, in 8
/// bits. Refused of others: a picture that counts something is not of colours.
Result<Image> decode_indices(std::string_view bytes, const std::string& where);

/// A PNG file's bytes: grey of 8 or 16 bits, or RGB of 8. Every value is kept.
Result<std::string> png_bytes(const PlaneView& image, PngEffort effort, PngColours colours = PngColours::rgb);

bool is_exr(std::string_view begin);

/// One channel: of the first part that has one Z or depth, else Y or R, or the only one (ExrLayers). R stands
/// for all three colours where they are the same. What the display window has beyond the data window is NaN,
/// of integers 0.
Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where);
/// The same with what is wanted beside it, as far as the file has it (StoredImage::beside), unpacked once.
/// `channel`: the name of depth's channel or layer; empty: found by the names of all. A file without it is
/// refused with the names that it has.
Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where,
                               const BesideDepth::Wanted& wanted, const std::string& channel = {});
/// Whether a channel is in a pass of depth as Unreal names them, which is in centimetres.
bool is_exr_depth_of_unreal(const std::string& channel);

/// Colour alone: linear light of R, G and B as sRGB of 8 bits, at exposure 1, without alpha; black beyond the
/// data window.
Result<StoredImage> decode_exr_colour(std::string_view bytes, const std::string& where);
/// Material indices alone, as numbers.
Result<StoredImage> decode_exr_materials(std::string_view bytes, const std::string& where);

/// A small array beside depth in its file.
struct SmallArray {
    std::string name;
    std::vector<std::int64_t> shape;
    std::vector<double> numbers;  ///< row by row
};

/// The pictures of a file that holds several, read one by one: of an array as NumPy writes it, height x width
/// or a stack of such; a data set of HDF5; the pages of a TIFF.
class ImageStack {
public:
    virtual ~ImageStack() = default;
    virtual std::int64_t count() const = 0;
    virtual int width() const = 0;
    virtual int height() const = 0;
    /// From 0 on. All are alike: floats where any picture has a number that is no integer from 0 to 65535.
    virtual Result<StoredImage> image(std::int64_t number) = 0;
    /// The name of the array or data set that they are of, of several the first one's; empty: it has none.
    virtual std::string array() const { return ""; }
    /// Where a .npz has a confidence beside depth: there is no depth (NaN, of integers 0) where it is below.
    virtual std::optional<double> least_confidence() const = 0;
    /// What the file has beside these pictures and is not read, and by which mask of it there is no depth,
    /// in words; empty: nothing.
    virtual std::string left_out() const { return ""; }
    /// Arrays of at most 65536 numbers in the same .npz, such as the cameras' matrices; at most 64.
    virtual std::span<const SmallArray> small_arrays() const { return {}; }
};

/// Of a .npy file, or of the member of a .npz file that holds depth, which is found out by its bytes: the
/// `array` of this name; without a name the only one, or else that which is found by its name
/// (depth_among); an error has those that there are. An array of one picture is a stack of one. A confidence
/// (conf, *conf*) and a mask (valid, valid_mask, mask) of as many pictures take depth away where they are
/// low; without `least_confidence` that is half of the median of the first picture's.
Result<std::shared_ptr<ImageStack>> open_npy_stack(const SourceFile& file,
                                                   std::optional<double> least_confidence = {},
                                                   const std::string& array = {});

/// Whether a file begins as such a one.
bool is_npy_file(const SourceFile& file);

/// Of a data set of an HDF5 file, also of MATLAB's, whose pictures are turned over as MATLAB shows them: the
/// one of this name, such as /data/demo_0/obs/depth; without a name it is found as an array of a .npz. Others
/// have to be named: an error has those that there are. The file is read by h5ls and h5dump (Debian:
/// hdf5-tools), each time up to 8 MiB of pictures, or one; it stays where it is meanwhile. One that wants
/// more than 60 s or 1 GiB is refused.
Result<std::shared_ptr<ImageStack>> open_hdf5_stack(const SourceFile& file, const std::string& dataset = "");

/// Whether a file begins as HDF5, or as MATLAB's 7.3, which is HDF5.
bool is_hdf5_file(const SourceFile& file);

/// Whether a file has arrays by name, HDF5's or NumPy's (.npz), by its first bytes.
bool has_named_arrays(const SourceFile& file);

/// The pages of a TIFF that are stored as the first one is. Null of a file with a single page.
Result<std::shared_ptr<ImageStack>> open_tiff_stack(const SourceFile& file);

/// Whether a file is a pointer of Git LFS, a small text in place of a large file that was not fetched, by its
/// first 64 bytes.
inline bool is_git_lfs_pointer(std::string_view begin) {
    return begin.starts_with("version https://git-lfs.github.com/spec/") ||
           begin.starts_with("version https://hawser.github.com/spec/");  // its name before 2014
}
/// What is said of such a file behind its name.
inline constexpr const char* git_lfs_words =
    "is a Git LFS pointer in place of the file itself: git lfs pull, in its repository, fetches all of them";

}  // namespace touchable
