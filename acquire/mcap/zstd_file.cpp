#include "acquire/mcap/zstd_file.h"

#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include "acquire/mcap/zstd_bytes.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

struct FreeStream {
  void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
};

/// Calls `take(bytes)` with what `packed` holds, a block at a time, until it returns false. False: torn or damaged.
template <typename Take>
bool unpack_blocks(const RandomAccess& packed, Take take) {
  const std::unique_ptr<ZSTD_DStream, FreeStream> stream(ZSTD_createDStream());
  if (!stream || ZSTD_isError(ZSTD_initDStream(stream.get())) != 0) return false;
  std::vector<std::byte> in(ZSTD_DStreamInSize()), out(ZSTD_DStreamOutSize());
  std::size_t hint = 1;  // 0: a frame has ended
  for (std::uint64_t at = 0; at < packed.size();) {
    const auto part =
        std::span(in).first(static_cast<std::size_t>(std::min<std::uint64_t>(in.size(), packed.size() - at)));
    if (!packed.read(at, part)) return false;
    at += part.size();
    ZSTD_inBuffer input{part.data(), part.size(), 0};
    bool is_full = true;  // more may come of what is read already
    while (input.pos < input.size || is_full) {
      ZSTD_outBuffer output{out.data(), out.size(), 0};
      hint = ZSTD_decompressStream(stream.get(), &output, &input);
      if (ZSTD_isError(hint) != 0) return false;
      if (output.pos > 0 && !take(std::span<const std::byte>(out).first(output.pos))) return true;
      is_full = output.pos == output.size;
      if (hint == 0 && input.pos == input.size) break;
    }
  }
  return hint == 0;
}

/// Has no name from the first.
class NamelessFile {
 public:
  NamelessFile() {
    std::error_code code;
    folder_ = fs::temp_directory_path(code);
    std::string name = (folder_ / "scanknit-bag-XXXXXX").string();
    descriptor_ = ::mkstemp(name.data());
    if (descriptor_ >= 0) ::unlink(name.c_str());
    const auto space = fs::space(folder_, code);
    constexpr std::uintmax_t kLeft = 64u << 20;  // for everybody else
    room_ = !code && space.available > kLeft ? space.available - kLeft : 0;
  }
  ~NamelessFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  NamelessFile(const NamelessFile&) = delete;
  NamelessFile& operator=(const NamelessFile&) = delete;

  /// False: there is no room for it.
  [[nodiscard]] bool append(std::span<const std::byte> bytes) {
    if (descriptor_ < 0 || bytes.size() > room_) return false;
    room_ -= bytes.size();
    while (!bytes.empty()) {
      const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
      if (count <= 0) return false;
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return true;
  }
  [[nodiscard]] Result<std::unique_ptr<RandomAccess>> reopen() const {
    return open_random_access("/proc/self/fd/" + std::to_string(descriptor_));
  }
  [[nodiscard]] const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
  int descriptor_ = -1;
  std::uintmax_t room_ = 0;
};

}  // namespace

std::vector<std::byte> zstd_front(const RandomAccess& packed, std::size_t count) {
  std::vector<std::byte> front(4);
  if (!packed.read(0, front) || !is_zstd(front)) return {};
  front.clear();
  (void)unpack_blocks(packed, [&](std::span<const std::byte> bytes) {
    front.insert(front.end(), bytes.begin(),
                 bytes.begin() + static_cast<std::ptrdiff_t>(std::min(bytes.size(), count - front.size())));
    return front.size() < count;
  });
  return front;
}

Result<UnpackedFile> unpack_zstd_file(const RandomAccess& packed) {
  constexpr std::uint64_t kMostTimes = 1000;
  NamelessFile file;
  std::uint64_t written = 0;
  bool has_room = true;
  const bool is_whole = unpack_blocks(packed, [&](std::span<const std::byte> bytes) {
    written += bytes.size();
    has_room = written / kMostTimes <= packed.size() && file.append(bytes);
    return has_room;
  });
  if (!has_room) {
    return Error{ErrorCode::kInput, "packed by zstd, and " + file.folder().string() +
                                        " has no room for what it holds (TMPDIR names another folder), or that is more "
                                        "than a thousand times as large; unpack it with 'zstd -d'"};
  }
  auto access = file.reopen();
  if (!access) return Error{ErrorCode::kInput, "packed by zstd, and cannot be unpacked: " + access.error().message};
  return UnpackedFile{*std::move(access), is_whole};
}

}  // namespace scanknit
