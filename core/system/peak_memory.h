// The largest resident memory of the process: so far, and while something runs.
#pragma once

namespace scanknit {

/// The largest resident memory of the process so far, MiB; 0 if the system does not say.
[[nodiscard]] double peak_rss_mib();

/// Raises a number to the largest resident memory of the whole process, MiB, during the life of this object. That
/// counts all threads, and what was there before. Watches may nest and overlap, in any threads. Where the kernel does
/// not let its mark be taken back (/proc/self/clear_refs), the number becomes the largest memory so far.
class PeakMemoryWatch {
 public:
  /// `peak_mib` outlives it, and is written by it and by other watches' begins and ends.
  explicit PeakMemoryWatch(double& peak_mib);
  ~PeakMemoryWatch();
  PeakMemoryWatch(const PeakMemoryWatch&) = delete;
  PeakMemoryWatch& operator=(const PeakMemoryWatch&) = delete;

 private:
  double& peak_mib_;
};

}  // namespace scanknit
