// BoundedRequests: limits the wait for a Kinect that does not answer. libfreenect sends requests without a time limit,
// and has no way to set one.
#pragma once

#include <chrono>
#include <optional>
#include <stop_token>

namespace scanknit {

/// During its lifetime, limits the libusb control requests that this thread makes without a time limit
/// (libusb_control_transfer with a timeout of 0): to `each` for one request, and to `all` for all of them together.
/// After that, or after a stop, they fail at once. They return LIBUSB_ERROR_TIMEOUT. Does not affect other threads, or
/// requests with their own limit. One object at a time in each thread.
class BoundedRequests {
 public:
  BoundedRequests(std::chrono::milliseconds all, std::chrono::milliseconds each, std::stop_token stop = {});
  ~BoundedRequests();
  BoundedRequests(const BoundedRequests&) = delete;
  BoundedRequests& operator=(const BoundedRequests&) = delete;

  /// The limit of the next request of this thread: nothing if there is none; 0 if the request must not be sent.
  [[nodiscard]] static std::optional<std::chrono::milliseconds> limit();
  /// To be called when a request was not answered: no other request is sent.
  static void give_up();

 private:
  const std::chrono::steady_clock::time_point deadline_;
  const std::chrono::milliseconds each_;
  const std::stop_token stop_;
  bool is_given_up_ = false;
};

}  // namespace scanknit
