// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures in memory, and pictures in files.
//
// An Image owns packed rows of grey (8 or 16 bits) or RGB; a PlaneView (engine/scene) shows one.
// read_stored_image reads a picture of any kind that its first bytes tell (PNG, JPEG, TIFF, OpenEXR, PGM,
// PPM, PFM, NumPy) as it is stored: a StoredImage is integers as the file has them, or floats, and says how
// it was stored, so that depth is never squeezed through a conversion. decode_* do the same for bytes of one
// kind in memory. An ImageStack reads the pictures of a NumPy file (.npy, .npz), HDF5 or TIFF one by one.
// write_png and png_bytes write PNG, lossless. A RankEncoder makes packets of our own codec, which rank_head
// and take_rank_plane read. Pictures of videos are in decoding.hpp.
//
// Claims of a file (sizes, expansion) are checked before memory is taken for them. Errors begin with `where`
// or the file's name (ErrorKind::input); a stop is obeyed within milliseconds.
// Threads: any may call functions; one uses an ImageStack.

#include <functional>
#include <span>

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

    PlaneView view() const { return packed_plane(samples.data(), width, height, bytes_per_sample, channels); }
};
inline std::size_t pixel_count(const Image& image) {
    return pixel_count(image.width, image.height);
}
/// Sample `k` of a picture of one channel.
inline std::uint16_t sample_at(const Image& image, std::size_t k) {
    if (image.bytes_per_sample == 1) return image.samples[k];
    std::uint16_t word = 0;
    std::memcpy(&word, image.samples.data() + 2 * k, 2);
    return word;
}
/// A picture whose samples are all 0.
Image blank_image(int width, int height, int bytes_per_sample, int channels);
/// A copy of these samples, without gaps between rows.
Image packed_image(const PlaneView& view);

/// Returns whole pages of memory that is not read again to the system before its owner is destroyed: so a
/// picture that is converted row by row is held once and not twice.
void give_back(void* memory, std::size_t bytes);

/// A picture as stored: grey of 8 or 16 bits, or RGB of 8; palettes become RGB, alpha is dropped.
Result<Image> read_image(const std::filesystem::path& file);
/// Whether red, green and blue are the same everywhere; false if a stop comes before this is known.
bool is_grey(const Image& image);
/// Grey, or grey that is stored as RGB: red, green and blue the same everywhere. Nullopt for colour.
std::optional<Image> as_grey(const Image& image);
/// How 8-bit RGB is stored: as it is, or, if a picture has at most 256 colours, as indices into a palette,
/// which take fewer bytes if colours form areas, as materials do. Both keep every value.
enum class PngColours { rgb, indexed_if_few };
/// Lossless. Grey of 8 or 16 bits, or RGB of 8. The owner of `file` commits it.
Result<void> write_png(NewFile& file, const PlaneView& image, PngColours colours = PngColours::rgb);
/// Quick: half the time, for 5 % more bytes of a photograph and fewer of smooth depth.
enum class PngEffort { quick, thorough };
/// The same into a file of any name; messages have `name`.
Result<void> write_png_to(const std::filesystem::path& path, const PlaneView& image,
                          const std::filesystem::path& name, PngEffort effort,
                          PngColours colours = PngColours::rgb);
/// The same, and commits it, over an earlier file.
Result<void> write_png(const std::filesystem::path& file, const PlaneView& image);

/// An OpenEXR picture of one channel of floats, Y: width x height, row by row.
Result<std::string> exr_bytes(std::span<const float> samples, int width, int height);
/// The header of a .npy file of (frames, height, width) floats, little-endian; 128 bytes, however many.
std::string npy_header(std::int64_t frames, int height, int width);

/// Pixels of a picture's width or height, at most.
inline constexpr int largest_picture_side = 16384;

struct BesideDepth;

