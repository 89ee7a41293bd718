#include <gtest/gtest.h>

#include "acquire/uvc/uvc_payload.h"
#include "acquire/uvc/uvc_probe.h"
#include "tests/usb/usb_bytes.h"

namespace scanknit::test {
namespace {

TEST(UvcProbe, HasTheLengthOfItsVersion) {
  EXPECT_EQ(probe_bytes(0x0100), 26u);
  EXPECT_EQ(probe_bytes(0x0110), 34u);
  EXPECT_EQ(probe_bytes(0x0150), 48u);
}

TEST(UvcProbe, ReadsWhatItWrote) {
  const UvcStreamControl control{2, 5, 333333, 614400, 614412};
  for (const std::size_t bytes : {26u, 34u, 48u}) {
    const auto written = encode_probe(control, bytes);
    ASSERT_EQ(written.size(), bytes);
    const auto read = decode_probe(written);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->format_index, 2);
    EXPECT_EQ(read->frame_index, 5);
    EXPECT_EQ(read->interval_100ns, 333333u);
    EXPECT_EQ(read->max_frame_bytes, 614400u);
    EXPECT_EQ(read->max_payload_bytes, 614412u);
  }
}

TEST(UvcProbe, PutsTheFieldsWhereTheStandardHasThem) {
  // UVC 1.5, table 4-75: format at 2, frame at 3, interval at 4, frame size at 18, payload size at 22.
  const auto bytes = encode_probe({7, 8, 0x01020304, 0x11121314, 0x21222324}, 26);
  EXPECT_EQ(bytes[0], std::byte{1});
  EXPECT_EQ(bytes[2], std::byte{7});
  EXPECT_EQ(bytes[3], std::byte{8});
  EXPECT_EQ(bytes[4], std::byte{0x04});
  EXPECT_EQ(bytes[18], std::byte{0x14});
  EXPECT_EQ(bytes[25], std::byte{0x21});
}

TEST(UvcProbe, RefusesAnyShorterAnswer) {
  const auto bytes = encode_probe({}, 26);
  for (std::size_t size = 0; size < 26; ++size) EXPECT_FALSE(decode_probe(std::span(bytes).first(size)));
}

Bytes realsense_header() {
  Bytes bytes{44, 0x8D};  // SCR, PTS, end of header, frame id
  bytes.u32(123456).u32(0).u16(0);
  return bytes.u32(0x80000001).u32(40).u32(1).u32(0).u32(77).fill(12);
}

TEST(UvcPayload, TellsFrameIdTimeAndRealsenseCounter) {
  const auto header = parse_payload_header(realsense_header().fill(100, 9).span());
  ASSERT_TRUE(header);
  EXPECT_EQ(header->bytes, 44u);
  EXPECT_TRUE(header->frame_id);
  EXPECT_FALSE(header->is_end);
  EXPECT_FALSE(header->has_error);
  EXPECT_EQ(header->presentation_ticks, 123456u);
  EXPECT_EQ(header->frame_counter, 77u);
}

TEST(UvcPayload, ReadsAHeaderOfTwoBytes) {
  const auto header = parse_payload_header(Bytes{2, 0x42}.span());
  ASSERT_TRUE(header);
  EXPECT_TRUE(header->is_end);
  EXPECT_TRUE(header->has_error);
  EXPECT_FALSE(header->presentation_ticks);
}

TEST(UvcPayload, RefusesHeadersShorterThanTheirBitsSay) {
  EXPECT_FALSE(parse_payload_header(Bytes{}.span()));
  EXPECT_FALSE(parse_payload_header(Bytes{0, 0, 0}.span()));
  EXPECT_FALSE(parse_payload_header(Bytes{1, 0, 0}.span()));
  EXPECT_FALSE(parse_payload_header(Bytes{5, 0x04, 0, 0, 0, 0, 0}.span())) << "no room for the time";
  EXPECT_FALSE(parse_payload_header(Bytes{7, 0x08, 0, 0, 0, 0, 0, 0}.span())) << "no room for the source clock";
}

TEST(UvcPayload, RefusesHeadersLongerThanThePayload) {
  const Bytes whole = realsense_header();
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(parse_payload_header(whole.span().first(size)));
}

TEST(UvcPayload, HasNoCounterWhereTheMetadataIsCutOrUnknown) {
  for (int length = 12; length < 32; ++length) {
    Bytes bytes = realsense_header();
    bytes[0] = std::byte(length);
    const auto header = parse_payload_header(bytes.span());
    ASSERT_TRUE(header) << length;
    EXPECT_FALSE(header->frame_counter) << length;
  }
}

}  // namespace
}  // namespace scanknit::test
