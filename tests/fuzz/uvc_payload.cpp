// The stream of one endpoint as payloads, the first byte of each its length; the second half of the input says where
// they are split. Whole or split, the frames are the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "acquire/uvc/uvc_assembler.h"

namespace {

using scanknit::AssembledFrame;
using scanknit::UvcAssembler;

constexpr std::size_t kFrameBytes = 100;

struct Outcome {
  std::vector<std::vector<std::byte>> frames;
  scanknit::LossCounters losses;
};

Outcome assemble(std::span<const std::byte> payloads, std::span<const std::byte> splits, bool is_compressed) {
  Outcome outcome;
  UvcAssembler assembler({kFrameBytes, is_compressed, false}, [&](AssembledFrame frame) {
    if (!is_compressed && frame.bytes->size() != kFrameBytes) std::abort();
    outcome.frames.push_back(*frame.bytes);
  });
  std::size_t next_split = 0;
  while (!payloads.empty()) {
    const std::size_t length = std::min(payloads.size() - 1, std::to_integer<std::size_t>(payloads[0]));
    auto rest = payloads.subspan(1, length);
    payloads = payloads.subspan(1 + length);
    while (!rest.empty()) {
      std::size_t part = rest.size();
      if (!splits.empty())
        part = std::min(part, 1 + std::to_integer<std::size_t>(splits[next_split++ % splits.size()]));
      assembler.add(rest.first(part), part == rest.size(), 0);
      rest = rest.subspan(part);
    }
  }
  outcome.losses = assembler.losses();
  return outcome;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const auto bytes = std::as_bytes(std::span(data, size));
  const bool is_compressed = (bytes[0] & std::byte{1}) != std::byte{0};
  const auto payloads = bytes.subspan(1, size / 2);
  const auto splits = bytes.subspan(1 + payloads.size());
  const Outcome whole = assemble(payloads, {}, is_compressed);
  const Outcome split = assemble(payloads, splits, is_compressed);
  if (whole.frames != split.frames || !(whole.losses == split.losses)) std::abort();
  return 0;
}
