// OpenNI's .oni files by bytes that tests write; files of its own recorder are read in tests/openni2.
#include <gtest/gtest.h>

#include <fstream>

#include "acquire/layouts/oni_depth.h"
#include "acquire/layouts/oni_file.h"
#include "acquire/mcap/byte_appender.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

std::vector<std::uint16_t> unpacked(std::initializer_list<int> packed, std::size_t pixels, bool has_table = false) {
  const auto values = unpack_oni_depth(bytes_of(packed), has_table, pixels);
  return values ? *values : std::vector<std::uint16_t>{};
}

using Values = std::vector<std::uint16_t>;

TEST(OniDepth, BeginsWithAWholeValue) {
  EXPECT_EQ(unpacked({0xE8, 0x03}, 1), Values{1000});
}

TEST(OniDepth, HoldsTwoSmallStepsInAByte) {
  // Steps lead downwards and are stored plus 6: 0xC0 is -6 and then +6.
  EXPECT_EQ(unpacked({0xE8, 0x03, 0xC0}, 3), (Values{1000, 994, 1000}));
  EXPECT_EQ(unpacked({0xE8, 0x03, 0x5D}, 2), (Values{1000, 1001})) << "0xD: no second step";
}

TEST(OniDepth, HoldsRuns) {
  EXPECT_EQ(unpacked({0xE8, 0x03, 0xE2}, 5), Values(5, 1000));
}

TEST(OniDepth, HoldsLongStepsAndWholeValues) {
  EXPECT_EQ(unpacked({0xE8, 0x03, 0xFF, 192 + 50}, 2), (Values{1000, 950}));
  EXPECT_EQ(unpacked({0xE8, 0x03, 0xFF, 192 - 50}, 2), (Values{1000, 1050}));
  EXPECT_EQ(unpacked({0xE8, 0x03, 0xFF, 0x07, 0xD0}, 2), (Values{1000, 2000}));
  EXPECT_EQ(unpacked({0xE8, 0x03, 0x6F, 0x07, 0xD0}, 3), (Values{1000, 1000, 2000}));
}

TEST(OniDepth, LooksValuesUpInItsTable) {
  // A table of 0 and 1500; the second of it, the first, the first twice.
  EXPECT_EQ(unpacked({2, 0, 0, 0, 0xDC, 0x05, 1, 0, 0x7D, 0xE1}, 4, true), (Values{1500, 0, 0, 0}));
  EXPECT_EQ(unpacked({2, 0, 0, 0, 0xDC, 0x05, 2, 0}, 1, true), Values{}) << "outside the table";
}

TEST(OniDepth, CutAnywhereIsRefused) {
  const Bytes whole = bytes_of({0xE8, 0x03, 0xC0, 0xFF, 0x07, 0xD0, 0x6F, 192 + 50, 0xE2});
  constexpr std::size_t kPixels = 10;
  ASSERT_TRUE(unpack_oni_depth(whole, false, kPixels));
  EXPECT_FALSE(unpack_oni_depth(whole, false, kPixels - 1));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(unpack_oni_depth(std::span(whole).first(size), false, kPixels)) << size;
  }
}

/// An .oni file as OpenNI2 records it: two nodes, and three pictures each of 4 x 2 pixels.
class OniBytes {
 public:
  explicit OniBytes(bool is_long = true) : is_long_(is_long) {
    ByteAppender writer(bytes_);
    for (const char c : {'N', 'I', '1', '0'}) writer.little_endian(static_cast<std::uint8_t>(c));
    writer.little_endian(std::uint16_t{1});                // major 1, minor 0
    writer.little_endian(std::uint16_t(is_long ? 1 : 0));  // maintenance
    writer.little_endian(std::uint32_t{0});                // build
    writer.little_endian(~std::uint64_t{0});               // latest time: unknown
    writer.little_endian(std::uint32_t{2});                // highest node
  }

  void record(std::uint32_t type, std::uint32_t node, const Bytes& fields, const Bytes& payload = {}) {
    ByteAppender writer(bytes_);
    writer.little_endian(std::uint32_t{0x0052494E});
    writer.little_endian(type);
    writer.little_endian(node);
    writer.little_endian(static_cast<std::uint32_t>((is_long_ ? 28 : 24) + fields.size()));
    writer.little_endian(static_cast<std::uint32_t>(payload.size()));
    if (is_long_) {
      writer.little_endian(std::uint64_t{0});
    } else {
      writer.little_endian(std::uint32_t{0});
    }
    writer.append(fields);
    writer.append(payload);
  }

