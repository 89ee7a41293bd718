#include "tests/app/volume_files.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

namespace scanknit {
namespace {

namespace fs = std::filesystem;

template <typename T>
void append(std::string& bytes, T value) {
  const auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  bytes.append(raw.data(), raw.size());
}

template <typename T>
void put(std::string& bytes, std::size_t offset, T value) {
  const auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  bytes.replace(offset, raw.size(), raw.data(), raw.size());
}

void write_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

std::string text_of(const std::array<double, 3>& numbers, const char* separator) {
  const auto text = [](double number) {
    std::string digits = std::to_string(number);
    while (digits.ends_with('0')) digits.pop_back();
    if (digits.ends_with('.')) digits.pop_back();
    return digits;
  };
  return text(numbers[0]) + separator + text(numbers[1]) + separator + text(numbers[2]);
}

/// One element in explicit VR, little endian; `value` is padded to an even length.
std::string element(std::uint16_t group, std::uint16_t number, const std::string& vr, std::string value) {
  if (value.size() % 2 != 0) value += vr == "UI" ? '\0' : ' ';
  std::string bytes;
  append(bytes, group);
  append(bytes, number);
  bytes += vr;
  if (vr == "OW" || vr == "OB") {
    append(bytes, std::uint16_t{0});
    append(bytes, static_cast<std::uint32_t>(value.size()));
  } else {
    append(bytes, static_cast<std::uint16_t>(value.size()));
  }
  return bytes + value;
}

std::string word(int value) {
  std::string bytes;
  append(bytes, static_cast<std::uint16_t>(value));
  return bytes;
}

}  // namespace

std::uint16_t Ball::sample(int i, int j, int k) const {
  const auto offset = [&](std::size_t axis, int index) { return (index - (dims[axis] - 1) / 2.0) * spacing_mm[axis]; };
  const double r = std::hypot(offset(0, i), offset(1, j), offset(2, k));
  return static_cast<std::uint16_t>(std::lround(std::max(0.0, 1000 - 80 * r)));
}

std::string Ball::slice(int k, bool is_big_endian) const {
  std::string bytes;
  for (int j = 0; j < dims[1]; ++j) {
    for (int i = 0; i < dims[0]; ++i) {
      append(bytes, sample(i, j, k));
      if (is_big_endian) std::swap(bytes[bytes.size() - 1], bytes[bytes.size() - 2]);
    }
  }
  return bytes;
}

std::string Ball::bytes(bool is_big_endian) const {
  std::string all;
  for (int k = 0; k < dims[2]; ++k) all += slice(k, is_big_endian);
  return all;
}

std::string Ball::dims_option() const {
  return std::to_string(dims[0]) + "x" + std::to_string(dims[1]) + "x" + std::to_string(dims[2]);
}

std::string Ball::spacing_option() const {
  return text_of(spacing_mm, "x");
}

void write_raw(const Ball& ball, const fs::path& path, bool is_big_endian) {
  write_bytes(path, ball.bytes(is_big_endian));
}

void write_nrrd(const Ball& ball, const fs::path& path) {
  const auto [x, y, z] = ball.spacing_mm;
  write_bytes(path, "NRRD0004\ntype: uint16\ndimension: 3\nspace: left-posterior-superior\nsizes: " +
                        std::to_string(ball.dims[0]) + " " + std::to_string(ball.dims[1]) + " " +
                        std::to_string(ball.dims[2]) + "\nspace directions: (" + text_of({x, 0, 0}, ",") + ") (" +
                        text_of({0, y, 0}, ",") + ") (" + text_of({0, 0, z}, ",") + ")\nspace origin: (" +
                        text_of(kBallOriginMm, ",") + ")\nendian: little\nencoding: raw\n\n" + ball.bytes());
}

void write_meta_image(const Ball& ball, const fs::path& path) {
  write_bytes(path,
              "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
              "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = " +
                  text_of(kBallOriginMm, " ") + "\nElementSpacing = " + text_of(ball.spacing_mm, " ") +
                  "\nDimSize = " + std::to_string(ball.dims[0]) + " " + std::to_string(ball.dims[1]) + " " +
                  std::to_string(ball.dims[2]) + "\nElementType = MET_USHORT\nElementDataFile = LOCAL\n" +
                  ball.bytes());
}

void write_nifti(const Ball& ball, const fs::path& path) {
  constexpr std::size_t kHeaderBytes = 352;  // and the four bytes of "no extension"
  std::string header(kHeaderBytes, '\0');
  put(header, 0, std::int32_t{348});
  put(header, 40, std::int16_t{3});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(header, 42 + 2 * axis, static_cast<std::int16_t>(ball.dims[axis]));
    put(header, 80 + 4 * axis, static_cast<float>(ball.spacing_mm[axis]));
    const std::size_t row = 280 + 16 * axis;  // srow_x, srow_y, srow_z
    put(header, row + 4 * axis, static_cast<float>(ball.spacing_mm[axis]));
    put(header, row + 12, static_cast<float>(kBallOriginMm[axis]));
  }
  for (std::size_t unused = 3; unused < 7; ++unused) put(header, 42 + 2 * unused, std::int16_t{1});
  put(header, 70, std::int16_t{512});  // uint16
  put(header, 72, std::int16_t{16});
  put(header, 76, 1.0f);
  put(header, 108, static_cast<float>(kHeaderBytes));
  put(header, 112, 1.0f);
  header[123] = 2;                    // millimetres
  put(header, 254, std::int16_t{1});  // sform_code
  header.replace(344, 4, std::string("n+1\0", 4));
  write_bytes(path, header + ball.bytes());
}

