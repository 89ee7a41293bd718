// Volumes larger than memory give the same mesh.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "extract/extract_surface.h"
#include "extract/stream_surface.h"
#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

/// An array read slice by slice; counts what is read.
class ArraySlices final : public SliceReader {
 public:
  ArraySlices(std::vector<float> samples, const Eigen::Vector3i& dims) : samples_(std::move(samples)) {
    header_.dims = dims;
  }
  [[nodiscard]] const VolumeHeader& header() const override { return header_; }
  [[nodiscard]] bool is_streamed() const override { return true; }
  [[nodiscard]] Result<void> read_slice(int k, std::span<float> samples) override {
    ++slices_read;
    if (k == broken_slice) return Error{ErrorCode::kInput, "broken", "slice"};
    const auto first = samples_.begin() + static_cast<std::ptrdiff_t>(samples.size()) * k;
    std::copy(first, first + static_cast<std::ptrdiff_t>(samples.size()), samples.begin());
    return {};
  }
  [[nodiscard]] DenseView view() const { return {samples_.data(), header_.dims, Eigen::Affine3d::Identity()}; }

  int slices_read = 0;
  int broken_slice = -1;

 private:
  VolumeHeader header_;
  std::vector<float> samples_;
};

/// Waves, some noise on them, and NaN holes.
ArraySlices waves(const Eigen::Vector3i& dims) {
  std::mt19937 random(3);
  std::vector<float> samples;
  samples.reserve(static_cast<std::size_t>(dims.prod()));
  for (int k = 0; k < dims.z(); ++k) {
    for (int j = 0; j < dims.y(); ++j) {
      for (int i = 0; i < dims.x(); ++i) {
        const auto bits = static_cast<unsigned>(random());
        const double wave = std::sin(0.31 * i) + std::sin(0.27 * j) + std::sin(0.29 * k);
        const double noise = static_cast<double>(bits) / 4294967296.0;
        samples.push_back(bits % 997 == 0 ? test::kNaN : static_cast<float>(wave + noise));
      }
    }
  }
  return ArraySlices(std::move(samples), dims);
}

ExtractConfig config_with(std::int64_t memory_budget_mib, Decider decider = Decider::kTrilinear) {
  ExtractConfig config;
  config.memory_budget_mib = memory_budget_mib;
  config.decider = decider;
  config.isovalue = 0.25;
  return config;
}

struct Streamed {
  Mesh mesh;  ///< all parts, one after the other
  StreamedSurface surface;
  std::size_t largest_part_bytes = 0;
  std::size_t parts = 0;
};

Streamed stream(ArraySlices& reader, const ExtractConfig& config) {
  Streamed streamed;
  const auto sink = [&](const Mesh& part) -> Result<void> {
    auto& mesh = streamed.mesh;
    mesh.positions_m.insert(mesh.positions_m.end(), part.positions_m.begin(), part.positions_m.end());
    mesh.normals.insert(mesh.normals.end(), part.normals.begin(), part.normals.end());
    mesh.triangles.insert(mesh.triangles.end(), part.triangles.begin(), part.triangles.end());
    const std::size_t bytes = part.triangles.size() * sizeof(Triangle) + part.positions_m.size() * 24;
    streamed.largest_part_bytes = std::max(streamed.largest_part_bytes, bytes);
    ++streamed.parts;
    return {};
  };
  streamed.surface = stream_surface(reader, Eigen::Affine3d::Identity(), config, sink).value();
  return streamed;
}

bool same_bits(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Eigen::Vector3f)) == 0;
}

TEST(Stream, GivesTheSameMeshWithATenthOfTheMemory) {
  const Eigen::Vector3i dims(70, 61, 650);  // 10.6 MiB
  for (const Decider decider : {Decider::kTrilinear, Decider::kKnit}) {
    ArraySlices reader = waves(dims);
    const ExtractConfig config = config_with(1, decider);
    const Streamed streamed = stream(reader, config);
    const Surface whole = extract_surface(reader.view(), config).value();
    EXPECT_EQ(streamed.mesh.triangles, whole.mesh.triangles);
    EXPECT_TRUE(same_bits(streamed.mesh.positions_m, whole.mesh.positions_m));
    EXPECT_TRUE(same_bits(streamed.mesh.normals, whole.mesh.normals));
    EXPECT_EQ(streamed.surface.vertices, whole.mesh.positions_m.size());
    EXPECT_EQ(streamed.surface.triangles, whole.mesh.triangles.size());
    EXPECT_EQ(reader.slices_read, dims.z());
    EXPECT_GT(streamed.parts, 10u);
    EXPECT_LE(streamed.largest_part_bytes, (1u << 20) / 4);
    for (std::size_t i = 0; i < whole.cases.sub_cases.size(); ++i)
      EXPECT_EQ(streamed.surface.cases.sub_cases[i].cells, whole.cases.sub_cases[i].cells);
  }
}

TEST(Stream, WorksForAnyNumberOfSlices) {
  for (const int slices : {1, 2, 7, 8, 9, 16, 17, 25, 26, 27, 40}) {
    ArraySlices reader = waves({150, 60, slices});  // 29 slices in the budget, so one layer a step
    const ExtractConfig config = config_with(1);
    const Streamed streamed = stream(reader, config);
    const Surface whole = extract_surface(reader.view(), config).value();
    EXPECT_EQ(streamed.mesh.triangles, whole.mesh.triangles) << slices;
    EXPECT_TRUE(same_bits(streamed.mesh.positions_m, whole.mesh.positions_m)) << slices;
  }
}

TEST(Stream, RefusesSlicesThatDoNotFit) {
  ArraySlices reader = waves({200, 200, 30});
  const auto refused = stream_surface(reader, Eigen::Affine3d::Identity(), config_with(1),
                                      [](const Mesh&) -> Result<void> { return {}; });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBudget);
}

TEST(Stream, HandsOnTheErrorsOfTheReaderAndTheSink) {
  ArraySlices reader = waves({20, 20, 60});
  reader.broken_slice = 41;
  const auto broken = stream_surface(reader, Eigen::Affine3d::Identity(), config_with(1),
                                     [](const Mesh&) -> Result<void> { return {}; });
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().code, ErrorCode::kInput);
  reader.broken_slice = -1;
  const auto full =
      stream_surface(reader, Eigen::Affine3d::Identity(), config_with(1), [](const Mesh&) -> Result<void> {
        return Error{ErrorCode::kOutput, "full", "disk"};
      });
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kOutput);
}

TEST(Stream, TetrahedraAreRefused) {
  ArraySlices reader = waves({20, 20, 20});
  const auto refused = stream_surface(reader, Eigen::Affine3d::Identity(), config_with(1, Decider::kTetra6),
                                      [](const Mesh&) -> Result<void> { return {}; });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConfig);
}

}  // namespace
}  // namespace scanknit