/// An image with how it was stored.
struct StoredImage {
    Image image;               ///< of floats: the picture's size, without samples
    std::string codec;         ///< "png", "mjpeg", "pgm", "ppm", "pfm", "npy", "hdf5", "tiff", "exr"
    std::string pixel_format;  ///< as FFmpeg names it: "gray16be", "grayf32le"
    /// Bits of a sample as stored: grey PNG also 1, 2 and 4, PGM as its greatest value needs; 16 if all
    /// larger integers fit.
    int bits = 8;
    bool interlaced = false;  ///< then missing data are not detected
    /// Floats, if stored as such: width * height, row by row; also NaN and infinity.
    std::vector<float> values{};
    /// Pictures beside a rendering's depth, if wanted and present; null otherwise.
    std::shared_ptr<BesideDepth> beside{};
    std::vector<std::uint8_t> alpha{};  ///< of a PNG in RGBA of 8 bits that is not opaque everywhere
    Packing packing = Packing::none;    ///< of the picture that these numbers were in
    bool is_rendered = false;           ///< an OpenEXR file's depth, named as renderers name it
};

/// Beside depth in a picture of more channels: other pictures of an OpenEXR rendering, of the same pixels as
/// its depth, and the name of depth's channel.
struct BesideDepth {
    struct Wanted {
        bool colour = false, materials = false;
    };
    std::optional<StoredImage> colour{};     ///< sRGB of 8 bits
    std::optional<StoredImage> materials{};  ///< indices: integers, or floats that are whole
    // The file's names for them, for messages.
    std::string depth_name{}, colour_name{}, materials_name{};
    int depths = 1;  ///< number of depths; this is the first (with colour)
};

/// All of a picture's file, up to 257 MiB: 8192x8192 floats fit.
Result<std::string> read_picture_bytes(const SourceFile& file);

/// A picture's kind by its first bytes: "PNG", "PGM" ...; empty if no reader here knows it.
std::string_view picture_kind(std::string_view begin);

/// A picture of any kind that its first bytes tell.
Result<StoredImage> read_stored_image(const SourceFile& file);
/// The same for a file's bytes; messages begin with `where`.
Result<StoredImage> decode_stored_image(std::string bytes, const std::string& where);

/// Makes a picture of the bytes of its file; messages begin with `where`.
using DecodePicture = std::function<Result<StoredImage>(std::string_view bytes, const std::string& where)>;
/// Runs `decode` on these bytes, however long it takes; a stop is obeyed meanwhile.
Result<StoredImage> decode_unless_stopped(std::string bytes, const std::string& where, DecodePicture decode);

/// Refuses pictures of more than 64 MiB in files of less than a 4096th of that, before memory is taken for
/// them.
Result<void> check_expansion(std::uint64_t unpacked, std::uint64_t packed, const std::string& where);
/// Refuses sides of 0 and beyond `largest_picture_side`.
Result<void> check_picture_size(std::int64_t width, std::int64_t height, const std::string& where);

/// PNG and JPEG, by FFmpeg's decoders: grey of 1 to 16 bits, colour of 8. Colour of 16 bits gives the channel
/// that holds numbers, if the others are the same or masks of few values; otherwise it is refused.
Result<StoredImage> decode_coded_image(std::string_view bytes, const std::string& where);

/// The indices of a PNG with a palette, whatever colours they stand for, or the values of a grey one, in 8
/// bits. Other pictures are refused: indices are not colours.
Result<Image> decode_indices(std::string_view bytes, const std::string& where);

/// A PNG file's bytes: grey of 8 or 16 bits, or RGB of 8. Every value is kept.
Result<std::string> png_bytes(const PlaneView& image, PngEffort effort, PngColours colours = PngColours::rgb);

/// A JPEG file's bytes, of RGB of 8 bits: good enough to look at.
Result<std::string> jpeg_bytes(const PlaneView& image);

bool is_exr(std::string_view begin);

/// Decodes depth: channel Z or depth of the first part that has one, else Y or R, or the only one
/// (ExrLayers). R stands for all three colours if they are the same. Pixels outside the data window are NaN,
/// or 0 for integers.
/// `wanted`: pictures beside it that are decoded, too, if the file has them (StoredImage::beside). `channel`:
/// the name of depth's channel or layer; empty: found by all names. A file without it is refused with its
/// list of names.
Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where,
                               const BesideDepth::Wanted& wanted = {}, const std::string& channel = {});
/// Whether a channel is called Z, or is in a pass of depth, as renderers name them.
bool is_exr_depth_of_renderer(const std::string& channel);
/// Whether a channel is in a pass of depth as Unreal names them, which is in centimetres.
bool is_exr_depth_of_unreal(const std::string& channel);

