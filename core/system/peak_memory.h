// The largest resident memory of the process: so far, and while something runs.
#pragma once

namespace scanknit {

/// The largest resident memory of the process so far, MiB; 0 if the system does not say.
[[nodiscard]] double peak_rss_mib();

/// Raises a number to the largest resident memory of the whole process, MiB, that is known of the life of this object.
/// That counts all threads, and what was there before. Where the process takes more than ever before, it is the peak;
/// else the larger of what it has at the begin and at the end: the kernel keeps one mark for the process, and taking it
/// back (/proc/self/clear_refs) would lower what `time -v` and other programs read. Watches may nest and overlap, in
/// any threads.
class PeakMemoryWatch {
 public:
  /// `peak_mib` outlives it.
  explicit PeakMemoryWatch(double& peak_mib);
  ~PeakMemoryWatch();
  PeakMemoryWatch(const PeakMemoryWatch&) = delete;
  PeakMemoryWatch& operator=(const PeakMemoryWatch&) = delete;

 private:
  double& peak_mib_;
  double most_before_mib_;
};

}  // namespace scanknit
