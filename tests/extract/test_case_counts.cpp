// The frequency table: every cell is counted once, as what it is.
#include "extract/cell/case_counts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tests/extract/trilinear_truth.h"
#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Box;
using test::Dense;

struct NamedCell {
  const char* name;
  std::array<std::int64_t, kCorners> values;  ///< in cell.h's order of corners; no ties
};

/// One of each. In those with four Highs or fewer the letter counts joined Highs.
constexpr std::array kNamedCells{
    NamedCell{"0", {-1, -1, -1, -1, -1, -1, -1, -1}},      NamedCell{"1", {1, -1, -1, -1, -1, -1, -1, -1}},
    NamedCell{"2", {1, 1, -1, -1, -1, -1, -1, -1}},        NamedCell{"3A", {1, -1, -2, 1, -1, -1, -1, -1}},
    NamedCell{"3B", {1, -1, -1, 2, -1, -1, -1, -1}},       NamedCell{"4", {1, -1, -1, -1, -1, -1, -1, 1}},
    NamedCell{"4 tunnel", {4, -1, -1, -1, -1, -1, -1, 3}}, NamedCell{"5", {1, 1, 1, -1, -1, -1, -1, -1}},
    NamedCell{"6A", {1, 1, -2, -1, -1, -1, 1, -1}},        NamedCell{"6A tunnel", {1, 4, -2, -1, -2, -1, 3, -1}},
    NamedCell{"6B", {1, 1, -1, -1, -1, -1, 2, -1}},        NamedCell{"7A", {1, -2, -1, 1, -1, 1, -1, -1}},
    NamedCell{"7B", {1, -2, -2, 2, -2, 2, -1, -1}},        NamedCell{"7C", {2, -1, -1, 1, -1, 1, -1, -2}},
    NamedCell{"7D", {2, -1, -1, 2, -1, 1, -1, -1}},        NamedCell{"7D tunnel", {2, -3, -1, 2, -1, 2, -1, -1}},
    NamedCell{"8", {1, 1, 1, 1, -1, -1, -1, -1}},          NamedCell{"9", {1, 1, 1, -1, 1, -1, -1, -1}},
    NamedCell{"10A", {1, 1, -1, -1, -2, -2, 1, 1}},        NamedCell{"10A tunnel", {4, 1, -2, -2, -3, -3, 1, 4}},
    NamedCell{"10B", {1, 2, -1, -1, -2, -1, 1, 1}},        NamedCell{"10C", {1, 1, -1, -1, -1, -1, 2, 2}},
    NamedCell{"10C tunnel", {2, 2, -4, -1, -1, -3, 3, 2}}, NamedCell{"11", {1, -1, -1, -1, 1, 1, -1, 1}},
    NamedCell{"12A", {1, 1, 1, -2, -1, -1, -1, 1}},        NamedCell{"12A tunnel", {3, 1, 1, -3, -1, -1, -1, 2}},
    NamedCell{"12B", {1, 1, 2, -1, -1, -2, -1, 1}},        NamedCell{"12C", {1, 1, 1, -1, -1, -1, -1, 2}},
    NamedCell{"12C tunnel", {1, 1, 1, -2, -3, -1, -1, 3}}, NamedCell{"13A", {1, -1, -2, 1, -2, 1, 1, -2}},
    NamedCell{"13B", {1, -1, -3, 2, -2, 1, 1, -1}},        NamedCell{"13C", {3, -2, -1, 1, -2, 1, 1, -2}},
    NamedCell{"13D", {2, -1, -1, 1, -1, 1, 1, -2}},        NamedCell{"13D tunnel", {3, -4, -4, 1, -2, 3, 3, -3}},
    NamedCell{"13E", {2, -1, -3, 1, -1, 2, 2, -1}},        NamedCell{"13F", {3, -2, -1, 1, -1, 1, 2, -1}},
    NamedCell{"13G", {2, -1, -1, 2, -1, 1, 2, -1}},        NamedCell{"14", {-1, 1, -1, -1, 1, 1, 1, -1}},
};

/// `sign`: +1, or -1 for the cell of the other colours.
CaseCounts counts_of(const NamedCell& cell, float sign = 1) {
  Dense volume(2);
  for (int i = 0; i < kCorners; ++i)
    volume.at(i & 1, (i >> 1) & 1, i >> 2) =
        sign * static_cast<float>(cell.values[static_cast<std::size_t>(i)]) + 0.01f;
  ExtractConfig config;
  config.isovalue = 0.01f;
  return test::extract(volume, config).cases;
}

std::size_t cells_of(const CaseCounts& counts) {
  std::size_t cells = 0;
  for (const SubCase& sub_case : counts.sub_cases) cells += sub_case.cells;
  return cells;
}

std::size_t cells_named(const CaseCounts& counts, const std::string& name) {
  for (const SubCase& sub_case : counts.sub_cases) {
    if (sub_case.name == name) return sub_case.cells;
  }
  ADD_FAILURE() << name << " is not listed";
  return 0;
}

TEST(CaseCounts, NameEverySubCase) {
  for (const NamedCell& cell : kNamedCells) {
    const CaseCounts counts = counts_of(cell);
    EXPECT_EQ(cells_named(counts, cell.name), 1u) << cell.name;
    EXPECT_EQ(cells_of(counts), 1u) << cell.name;
    EXPECT_EQ(counts.of_configuration(std::atoi(cell.name)), 1u) << cell.name;
  }
}

