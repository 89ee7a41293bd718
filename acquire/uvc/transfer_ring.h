// TransferRing: transfers of one endpoint that are always pending, so that the camera never waits.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "acquire/uvc/uvc_assembler.h"
#include "core/result.h"

struct libusb_transfer;

namespace scanknit {

class UsbHandle;

struct RingPlan {
  std::uint8_t endpoint = 0;
  bool is_isochronous = false;
  std::size_t transfer_bytes = 0;  ///< a multiple of the endpoint's packet size, else the camera's last packet may not
                                   ///< fit
  std::size_t payload_bytes = 0;   ///< bulk: the longest payload, which ends without a short packet
  std::size_t packet_bytes = 0;    ///< isochronous: of one packet
  int packets = 0;                 ///< isochronous: of one transfer
  int transfers = 0;
};

/// Plans transfers for at least 100 ms of a stream, within `budget_bytes` (at least two transfers). `packet_bytes`: of
/// the endpoint.
[[nodiscard]] RingPlan plan_bulk(std::uint8_t endpoint, std::size_t packet_bytes, std::size_t payload_bytes,
                                 std::size_t frame_bytes, double frames_per_second, std::size_t budget_bytes);
[[nodiscard]] RingPlan plan_isochronous(std::uint8_t endpoint, std::size_t packet_bytes);

/// Receives the data of transfers, on the thread `usb`.
class PayloadReceiver {
 public:
  virtual void on_bytes(std::span<const std::byte> bytes, bool ends_payload, std::int64_t host_ns) = 0;
  virtual void on_loss(UvcAssembler::Loss kind) = 0;
  /// Called when the ring is no longer kRunning.
  virtual void on_trouble() = 0;

 protected:
  ~PayloadReceiver() = default;
};

/// Call it from one thread, other than `usb`.
class TransferRing {
 public:
  enum class State {
    kStopped,
    kRunning,
    kHalted,  ///< the endpoint stalled, or failed many times in a row: stop(), clear its halt, start() again
    kGone,    ///< unplugged
  };

  TransferRing(UsbHandle& device, const RingPlan& plan, PayloadReceiver& receiver);
  ~TransferRing();
  TransferRing(const TransferRing&) = delete;
  TransferRing& operator=(const TransferRing&) = delete;

  /// Starts fewer transfers than planned if the system has too little USB memory, but at least two. Errors (kDevice).
  [[nodiscard]] Result<void> start();

  /// Cancels all transfers and waits until they have ended, for at most half a second. False: some have not ended; they
  /// and the ring's memory are then leaked, because the system may still write to it.
  bool stop();

  [[nodiscard]] State state() const { return state_.load(); }

 private:
  struct Slot;
  static void on_done(libusb_transfer* transfer);
  void handle(libusb_transfer& transfer);
  void handle_packets(libusb_transfer& transfer, std::int64_t host_ns);
  void handle_bulk(const libusb_transfer& transfer, std::int64_t host_ns);
  void handle_failure(UvcAssembler::Loss kind);
  void leave(State state);

  UsbHandle& device_;
  const RingPlan plan_;
  PayloadReceiver& receiver_;
  std::vector<std::unique_ptr<Slot>> slots_;
  std::atomic<State> state_{State::kStopped};
  std::mutex mutex_;
  std::condition_variable returned_;
  int in_flight_ = 0;
  std::size_t payload_so_far_ = 0;
  int failures_in_a_row_ = 0;
};

}  // namespace scanknit
