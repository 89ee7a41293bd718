#include <zlib.h>

#include <algorithm>
#include <array>
#include <new>

#include "acquire/range/range_files.h"

namespace scanknit {
namespace {

constexpr int kGzipWindow = 15 + 16;  // zlib's largest window, with gzip's header and check sum
constexpr std::size_t kChunk = 1u << 16;

bool is_gzip(std::string_view bytes) {
  return bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b';
}

Error damaged(const char* what) {
  return {ErrorCode::kInput, std::string("gzip: ") + what};
}

/// An open zlib stream, closed at the end.
struct Inflater {
  z_stream stream{};
  bool is_open = false;
  Inflater() { is_open = inflateInit2(&stream, kGzipWindow) == Z_OK; }
  ~Inflater() {
    if (is_open) inflateEnd(&stream);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
};

/// All members one after the other, as gzip has it (RFC 1952, section 2.2).
Result<std::string> inflate_all(std::string& packed, std::uintmax_t max_bytes) {
  Inflater inflater;
  if (!inflater.is_open) throw std::bad_alloc();
  z_stream& stream = inflater.stream;
  std::string unpacked;
  std::array<char, kChunk> chunk;
  std::size_t offset = 0;
  while (true) {
    if (stream.avail_in == 0) {  // zlib counts in 32 bits
      const std::size_t part = std::min<std::size_t>(packed.size() - offset, 1u << 30);
      if (part == 0) return damaged("truncated; is the file whole?");
      stream.next_in = reinterpret_cast<Bytef*>(packed.data() + offset);
      stream.avail_in = static_cast<uInt>(part);
      offset += part;
    }
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = static_cast<uInt>(chunk.size());
    const int status = inflate(&stream, Z_NO_FLUSH);
    if (status != Z_OK && status != Z_STREAM_END) return damaged("damaged");
    unpacked.append(chunk.data(), chunk.size() - stream.avail_out);
    if (unpacked.size() > max_bytes) {
      return Error{ErrorCode::kInput,
                   "gzip: unpacks to more than the limit of " + std::to_string(max_bytes) + " bytes"};
    }
    if (status != Z_STREAM_END) continue;
    const std::size_t rest = offset - stream.avail_in;  // zeros may fill up a block of a tape, as gunzip takes them
    const bool is_last =
        std::all_of(packed.begin() + static_cast<std::ptrdiff_t>(rest), packed.end(), [](char c) { return c == 0; });
    if (is_last) return unpacked;
    if (inflateReset(&stream) != Z_OK) return damaged("zlib cannot go on");
  }
}

}  // namespace

Result<std::string> unpack_gzip(std::string bytes, std::uintmax_t max_bytes) {
  if (!is_gzip(bytes)) return bytes;
  try {
    return inflate_all(bytes, max_bytes);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "gzip: what it unpacks to does not fit into memory"};
  }
}

}  // namespace scanknit
