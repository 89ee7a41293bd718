// UvcAssembler: assembles pictures from the payloads of a UVC stream. It delivers complete, undamaged pictures, and
// counts all others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "acquire/raw_frame.h"
#include "acquire/uvc/uvc_payload.h"

namespace scanknit {

struct AssembledFrame {
  std::shared_ptr<const std::vector<std::byte>> bytes;
  std::uint64_t sequence = 0;          ///< strictly increasing; lost frames leave gaps
  std::optional<std::uint32_t> ticks;  ///< the camera's clock
  std::int64_t host_ns = 0;            ///< of the last byte
};

/// A picture that has begun.
struct UnfinishedPicture {
  std::optional<bool> frame_id;  ///< nothing: unknown, only a loss was seen
  std::shared_ptr<std::vector<std::byte>> bytes;
  std::optional<std::uint32_t> ticks, frame_counter;
  std::int64_t host_ns = 0;
  bool is_bad = false;       ///< certainly damaged
  bool is_doubtful = false;  ///< data was lost before its first byte: its size will decide
  bool is_too_long = false;  ///< why it is bad: too long, else incomplete
};

/// One thread. A picture ends with the end-of-frame bit, or where the frame id flips. It is delivered if none of its
/// payloads was marked as bad or lost, and if it has exactly the expected number of bytes (compressed: a JPEG from its
/// start marker to its end marker). The result does not depend on how the bytes of a payload are split into calls of
/// add().
class UvcAssembler {
 public:
  using Deliver = std::function<void(AssembledFrame)>;

  struct Framing {
    std::size_t frame_bytes = 0;  ///< >= 1; for a compressed picture the largest size
    bool is_compressed = false;
    bool is_one_payload = false;  ///< each picture is one payload: a lost payload is a lost picture
  };
  UvcAssembler(const Framing& framing, Deliver deliver);

  /// Takes the next bytes of the endpoint; `ends_payload`: they are the payload's last ones. No bytes: a zero-length
  /// packet.
  void add(std::span<const std::byte> bytes, bool ends_payload, std::int64_t host_ns);

  /// The kind of a loss that the payloads' bytes do not show.
  enum class Loss { kTransport, kOverflow };
  /// An unknown number of bytes was lost here. The picture that they belong to will not be delivered.
  void lose(Loss kind);

  /// The stream restarts: an unfinished picture is lost. Does nothing between pictures.
  void restart();

  /// Counts of device, transport and overflow.
  [[nodiscard]] const LossCounters& losses() const { return losses_; }

 private:
  [[nodiscard]] std::span<const std::byte> take_header(std::span<const std::byte> bytes);
  void begin_payload();
  void append(std::span<const std::byte> bytes, std::int64_t host_ns);
  void end_payload();
  void open_picture();
  void keep_only_last_payload();
  void finish_picture();
  void deliver(UnfinishedPicture picture);
  void count(Loss kind);
  [[nodiscard]] std::optional<std::uint64_t> sequence_after(const UnfinishedPicture& picture);

  const Framing framing_;
  const Deliver deliver_;

  std::array<std::byte, kMaxPayloadHeader> header_bytes_{};
  std::size_t header_size_ = 0;
  bool is_in_payload_ = false;               // the header is known, or known to be bad
  std::optional<UvcPayloadHeader> payload_;  // nothing while in a payload: its header was bad
  std::size_t payload_size_ = 0;             // picture bytes of this payload
  bool is_payload_hurt_ = false;             // data was lost within it

  std::optional<UnfinishedPicture> picture_;
  std::optional<bool> last_frame_id_;
  std::optional<std::uint32_t> last_counter_;
  std::uint64_t next_sequence_ = 0;
  std::uint64_t lost_since_delivered_ = 0;
  LossCounters losses_;
};

}  // namespace scanknit
