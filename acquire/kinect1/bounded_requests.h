// BoundedRequests: an end to waiting for a Kinect that does not answer. libfreenect asks without a time limit, and
// gives no way to set one.
#pragma once

#include <chrono>
#include <optional>
#include <stop_token>

namespace scanknit {

/// While it lives, control requests of libusb that this thread makes without a time limit (libusb_control_transfer with
/// a timeout of 0) have one: `each` for one, and none is begun after they have taken `all` together, nor
/// after a stop. They end as LIBUSB_ERROR_TIMEOUT. Other threads, and requests with a limit of their own, are left
/// alone. One at a time in each thread.
class BoundedRequests {
 public:
  BoundedRequests(std::chrono::milliseconds all, std::chrono::milliseconds each, std::stop_token stop = {});
  ~BoundedRequests();
  BoundedRequests(const BoundedRequests&) = delete;
  BoundedRequests& operator=(const BoundedRequests&) = delete;

  /// For the request that is about to be made by this thread: nothing, where it is as free as ever; 0, where it must
  /// not be begun.
  [[nodiscard]] static std::optional<std::chrono::milliseconds> limit();
  /// One was not answered: no other is begun.
  static void give_up();

 private:
  const std::chrono::steady_clock::time_point deadline_;
  const std::chrono::milliseconds each_;
  const std::stop_token stop_;
  bool is_given_up_ = false;
};

}  // namespace scanknit