/// Colour alone: linear light of R, G and B as sRGB of 8 bits, at exposure 1, without alpha; black beyond the
/// data window.
Result<StoredImage> decode_exr_colour(std::string_view bytes, const std::string& where);
/// Material indices alone, as numbers.
Result<StoredImage> decode_exr_materials(std::string_view bytes, const std::string& where);

inline constexpr std::uint64_t most_small_numbers = 65536;
inline constexpr std::size_t most_small_arrays = 64;
/// A small array beside depth in its file.
struct SmallArray {
    std::string name;
    std::vector<std::int64_t> shape;
    std::vector<double> numbers;  ///< row by row
};

/// The pictures of a file that holds several, read one by one: of a NumPy array, height x width or a stack; a
/// data set of HDF5; the pages of a TIFF.
class ImageStack {
public:
    virtual ~ImageStack() = default;
    virtual std::int64_t count() const = 0;
    virtual int width() const = 0;
    virtual int height() const = 0;
    /// A picture, from 0 on. All are floats if any picture has a number that is no integer from 0 to 65535.
    Result<StoredImage> image(std::int64_t number);
    /// The name of the array or data set, the first one's of several; empty: it has none.
    const std::string& array() const { return array_; }
    /// The limit of a .npz's confidence: where that is below it, there is no depth (NaN, or 0 for integers).
    std::optional<double> least_confidence() const { return least_confidence_; }
    /// In words, what else the file has that is not read, and which mask removes depth; empty: nothing.
    const std::string& left_out() const { return left_out_; }
    /// Arrays of at most `most_small_numbers` in the same .npz or HDF5 file, such as the cameras' matrices,
    /// and attributes; at most `most_small_arrays`, those of depth's own group first.
    virtual std::span<const SmallArray> small_arrays() { return small_arrays_; }

protected:
    /// Errors begin with `where`; `unit`: what a picture of this file is called in them.
    explicit ImageStack(std::string where, std::string left_out = "", const char* unit = "picture")
        : where_(std::move(where)), left_out_(std::move(left_out)), unit_(unit) {}
    ImageStack(ImageStack&&) = default;
    /// Reads a picture of the stack, as floats if its numbers are no codes, or `floats_anyway`. Unfinished if
    /// a stop comes meanwhile.
    virtual Result<StoredImage> read(std::int64_t number, bool floats_anyway) = 0;
    /// Call before `image` if pictures may have integers beyond 16 bits: reads them, and finds out whether
    /// all have to be floats.
    Result<void> find_floats();

    std::string where_, left_out_, array_;
    std::optional<double> least_confidence_;
    std::vector<SmallArray> small_arrays_;

private:
    const char* unit_;
    bool floats_ = false;
};

/// Opens a .npy file, or the depth array of a .npz file, told apart by their bytes: the `array` of this name;
/// without a name the only one, or else one found by its name (depth_among); an error lists the arrays. An
/// array of one picture is a stack of one. A confidence (conf, *conf*) and a mask (valid, valid_mask, mask)
/// of as many pictures remove depth where they are low; without `least_confidence` the limit is half the
/// median of the first picture's.
Result<std::shared_ptr<ImageStack>> open_npy_stack(const SourceFile& file,
                                                   std::optional<double> least_confidence = {},
                                                   const std::string& array = {});

/// The small arrays of a .npz file, or the one of a .npy, by the file's name; none if it cannot be read.
std::vector<SmallArray> small_arrays_in(const SourceFile& file);

/// Whether a file begins as .npy or .npz.
bool is_npy_file(const SourceFile& file);

/// Opens a data set of an HDF5 file, also MATLAB's, whose pictures are transposed as MATLAB shows them: the
/// one of this name, such as /data/demo_0/obs/depth; without a name it is found like an array of a .npz; an
/// error lists the data sets. h5ls and h5dump (Debian: hdf5-tools) read the file, each time up to 8 MiB of
/// pictures, or one; it must stay in place meanwhile. A file that takes more than 60 s or 1 GiB is refused.
Result<std::shared_ptr<ImageStack>> open_hdf5_stack(const SourceFile& file, const std::string& dataset = "");

/// Whether a file begins as HDF5, or as MATLAB's 7.3, which is HDF5.
bool is_hdf5_file(const SourceFile& file);

