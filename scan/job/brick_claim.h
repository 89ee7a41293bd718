// BrickClaim: says to all workers of a job, on all machines, that one of them is at work on a brick.
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "core/result.h"

namespace scanknit {

/// A file that one worker made and whose time it renews while it works. The claim of a worker that died ends when its
/// file is kLease old, by the clock of the file system, which all machines have in common. A worker that was only slow
/// then shares its brick with another one: both write the same bytes.
class BrickClaim {
 public:
  static constexpr std::chrono::seconds kLease{60};
  static constexpr std::chrono::seconds kRenewal{10};

  /// Makes the file `path`, or takes it over. Null: another worker has it. Errors: kOutput when the folder is
  /// not writable; kBudget when no thread is left.
  [[nodiscard]] static Result<std::unique_ptr<BrickClaim>> take(const std::filesystem::path& path);

  /// True if a worker has it. Errors: as above.
  [[nodiscard]] static Result<bool> is_taken(const std::filesystem::path& path);

  BrickClaim(const BrickClaim&) = delete;
  BrickClaim& operator=(const BrickClaim&) = delete;
  /// Removes the file, unless another worker took it over.
  ~BrickClaim();

 private:
  BrickClaim(std::filesystem::path path, int descriptor);
  void renew(const std::stop_token& stop);

  std::filesystem::path path_;
  int descriptor_;
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread renewer_;
};

}  // namespace scanknit
