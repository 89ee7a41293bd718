#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "acquire/uvc/uvc_descriptors.h"
#include "tests/usb/usb_bytes.h"

namespace scanknit::test {
namespace {

using namespace std::string_view_literals;

Bytes interface(int number, int alternate, int subclass) {
  return descriptor({0x04, number, alternate, 1, 0x0E, subclass, 0, 0});
}

Bytes vc_header(std::uint32_t version) {
  return descriptor(Bytes{0x24, 0x01}.u16(version).u16(0).u32(48'000'000).u8(1).u8(1));
}

Bytes frame_based_format(int index, std::string_view code) {
  return descriptor(Bytes{0x24, 0x10, index, 1}.add(format_guid(code)).u8(16).u8(1).fill(5));
}

Bytes frame_based_size(int index, int width, int height, std::initializer_list<std::uint32_t> intervals) {
  Bytes body{0x24, 0x11, index, 0};
  body.u16(static_cast<std::uint32_t>(width)).u16(static_cast<std::uint32_t>(height)).u32(0).u32(0).u32(333333);
  body.u8(static_cast<int>(intervals.size())).u32(static_cast<std::uint32_t>(2 * width));
  for (const std::uint32_t interval : intervals) body.u32(interval);
  return descriptor(body);
}

Bytes uncompressed_format(int index, std::string_view code) {
  return descriptor(Bytes{0x24, 0x04, index, 1}.add(format_guid(code)).u8(16).u8(1).fill(4));
}

Bytes plain_size(int subtype, int index, int width, int height, std::initializer_list<std::uint32_t> intervals) {
  Bytes body{0x24, subtype, index, 0};
  body.u16(static_cast<std::uint32_t>(width)).u16(static_cast<std::uint32_t>(height)).u32(0).u32(0);
  body.u32(static_cast<std::uint32_t>(2 * width * height)).u32(333333).u8(static_cast<int>(intervals.size()));
  for (const std::uint32_t interval : intervals) body.u32(interval);
  return descriptor(body);
}

Bytes bulk_endpoint(int address) {
  return descriptor(Bytes{0x05, address, 0x02}.u16(1024).u8(0));
}

const Bytes kConfiguration = {9, 2, 0, 0, 5, 1, 0, 0x80, 50};
const Bytes kXuGuid = {0xCB, 0x6C, 0x60, 0xC9, 0x4C, 0x59, 0x25, 0x4D, 0xAF, 0x47, 0xCC, 0xC4, 0x96, 0x43, 0x59, 0x95};

/// As a D421 describes itself (usb.md), with a second function for colour.
Bytes d400() {
  Bytes bytes = kConfiguration;
  bytes.add(descriptor({0x0B, 0, 2, 0x0E, 3, 0, 0})).add(interface(0, 0, 1)).add(vc_header(0x0150));
  bytes.add(descriptor(Bytes{0x24, 0x02, 1}.u16(0x0201).fill(10)));
  bytes.add(descriptor({0x24, 0x05, 2, 1, 0, 0, 2, 0, 0, 0}));
  bytes.add(descriptor(Bytes{0x24, 0x06, 3}.add(kXuGuid).u8(17).u8(1).u8(2).u8(1).u8(0xFF).u8(0)));
  bytes.add(interface(1, 0, 2)).add(descriptor({0x24, 0x01, 2, 0, 0, 0x82, 0, 4, 0, 0, 0, 1, 0}));
  bytes.add(frame_based_format(1, "Z16 ")).add(frame_based_size(1, 640, 480, {111111, 333333}));
  bytes.add(frame_based_size(2, 1280, 720, {333333})).add(descriptor({0x24, 0x0D, 1, 1, 4}));
  bytes.add(frame_based_format(2, "\x32\0\0\0"sv)).add(frame_based_size(1, 640, 480, {333333}));
  bytes.add(bulk_endpoint(0x82)).add(descriptor({0x30, 15, 0, 0, 0}));
  bytes.add(descriptor({0x0B, 3, 2, 0x0E, 3, 0, 0})).add(interface(3, 0, 1)).add(vc_header(0x0150));
  bytes.add(interface(4, 0, 2)).add(uncompressed_format(1, "YUY2")).add(plain_size(0x05, 1, 640, 480, {333333}));
  bytes.add(descriptor({0x24, 0x06, 2, 1, 1, 1, 0, 0, 0, 0})).add(plain_size(0x07, 1, 640, 480, {}));
  return bytes.add(bulk_endpoint(0x84));
}

TEST(UvcDescriptors, FindDepthAndColourOfARealsense) {
  const auto functions = parse_uvc_configuration(d400().span());
  ASSERT_TRUE(functions) << functions.error().text();
  ASSERT_EQ(functions->size(), 2u);
  const UvcFunction& depth = (*functions)[0];
  EXPECT_EQ(depth.version, 0x0150);
  EXPECT_EQ(depth.clock_hz, 48'000'000u);
  EXPECT_EQ(depth.camera_terminal, 1);
  EXPECT_EQ(depth.processing_unit, 2);
  ASSERT_EQ(depth.extension_units.size(), 1u);
  EXPECT_EQ(depth.extension_units[0].id, 3);
  EXPECT_TRUE(
      std::equal(depth.extension_units[0].guid.begin(), depth.extension_units[0].guid.end(), kXuGuid.span().begin()));
  ASSERT_EQ(depth.streams.size(), 1u);
  const UvcStreamingInterface& stream = depth.streams[0];
  EXPECT_EQ(stream.number, 1);
  ASSERT_EQ(stream.formats.size(), 2u);
  EXPECT_EQ(stream.formats[0].pixel_format, PixelFormat::kZ16);
  EXPECT_FALSE(stream.formats[1].pixel_format);  // infrared
  ASSERT_EQ(stream.formats[0].sizes.size(), 2u);
  EXPECT_EQ(stream.formats[0].sizes[0].width, 640);
  EXPECT_EQ(stream.formats[0].sizes[0].height, 480);
  EXPECT_EQ(stream.formats[0].sizes[0].max_frame_bytes, 614400u);
  EXPECT_EQ(stream.formats[0].sizes[0].intervals_100ns, (std::vector<std::uint32_t>{111111, 333333}));
  ASSERT_EQ(stream.alternates.size(), 1u);
  EXPECT_EQ(stream.alternates[0].endpoint, 0x82);
  EXPECT_FALSE(stream.alternates[0].is_isochronous);
  EXPECT_EQ(stream.alternates[0].packet_bytes, 1024);
  const UvcStreamingInterface& colour = (*functions)[1].streams.at(0);
  EXPECT_EQ(colour.formats.at(0).pixel_format, PixelFormat::kYuyv);
  EXPECT_EQ(colour.formats.at(1).pixel_format, PixelFormat::kMjpeg);
  EXPECT_TRUE(colour.formats.at(1).is_compressed);
  EXPECT_EQ(colour.formats.at(1).sizes.at(0).intervals_100ns, std::vector<std::uint32_t>{333333});
}

TEST(UvcDescriptors, HungOnTheEndpointCountForTheInterface) {
  Bytes bytes = kConfiguration;
  bytes.add(interface(0, 0, 1)).add(vc_header(0x0110)).add(interface(1, 0, 2)).add(bulk_endpoint(0x81));
  bytes.add(uncompressed_format(1, "Y16 ")).add(plain_size(0x05, 1, 320, 240, {333333}));
  const auto functions = parse_uvc_configuration(bytes.span());
  ASSERT_TRUE(functions);
  const UvcStreamingInterface& stream = functions->at(0).streams.at(0);
  EXPECT_EQ(stream.formats.at(0).pixel_format, PixelFormat::kZ16);
  EXPECT_EQ(stream.formats.at(0).sizes.at(0).max_frame_bytes, 153600u);
}

TEST(UvcDescriptors, IsochronousAlternatesSayTheirBytesPerInterval) {
  Bytes bytes = kConfiguration;
  bytes.add(interface(0, 0, 1)).add(interface(1, 0, 2)).add(interface(1, 1, 2));
  bytes.add(descriptor(Bytes{0x05, 0x81, 0x05}.u16(0x1400).u8(1)));
  bytes.add(interface(1, 2, 2)).add(descriptor(Bytes{0x05, 0x81, 0x05}.u16(1024).u8(1)));
  bytes.add(descriptor(Bytes{0x30, 3, 0}.u16(12288)));
  const auto functions = parse_uvc_configuration(bytes.span());
  ASSERT_TRUE(functions);
  ASSERT_EQ(functions->at(0).streams.size(), 1u);
  const auto& alternates = functions->at(0).streams[0].alternates;
  ASSERT_EQ(alternates.size(), 2u);
  EXPECT_TRUE(alternates[0].is_isochronous);
  EXPECT_EQ(alternates[0].number, 1);
  EXPECT_EQ(alternates[0].bytes_per_interval, 3072u);
  EXPECT_EQ(alternates[1].bytes_per_interval, 12288u);
}

TEST(UvcDescriptors, DepthHasManyNames) {
  for (const std::string_view code : {"Z16 "sv, "Y16 "sv, "\x50\0\0\0"sv, "INVZ"sv}) {
    UvcGuid guid;
    const Bytes bytes = format_guid(code);
    std::copy(bytes.span().begin(), bytes.span().end(), guid.begin());
    EXPECT_EQ(pixel_format_of(guid), PixelFormat::kZ16) << code;
    guid[15] = std::byte{0};
    EXPECT_FALSE(pixel_format_of(guid)) << "the tail counts";
  }
}

TEST(UvcDescriptors, CutAtAnyByteGiveAnErrorOrLess) {
  const Bytes whole = d400();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto functions = parse_uvc_configuration(whole.span().first(size));
    EXPECT_TRUE(!functions || functions->size() <= 2u);
  }
}

TEST(UvcDescriptors, OfAnInterfaceWithoutAFirstSettingAreSkipped) {
  Bytes bytes = kConfiguration;
  bytes.add(interface(0, 1, 1)).add(vc_header(0x0150)).add(interface(1, 0, 2)).add(bulk_endpoint(0x82));
  const auto functions = parse_uvc_configuration(bytes.span());
  ASSERT_TRUE(functions);
  EXPECT_TRUE(functions->empty());
}

TEST(UvcDescriptors, OfNoLengthAreRefused) {
  Bytes bytes = kConfiguration;
  EXPECT_FALSE(parse_uvc_configuration(bytes.add({0, 0x24}).span()));
}

TEST(UvcDescriptors, LongerThanWhatIsLeftAreRefused) {
  Bytes bytes = kConfiguration;
  const auto functions = parse_uvc_configuration(bytes.add({200, 0x24, 1}).span());
  ASSERT_FALSE(functions);
  EXPECT_NE(functions.error().message.find("200 bytes"), std::string::npos);
}

TEST(UvcDescriptors, BeyondAnyCameraAreRefused) {
  Bytes bytes = kConfiguration;
  bytes.add(interface(0, 0, 1)).add(interface(1, 0, 2)).add(frame_based_format(1, "Z16 "));
  for (int i = 0; i < 300; ++i) bytes.add(frame_based_size(1, 640, 480, {333333}));
  EXPECT_FALSE(parse_uvc_configuration(bytes.span()));
}

TEST(UvcDescriptors, SizesBeyondTheLimitHaveNoPicture) {
  EXPECT_EQ(picture_bytes(PixelFormat::kZ16, 640, 480), 614400u);
  EXPECT_EQ(picture_bytes(PixelFormat::kRgb8, 640, 480), 921600u);
  EXPECT_FALSE(picture_bytes(PixelFormat::kZ16, 65535, 65535));
  EXPECT_FALSE(picture_bytes(PixelFormat::kMjpeg, 640, 480));
}

}  // namespace
}  // namespace scanknit::test
