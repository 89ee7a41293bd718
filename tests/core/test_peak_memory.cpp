// Stages know the largest memory while they ran.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include "core/system/peak_memory.h"

namespace scanknit {
namespace {

constexpr double kLargeMib = 64;
constexpr double kRestMib = 8;  // what the test and the kernel's counters may take or forget meanwhile

/// What the process has now.
double peak_of_nothing() {
  double peak_mib = 0;
  { const PeakMemoryWatch watch(peak_mib); }
  return peak_mib;
}

/// Takes so much memory from the system that the process has more than ever before, and gives it back.
void take_for_a_moment() {
  const double mib = peak_rss_mib() - peak_of_nothing() + kLargeMib;
  const auto bytes = static_cast<std::size_t>(mib) << 20;
  void* const memory =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  ASSERT_EQ(::munmap(memory, bytes), 0);
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

TEST(PeakMemoryWatch, LeavesTheProcesssOwnMark) {
  take_for_a_moment();
  const double peak_mib = peak_rss_mib();
  EXPECT_LE(peak_of_nothing(), peak_mib - kLargeMib + kRestMib);
  rusage usage{};
  ASSERT_EQ(::getrusage(RUSAGE_SELF, &usage), 0);
  EXPECT_GE(static_cast<double>(usage.ru_maxrss) / 1024, peak_mib - 1) << "what `time -v` says";
}

TEST(PeakMemoryWatch, NeverLowersTheNumber) {
  double peak_mib = 1e6;
  { const PeakMemoryWatch watch(peak_mib); }
  EXPECT_EQ(peak_mib, 1e6);
}

}  // namespace
}  // namespace scanknit
