#include "acquire/uvc/transfer_ring.h"

#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <cmath>

#include "acquire/steady_now.h"
#include "acquire/usb/keep_for_ever.h"
#include "acquire/usb/usb_context.h"

namespace scanknit {
namespace {

constexpr std::size_t kLargestTransfer = 2u << 20;  // larger payloads are taken in pieces: one lost piece costs less
constexpr double kBufferedSeconds = 0.1;
constexpr int kMostTransfers = 64;
constexpr int kFewestTransfers = 4;
constexpr int kIsochronousPackets = 32;
constexpr int kIsochronousTransfers = 10;
constexpr int kMostFailuresInARow = 8;
constexpr std::chrono::milliseconds kLongestReturn{500};

std::size_t rounded_up(std::size_t bytes, std::size_t packet) {
  return (bytes + packet - 1) / packet * packet;
}

}  // namespace

RingPlan plan_bulk(std::uint8_t endpoint, std::size_t packet_bytes, std::size_t payload_bytes, std::size_t frame_bytes,
                   double frames_per_second, std::size_t budget_bytes) {
  RingPlan plan;
  plan.endpoint = endpoint;
  plan.payload_bytes = payload_bytes;
  plan.transfer_bytes = rounded_up(std::min(payload_bytes, kLargestTransfer), packet_bytes);
  const double rate = frames_per_second > 0 ? frames_per_second : 30;
  const double per_frame = std::ceil(static_cast<double>(frame_bytes) / static_cast<double>(plan.transfer_bytes));
  const double wanted = std::min<double>(kMostTransfers, std::ceil(kBufferedSeconds * rate) * per_frame + 1);
  const auto affordable = static_cast<int>(std::min<std::size_t>(kMostTransfers, budget_bytes / plan.transfer_bytes));
  plan.transfers = std::max(2, std::min(std::max(kFewestTransfers, static_cast<int>(wanted)), affordable));
  return plan;
}

RingPlan plan_isochronous(std::uint8_t endpoint, std::size_t packet_bytes) {
  RingPlan plan;
  plan.endpoint = endpoint;
  plan.is_isochronous = true;
  plan.packet_bytes = packet_bytes;
  plan.packets = kIsochronousPackets;
  plan.transfer_bytes = packet_bytes * kIsochronousPackets;
  plan.transfers = kIsochronousTransfers;
  return plan;
}

struct TransferRing::Slot {
  libusb_transfer* transfer = nullptr;
  std::vector<unsigned char> buffer;
  bool is_in_flight = false;

