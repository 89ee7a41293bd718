#include "core/system/peak_memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>

namespace scanknit {
namespace {

constexpr double kKibibytesPerMebibyte = 1024;

/// A file of the kernel's about this process.
class ProcessFile {
 public:
  explicit ProcessFile(const char* path) : file_(std::fopen(path, "re")) {
    if (file_) std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  }
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

/// What the kernel knows of the process's resident memory. The files stay open: stages begin and end many times a
/// frame.
class ResidentMemory {
 public:
  static ResidentMemory& get() {
    static ResidentMemory memory;
    return memory;
  }

  struct Mib {
    double now, most_so_far;
  };
  [[nodiscard]] Mib look() {
    const std::lock_guard lock(mutex_);
    rusage usage{};
    const bool is_known = ::getrusage(RUSAGE_SELF, &usage) == 0;
    const double at_most_mib = is_known ? static_cast<double>(usage.ru_maxrss) / kKibibytesPerMebibyte : 0;
    if (most_so_far_mib_ < at_most_mib) most_so_far_mib_ = std::max(most_so_far_mib_, exact_mib(at_most_mib));
    return {now_mib(), most_so_far_mib_};
  }

 private:
  /// getrusage() takes a twentieth of the time, but counts the memory of the program that started this one, too.
  [[nodiscard]] double exact_mib(double at_most_mib) const {
    std::array<char, 4096> text;
    if (!status_.read(text)) return at_most_mib;
    constexpr const char* kName = "VmHWM:";
    const char* const line = std::strstr(text.data(), kName);
    return line == nullptr ? at_most_mib : std::strtod(line + std::strlen(kName), nullptr) / kKibibytesPerMebibyte;
  }

  [[nodiscard]] double now_mib() const {
    std::array<char, 128> text;
    if (!pages_.read(text)) return 0;
    const char* const resident = std::strchr(text.data(), ' ');  // the first number is the size of the addresses
    if (resident == nullptr) return 0;
    static const auto kPageBytes = static_cast<double>(::sysconf(_SC_PAGESIZE));
    return std::strtod(resident, nullptr) * kPageBytes / (kKibibytesPerMebibyte * kKibibytesPerMebibyte);
  }

  std::mutex mutex_;
  ProcessFile status_{"/proc/self/status"}, pages_{"/proc/self/statm"};
  double most_so_far_mib_ = 0;
};

}  // namespace

double peak_rss_mib() {
  return ResidentMemory::get().look().most_so_far;
}

PeakMemoryWatch::PeakMemoryWatch(double& peak_mib) : peak_mib_(peak_mib) {
  const auto [now, most_so_far] = ResidentMemory::get().look();
  peak_mib_ = std::max(peak_mib_, now);
  most_before_mib_ = most_so_far;
}

PeakMemoryWatch::~PeakMemoryWatch() {
  const auto [now, most_so_far] = ResidentMemory::get().look();
  peak_mib_ = std::max(peak_mib_, most_so_far > most_before_mib_ ? most_so_far : now);
}

}  // namespace scanknit