TEST(CaseCounts, NameItAlikeWithColoursChanged) {
  for (const NamedCell& cell : kNamedCells) {
    const auto highs = std::count_if(cell.values.begin(), cell.values.end(), [](std::int64_t v) { return v >= 0; });
    if (highs == 4) continue;  // the rarer colour is then the Highs, whichever they are
    EXPECT_EQ(cells_named(counts_of(cell, -1), cell.name), 1u) << cell.name;
  }
}

TEST(CaseCounts, CountFacesAndTunnelsAsTheTruthDoes) {
  for (const NamedCell& cell : kNamedCells) {
    const test::CellTruth truth = test::trilinear_truth(cell.values);
    const auto faces = [&](char kind) {
      return static_cast<std::size_t>(std::count(truth.faces.begin(), truth.faces.end(), kind));
    };
    const CaseCounts counts = counts_of(cell);
    EXPECT_EQ(counts.ambiguous_faces_joined, faces('H')) << cell.name;
    EXPECT_EQ(counts.ambiguous_faces_separated, faces('L')) << cell.name;
    EXPECT_EQ(counts.tunnels, truth.euler != truth.components ? 1u : 0u) << cell.name;
  }
}

TEST(CaseCounts, ListEverySubCaseOnceByConfiguration) {
  const CaseCounts counts = test::extract(Dense(0)).cases;  // met or not
  std::set<std::string> names;
  int last = 0;
  for (const SubCase& sub_case : counts.sub_cases) {
    EXPECT_TRUE(names.insert(sub_case.name).second) << sub_case.name;
    EXPECT_EQ(std::atoi(sub_case.name.c_str()), sub_case.configuration);
    EXPECT_GE(sub_case.configuration, last);
    EXPECT_EQ(sub_case.cells, 0u);
    last = sub_case.configuration;
  }
  for (const NamedCell& cell : kNamedCells) {  // those with a tunnel are listed where they were met
    const bool has_tunnel = std::string(cell.name).find("tunnel") != std::string::npos;
    EXPECT_EQ(names.count(cell.name), has_tunnel ? 0u : 1u) << cell.name;
  }
}

/// Cells with eight observed corners.
std::size_t whole_cells(Box box) {
  std::size_t whole = 0;
  for (int i = 0; i + 1 < box.dims.x(); ++i) {
    for (int j = 0; j + 1 < box.dims.y(); ++j) {
      for (int k = 0; k + 1 < box.dims.z(); ++k) {
        bool is_whole = true;
        for (int c = 0; c < kCorners; ++c)
          is_whole = is_whole && std::isfinite(box.at(i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2)));
        whole += is_whole ? 1 : 0;
      }
    }
  }
  return whole;
}

Box noise(const Eigen::Vector3i& dims, unsigned seed, unsigned levels, unsigned holes_one_in) {
  std::mt19937 random(seed);
  Box box(dims);
  for (float& sample : box.samples) {
    sample = static_cast<float>(random() % (2 * levels + 1)) - static_cast<float>(levels);
    if (holes_one_in > 0 && random() % holes_one_in == 0) sample = test::kNaN;
  }
  return box;
}

TEST(CaseCounts, AddUpToTheWholeCells) {
  for (const unsigned holes_one_in : {0u, 200u, 20u, 4u}) {
    for (const unsigned levels : {1u, 1000u}) {
      const Box box = noise({19, 10, 25}, holes_one_in + levels, levels, holes_one_in);
      for (const Decider decider : {Decider::kTrilinear, Decider::kAsymptotic, Decider::kKnit, Decider::kFixedHigh,
                                    Decider::kFixedLow, Decider::kLorensen}) {
        ExtractConfig config;
        config.decider = decider;
        EXPECT_EQ(cells_of(test::extract(box, config).cases), whole_cells(box));
      }
    }
  }
}

TEST(CaseCounts, AddUpWhereThereIsNoSurface) {
  for (const float value : {-1.0f, 1.0f}) {
    const Box box({20, 9, 12}, value);
    const CaseCounts counts = test::extract(box).cases;
    EXPECT_EQ(cells_named(counts, "0"), whole_cells(box));
    EXPECT_EQ(cells_of(counts), whole_cells(box));
  }
}

TEST(CaseCounts, OfAVolumeAreThoseOfItsCells) {
  const Dense volume = test::white_noise(12, 2);
  std::map<std::string, std::size_t> expected;
  for (int x = 0; x + 1 < volume.n; ++x) {
    for (int y = 0; y + 1 < volume.n; ++y) {
      for (int z = 0; z + 1 < volume.n; ++z) {
        Dense cell(2);
        for (int c = 0; c < kCorners; ++c)
          cell.at(c & 1, (c >> 1) & 1, c >> 2) = volume.at(x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2));
        for (const SubCase& sub_case : test::extract(cell).cases.sub_cases) expected[sub_case.name] += sub_case.cells;
      }
    }
  }
  for (const SubCase& sub_case : test::extract(volume).cases.sub_cases)
    EXPECT_EQ(sub_case.cells, expected[sub_case.name]) << sub_case.name;
}

TEST(CaseCounts, TellHandednessByTheGridsIndices) {
  // A chain of four Highs is configuration 11, its mirror image 14; where the samples lie in memory does not matter.
  const auto chain = std::find_if(kNamedCells.begin(), kNamedCells.end(),
                                  [](const NamedCell& cell) { return std::string(cell.name) == "11"; });
  Box box({2, 2, 2});
  std::transform(chain->values.begin(), chain->values.end(), box.samples.begin(),
                 [](std::int64_t v) { return static_cast<float>(v); });
  EXPECT_EQ(cells_named(test::extract(box).cases, "11"), 1u);
}

}  // namespace
}  // namespace scanknit
