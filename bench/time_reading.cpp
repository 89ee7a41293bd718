// How fast recordings are read: each frame decoded and straightened, nothing done with it. One line a recording.
//   time_reading RECORDING...
#include <fmt/core.h>

#include <chrono>
#include <filesystem>
#include <stop_token>
#include <string>
#include <variant>

#include "acquire/frame_source.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// Of a file, or of all files in a folder.
double megabytes_of(const fs::path& path) {
  double bytes = 0;
  if (!fs::is_directory(path)) {
    bytes = static_cast<double>(fs::file_size(path));
  } else {
    for (const auto& file : fs::recursive_directory_iterator(path)) {
      if (file.is_regular_file()) bytes += static_cast<double>(file.file_size());
    }
  }
  return bytes / 1e6;
}

struct Read {
  std::string format;
  int frames = 0, dropped = 0;
  double opened_s = 0, read_s = 0;
};

Result<Read> read_all(const fs::path& path) {
  using Clock = std::chrono::steady_clock;
  const auto since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  const auto begin = Clock::now();
  auto source = open_recording(path, AcquireConfig{});
  if (!source) return source.error();
  Read read{.format = (*source)->info().format, .opened_s = since(begin)};
  const auto first = Clock::now();
  for (;;) {
    const FrameEvent event = (*source)->next(std::stop_token{});
    if (std::holds_alternative<EndOfStream>(event)) break;
    if (const auto* error = std::get_if<Error>(&event)) return *error;
    ++(std::holds_alternative<Frame>(event) ? read.frames : read.dropped);
  }
  read.read_s = since(first);
  return read;
}

int run(int count, char** arguments) {
  if (count < 2) {
    fmt::print(stderr, "usage: time_reading RECORDING...\n");
    return 2;
  }
  for (int i = 1; i < count; ++i) {
    const auto read = read_all(arguments[i]);
    if (!read) {
      fmt::print(stderr, "{}\n", read.error().text());
      return 4;
    }
    fmt::print("{:14} {:5} frames, {} dropped, opened in {:6.1f} ms, {:6.1f} frames a second, {:6.1f} MB a second\n",
               read->format, read->frames, read->dropped, 1000 * read->opened_s, read->frames / read->read_s,
               megabytes_of(arguments[i]) / read->read_s);
  }
  return 0;
}

}  // namespace
}  // namespace scanknit

int main(int count, char** arguments) {
  return scanknit::run(count, arguments);
}
