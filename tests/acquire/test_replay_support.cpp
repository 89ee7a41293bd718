#include "test_replay_support.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/files/read_file.h"

namespace scanknit::test {

namespace fs = std::filesystem;

void write_bytes(const fs::path& path, const std::vector<std::byte>& bytes) {
  std::string text(bytes.size(), '\0');
  if (!bytes.empty()) std::memcpy(text.data(), bytes.data(), bytes.size());
  write_text(path, text);
}

std::vector<std::byte> bytes_of(const fs::path& path) {
  return read_file(path, 1u << 30).value();
}

void write_depth(const fs::path& path, std::uint16_t raw, int width, int height) {
  fs::create_directories(path.parent_path());
  cv::imwrite(path.string(), cv::Mat(height, width, CV_16UC1, cv::Scalar(raw)));
}

void write_colour(const fs::path& path, Rgb8 colour, int width, int height) {
  fs::create_directories(path.parent_path());
  cv::imwrite(path.string(), cv::Mat(height, width, CV_8UC3, cv::Scalar(colour.b, colour.g, colour.r)));
}

void write_grey8(const fs::path& path, std::uint8_t value, int width, int height) {
  fs::create_directories(path.parent_path());
  cv::imwrite(path.string(), cv::Mat(height, width, CV_8UC1, cv::Scalar(value)));
}

std::string seven_scenes_name(int number, std::string_view what) {
  std::ostringstream name;
  name << "frame-" << std::setw(6) << std::setfill('0') << number << '.' << what;
  return name.str();
}

void write_seven_scenes(const fs::path& folder, int count) {
  write_text(folder / "camera-intrinsics.txt", kMatrix);
  for (int i = 0; i < count; ++i) {
    write_depth(folder / seven_scenes_name(i, "depth.png"), 1000);
    write_text(folder / seven_scenes_name(i, "pose.txt"), kIdentity);
  }
}

std::vector<std::string> Played::reasons() const {
  std::vector<std::string> words;
  for (const FrameDropped& drop : dropped) words.emplace_back(to_string(drop.reason));
  return words;
}

Played play(FrameSource& source) {
  Played played;
  for (;;) {
    FrameEvent event = source.next({});
    if (std::holds_alternative<EndOfStream>(event)) return played;
    if (auto* error = std::get_if<Error>(&event)) {
      played.errors.push_back(*error);
      return played;
    }
    if (auto* frame = std::get_if<Frame>(&event)) played.frames.push_back(std::move(*frame));
    if (auto* drop = std::get_if<FrameDropped>(&event)) played.dropped.push_back(std::move(*drop));
  }
}

Played play(const fs::path& path, const AcquireConfig& config) {
  auto source = open_recording(path, config);
  EXPECT_TRUE(source) << source.error().text();
  return source ? play(**source) : Played{};
}

std::string open_error(const fs::path& path, const AcquireConfig& config) {
  const auto source = open_recording(path, config);
  return source ? std::string() : source.error().text();
}

}  // namespace scanknit::test
