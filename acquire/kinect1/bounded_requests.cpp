#include "acquire/kinect1/bounded_requests.h"

#include <dlfcn.h>
#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <utility>

#include "core/check.h"

namespace scanknit {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

thread_local BoundedRequests* current = nullptr;

}  // namespace

BoundedRequests::BoundedRequests(milliseconds all, milliseconds each, std::stop_token stop)
    : deadline_(Clock::now() + all), each_(each), stop_(std::move(stop)) {
  SCANKNIT_CHECK(current == nullptr);
  current = this;
}

BoundedRequests::~BoundedRequests() {
  current = nullptr;
}

std::optional<milliseconds> BoundedRequests::limit() {
  if (current == nullptr) return std::nullopt;
  const auto left = std::chrono::duration_cast<milliseconds>(current->deadline_ - Clock::now());
  const bool is_over = left <= milliseconds(0) || current->is_given_up_ || current->stop_.stop_requested();
  return is_over ? milliseconds(0) : std::min(left, current->each_);
}

void BoundedRequests::give_up() {
  if (current != nullptr) current->is_given_up_ = true;
}

}  // namespace scanknit

/// Found before libusb's own by libfreenect, too, which is linked after this library; it hands every request on.
extern "C" int LIBUSB_CALL libusb_control_transfer(libusb_device_handle* device, std::uint8_t type,
                                                   std::uint8_t request, std::uint16_t value, std::uint16_t index,
                                                   unsigned char* data, std::uint16_t length, unsigned int timeout) {
  static const auto next =
      reinterpret_cast<decltype(&libusb_control_transfer)>(::dlsym(RTLD_NEXT, "libusb_control_transfer"));
  if (next == nullptr) return LIBUSB_ERROR_NOT_SUPPORTED;
  const auto limit = timeout == 0 ? scanknit::BoundedRequests::limit() : std::nullopt;
  if (limit && limit->count() == 0) return LIBUSB_ERROR_TIMEOUT;
  const int code = next(device, type, request, value, index, data, length,
                        limit ? static_cast<unsigned int>(limit->count()) : timeout);
  if (limit && code == LIBUSB_ERROR_TIMEOUT) scanknit::BoundedRequests::give_up();
  return code;
}
