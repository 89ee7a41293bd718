#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>

#include "core/files/atomic_file.h"
#include "core/files/temporary_files.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

using test::read_text;
using test::TemporaryFolder;
using test::write_text;

TEST(AtomicFile, CommitMakesTheFileWithWhatWasWritten) {
  const TemporaryFolder folder;
  auto file = AtomicFile::create(folder / "a.txt");
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->write("one "));
  ASSERT_TRUE(file->write("two"));
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(read_text(folder / "a.txt"), "one two");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, WritesMoreThanItsBuffer) {
  const TemporaryFolder folder;
  const std::string text(5'000'000, 'x');
  ASSERT_TRUE(write_file_atomically(folder / "a.txt", text));
  EXPECT_EQ(std::filesystem::file_size(folder / "a.txt"), text.size());
}

TEST(AtomicFile, DestroyedWithoutCommitLeavesNothing) {
  const TemporaryFolder folder;
  {
    auto file = AtomicFile::create(folder / "a.txt");
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write("lost"));
  }
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(AtomicFile, DestroyedWithoutCommitKeepsTheOldFile) {
  const TemporaryFolder folder;
  write_text(folder / "a.txt", "old");
  {
    auto file = AtomicFile::create(folder / "a.txt");
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write("new"));
  }
  EXPECT_EQ(read_text(folder / "a.txt"), "old");
}

TEST(AtomicFile, OldFileStaysUntilCommit) {
  const TemporaryFolder folder;
  write_text(folder / "a.txt", "old");
  auto file = AtomicFile::create(folder / "a.txt");
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->write("new"));
  EXPECT_EQ(read_text(folder / "a.txt"), "old");
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(read_text(folder / "a.txt"), "new");
}

TEST(AtomicFile, MovedFromObjectLeavesTheFileToTheOther) {
  const TemporaryFolder folder;
  auto created = AtomicFile::create(folder / "a.txt");
  ASSERT_TRUE(created);
  {
    AtomicFile moved = std::move(*created);
    ASSERT_TRUE(moved.write("kept"));
    ASSERT_TRUE(moved.commit());
  }
  EXPECT_EQ(read_text(folder / "a.txt"), "kept");
}

TEST(AtomicFile, MoveAssignmentDiscardsTheTargetsOwnFile) {
  const TemporaryFolder folder;
  auto first = AtomicFile::create(folder / "first.txt");
  auto second = AtomicFile::create(folder / "second.txt");
  ASSERT_TRUE(first && second);
  *first = std::move(*second);
  ASSERT_TRUE(first->commit());
  EXPECT_TRUE(std::filesystem::exists(folder / "second.txt"));
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, MakesMissingFolders) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file_atomically(folder / "x/y/a.txt", "deep"));
  EXPECT_EQ(read_text(folder / "x/y/a.txt"), "deep");
}

TEST(AtomicFile, RefusesAFolderAsDestination) {
  const TemporaryFolder folder;
  const auto file = AtomicFile::create(folder.path());
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kOutput);
  EXPECT_NE(file.error().message.find("folder"), std::string::npos);
}

TEST(AtomicFile, RefusesAPathBelowAFile) {
  const TemporaryFolder folder;
  write_text(folder / "plain", "x");
  const auto file = AtomicFile::create(folder / "plain/a.txt");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kOutput);
  EXPECT_EQ(read_text(folder / "plain"), "x");
}

TEST(AtomicFile, ReplacesASymbolicLinkAndSparesItsTarget) {
  const TemporaryFolder folder;
  write_text(folder / "target", "precious");
  std::filesystem::create_symlink(folder / "target", folder / "link");
  ASSERT_TRUE(write_file_atomically(folder / "link", "new"));
  EXPECT_FALSE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_text(folder / "link"), "new");
  EXPECT_EQ(read_text(folder / "target"), "precious");
}

