#include "core/system/peak_memory.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <vector>

namespace scanknit {
namespace {

constexpr double kKibibytesPerMebibyte = 1024;

/// A file of the kernel's about this process.
class ProcessFile {
 public:
  ProcessFile(const char* path, const char* mode) : file_(std::fopen(path, mode)) {
    if (file_) std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  }
  [[nodiscard]] bool write(char character) const { return file_ && std::fputc(character, file_.get()) == character; }
  /// The text from its begin; as much of it as fits.
  template <std::size_t N>
  [[nodiscard]] bool read(std::array<char, N>& text) const {
    if (!file_) return false;
    std::rewind(file_.get());
    text[std::fread(text.data(), 1, N - 1, file_.get())] = '\0';
    return true;
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

/// The kernel keeps one mark for the process, the largest memory since it was taken back last. Whoever reads it does so
/// for all watches. The files stay open: stages begin and end many times a frame.
class KernelMark {
 public:
  static KernelMark& get() {
    static KernelMark mark;
    return mark;
  }

  void begin(double& peak_mib) {
    const std::lock_guard lock(mutex_);
    pass_on();
    watched_.push_back(&peak_mib);
  }
  void end(double& peak_mib) {
    const std::lock_guard lock(mutex_);
    pass_on();
    watched_.erase(std::find(watched_.begin(), watched_.end(), &peak_mib));
  }
  [[nodiscard]] double so_far_mib() {
    const std::lock_guard lock(mutex_);
    pass_on();
    return so_far_mib_;
  }

 private:
  KernelMark() { watched_.push_back(&so_far_mib_); }

  /// Raises all that is watched, and takes the mark back.
  void pass_on() {
    rusage usage{};
    const bool is_known = ::getrusage(RUSAGE_SELF, &usage) == 0;
    const double at_most_mib = is_known ? static_cast<double>(usage.ru_maxrss) / kKibibytesPerMebibyte : 0;
    const auto is_below = [&](const double* peak_mib) { return *peak_mib < at_most_mib; };
    if (std::any_of(watched_.begin(), watched_.end(), is_below)) {
      const double mib = exact_mib(at_most_mib);
      for (double* const peak_mib : watched_) *peak_mib = std::max(*peak_mib, mib);
    }
    (void)take_back_.write('5');
  }

  /// getrusage() takes a twentieth of the time, but counts the memory of the program that started this one, too.
  [[nodiscard]] double exact_mib(double at_most_mib) const {
    std::array<char, 4096> text;
    if (!status_.read(text)) return at_most_mib;
    constexpr const char* kName = "VmHWM:";
    const char* const line = std::strstr(text.data(), kName);
    return line == nullptr ? at_most_mib : std::strtod(line + std::strlen(kName), nullptr) / kKibibytesPerMebibyte;
  }

  std::mutex mutex_;
  ProcessFile status_{"/proc/self/status", "re"};
  ProcessFile take_back_{"/proc/self/clear_refs", "we"};
  std::vector<double*> watched_;
  double so_far_mib_ = 0;
};

}  // namespace

double peak_rss_mib() {
  return KernelMark::get().so_far_mib();
}

PeakMemoryWatch::PeakMemoryWatch(double& peak_mib) : peak_mib_(peak_mib) {
  KernelMark::get().begin(peak_mib_);
}

PeakMemoryWatch::~PeakMemoryWatch() {
  KernelMark::get().end(peak_mib_);
}

}  // namespace scanknit