void write_dicom_series(const Ball& ball, const fs::path& folder) {
  fs::create_directories(folder);
  const std::string explicit_little_endian = "1.2.840.10008.1.2.1", ct_image = "1.2.840.10008.5.1.4.1.1.2";
  const auto [x, y, z] = kBallOriginMm;
  for (int k = 0; k < ball.dims[2]; ++k) {
    const std::string uid = "1.2.826.0.1.3680043.2.1125.1." + std::to_string(k + 1);
    const std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", ct_image) +
                             element(2, 3, "UI", uid) + element(2, 0x10, "UI", explicit_little_endian) +
                             element(2, 0x12, "UI", "1.2.826.0.1.3680043.2.1125");
    std::string length;
    append(length, static_cast<std::uint32_t>(meta.size()));
    write_bytes(
        folder / ("slice" + std::to_string(100 - k) + ".dcm"),  // the names run against the positions
        std::string(128, '\0') + "DICM" + element(2, 0, "UL", length) + meta + element(8, 0x16, "UI", ct_image) +
            element(8, 0x18, "UI", uid) + element(8, 0x60, "CS", "CT") +
            element(0x20, 0xD, "UI", "1.2.826.0.1.3680043.2.1125.2") +
            element(0x20, 0xE, "UI", "1.2.826.0.1.3680043.2.1125.3") +
            element(0x20, 0x13, "IS", std::to_string(k + 1)) +
            element(0x20, 0x32, "DS", text_of({x, y, z + k * ball.spacing_mm[2]}, "\\")) +
            element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") + element(0x28, 2, "US", word(1)) +
            element(0x28, 4, "CS", "MONOCHROME2") + element(0x28, 0x10, "US", word(ball.dims[1])) +
            element(0x28, 0x11, "US", word(ball.dims[0])) +
            element(0x28, 0x30, "DS", std::to_string(ball.spacing_mm[1]) + "\\" + std::to_string(ball.spacing_mm[0])) +
            element(0x28, 0x100, "US", word(16)) + element(0x28, 0x101, "US", word(16)) +
            element(0x28, 0x102, "US", word(15)) + element(0x28, 0x103, "US", word(0)) +
            element(0x7FE0, 0x10, "OW", ball.slice(k)));
  }
}

void write_tiff_stack(const Ball& ball, const fs::path& folder) {
  fs::create_directories(folder);
  for (int k = 0; k < ball.dims[2]; ++k) {
    const std::string pixels = ball.slice(k);
    std::string file = "II*" + std::string(1, '\0');
    append(file, static_cast<std::uint32_t>(8 + pixels.size()));  // the directory follows the pixels
    file += pixels;
    const std::vector<std::array<std::uint32_t, 2>> entries = {{256, static_cast<std::uint32_t>(ball.dims[0])},
                                                               {257, static_cast<std::uint32_t>(ball.dims[1])},
                                                               {258, 16},
                                                               {259, 1},
                                                               {262, 1},
                                                               {273, 8},
                                                               {277, 1},
                                                               {278, static_cast<std::uint32_t>(ball.dims[1])},
                                                               {279, static_cast<std::uint32_t>(pixels.size())}};
    append(file, static_cast<std::uint16_t>(entries.size()));
    for (const auto& [tag, value] : entries) {
      append(file, static_cast<std::uint16_t>(tag));
      append(file, std::uint16_t{4});  // LONG
      append(file, std::uint32_t{1});
      append(file, value);
    }
    append(file, std::uint32_t{0});
    write_bytes(folder / ("slice" + std::to_string(k) + ".tif"), file);
  }
}

}  // namespace scanknit
