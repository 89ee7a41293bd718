// Small volumes written byte by byte, so that the readers meet files that no library of theirs made.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "extract/volume/sample_type.h"
#include "extract/volume/slice_reader.h"
#include "tests/core/deflated.h"

namespace scanknit {

/// A folder of its own, whose name has a space, gone afterwards.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "a volume XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline const Eigen::Vector3i kDims{4, 3, 2};
inline constexpr std::size_t kSamples = 24;

/// Sample n of the test volume: small enough for int8, and never negative.
inline float expected_sample(std::size_t n) {
  return static_cast<float>((n * 37) % 101);
}

template <typename T>
void append(std::string& bytes, T value, ByteOrder order = ByteOrder::kLittle) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if ((order == ByteOrder::kLittle) != (std::endian::native == std::endian::little)) std::ranges::reverse(raw);
  bytes.append(raw.data(), raw.size());
}

inline constexpr std::array kAllTypes = {
    SampleType::kInt8,   SampleType::kUint8, SampleType::kInt16,  SampleType::kUint16, SampleType::kInt32,
    SampleType::kUint32, SampleType::kInt64, SampleType::kUint64, SampleType::kFloat,  SampleType::kDouble};
inline constexpr std::array kBothOrders = {ByteOrder::kLittle, ByteOrder::kBig};

inline void append_sample(std::string& bytes, float value, SampleType type, ByteOrder order) {
  switch (type) {
    case SampleType::kInt8: return append(bytes, static_cast<std::int8_t>(value), order);
    case SampleType::kUint8: return append(bytes, static_cast<std::uint8_t>(value), order);
    case SampleType::kInt16: return append(bytes, static_cast<std::int16_t>(value), order);
    case SampleType::kUint16: return append(bytes, static_cast<std::uint16_t>(value), order);
    case SampleType::kInt32: return append(bytes, static_cast<std::int32_t>(value), order);
    case SampleType::kUint32: return append(bytes, static_cast<std::uint32_t>(value), order);
    case SampleType::kInt64: return append(bytes, static_cast<std::int64_t>(value), order);
    case SampleType::kUint64: return append(bytes, static_cast<std::uint64_t>(value), order);
    case SampleType::kFloat: return append(bytes, value, order);
    case SampleType::kDouble: return append(bytes, static_cast<double>(value), order);
  }
}

/// The kSamples samples.
inline std::string sample_bytes(SampleType type = SampleType::kInt16, ByteOrder order = ByteOrder::kLittle) {
  std::string bytes;
  for (std::size_t n = 0; n < kSamples; ++n) append_sample(bytes, expected_sample(n), type, order);
  return bytes;
}

inline Result<DenseVolume> read_file_volume(const std::filesystem::path& path, const VolumeOptions& options = {}) {
  auto reader = open_volume(path, options);
  if (!reader) return reader.error();
  return read_volume(**reader);
}

inline void expect_test_volume(const Result<DenseVolume>& volume, double slope = 1, double intercept = 0) {
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  EXPECT_EQ(volume->header.dims, kDims);
  ASSERT_EQ(volume->samples.size(), kSamples);
  for (std::size_t n = 0; n < kSamples; ++n) {
    EXPECT_FLOAT_EQ(volume->samples[n], static_cast<float>(slope * static_cast<double>(expected_sample(n)) + intercept))
        << n;
  }
}

inline void expect_error(const Result<DenseVolume>& volume, ErrorCode code, const std::string& part) {
  ASSERT_FALSE(volume.has_value());
  EXPECT_EQ(volume.error().code, code);
  EXPECT_NE(volume.error().text().find(part), std::string::npos) << volume.error().text();
}

/// However short the file, the answer is an error (and no crash), or the right volume.
inline void expect_safe_at_every_length(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const auto volume = read_file_volume(folder.write(name, bytes.substr(0, length)));
    if (volume) {
      expect_test_volume(volume);
    } else {
      EXPECT_EQ(volume.error().code, ErrorCode::kInput) << volume.error().text();
    }
  }
}

/// However a byte is changed, nothing crashes.
inline void expect_safe_with_any_byte_changed(const std::string& name, const std::string& bytes, std::size_t header) {
  const TemporaryFolder folder;
  VolumeOptions options;
  options.memory_budget_bytes = std::size_t{16} << 20;
  for (std::size_t at = 0; at < header; ++at) {
    for (const char replacement : {'\0', '\xff', '9', '-', ' '}) {
      std::string changed = bytes;
      changed[at] = replacement;
      const auto reader = open_volume(folder.write(name, changed), options);
      if (!reader) continue;
      (void)read_volume(**reader, options.memory_budget_bytes).has_value();
    }
  }
}

/// However several places of the header are changed, cut out, repeated or stretched, nothing crashes.
inline void expect_safe_with_random_changes(const std::string& name, const std::string& header,
                                            const std::string& samples, bool is_text) {
  constexpr int kTries = 2000;
  const std::array<std::string, 13> kWords = {
      "-1", "99999999999999999999", "1e300", "nan", "(", "none", "=", ": ", "\n", "LIST", "\r",
      ":=", std::string(3000, '1')};
  const TemporaryFolder folder;
  VolumeOptions options;
  options.memory_budget_bytes = std::size_t{16} << 20;
  std::mt19937 random(7);
  const auto below = [&](std::size_t end) { return std::uniform_int_distribution<std::size_t>(0, end - 1)(random); };
  for (int n = 0; n < kTries; ++n) {
    std::string changed = header;
    for (std::size_t edits = 1 + below(3); edits > 0; --edits) {
      const std::size_t at = below(changed.size());
      switch (is_text ? below(4) : 0) {
        case 0: changed[at] = static_cast<char>(below(256)); break;
        case 1: changed.replace(at, 1, kWords[below(kWords.size())]); break;
        case 2: changed.insert(at, changed.substr(below(changed.size()), 1 + below(60))); break;
        case 3: changed.erase(at, below(std::min<std::size_t>(12, changed.size() - at))); break;
      }
    }
    const auto volume = read_file_volume(folder.write(name, changed + samples), options);
    if (volume) continue;
    const ErrorCode code = volume.error().code;
    EXPECT_TRUE(code == ErrorCode::kInput || code == ErrorCode::kBudget) << "try " << n << volume.error().text();
  }
}

}  // namespace scanknit
