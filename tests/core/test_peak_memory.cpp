// Stages know the largest memory while they ran.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "core/system/peak_memory.h"

namespace scanknit {
namespace {

constexpr double kLargeMib = 64;
constexpr double kRestMib = 8;  // what the test and the kernel's counters may take or forget meanwhile

/// Takes so much memory from the system and gives it back.
void take_for_a_moment() {
  constexpr std::size_t kBytes = static_cast<std::size_t>(kLargeMib) << 20;
  void* const memory =
      ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  ASSERT_EQ(::munmap(memory, kBytes), 0);
}

/// The peak of something that takes next to nothing.
double peak_of_nothing() {
  double peak_mib = 0;
  { const PeakMemoryWatch watch(peak_mib); }
  return peak_mib;
}

TEST(PeakMemoryWatch, SeesWhatWasGivenBackMeanwhile) {
  const double before_mib = peak_of_nothing();
  double peak_mib = 0;
  {
    const PeakMemoryWatch watch(peak_mib);
    take_for_a_moment();
  }
  EXPECT_GE(peak_mib, before_mib + kLargeMib - kRestMib);
  EXPECT_GE(peak_rss_mib(), peak_mib);
}

TEST(PeakMemoryWatch, DoesNotSeeWhatWasGivenBackBefore) {
  if (::access("/proc/self/clear_refs", W_OK) != 0) GTEST_SKIP() << "the kernel's mark cannot be taken back here";
  const double before_mib = peak_of_nothing();
  take_for_a_moment();
  EXPECT_LE(peak_of_nothing(), before_mib + kRestMib);
  EXPECT_GE(peak_rss_mib(), before_mib + kLargeMib - kRestMib) << "the whole process has seen it";
}

TEST(PeakMemoryWatch, SeesWhatAWatchWithinItSaw) {
  const double before_mib = peak_of_nothing();
  double outer_mib = 0, inner_mib = 0;
  {
    const PeakMemoryWatch outer(outer_mib);
    {
      const PeakMemoryWatch inner(inner_mib);
      take_for_a_moment();
    }
    EXPECT_LE(peak_of_nothing(), inner_mib);
  }
  EXPECT_GE(inner_mib, before_mib + kLargeMib - kRestMib);
  EXPECT_GE(outer_mib, inner_mib);
}

TEST(PeakMemoryWatch, NeverLowersTheNumber) {
  double peak_mib = 1e6;
  { const PeakMemoryWatch watch(peak_mib); }
  EXPECT_EQ(peak_mib, 1e6);
}

}  // namespace
}  // namespace scanknit