  void node(std::uint32_t id, std::uint32_t type, std::string_view coding) {
    Bytes fields = named("node");
    ByteAppender writer(fields);
    writer.little_endian(type);
    for (const char c : coding) writer.little_endian(static_cast<std::uint8_t>(c));
    record(0x02, id, fields);
  }
  void number(std::uint32_t id, std::string_view name, std::uint64_t value) {
    Bytes fields = named(name);
    ByteAppender writer(fields);
    writer.little_endian(std::uint32_t{8});
    writer.little_endian(value);
    record(0x03, id, fields);
  }
  void size(std::uint32_t id, std::uint32_t width, std::uint32_t height) {
    Bytes fields = named("xnMapOutputMode");
    ByteAppender writer(fields);
    for (const std::uint32_t value : {12u, width, height, 30u}) writer.little_endian(value);
    record(0x06, id, fields);
  }
  void view(std::uint32_t id, double x_rad, double y_rad) {
    Bytes fields = named("xnFOV");
    ByteAppender writer(fields);
    writer.little_endian(std::uint32_t{16});
    writer.little_endian(x_rad);
    writer.little_endian(y_rad);
    record(0x06, id, fields);
  }
  void picture(std::uint32_t id, std::uint32_t number, const Bytes& payload) {
    Bytes fields;
    ByteAppender writer(fields);
    writer.little_endian(std::uint64_t{33333} * number);
    writer.little_endian(number);
    record(0x0A, id, fields, payload);
  }
  void end() { record(0x0B, 0, {}); }

  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  static Bytes named(std::string_view name) {
    Bytes fields;
    ByteAppender writer(fields);
    writer.little_endian(static_cast<std::uint32_t>(name.size() + 1));
    for (const char c : name) writer.little_endian(static_cast<std::uint8_t>(c));
    writer.little_endian(std::uint8_t{0});
    return fields;
  }

  bool is_long_;
  Bytes bytes_;
};

constexpr std::uint32_t kPictures = 3;

OniBytes small_recording(bool is_long = true, bool is_mirrored = false) {
  OniBytes oni(is_long);
  oni.node(1, 2, "16zP");
  oni.size(1, 4, 2);
  oni.number(1, "oniPixelFormat", 100);
  oni.view(1, 1, 0.5);
  if (is_mirrored) oni.number(1, "xnMirror", 1);
  oni.node(2, 3, "NONE");
  oni.size(2, 4, 2);
  oni.number(2, "oniPixelFormat", 200);
  if (is_mirrored) oni.number(2, "xnMirror", 1);
  Bytes rgb;
  for (int i = 0; i < 4 * 2 * 3; ++i) rgb.push_back(static_cast<std::byte>(i));
  for (std::uint32_t n = 1; n <= kPictures; ++n) {
    oni.picture(1, n, bytes_of({0xE8, 0x03, 0xFF, 0x07, 0xD0, 0xE3}));  // 1000, then seven times 2000 mm
    oni.picture(2, n, rgb);
  }
  oni.end();
  return oni;
}

Result<OniFile> opened(const Bytes& bytes) {
  return OniFile::open(std::make_unique<MemoryAccess>(bytes), {});
}

std::vector<int> values_of(const RawFrame& frame) {
  std::vector<int> values;
  const Bytes& b = *frame.bytes;
  const auto at = [&](std::size_t i) { return std::to_integer<int>(b[i]); };
  for (std::size_t i = 0; i + 1 < b.size(); i += 2) values.push_back(at(i) | at(i + 1) << 8);
  return values;
}

TEST(OniFile, HoldsPicturesOfBothKinds) {
  for (const bool is_long : {true, false}) {
    const OniBytes oni = small_recording(is_long);
    const auto file = opened(oni.bytes());
    ASSERT_TRUE(file) << file.error().text();
    EXPECT_FALSE(file->fault());
    EXPECT_EQ(file->depth().profile, (StreamProfile{StreamKind::kDepth, PixelFormat::kZ16, 4, 2, 30}));
    EXPECT_EQ(file->depth().view_x_rad, 1);
    ASSERT_EQ(file->depth().pictures.size(), kPictures);
    const auto depth = file->read(StreamKind::kDepth, 1);
    ASSERT_TRUE(depth) << depth.error().text();
    EXPECT_EQ(values_of(*depth), (std::vector<int>{1000, 2000, 2000, 2000, 2000, 2000, 2000, 2000}));
    EXPECT_EQ(depth->sequence, 2u);
    EXPECT_EQ(depth->device_ns, 66'666'000);
    ASSERT_TRUE(file->colour());
    EXPECT_EQ(file->read(StreamKind::kColour, 2).value().bytes->size(), 24u);
  }
}