  ~Slot() { libusb_free_transfer(transfer); }
};

TransferRing::TransferRing(UsbHandle& device, const RingPlan& plan, PayloadReceiver& receiver)
    : device_(device), plan_(plan), receiver_(receiver) {}

TransferRing::~TransferRing() {
  stop();
}

Result<void> TransferRing::start() {
  payload_so_far_ = 0;
  failures_in_a_row_ = 0;
  state_ = State::kRunning;
  for (int i = 0; i < plan_.transfers; ++i) {
    auto slot = std::make_unique<Slot>();
    slot->transfer = libusb_alloc_transfer(plan_.packets);
    if (slot->transfer == nullptr) break;
    slot->buffer.resize(plan_.transfer_bytes);
    const auto length = static_cast<int>(plan_.transfer_bytes);
    if (plan_.is_isochronous) {
      libusb_fill_iso_transfer(slot->transfer, device_.raw(), plan_.endpoint, slot->buffer.data(), length,
                               plan_.packets, on_done, this, 0);
      libusb_set_iso_packet_lengths(slot->transfer, static_cast<unsigned>(plan_.packet_bytes));
    } else {
      libusb_fill_bulk_transfer(slot->transfer, device_.raw(), plan_.endpoint, slot->buffer.data(), length, on_done,
                                this, 0);
    }
    const std::lock_guard lock(mutex_);  // held, so that the callback finds the transfer counted
    const int code = libusb_submit_transfer(slot->transfer);
    if (code == 0) {
      ++in_flight_;
      slot->is_in_flight = true;
      slots_.push_back(std::move(slot));
      continue;
    }
    const bool is_enough = code == LIBUSB_ERROR_NO_MEM && slots_.size() >= 2;
    if (is_enough) break;
    state_ = code == LIBUSB_ERROR_NO_DEVICE ? State::kGone : State::kHalted;
    return usb_error(code, "cannot stream from", device_.info());
  }
  return {};
}

bool TransferRing::stop() {
  State running = State::kRunning;
  state_.compare_exchange_strong(running, State::kStopped);
  std::unique_lock lock(mutex_);
  for (const auto& slot : slots_) {
    if (slot->is_in_flight) libusb_cancel_transfer(slot->transfer);
  }
  const bool all_returned = returned_.wait_for(lock, kLongestReturn, [this] { return in_flight_ == 0; });
  if (!all_returned) {
    for (auto& slot : slots_) {
      if (slot->is_in_flight) keep_for_ever(std::move(slot));  // the system may still write into it
    }
    in_flight_ = 0;
  }
  slots_.clear();
  return all_returned;
}

void TransferRing::on_done(libusb_transfer* transfer) {
  static_cast<TransferRing*>(transfer->user_data)->handle(*transfer);
}

void TransferRing::handle(libusb_transfer& transfer) {
  const std::int64_t host_ns = steady_now_ns();
  switch (transfer.status) {
    case LIBUSB_TRANSFER_COMPLETED:
      failures_in_a_row_ = 0;
      if (state_ != State::kRunning) break;
      if (plan_.is_isochronous) {
        handle_packets(transfer, host_ns);
      } else {
        handle_bulk(transfer, host_ns);
      }
      break;
    case LIBUSB_TRANSFER_STALL: leave(State::kHalted); break;
    case LIBUSB_TRANSFER_NO_DEVICE: leave(State::kGone); break;
    case LIBUSB_TRANSFER_CANCELLED: break;
    case LIBUSB_TRANSFER_OVERFLOW: handle_failure(UvcAssembler::Loss::kOverflow); break;
    default: handle_failure(UvcAssembler::Loss::kTransport); break;
  }
  const std::lock_guard lock(mutex_);
  // Decided under the lock: stop() has cancelled what is on its way, and must not find it on its way again.
  if (state_ == State::kRunning && transfer.status != LIBUSB_TRANSFER_CANCELLED) {
    const int code = libusb_submit_transfer(&transfer);
    if (code == 0) return;
    if (code == LIBUSB_ERROR_NO_DEVICE) leave(State::kGone);
  }
  const auto slot = std::find_if(slots_.begin(), slots_.end(),
                                 [&](const std::unique_ptr<Slot>& s) { return s->transfer == &transfer; });
  if (slot == slots_.end()) return;  // given up by stop()
  (*slot)->is_in_flight = false;
  if (--in_flight_ == 0) leave(State::kHalted);
  returned_.notify_all();
}

void TransferRing::handle_bulk(const libusb_transfer& transfer, std::int64_t host_ns) {
  const auto size = static_cast<std::size_t>(transfer.actual_length);
  const auto bytes = std::as_bytes(std::span(transfer.buffer, plan_.transfer_bytes)).first(size);
  payload_so_far_ += size;
  // A payload ends with a packet that is not full, or where it is as long as it may be.
  const bool ends_payload = size < plan_.transfer_bytes || payload_so_far_ >= plan_.payload_bytes;
  if (ends_payload) payload_so_far_ = 0;
  receiver_.on_bytes(bytes, ends_payload, host_ns);
}

void TransferRing::handle_packets(libusb_transfer& transfer, std::int64_t host_ns) {
  const std::span<const libusb_iso_packet_descriptor> packets(transfer.iso_packet_desc,
                                                              static_cast<std::size_t>(transfer.num_iso_packets));
  const auto buffer = std::as_bytes(std::span(transfer.buffer, plan_.transfer_bytes));
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (packets[i].status != LIBUSB_TRANSFER_COMPLETED) {
      receiver_.on_loss(UvcAssembler::Loss::kTransport);
    } else if (packets[i].actual_length > 0) {
      const std::size_t size = std::min<std::size_t>(packets[i].actual_length, plan_.packet_bytes);
      receiver_.on_bytes(buffer.subspan(i * plan_.packet_bytes, size), true, host_ns);
    }
  }
}

void TransferRing::handle_failure(UvcAssembler::Loss kind) {
  payload_so_far_ = 0;
  if (state_ != State::kRunning) return;
  receiver_.on_loss(kind);
  if (++failures_in_a_row_ > kMostFailuresInARow) leave(State::kHalted);
}

/// From kRunning only: the first trouble counts.
void TransferRing::leave(State state) {
  State running = State::kRunning;
  if (state_.compare_exchange_strong(running, state)) receiver_.on_trouble();
}

}  // namespace scanknit
