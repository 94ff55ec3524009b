#pragma once

#include <filesystem>

#include "engine/base/result.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// Writes a clip frame by frame, in whatever form: Matroska, a folder of pictures.
class ClipWriter {
public:
    virtual ~ClipWriter() = default;
    /// Every frame has the planes of the first one, and the next number. Times come from the scene's rate.
    /// Its planes need last no longer than the call.
    virtual Result<void> write(const RawFrame& frame) = 0;
    /// The colour of the frame that was written last as readers will be given it, where its coding changes
    /// values and ClipStorage::gives_colour asked for it; empty otherwise. Until the next `write`.
    virtual PlaneView stored_colour() const { return {}; }
    /// The disk has little more room than it takes to complete the clip. Writing goes on, as far as it goes.
    virtual bool is_full() const { return false; }
    /// Completes the clip, which has no name yet, and gives where it can be opened until `finish`. May be
    /// left out.
    virtual Result<std::filesystem::path> complete() = 0;
    /// Gives the complete clip its name; without this nothing is left behind.
    virtual Result<void> finish() = 0;
};

}  // namespace touchable
