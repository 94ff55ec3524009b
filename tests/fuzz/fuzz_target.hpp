// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/image.hpp"

namespace touchable::fuzz {

/// A parser of bytes of unknown origin. Besides a crash, an exception that leaves it is a fault.
struct Target {
    const char* name;  ///< and of the folder of its seeds
    /// Gives whether the bytes were taken. Throws Fault where what came of them is not what the parser
    /// states.
    bool (*parse)(std::string_view bytes);
    /// Whether a seed that is taken is refused wherever it is cut, but for so many bytes at its end.
    bool cuts_are_refused = false;
    std::size_t needless_bytes = 0;
    /// Whether so much of a whole seed that is taken has to be refused.
    bool refuses_cut(std::size_t length, std::size_t whole) const {
        return cuts_are_refused && length + needless_bytes < whole;
    }
    int changes = 300;              ///< how often its seeds are changed in the ordinary tests
    std::size_t most_bytes = 4096;  ///< of an input that libFuzzer makes
    /// Raises both bounds below to 2 GiB. A codec's header may say a picture of 16384x16384 pixels
    /// (PacketDecoder), of up to 8 bytes each, for which FFmpeg asks before it finds no such picture; and an
    /// AVI's stream header has private data ("strd") of up to 1 GiB, for which it asks before it finds the
    /// file's end. It touches neither.
    bool decodes_video = false;
    int most_mebibytes = 512;  ///< largest single request of memory
    /// Most memory at a time, all together, touched or not: enough for a picture as large as a file of
    /// most_bytes can make one, and all that is made of it.
    int most_live_mebibytes = 64;
};

/// The result of target.parse. Throws Fault also where it had more memory at a time than it may.
bool parse_in_memory(const Target& target, std::string_view bytes);

/// Makes a target known: a constant of this type is all that a file of one needs.
struct Registered {
    explicit Registered(const Target& target);
};
const std::vector<Target>& all_targets();

struct Seed {
    std::string name, bytes;
};
/// The seeds of its folder, by name. Throws Fault where there are none.
std::vector<Seed> seeds_of(const Target& target);

/// A fault of a parser.
struct Fault {
    std::string what;
};
/// Throws where it is not so.
void require(bool is_so, std::string_view what);

/// An error is short, and where it quotes a file, one line without control characters. What a person typed
/// may come back as it is: the program shows messages by `printable`.
enum class Quotes { file, typed };
void require_readable(const Error& error, Quotes quotes = Quotes::file);
template <class T>
bool is_taken(const Result<T>& result, Quotes quotes = Quotes::file) {
    if (!result) require_readable(result.error(), quotes);
    return bool(result);
}
/// A picture has the samples that its size says.
bool is_picture(const Result<StoredImage>& picture);
/// The clip's first frames have the planes that its scene says.
bool is_clip(const Result<std::unique_ptr<ClipReader>>& clip);

/// A file of these bytes in a folder of this process, until the next one of that name.
std::filesystem::path file_of(std::string_view bytes, const std::string& name);

/// Takes numbers and text from the beginning of an input, zeros and nothing where it has ended.
class Taken {
public:
    explicit Taken(std::string_view bytes) : rest_(bytes) {}
    unsigned byte();
    double number();          ///< of eight bytes, any
    std::string_view line();  ///< up to a line feed, which is left out
    std::string_view rest() const { return rest_; }

private:
    std::string_view rest_;
};

/// Bytes of the heap and of planes that this program holds, its libraries and all its threads included. Bytes
/// of files that are mapped do not count.
///
/// Begins anew: what is there already is none of it. More than `most` at a time are refused where this
/// program's own malloc counts (glibc's), which is no memory for the caller; sanitizers' only count.
void count_live_memory(std::size_t most);
/// The most that were there at a time since then.
std::size_t most_live_memory();

}  // namespace touchable::fuzz
