// UvcStream: one picture stream of a UVC camera, from negotiation to whole pictures.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "acquire/device_source.h"
#include "acquire/usb/clock_map.h"
#include "acquire/usb/usb_context.h"
#include "acquire/uvc/transfer_ring.h"
#include "acquire/uvc/uvc_assembler.h"
#include "acquire/uvc/uvc_descriptors.h"
#include "acquire/uvc/uvc_probe.h"
#include "acquire/uvc/uvc_selection.h"

namespace scanknit {

/// One thread other than `usb` calls it, except what says otherwise.
class UvcStream final : public PayloadReceiver {
 public:
  struct Sinks {
    FrameSink frame;                     ///< on the thread `usb`
    std::function<void()> trouble;       ///< on the thread `usb`: look at state()
    std::function<void()> clock_jumped;  ///< on the thread `usb`
  };

  UvcStream(UsbHandle& device, const UvcSelection& selection, std::uint32_t ticks_per_second, std::size_t budget_bytes,
            Sinks sinks);
  ~UvcStream();
  UvcStream(const UvcStream&) = delete;
  UvcStream& operator=(const UvcStream&) = delete;

  /// Negotiates, reserves bandwidth and streams. Errors (kDevice), with the camera stopped.
  [[nodiscard]] Result<void> start();
  void stop();
  /// The first half of stop(): takes the transfers back, and asks the camera nothing.
  void take_back();

  /// After a stall or silence: stops, clears the halt and starts again; frame numbers and times go on.
  [[nodiscard]] Result<void> restart();

  [[nodiscard]] TransferRing::State state() const;
  [[nodiscard]] const StreamProfile& profile() const { return selection_.profile; }
  [[nodiscard]] LossCounters losses() const;                      ///< any thread
  [[nodiscard]] std::uint64_t frames() const { return frames_; }  ///< delivered; any thread
  /// When the last good picture ended, or the stream was started; steady clock. Any thread. (Not when the last bytes
  /// came: isochronous cameras send empty headers all the time.)
  [[nodiscard]] std::int64_t last_picture_ns() const { return last_picture_ns_; }
  /// Lost on the way since the last good picture, however often the stream was started since; any thread.
  [[nodiscard]] LossCounters losses_since_picture() const;

 private:
  void on_bytes(std::span<const std::byte> bytes, bool ends_payload, std::int64_t host_ns) override;
  void on_loss(UvcAssembler::Loss kind) override;
  void on_trouble() override;
  void on_frame(AssembledFrame frame);
  void keep_losses();
  [[nodiscard]] Result<UvcStreamControl> negotiate();
  [[nodiscard]] Result<RingPlan> plan(const UvcStreamControl& control);
  [[nodiscard]] std::size_t frame_bytes(const UvcStreamControl& control) const;

  UsbHandle& device_;
  const UvcSelection selection_;
  const std::size_t budget_bytes_;
  const Sinks sinks_;
  DeviceClock clock_;
  std::optional<UvcAssembler> assembler_;
  std::unique_ptr<TransferRing> ring_;
  bool is_alternate_set_ = false;
  bool was_jump_ = false;
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<std::int64_t> last_picture_ns_{0};
  mutable std::mutex losses_mutex_;  // of the next two
  LossCounters losses_, losses_at_picture_;
};

}  // namespace scanknit
