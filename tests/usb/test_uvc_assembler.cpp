#include <gtest/gtest.h>

#include <random>

#include "acquire/uvc/uvc_assembler.h"
#include "tests/usb/usb_bytes.h"

namespace scanknit::test {
namespace {

constexpr std::size_t kFrame = 1000;
constexpr int kEnd = 0x02, kError = 0x40;

/// A payload of the picture `value`, which all its bytes have; its frame id is the value's last bit.
Bytes payload(int value, std::size_t bytes, int flags = 0) {
  return Bytes{2, flags | (value & 1)}.fill(bytes, value);
}

/// With a frame counter in metadata like a RealSense's.
Bytes counted_payload(std::uint32_t counter, std::size_t bytes = kFrame) {
  Bytes out{22, static_cast<int>(kEnd | (counter & 1))};
  out.u32(0x80000001).u32(0).u32(0).u32(0).u32(counter);
  return out.fill(bytes, static_cast<int>(counter));
}

/// What comes out, as the value of each picture.
class Harness {
 public:
  explicit Harness(UvcAssembler::Framing framing = {kFrame, false, false})
      : assembler_(framing, [this](AssembledFrame frame) {
          values.push_back(std::to_integer<int>(frame.bytes->front()));
          for (const std::byte byte : *frame.bytes) EXPECT_EQ(std::to_integer<int>(byte), values.back());
          sequences.push_back(frame.sequence);
          sizes.push_back(frame.bytes->size());
        }) {}

  Harness& add(const Bytes& bytes) { return assembler_.add(bytes.span(), true, 0), *this; }
  UvcAssembler& operator*() { return assembler_; }
  UvcAssembler* operator->() { return &assembler_; }

  std::vector<int> values;
  std::vector<std::uint64_t> sequences;
  std::vector<std::size_t> sizes;

