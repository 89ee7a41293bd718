#include <gtest/gtest.h>

#include "app/config/suggestion.h"

namespace scanknit {
namespace {

TEST(EditDistance, CountsInsertionsDeletionsReplacementsAndSwaps) {
  EXPECT_EQ(edit_distance("voxel", "voxel"), 0u);
  EXPECT_EQ(edit_distance("voxel", "voxels"), 1u);
  EXPECT_EQ(edit_distance("voxel", "vxel"), 1u);
  EXPECT_EQ(edit_distance("voxel", "vowel"), 1u);
  EXPECT_EQ(edit_distance("exprot", "export"), 1u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
}

TEST(NearestWord, FindsAMisspeltWord) {
  const std::vector<std::string> words = {"acquire", "fusion", "export"};
  EXPECT_EQ(nearest_word("exprot", words), "export");
  EXPECT_EQ(nearest_word("fusoin", words), "fusion");
}

TEST(NearestWord, StaysSilentWhenNothingIsNear) {
  const std::vector<std::string> words = {"acquire", "fusion", "export"};
  EXPECT_FALSE(nearest_word("banana", words));
  EXPECT_FALSE(nearest_word("", words));
  EXPECT_FALSE(nearest_word(std::string(100'000, 'a'), words));
}

}  // namespace
}  // namespace scanknit
