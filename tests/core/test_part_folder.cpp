#include "core/files/part_folder.h"

#include <gtest/gtest.h>

#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

using test::read_text;
using test::TemporaryFolder;
using test::write_text;

TEST(PartFolder, IsGoneWithAllInItUnlessItIsKept) {
  const TemporaryFolder folder;
  {
    const auto made = PartFolder::create(folder / "out");
    ASSERT_TRUE(made);
    write_text(made->path() / "deep" / "file", "x");
  }
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(PartFolder, ReplaceTakesThePlaceOfAFolderAndRemovesIt) {
  const TemporaryFolder folder;
  write_text(folder / "out" / "old", "x");
  {
    auto made = PartFolder::create(folder / "out");
    ASSERT_TRUE(made);
    write_text(made->path() / "new", "y");
    ASSERT_TRUE(made->replace(folder / "out"));
  }
  EXPECT_EQ(read_text(folder / "out" / "new"), "y");
  EXPECT_FALSE(std::filesystem::exists(folder / "out" / "old"));
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(PartFolder, ReplaceMakesWhatIsNotThere) {
  const TemporaryFolder folder;
  auto made = PartFolder::create(folder / "out");
  ASSERT_TRUE(made);
  ASSERT_TRUE(made->replace(folder / "out"));
  EXPECT_TRUE(std::filesystem::is_directory(folder / "out"));
}

TEST(PartFolder, ReplaceLeavesAFileAsItWas) {
  const TemporaryFolder folder;
  write_text(folder / "out", "x");
  {
    auto made = PartFolder::create(folder / "out");
    ASSERT_TRUE(made);
    const auto replaced = made->replace(folder / "out");
    ASSERT_FALSE(replaced);
    EXPECT_EQ(replaced.error().code, ErrorCode::kOutput);
  }
  EXPECT_EQ(read_text(folder / "out"), "x");
  EXPECT_EQ(folder.entries(), 1u);
}

}  // namespace
}  // namespace scanknit
