#include <gtest/gtest.h>

#include "tests/usb/realsense_bytes.h"

namespace scanknit::test {
namespace {

TEST(RealsenseTables, ACommandIsLengthMagicOpcodeAndParameters) {
  const auto bytes = encode_command(RealsenseOpcode::kReadTable, 25);
  Bytes expected{20, 0, 0xAB, 0xCD};
  EXPECT_EQ(bytes, expected.u32(0x15).u32(25).fill(12).vector());
}

TEST(RealsenseTables, AReplyEchoesItsOpcode) {
  const auto data = decode_reply(RealsenseOpcode::kIdentity, Bytes{0x10, 0, 0, 0, 42}.span());
  ASSERT_TRUE(data);
  EXPECT_EQ(data->size(), 1u);
  const auto refused = decode_reply(RealsenseOpcode::kIdentity, Bytes{0xFB, 0xFF, 0xFF, 0xFF}.span());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("code -5"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(decode_reply(RealsenseOpcode::kIdentity, Bytes{0x10, 0, 0}.span()));
}

TEST(RealsenseTables, TheIdentityHasFirmwareAndSerial) {
  const auto identity = parse_identity(identity_data().span());
  ASSERT_TRUE(identity);
  EXPECT_EQ(identity->firmware, "5.12.7.100");
  EXPECT_EQ(identity->serial, "0123456789ab");
  for (std::size_t size = 0; size < 54; ++size) EXPECT_FALSE(parse_identity(identity_data().span().first(size)));
}

TEST(RealsenseTables, DepthHasItsOwnValuesForEachResolution) {
  const auto vga = parse_depth_table(depth_table().span(), 640, 480);
  ASSERT_TRUE(vga) << vga.error().text();
  EXPECT_EQ(*vga, (CameraIntrinsics{640, 480, 380, 381, 319, 241}));
  const auto hd = parse_depth_table(depth_table().span(), 1280, 720);
  ASSERT_TRUE(hd);
  EXPECT_EQ(hd->fx, 640);
  EXPECT_FALSE(parse_depth_table(depth_table().span(), 848, 480)) << "zero focal length";
  EXPECT_FALSE(parse_depth_table(depth_table().span(), 641, 480)) << "no such resolution";
}

TEST(RealsenseTables, DepthHasTheBaseline) {
  const auto baseline_m = parse_baseline(depth_table().span());
  ASSERT_TRUE(baseline_m) << baseline_m.error().text();
  EXPECT_DOUBLE_EQ(*baseline_m, 0.05) << "whatever its sign";
  for (const float baseline_mm : {0.0f, 1.0f, 1000.0f}) {
    EXPECT_FALSE(parse_baseline(realsense_table(kDepthTable, Bytes{}.fill(144).f32(baseline_mm).fill(500)).span()))
        << baseline_mm;
  }
}

TEST(RealsenseTables, ColourIsScaledToThePicture) {
  const auto full = parse_colour_table(colour_table().span(), 1920, 1080);
  ASSERT_TRUE(full) << full.error().text();
  EXPECT_NEAR(full->camera.intrinsics.fx, 1400, 1e-3);
  EXPECT_NEAR(full->camera.intrinsics.fy, 1400, 1e-3);
  EXPECT_NEAR(full->camera.intrinsics.cx, 960, 1e-3);
  EXPECT_NEAR(full->camera.distortion[1], -0.02, 1e-6);
  // 4:3 is cut from 16:9: the same height, so 480/1080 of the focal length in both directions.
  const auto vga = parse_colour_table(colour_table().span(), 640, 480);
  ASSERT_TRUE(vga);
  EXPECT_NEAR(vga->camera.intrinsics.fx, 1400 * 480.0 / 1080, 1e-3);
  EXPECT_NEAR(vga->camera.intrinsics.fy, 1400 * 480.0 / 1080, 1e-3);
  EXPECT_NEAR(vga->camera.intrinsics.cx, 320, 1e-3);
}

TEST(RealsenseTables, ColourKnowsWhereItSits) {
  const auto colour = parse_colour_table(colour_table().span(), 640, 480);
  ASSERT_TRUE(colour);
  // The colour camera's own centre is 15 mm to the right of the depth camera's.
  const Eigen::Vector3d centre_depth = colour->T_colour_depth.inverse() * Eigen::Vector3d::Zero();
  EXPECT_NEAR(centre_depth.x(), 0.015, 1e-6);
}

TEST(RealsenseTables, CutAtAnyByteAreRefused) {
  const Bytes depth = depth_table(), colour = colour_table();
  for (std::size_t size = 0; size < depth.size(); ++size) {
    EXPECT_FALSE(parse_depth_table(depth.span().first(size), 640, 480)) << size;
    EXPECT_FALSE(parse_baseline(depth.span().first(size))) << size;
  }
  for (std::size_t size = 0; size < colour.size(); ++size) {
    EXPECT_FALSE(parse_colour_table(colour.span().first(size), 640, 480)) << size;
  }
}

TEST(RealsenseTables, AnyWrongByteIsFoundByTheChecksum) {
  for (std::size_t at = 16; at < depth_table().size(); at += 7) {
    Bytes table = depth_table();
    table[at] ^= std::byte{0x10};
    EXPECT_FALSE(parse_depth_table(table.span(), 640, 480)) << at;
  }
}

TEST(RealsenseTables, OneTableIsNotTakenForAnother) {
  EXPECT_FALSE(parse_depth_table(colour_table().span(), 640, 480));
  EXPECT_FALSE(parse_colour_table(depth_table().span(), 640, 480));
}

TEST(RealsenseTables, ShortBodiesWithARightChecksumAreRefused) {
  for (std::size_t size = 0; size < 216; ++size) {
    const Bytes colour = realsense_table(kColourTable, Bytes{}.fill(size, 0x3F));
    EXPECT_FALSE(parse_colour_table(colour.span(), 640, 480)) << size;
  }
  for (std::size_t size = 0; size < 288; ++size) {
    const Bytes depth = realsense_table(kDepthTable, Bytes{}.fill(size, 0x42));
    EXPECT_FALSE(parse_depth_table(depth.span(), 640, 480)) << size;
    EXPECT_EQ(parse_baseline(depth.span()).has_value(), size >= 148) << size;
  }
}

TEST(RealsenseDepthUnit, IsReadInMicrometres) {
  EXPECT_DOUBLE_EQ(parse_depth_unit(Bytes{}.u32(100).u32(0).u32(65535).span()).value(), 0.0001);
}

TEST(RealsenseDepthUnit, ThatIsNoneIsAnError) {
  for (const std::uint32_t unit_um : {0u, 10'001u, 0xFFFFFFFFu}) {
    EXPECT_FALSE(parse_depth_unit(Bytes{}.u32(unit_um).span())) << unit_um;
  }
  EXPECT_FALSE(parse_depth_unit(Bytes{1, 2, 3}.span())) << "cut short";
}

}  // namespace
}  // namespace scanknit::test
