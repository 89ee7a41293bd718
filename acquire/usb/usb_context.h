// USB devices, and the thread on which their transfers end.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"

struct libusb_context;
struct libusb_device_handle;

namespace scanknit {

/// The properties of a device that are known without opening it, which needs no permission.
struct UsbDeviceInfo {
  int bus = 0;
  int address = 0;
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  int speed_mbit = 0;                    ///< 12, 480, 5000 ...; 0: unknown
  std::string port;                      ///< Linux's name, "2-1.4"
  std::string product_name;              ///< empty: unknown
  std::string serial;                    ///< empty: none
  std::vector<std::byte> configuration;  ///< the active configuration descriptor and all that belong to it

  /// "8086:0b07 at bus 2 address 4".
  [[nodiscard]] std::string place() const;
  /// /dev/bus/usb/002/004.
  [[nodiscard]] std::string node() const;
};

class UsbHandle;

/// Runs the thread `usb` during its lifetime. Any thread may call the methods.
class UsbContext : public std::enable_shared_from_this<UsbContext> {
 public:
  /// Error (kDevice): USB cannot be used; the message says why.
  [[nodiscard]] static Result<std::shared_ptr<UsbContext>> create();
  ~UsbContext();
  UsbContext(const UsbContext&) = delete;
  UsbContext& operator=(const UsbContext&) = delete;

  [[nodiscard]] std::vector<UsbDeviceInfo> devices() const;

  /// Errors (kDevice): no permission, unplugged ...; the message says what to do.
  [[nodiscard]] Result<std::unique_ptr<UsbHandle>> open(const UsbDeviceInfo& device);

  /// A number that changes whenever a device is plugged in or out.
  [[nodiscard]] std::uint64_t generation() const;
  /// Waits until generation() is not `seen` any more, until `timeout`, or until a stop.
  void wait_for_change(std::uint64_t seen, std::chrono::milliseconds timeout, std::stop_token stop) const;

  void device_came_or_went();  ///< for libusb's callback

 private:
  explicit UsbContext(libusb_context* context);

  libusb_context* context_;
  int hotplug_ = -1;  // no handle: changes are found by polling
  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  std::uint64_t generation_ = 0;
  std::jthread events_;
};

/// An opened device. Every request ends within kControlTimeout. Call it from one thread, other than `usb`, except
/// hurry().
class UsbHandle {
 public:
  static constexpr std::chrono::milliseconds kControlTimeout{1000};
  static constexpr std::chrono::milliseconds kHurriedTimeout{300};

  UsbHandle(std::shared_ptr<UsbContext> context, libusb_device_handle* handle, UsbDeviceInfo info);
  ~UsbHandle();  ///< releases all claimed interfaces; transfers must have ended
  UsbHandle(const UsbHandle&) = delete;
  UsbHandle& operator=(const UsbHandle&) = delete;

  [[nodiscard]] const UsbDeviceInfo& info() const { return info_; }
  [[nodiscard]] libusb_device_handle* raw() const { return handle_; }

  /// Detaches the kernel's driver, which is attached again on release. Errors (kDevice): in use by another program
  /// (named if it can be found), unplugged ...
  [[nodiscard]] Result<void> claim(std::uint8_t interface);
  /// The system sends these two requests and would wait for five seconds. Therefore they are not sent to a device that
  /// has not answered its last request.
  [[nodiscard]] Result<void> set_alternate(std::uint8_t interface, std::uint8_t alternate);
  [[nodiscard]] Result<void> clear_halt(std::uint8_t endpoint);

  /// Class requests to an interface: `value` and `index` as USB has them. Errors (kDevice): refused, no answer,
  /// unplugged.
  [[nodiscard]] Result<void> write_class(std::uint8_t request, std::uint16_t value, std::uint16_t index,
                                         std::span<const std::byte> data);
  /// Returns the received bytes, at most `bytes`.
  [[nodiscard]] Result<std::vector<std::byte>> read_class(std::uint8_t request, std::uint16_t value,
                                                          std::uint16_t index, std::uint16_t bytes);

  /// True: all requests, also the current one, now end within kHurriedTimeout, because a caller waits for a stop. After
  /// a request that was not answered, no other is sent until the next call of hurry(). Any thread may call it.
  void hurry(bool is_hurried);

 private:
  struct Patience;
  struct Request;
  /// Like libusb_control_transfer(): returns the number of transferred bytes, or an error of libusb.
  [[nodiscard]] int control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                            std::span<std::byte> data);
  [[nodiscard]] int send(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                         std::span<std::byte> data);

  std::shared_ptr<UsbContext> context_;
  libusb_device_handle* handle_;
  UsbDeviceInfo info_;
  std::vector<std::uint8_t> claimed_;
  std::shared_ptr<Patience> patience_;
  bool is_mute_ = false;  // the last request was not answered
};

/// Describes an error code of libusb, with the remedy: "cannot open 8086:0b07 at bus 2 address 4: ...".
[[nodiscard]] Error usb_error(int libusb_code, const std::string& action, const UsbDeviceInfo& device);

/// Error (kDevice): another program has the device, or one of its video nodes, open; the message names it if this
/// process may see it.
[[nodiscard]] Result<void> refuse_if_used(const UsbDeviceInfo& device);

/// True for usb_error()'s error of an unplugged device.
[[nodiscard]] bool is_unplugged(const Error& error);

}  // namespace scanknit
