#include "core/system/machine_memory.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/core/temporary_folder.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

/// What a kernel with 16 GiB of memory says.
class MachineMemory : public testing::Test {
 protected:
  MachineMemory() {
    write("proc/meminfo", "MemTotal:       16777216 kB\nMemFree:         1000000 kB\n");
    write("proc/self/limits",
          "Limit                     Soft Limit           Hard Limit           Units\n"
          "Max address space         unlimited            unlimited            bytes\n");
  }

  void write(const fs::path& name, const std::string& text) {
    const fs::path path = folder_.path() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  [[nodiscard]] std::optional<std::size_t> mib() const {
    return machine_memory_mib({folder_.path() / "proc", folder_.path() / "groups"});
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(MachineMemory, IsThatOfTheMachine) {
  EXPECT_EQ(mib(), 16384u);
  write("proc/meminfo", "MemFree: 12 kB\n");
  EXPECT_EQ(mib(), std::nullopt) << "and none of a kernel that does not say it";
}

TEST_F(MachineMemory, IsTheLeastLimitOfTheGroupsRoundTheProcess) {
  write("proc/self/cgroup", "0::/user/scan\n");
  write("groups/user/scan/memory.max", "max\n");
  EXPECT_EQ(mib(), 16384u);
  write("groups/user/memory.max", "2147483648\n");
  EXPECT_EQ(mib(), 2048u);
  write("groups/user/scan/memory.max", "536870912\n");
  EXPECT_EQ(mib(), 512u);
  write("groups/other/memory.max", "1048576\n");
  EXPECT_EQ(mib(), 512u) << "another's";
}

TEST_F(MachineMemory, OfAContainerThatSeesItsOwnGroupAsTheRoot) {
  write("groups/memory.max", "1073741824\n");
  for (const char* path : {"/", "/../../scan", "/docker/0123"}) {
    write("proc/self/cgroup", std::string("0::") + path + "\n");
    EXPECT_EQ(mib(), 1024u) << path;
  }
}

TEST_F(MachineMemory, OfGroupsOfVersionOne) {
  write("proc/self/cgroup", "5:cpu,memory:/a/b\n1:cpu:/\n0::/\n");
  write("groups/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(mib(), 16384u);
  write("groups/memory/a/memory.limit_in_bytes", "3221225472\n");
  EXPECT_EQ(mib(), 3072u);
  write("groups/memory/a/b/memory.limit_in_bytes", "1610612736\n");
  EXPECT_EQ(mib(), 1536u);
}

TEST_F(MachineMemory, IsAtMostWhatTheProcessMayAddress) {
  write("proc/self/limits", "Max address space         786432000            unlimited            bytes\n");
  EXPECT_EQ(mib(), 750u);
}

TEST_F(MachineMemory, WhateverTheFilesHold) {
  for (const char* text : {"", ":", "::", "a:memory", "0::", "0::relative", "1:memory:\n0::\n"}) {
    write("proc/self/cgroup", text);
    EXPECT_EQ(mib(), 16384u) << text;
  }
  write("proc/self/cgroup", "0::/a\n");
  for (const char* text : {"", "-1\n", "x\n", "99999999999999999999999\n"}) {
    write("groups/a/memory.max", text);
    EXPECT_EQ(mib(), 16384u) << text;
  }
}

TEST(MachineMemoryHere, IsKnown) {
  EXPECT_GT(machine_memory_mib().value_or(0), 0u);
}

TEST(DefaultMemoryBudget, IsHalfBetweenItsBounds) {
  EXPECT_EQ(default_memory_budget_mib(1024), 512u);
  EXPECT_EQ(default_memory_budget_mib(100), 128u);
  EXPECT_EQ(default_memory_budget_mib(8192), 4096u);
  EXPECT_EQ(default_memory_budget_mib(1 << 20), 4096u) << "the same mesh on every machine with 8 GiB and more";
  EXPECT_EQ(default_memory_budget_mib(std::nullopt), 4096u);
}

}  // namespace
}  // namespace scanknit::test
