// What recording costs: the depth codec and a whole frame's way into a chunk, in bytes of raw depth a second.
#include <benchmark/benchmark.h>

#include <memory>
#include <random>
#include <vector>

#include "acquire/record/depth_codec.h"
#include "acquire/record/recording_writer.h"

namespace scanknit {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

// Slanted surfaces with steps, holes and two units of noise.
std::vector<std::byte> depth_picture() {
  std::minstd_rand random(1);
  std::vector<std::byte> bytes;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool is_hole = (x / 40 + y / 40) % 9 == 0;
      const unsigned step = static_cast<unsigned>((x / 160) * 300);
      const unsigned raw =
          is_hole ? 0 : 700u + step + static_cast<unsigned>(x / 4 + y / 2) + static_cast<unsigned>(random() % 3);
      bytes.push_back(static_cast<std::byte>(raw & 0xFF));
      bytes.push_back(static_cast<std::byte>(raw >> 8));
    }
  }
  return bytes;
}

void count_bytes(benchmark::State& state) {
  state.SetBytesProcessed(state.iterations() * kWidth * kHeight * 2);
}

void BM_encode_depth(benchmark::State& state) {
  const auto picture = depth_picture();
  std::size_t packed = 1;
  for (auto _ : state) {
    const auto bytes = encode_depth(picture);
    packed = bytes.size();
    benchmark::DoNotOptimize(bytes.data());
  }
  count_bytes(state);
  state.counters["ratio"] = static_cast<double>(picture.size()) / static_cast<double>(packed);
}
BENCHMARK(BM_encode_depth);

void BM_decode_depth(benchmark::State& state) {
  const auto packed = encode_depth(depth_picture());
  for (auto _ : state) benchmark::DoNotOptimize(decode_depth(packed, kWidth * kHeight));
  count_bytes(state);
}
BENCHMARK(BM_decode_depth);

void BM_write_depth_frame(benchmark::State& state) {
  RawFrame frame;
  frame.profile = {StreamKind::kDepth, PixelFormat::kZ16, kWidth, kHeight, 30};
  frame.bytes = std::make_shared<const std::vector<std::byte>>(depth_picture());
  RecordingWriter writer([](std::span<const std::byte>) { return Result<void>(); }, {});
  for (auto _ : state) {
    ++frame.sequence;
    benchmark::DoNotOptimize(writer.write(frame).has_value());
  }
  count_bytes(state);
}
BENCHMARK(BM_write_depth_frame);

}  // namespace
}  // namespace scanknit