/// Whether a file has arrays by name, HDF5's or NumPy's (.npz), by its first bytes.
bool has_named_arrays(const SourceFile& file);

/// The pages of a TIFF stored like its first one (if that is in colour: like the first of more than 8 bits in
/// grey). Null for a single page.
Result<std::shared_ptr<ImageStack>> open_tiff_stack(const SourceFile& file);

// A lossless coding of grey pictures of two bytes a sample, each on its own, before it is compressed
// (docs/codecs.md, A packet of our own codec): by zstd in clips, by deflate in packed ones (docs/web.md),
// which browsers inflate. A packet has a head, its mode and how many distinct values the picture has, and
// then the compressed content: what the values are, and a code of each sample, or of its rank among them. In
// packed clips the head is compressed, too, so that deflate's checksum covers it. A
// camera that measures in millimetres has few distinct values in a picture, fewer with distance; so do values
// stretched to more bits.

/// The modes, by their numbers.
enum class RankMode : std::uint8_t { samples_by_gradient, ranks_by_left, ranks_by_gradient };

/// What stands before a packet's content.
struct RankHead {
    RankMode mode = RankMode::samples_by_gradient;
    std::size_t distinct = 0;  ///< distinct values; 0: the mode has none
    std::size_t bytes = 0;     ///< of this head

    /// Bytes of the content of a picture with so many samples.
    std::size_t content(std::size_t samples) const { return 2 * (distinct + samples); }
};
/// The head of a packet of a picture with so many samples; nullopt: it cannot be one.
std::optional<RankHead> rank_head(std::span<const std::uint8_t> packet, std::size_t samples);

/// Turns content, of the size that its head states, into rows of `width` samples, `stride` samples apart.
/// False if it holds no such picture (any bytes are safe); the samples are then undefined.
bool take_rank_content(const RankHead& head, std::span<const std::uint8_t> content, int width, int height,
                       std::uint16_t* samples, std::ptrdiff_t stride);

/// The same into the samples of a plane of this form, row by row; channels, whose pictures content has one
/// below the other, become interleaved.
bool take_rank_plane(const RankHead& head, std::span<const std::uint8_t> content, const PlaneView& form,
                     std::vector<std::uint8_t>& samples);

/// Makes packets. One thread uses it.
class RankEncoder : NonCopyable {
public:
    /// Compresses `from` into `to`, which has room, and returns its size; 0: memory ran out.
    using Compress =
        std::function<std::size_t(std::span<const std::uint8_t> from, std::span<std::uint8_t> to)>;
    /// `packs_head`: `from` begins with the head.
    explicit RankEncoder(Compress compress, bool packs_head = false)
        : compress_(std::move(compress)), packs_head_(packs_head) {}

    /// The packet of a picture, valid until the next call; empty if memory runs out. With `choose` every mode
    /// is tried and the smallest packet taken, one of ranks, which takes longer to decode, only if it saves a
    /// 64th. Otherwise the last choice stands, unless packets have grown by a 16th since.
    std::span<const std::uint8_t> encode(const PlaneView& plane, bool choose);

private:
    struct Packet {
        std::vector<std::uint8_t> memory;
        std::size_t size = 0;
    };
    void take_samples(const PlaneView& plane);
    void find_ranks();
    bool pack(RankMode mode);

    const Compress compress_;
    const bool packs_head_;
    int width_ = 0;
    std::vector<std::uint16_t> samples_, distinct_, ranks_;
    std::vector<std::uint16_t> rank_of_;  // by sample
    std::vector<std::uint8_t> bytes_;     // head and content
    Packet newest_, chosen_;
    std::optional<RankMode> mode_;  // chosen when packets had `size_then_` bytes
    std::size_t size_then_ = 0;
};

/// Whether a file is a Git LFS pointer, a small text in place of a large file that was not fetched, by its
/// first 64 bytes.
inline bool is_git_lfs_pointer(std::string_view begin) {
    return begin.starts_with("version https://git-lfs.github.com/spec/") ||
           begin.starts_with("version https://hawser.github.com/spec/");  // its name before 2014
}
/// The message about such a file, after its name.
inline constexpr const char* git_lfs_words =
    "is a Git LFS pointer in place of the file itself: git lfs pull, in its repository, fetches all of them";

}  // namespace touchable
