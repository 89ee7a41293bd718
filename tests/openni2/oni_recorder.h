// Recordings by OpenNI2's own recorder, of the emulated camera.
#pragma once

#include <filesystem>

namespace scanknit::test {

struct OniRecorderOptions {
  int pictures = 12;         ///< at least so many of depth
  bool is_lossy = false;     ///< colour as JPEG
  bool is_mirrored = false;  ///< as NiViewer records unless told otherwise
};

/// False: the library refused.
[[nodiscard]] bool record_oni(const std::filesystem::path& path, const OniRecorderOptions& options = {});

}  // namespace scanknit::test