 private:
  UvcAssembler assembler_;
};

LossCounters transport(std::uint64_t count) {
  return {0, count, 0, 0, 0};
}

using Values = std::vector<int>;

TEST(UvcAssembler, EndsAFrameAtItsEndBit) {
  Harness harness;
  harness.add(payload(1, 600)).add(payload(1, 400, kEnd)).add(payload(2, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{1, 2}));
  EXPECT_EQ(harness->losses(), transport(0));
}

TEST(UvcAssembler, EndsAFrameWhereTheIdFlips) {
  Harness harness;
  harness.add(payload(1, 1000)).add(payload(2, 1000)).add(payload(3, 1000));
  EXPECT_EQ(harness.values, (Values{1, 2}));
}

TEST(UvcAssembler, TakesASecondFrameOfTheSameIdAfterTheEndBit) {
  Harness harness;
  harness.add(payload(1, 1000, kEnd)).add(payload(3, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{1, 3}));
}

TEST(UvcAssembler, IgnoresHeadersWithoutData) {
  Harness harness;
  harness.add(payload(1, 0)).add(payload(1, 1000)).add(payload(1, 0)).add(payload(1, 0, kEnd)).add(payload(1, 0, kEnd));
  harness.add(Bytes{}).add(payload(2, 0)).add(payload(2, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{1, 2}));
  EXPECT_EQ(harness->losses(), transport(0));
}

TEST(UvcAssembler, NeverDeliversAShortFrame) {
  Harness harness;
  harness.add(payload(1, 999, kEnd)).add(payload(2, 1000, kEnd)).add(payload(3, 500)).add(payload(4, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{2, 4}));
  EXPECT_EQ(harness->losses(), transport(2));
}

TEST(UvcAssembler, NeverDeliversALongFrame) {
  Harness harness;
  harness.add(payload(1, 1001, kEnd)).add(payload(2, 700)).add(payload(2, 700, kEnd)).add(payload(3, 90'000, kEnd));
  harness.add(payload(4, 1000, kEnd));
  EXPECT_EQ(harness.values, Values{4});
  EXPECT_EQ(harness->losses().overflow, 3u);
  EXPECT_EQ(harness->losses().total(), 3u);
}

TEST(UvcAssembler, NeverDeliversAFrameMarkedAsBad) {
  Harness harness;
  harness.add(payload(1, 500, kError)).add(payload(1, 500, kEnd)).add(payload(2, 1000, kEnd));
  harness.add(payload(3, 1000, kError | kEnd)).add(payload(4, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{2, 4}));
  EXPECT_EQ(harness->losses(), transport(2));
}

TEST(UvcAssembler, CountsEachWholeFramePayloadWithABadHeader) {
  Harness harness({kFrame, false, true});
  harness.add(payload(1, 1000, kEnd));
  for (const int length : {0, 1, 255}) {
    Bytes bad = payload(2, 100, kEnd);
    bad[0] = std::byte(length);
    harness.add(bad);
  }
  harness.add(payload(5, 1000, kEnd)).add(payload(6, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{1, 5, 6}));
  EXPECT_EQ(harness->losses(), transport(3));
}

TEST(UvcAssembler, LosesTheFrameOfABadHeaderAmongManyPayloads) {
  for (const int bad_one : {0, 1, 2}) {
    Harness harness;
    harness.add(payload(1, 1000, kEnd));
    for (int i = 0; i < 3; ++i) {
      Bytes part = payload(2, i == 2 ? 200 : 400, i == 2 ? kEnd : 0);
      if (i == bad_one) part[0] = std::byte{0};
      harness.add(part);
    }
    harness.add(payload(3, 400)).add(payload(3, 600, kEnd)).add(payload(4, 1000, kEnd));
    EXPECT_EQ(harness.values, (Values{1, 3, 4})) << bad_one;
    EXPECT_EQ(harness->losses(), transport(1)) << bad_one;
  }
}

TEST(UvcAssembler, CountsLostTransfersByKind) {
  Harness harness({kFrame, false, true});
  harness.add(payload(1, 1000, kEnd));
  harness->lose(UvcAssembler::Loss::kOverflow);
  harness->lose(UvcAssembler::Loss::kTransport);
  harness->lose(UvcAssembler::Loss::kTransport);
  harness.add(payload(5, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{1, 5}));
  EXPECT_EQ(harness.sequences, (std::vector<std::uint64_t>{0, 4}));
  EXPECT_EQ(harness->losses().overflow, 1u);
  EXPECT_EQ(harness->losses().transport, 2u);
}

TEST(UvcAssembler, LosesOneFrameWithOneOfItsPackets) {
  Harness harness;
  harness.add(payload(1, 1000, kEnd)).add(payload(2, 400));
  harness->lose(UvcAssembler::Loss::kTransport);
  harness.add(payload(2, 200, kEnd)).add(payload(3, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{1, 3}));
  EXPECT_EQ(harness->losses(), transport(1));
}

TEST(UvcAssembler, LosesNothingWithAPacketBetweenFrames) {
  Harness harness;
  harness.add(payload(1, 1000, kEnd));
  harness->lose(UvcAssembler::Loss::kTransport);
  harness.add(payload(2, 600)).add(payload(2, 400, kEnd));
  EXPECT_EQ(harness.values, (Values{1, 2}));
  EXPECT_EQ(harness->losses(), transport(0));
}

TEST(UvcAssembler, DeliversAWholeFrameAfterTheRemainsOfAnother) {
  Harness harness;
  harness.add(payload(1, 300)).add(payload(3, 1000, kEnd));  // the end of frame 1 and all of frame 2 are missing
  EXPECT_EQ(harness.values, Values{3});
  EXPECT_EQ(harness->losses(), transport(1));
}

TEST(UvcAssembler, TellsWhatTheCameraLostFromWhatTheCableLost) {
  Harness harness({kFrame, false, true});
  harness.add(counted_payload(10)).add(counted_payload(11, 500)).add(counted_payload(14));
  EXPECT_EQ(harness.sequences, (std::vector<std::uint64_t>{0, 4}));
  EXPECT_EQ(harness->losses().transport, 1u);  // 11
  EXPECT_EQ(harness->losses().device, 2u);     // 12, 13
}

TEST(UvcAssembler, DeliversNoFrameTwice) {
  Harness harness({kFrame, false, true});
  harness.add(counted_payload(10)).add(counted_payload(10)).add(counted_payload(11));
  EXPECT_EQ(harness.values, (Values{10, 11}));
  EXPECT_EQ(harness->losses(), transport(1));
}

TEST(UvcAssembler, GoesOnCountingWhenTheCounterBeginsAnewOrWraps) {
  Harness harness({kFrame, false, true});
  harness.add(counted_payload(0xFFFFFFFF)).add(counted_payload(0)).add(counted_payload(100'000));
  harness.add(counted_payload(3));
  EXPECT_EQ(harness.sequences, (std::vector<std::uint64_t>{0, 1, 2, 3}));
  EXPECT_EQ(harness->losses().total(), 0u);
}

TEST(UvcAssembler, RestartLosesOnlyAnOpenFrame) {
  Harness harness;
  harness->restart();
  harness.add(payload(1, 1000, kEnd))->restart();
  EXPECT_EQ(harness->losses().total(), 0u);
  harness.add(payload(2, 100))->restart();
  harness.add(payload(2, 1000, kEnd));
  EXPECT_EQ(harness.values, (Values{1, 2}));
  EXPECT_EQ(harness->losses(), transport(1));
}

TEST(UvcAssembler, WantsAJpegFromStartToEnd) {
  std::vector<std::size_t> sizes;
  UvcAssembler assembler({kFrame, true, false}, [&](AssembledFrame frame) { sizes.push_back(frame.bytes->size()); });
  const auto add = [&](const Bytes& bytes) { assembler.add(bytes.span(), true, 0); };
  add(Bytes{2, 2, 0xFF, 0xD8, 1, 2, 3, 0xFF, 0xD9});
  add(Bytes{2, 3, 0xFF, 0xD8, 1, 2, 0xFF, 0xD9, 0, 0});  // padded
  add(Bytes{2, 2, 0xFF, 0xD8, 1, 2, 3});                 // cut
  add(Bytes{2, 3, 0, 1, 2, 0xFF, 0xD9});                 // no start
  add(Bytes{2, 2, 0xFF, 0xD8, 0xFF, 0xD9});
  EXPECT_EQ(sizes, (std::vector<std::size_t>{7, 6, 4}));
  EXPECT_EQ(assembler.losses(), transport(2));
}

/// A stream with every fault in it, as payloads.
std::vector<Bytes> random_payloads(unsigned seed) {
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  std::vector<Bytes> payloads;
  for (int frame = 0; frame < 60; ++frame) {
    std::size_t left = below(6) == 0 ? static_cast<std::size_t>(below(1500)) : kFrame;
    while (left > 0) {
      const std::size_t part = std::min<std::size_t>(left, 1 + static_cast<std::size_t>(below(900)));
      left -= part;
      const int flags = (left == 0 && below(8) != 0 ? kEnd : 0) | (below(30) == 0 ? kError : 0);
      Bytes bytes = payload(frame, part, flags);
      if (below(25) == 0) bytes[0] = std::byte(below(256));
      if (below(40) != 0) payloads.push_back(bytes);
    }
  }
  return payloads;
}

TEST(UvcAssembler, GivesTheSameFramesHoweverPayloadsAreSplit) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    for (const bool is_one_payload : {false, true}) {
      std::vector<std::pair<std::uint64_t, std::vector<std::byte>>> whole, split;
      UvcAssembler first({kFrame, false, is_one_payload},
                         [&](AssembledFrame frame) { whole.emplace_back(frame.sequence, *frame.bytes); });
      UvcAssembler second({kFrame, false, is_one_payload},
                          [&](AssembledFrame frame) { split.emplace_back(frame.sequence, *frame.bytes); });
      std::mt19937 random(seed);
      for (const Bytes& bytes : random_payloads(seed)) {
        first.add(bytes.span(), true, 0);
        std::span<const std::byte> rest = bytes.span();
        while (!rest.empty()) {
          const std::size_t part = std::min<std::size_t>(rest.size(), 1 + random() % 300);
          second.add(rest.first(part), part == rest.size(), 0);
          rest = rest.subspan(part);
        }
      }
      EXPECT_EQ(whole, split) << "seed " << seed;
      EXPECT_EQ(first.losses(), second.losses()) << "seed " << seed;
      for (const auto& frame : whole) EXPECT_EQ(frame.second.size(), kFrame);
    }
  }
}

}  // namespace
}  // namespace scanknit::test