TEST(OniFile, TurnsMirroredPicturesBack) {
  const OniBytes oni = small_recording(true, true);
  const auto file = opened(oni.bytes());
  ASSERT_TRUE(file);
  const auto depth = file->read(StreamKind::kDepth, 0);
  ASSERT_TRUE(depth);
  EXPECT_EQ(values_of(*depth), (std::vector<int>{2000, 2000, 2000, 1000, 2000, 2000, 2000, 2000}));
  const auto colour = file->read(StreamKind::kColour, 0);
  ASSERT_TRUE(colour);
  EXPECT_EQ(std::vector(colour->bytes->begin(), colour->bytes->begin() + 6), bytes_of({9, 10, 11, 6, 7, 8}));
}

TEST(OniFile, KnowsTenthsOfMillimetres) {
  OniBytes oni;
  oni.node(1, 2, "NONE");
  oni.size(1, 1, 1);
  oni.number(1, "oniPixelFormat", 101);
  oni.picture(1, 1, bytes_of({1, 0}));
  oni.end();
  const auto file = opened(oni.bytes());
  ASSERT_TRUE(file) << file.error().text();
  EXPECT_EQ(file->depth().depth_unit_m, 0.0001);
}

TEST(OniFile, CutAnywhereGivesWhatCameBefore) {
  const OniBytes oni = small_recording();
  std::size_t most = 0;
  for (std::size_t size = 0; size < oni.bytes().size(); ++size) {
    const auto file = OniFile::open(std::make_unique<MemoryAccess>(std::span(oni.bytes()).first(size)), {});
    if (!file) continue;
    EXPECT_TRUE(file->fault()) << size;
    EXPECT_GE(file->depth().pictures.size(), most);
    most = file->depth().pictures.size();
    for (std::size_t i = 0; i < most; ++i) EXPECT_TRUE(file->read(StreamKind::kDepth, i)) << size;
  }
  EXPECT_EQ(most, kPictures);
}

TEST(OniFile, AnyByteMayBeWrong) {
  const OniBytes oni = small_recording();
  for (std::size_t i = 0; i < oni.bytes().size(); ++i) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      Bytes bytes = oni.bytes();
      bytes[i] ^= static_cast<std::byte>(change);
      const auto file = opened(bytes);
      if (!file) continue;
      for (std::size_t k = 0; k < file->depth().pictures.size(); ++k) {
        const auto frame = file->read(StreamKind::kDepth, k);
        if (!frame || file->depth().coding == OniCoding::kPlain) continue;
        const StreamProfile& profile = frame->profile;
        EXPECT_EQ(frame->bytes->size(), std::size_t{2} * static_cast<std::size_t>(profile.width * profile.height));
      }
      for (std::size_t k = 0; file->colour() && k < file->colour()->pictures.size(); ++k) {
        (void)file->read(StreamKind::kColour, k);
      }
    }
  }
}

TEST(OniFile, RefusesWhatItCannotRead) {
  const auto error_of = [](const OniBytes& oni) {
    const auto file = opened(oni.bytes());
    return file ? std::string() : file.error().message;
  };
  OniBytes empty;
  empty.end();
  EXPECT_NE(error_of(empty).find("without one depth picture"), std::string::npos);
  OniBytes shifts;
  shifts.node(1, 2, "NONE");
  shifts.size(1, 1, 1);
  shifts.number(1, "oniPixelFormat", 102);
  shifts.picture(1, 1, bytes_of({1, 0}));
  EXPECT_NE(error_of(shifts).find("kind that is not read"), std::string::npos);
  OniBytes huge;
  huge.node(1, 2, "16zP");
  huge.size(1, 65535, 65535);
  huge.picture(1, 1, bytes_of({1, 0}));
  EXPECT_NE(error_of(huge).find("damaged"), std::string::npos);
}

TEST(OniRecording, IsRecognisedByItsFirstBytes) {
  const TemporaryFolder folder;
  const OniBytes oni = small_recording();
  const auto path = folder.path() / "scan.bin";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(oni.bytes().data()), static_cast<std::streamsize>(oni.bytes().size()));
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  const auto source = open_recording(path, config);
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "oni");
  EXPECT_EQ((*source)->info().frames, kPictures);
  EXPECT_TRUE((*source)->info().has_colour);
  const FrameEvent event = (*source)->next({});
  ASSERT_TRUE(std::holds_alternative<Frame>(event));
  EXPECT_EQ(std::get<Frame>(event).depth_m.at(0, 0), 1.0f);
}

}  // namespace
}  // namespace scanknit::test
