#include <gtest/gtest.h>

#include "core/files/read_file.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;
using test::write_text;

TEST(ReadFile, GivesEveryByte) {
  const TemporaryFolder folder;
  write_text(folder / "a", std::string("a\0b\n", 4));
  const auto text = read_text_file(folder / "a", 100);
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, std::string("a\0b\n", 4));
  const auto bytes = read_file(folder / "a", 100);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(bytes->size(), 4u);
}

TEST(ReadFile, TakesAnEmptyFile) {
  const TemporaryFolder folder;
  write_text(folder / "a", "");
  const auto bytes = read_file(folder / "a", 0);
  ASSERT_TRUE(bytes);
  EXPECT_TRUE(bytes->empty());
}

TEST(ReadFile, TakesTheLimitAndNotOneByteMore) {
  const TemporaryFolder folder;
  write_text(folder / "a", "12345");
  EXPECT_TRUE(read_file(folder / "a", 5));
  EXPECT_FALSE(read_file(folder / "a", 4));
}

TEST(ReadFile, NamesTheFileThatIsNotThere) {
  const TemporaryFolder folder;
  const auto read = read_file(folder / "absent", 100);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kInput);
  EXPECT_EQ(read.error().text(), (folder / "absent").string() + ": no such file");
}

TEST(ReadFile, RefusesFoldersAndDevices) {
  const TemporaryFolder folder;
  EXPECT_FALSE(read_file(folder.path(), 100));
  EXPECT_FALSE(read_file("/dev/zero", 100));
}

}  // namespace
}  // namespace scanknit