TEST(AtomicFile, CommitFailsWhenTheTemporaryFileIsGone) {
  const TemporaryFolder folder;
  auto file = AtomicFile::create(folder / "a.txt");
  ASSERT_TRUE(file);
  std::filesystem::remove(file->temporary_path());
  const auto committed = file->commit();
  ASSERT_FALSE(committed);
  EXPECT_EQ(committed.error().code, ErrorCode::kOutput);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
}

TEST(AtomicFile, PermissionsFollowTheUmask) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file_atomically(folder / "a.txt", "x"));
  const auto permissions = std::filesystem::status(folder / "a.txt").permissions();
  EXPECT_NE(permissions & std::filesystem::perms::owner_write, std::filesystem::perms::none);
  EXPECT_EQ(permissions & std::filesystem::perms::owner_exec, std::filesystem::perms::none);
}

/// A file as a killed process leaves it, last written so long ago.
std::filesystem::path left_behind(const TemporaryFolder& folder, const char* name, std::chrono::seconds age) {
  write_text(folder / name, "half");
  std::filesystem::last_write_time(folder / name, std::filesystem::file_time_type::clock::now() - age);
  return folder / name;
}

TEST(CheckWritable, RemovesWhatAKilledProcessLeftOfThisFile) {
  using std::chrono::minutes;
  const TemporaryFolder folder;
  const auto abandoned = left_behind(folder, ".a.txt.scanknit.Xy12Zz", minutes(2));
  const auto of_another_file = left_behind(folder, ".b.txt.scanknit.Xy12Zz", minutes(2));
  const auto no_temporary_file = left_behind(folder, ".a.txt.backup", minutes(2));
  const auto young = left_behind(folder, ".a.txt.scanknit.Xy12Zy", minutes(0));
  std::filesystem::create_directory(folder / ".a.txt.scanknit.folder");
  ASSERT_TRUE(check_writable(folder / "a.txt"));
  EXPECT_FALSE(std::filesystem::exists(abandoned));
  EXPECT_TRUE(std::filesystem::exists(of_another_file));
  EXPECT_TRUE(std::filesystem::exists(no_temporary_file));
  EXPECT_TRUE(std::filesystem::exists(young));
  EXPECT_TRUE(std::filesystem::exists(folder / ".a.txt.scanknit.folder"));
}

TEST(CheckWritable, LeavesAFileThatIsStillWritten) {
  const TemporaryFolder folder;
  auto file = AtomicFile::create(folder / "a.txt");
  ASSERT_TRUE(file);
  std::filesystem::last_write_time(file->temporary_path(),
                                   std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
  ASSERT_TRUE(check_writable(folder / "a.txt"));
  EXPECT_TRUE(file->commit());
}

TEST(TemporaryFiles, AllAreRemovedBeforeAnExitWithoutDestructors) {
  const TemporaryFolder folder;
  write_text(folder / "a.txt", "old");
  const auto write_and_exit = [&] {
    const auto first = AtomicFile::create(folder / "a.txt");
    auto second = AtomicFile::create(folder / "b.txt");
    if (!first || !second || !second->commit()) ::_exit(1);
    remove_temporary_files();
    ::_exit(0);
  };
  EXPECT_EXIT(write_and_exit(), ::testing::ExitedWithCode(0), "");
  EXPECT_EQ(read_text(folder / "a.txt"), "old");
  EXPECT_TRUE(std::filesystem::exists(folder / "b.txt"));
  EXPECT_EQ(folder.entries(), 2u);
}

TEST(CheckWritable, LeavesNoTrace) {
  const TemporaryFolder folder;
  EXPECT_TRUE(check_writable(folder / "a.txt"));
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(CheckWritable, LeavesNoFolderEither) {
  const TemporaryFolder folder;
  EXPECT_TRUE(check_writable(folder / "new/newer/a.txt"));
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(CheckWritable, RefusesAPathBelowAFile) {
  const TemporaryFolder folder;
  write_text(folder / "plain", "x");
  EXPECT_FALSE(check_writable(folder / "plain/a.txt"));
}

}  // namespace
}  // namespace scanknit
