#include "acquire/uvc/uvc_stream.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "acquire/steady_now.h"
#include "acquire/usb/keep_for_ever.h"

namespace scanknit {
namespace {

// Requests and controls of a VideoStreaming interface (UVC 1.5, tables ).
constexpr std::uint8_t kSetCurrent = 0x01;
constexpr std::uint8_t kGetCurrent = 0x81;
constexpr std::uint16_t kProbe = 0x0100;
constexpr std::uint16_t kCommit = 0x0200;

constexpr std::size_t kRoomForHeader = 1024;

Error refused(const UsbDeviceInfo& device, const std::string& what) {
  return {ErrorCode::kDevice, "cannot stream from " + device.place() + ": " + what};
}

}  // namespace

UvcStream::UvcStream(UsbHandle& device, const UvcSelection& selection, std::uint32_t ticks_per_second,
                     std::size_t budget_bytes, Sinks sinks)
    : device_(device),
      selection_(selection),
      budget_bytes_(budget_bytes),
      sinks_(std::move(sinks)),
      clock_(std::max(1u, ticks_per_second)) {}

UvcStream::~UvcStream() {
  stop();
}

Result<UvcStreamControl> UvcStream::negotiate() {
  const std::size_t bytes = probe_bytes(selection_.function->version);
  const std::uint16_t interface = selection_.stream->number;
  UvcStreamControl wanted;
  wanted.format_index = selection_.format->index;
  wanted.frame_index = selection_.size->index;
  wanted.interval_100ns = selection_.interval_100ns;
  if (const auto set = device_.write_class(kSetCurrent, kProbe, interface, encode_probe(wanted, bytes)); !set) {
    return set.error();
  }
  auto answer = device_.read_class(kGetCurrent, kProbe, interface, static_cast<std::uint16_t>(bytes));
  if (!answer) return answer.error();
  const auto control = decode_probe(*answer);
  if (!control) return control.error();
  if (control->format_index != wanted.format_index || control->frame_index != wanted.frame_index) {
    return refused(device_.info(), "it answered with another picture format than was asked for");
  }
  answer->resize(bytes);  // what it left out is 0; what it said too much is not wanted
  if (const auto set = device_.write_class(kSetCurrent, kCommit, interface, *answer); !set) return set.error();
  return *control;
}

std::size_t UvcStream::frame_bytes(const UvcStreamControl& control) const {
  const StreamProfile& profile = selection_.profile;
  if (const auto exact = picture_bytes(profile.format, profile.width, profile.height)) return *exact;
  // A JPEG is smaller than three bytes a pixel, whatever the camera says.
  const auto most = static_cast<std::size_t>(profile.width) * static_cast<std::size_t>(profile.height) * 3;
  return control.max_frame_bytes > 0 ? std::min<std::size_t>(control.max_frame_bytes, most) : most;
}

Result<RingPlan> UvcStream::plan(const UvcStreamControl& control) {
  const auto& alternates = selection_.stream->alternates;
  const auto bulk = std::find_if(alternates.begin(), alternates.end(),
                                 [](const UvcAlternate& a) { return !a.is_isochronous && a.packet_bytes > 0; });
  if (bulk != alternates.end()) {
    const std::size_t most = frame_bytes(control) + kRoomForHeader;
    const std::size_t payload =
        control.max_payload_bytes > 0 ? std::min<std::size_t>(control.max_payload_bytes, most) : most;
    return plan_bulk(bulk->endpoint, bulk->packet_bytes, payload, frame_bytes(control),
                     selection_.profile.frames_per_second, budget_bytes_);
  }
  // The smallest that is large enough, or the largest.
  const UvcAlternate* best = nullptr;
  for (const UvcAlternate& alternate : alternates) {
    const bool is_enough = alternate.bytes_per_interval >= control.max_payload_bytes;
    const bool best_is_enough = best != nullptr && best->bytes_per_interval >= control.max_payload_bytes;
    if (best == nullptr ||
        (is_enough && (!best_is_enough || alternate.bytes_per_interval < best->bytes_per_interval)) ||
        (!is_enough && !best_is_enough && alternate.bytes_per_interval > best->bytes_per_interval)) {
      best = &alternate;
    }
  }
  if (best == nullptr || best->bytes_per_interval == 0) return refused(device_.info(), "it has no video endpoint");
  if (const auto set = device_.set_alternate(selection_.stream->number, best->number); !set) return set.error();
  is_alternate_set_ = true;
  return plan_isochronous(best->endpoint, best->bytes_per_interval);
}

Result<void> UvcStream::start() {
  if (const auto claimed = device_.claim(selection_.stream->number); !claimed) return claimed.error();
  const auto control = negotiate();
  if (!control) return control.error();
  if (control->max_frame_bytes > 0 && !selection_.format->is_compressed &&
      control->max_frame_bytes < frame_bytes(*control)) {
    return refused(device_.info(), "it would send " + std::to_string(control->max_frame_bytes) +
                                       " bytes a picture, expected " + std::to_string(frame_bytes(*control)));
  }
  const auto ring_plan = plan(*control);
  if (!ring_plan) return ring_plan.error();
  if (!assembler_) {
    const bool is_one_payload = !ring_plan->is_isochronous && ring_plan->payload_bytes > frame_bytes(*control);
    const UvcAssembler::Framing framing{frame_bytes(*control), selection_.format->is_compressed, is_one_payload};
    assembler_.emplace(framing, [this](AssembledFrame frame) { on_frame(std::move(frame)); });
  }
  assembler_->restart();
  last_picture_ns_ = steady_now_ns();
  ring_ = std::make_unique<TransferRing>(device_, *ring_plan, *this);
  if (const auto started = ring_->start(); !started) {
    stop();
    return started.error();
  }
  return {};
}

void UvcStream::take_back() {
  if (ring_ && !ring_->stop()) {
    keep_for_ever(std::move(ring_));  // transfers are still out there and would call it
  }
}

void UvcStream::stop() {
  take_back();
  const bool is_gone = ring_ && ring_->state() == TransferRing::State::kGone;
  if (ring_ && !is_gone) {
    // So that the handle knows whether the camera still answers, before the system waits for it.
    const auto bytes = static_cast<std::uint16_t>(probe_bytes(selection_.function->version));
    (void)device_.read_class(kGetCurrent, kProbe, selection_.stream->number, bytes);
    if (is_alternate_set_) {
      (void)device_.set_alternate(selection_.stream->number, 0);
    } else {
      // A bulk camera streams until its endpoint is cleared.
      for (const UvcAlternate& alternate : selection_.stream->alternates) (void)device_.clear_halt(alternate.endpoint);
    }
  }
  ring_.reset();
  is_alternate_set_ = false;
  if (assembler_) keep_losses();
}

Result<void> UvcStream::restart() {
  stop();
  return start();
}

TransferRing::State UvcStream::state() const {
  return ring_ ? ring_->state() : TransferRing::State::kStopped;
}

LossCounters UvcStream::losses() const {
  const std::lock_guard lock(losses_mutex_);
  return losses_;
}

LossCounters UvcStream::losses_since_picture() const {
  const std::lock_guard lock(losses_mutex_);
  LossCounters since;
  since.transport = losses_.transport - losses_at_picture_.transport;
  since.overflow = losses_.overflow - losses_at_picture_.overflow;
  return since;
}

void UvcStream::keep_losses() {
  const std::lock_guard lock(losses_mutex_);
  losses_ = assembler_->losses();
}

void UvcStream::on_bytes(std::span<const std::byte> bytes, bool ends_payload, std::int64_t host_ns) {
  assembler_->add(bytes, ends_payload, host_ns);
  keep_losses();
}

void UvcStream::on_loss(UvcAssembler::Loss kind) {
  assembler_->lose(kind);
  keep_losses();
}

void UvcStream::on_trouble() {
  sinks_.trouble();
}

void UvcStream::on_frame(AssembledFrame frame) {
  const DeviceClock::Stamp stamp = clock_.stamp(frame.ticks, frame.host_ns);
  // Said once, not for every frame of a clock that stands still.
  if (stamp.is_jump && !std::exchange(was_jump_, true)) sinks_.clock_jumped();
  if (!stamp.is_jump) was_jump_ = false;
  ++frames_;
  last_picture_ns_ = frame.host_ns;
  {
    const std::lock_guard lock(losses_mutex_);
    losses_ = losses_at_picture_ = assembler_->losses();
  }
  sinks_.frame({selection_.profile, frame.sequence, stamp.device_ns, frame.host_ns, std::move(frame.bytes)});
}

}  // namespace scanknit
