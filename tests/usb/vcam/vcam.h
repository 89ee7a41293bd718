// Vcam: a UVC depth camera as a model, without any input or output: descriptors, controls, and what its endpoints send.
// Like a RealSense D400: Z16 depth, colour in a second function, an extension unit with calibration. It can be told to
// misbehave.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/usb/vcam/usb_model.h"

namespace scanknit::test {

/// What is wrong with one picture.
enum class Fault {
  kTruncated,  ///< the last 1000 bytes are missing
  kOversize,   ///< 100 bytes too many
  kHeaderLength0,
  kHeaderLength1,
  kHeaderTooLong,  ///< longer than the payload
  kErrorBit,
  kSameFrameId,  ///< as the picture before
  kMissingEnd,   ///< without the end-of-frame bit
  kHeaderOnly,   ///< no bytes of the picture
  kBabble,       ///< the device sends more than the computer asked for
  kIoError,      ///< a transfer fails: EPROTO
  kEio,          ///< ... with EIO
  kStall,        ///< the endpoint halts until its halt is cleared
  kStallForever,
  kSilent,  ///< nothing until the stream is committed again
  kSilentForever,
  kSkipped,  ///< the camera itself loses it: its counter goes on
  kSentTwice,
  // Of pictures in many payloads.
  kShortPayload,     ///< one in the middle has 1000 bytes too few
  kLongPayload,      ///< ... 100 too many
  kRepeatedPayload,  ///< ... comes twice
  kReordered,        ///< the last payload comes before the one before it
  kLostPacket,       ///< isochronous: one packet in the middle is lost
  kGarbledPacket,    ///< ... arrives with a wrong checksum: EILSEQ
  kClockBack,        ///< from here on the clock is 3 s behind
  kClockAhead,       ///< ... 5 s ahead
};

struct VcamOptions {
  std::uint16_t vendor = 0x8086, product = 0x0b07;
  std::string serial = "0123456789ab";
  std::uint16_t uvc_version = 0x0150;
  bool is_isochronous = false;          ///< depth; high speed
  bool has_isochronous_colour = false;  ///< high speed
  std::size_t payload_bytes = 0;        ///< bulk: at most; 0: a whole picture
  int speed_mbit = 5000;
  bool has_colour = true;
  bool has_yuyv = true;      ///< else colour is offered as MJPEG only
  bool has_metadata = true;  ///< RealSense's frame counter
  std::string depth_code = "Z16 ";
  bool has_infrared = false;       ///< the depth function offers UYVY, 16-bit grey and Y8I, too, as a D400 does
  bool hangs_on_endpoint = false;  ///< class descriptors come after the endpoint
  std::uint32_t clock_start_us = 1'000'000;
  std::uint32_t depth_unit_um = 1000;
  int width = 640, height = 480;  ///< of both streams
  /// The bytes of depth picture n; without one, depth_pixels(n).
  std::function<std::vector<std::byte>(std::uint64_t)> depth_picture = {};
  /// The same for pairs of infrared pictures: Y8I.
  std::function<std::vector<std::byte>(std::uint64_t)> infrared_pair = {};
  /// The same for colour: YUYV, or a whole JPEG where that is what was asked for.
  std::function<std::vector<std::byte>(std::uint64_t)> colour_picture = {};
  bool waits_for_computer = true;  ///< else what is not fetched in time is lost; tests on a busy machine must not be
};

/// All depth pictures from one on, until the camera's streams were committed so often in all.
struct LastingFault {
  Fault fault;
  std::uint64_t from = 0;
  int until_commits = std::numeric_limits<int>::max();
};

/// How it answers requests wrongly.
struct ControlFaults {
  std::optional<std::size_t> probe_bytes;
  bool probe_stalls = false, probe_changes_format = false, probe_has_no_sizes = false;
  bool has_no_calibration = false;      ///< the hardware monitor stalls
  bool has_mute_calibration = false;    ///< the hardware monitor gives no answer
  bool has_broken_calibration = false;  ///< its tables have wrong checksums
  bool has_broken_colour = false;       ///< only the colour table has
  bool has_no_advanced_mode = false;    ///< the hardware monitor refuses to tell the depth unit
  bool is_mute = false;                 ///< no request is answered, and nothing is sent any more
};

/// Not thread-safe.
class Vcam final : public UsbModel {
 public:
  static constexpr std::uint8_t kDepthEndpoint = 0x82, kColourEndpoint = 0x84;
  static constexpr int kPairFormat = 4;  ///< index of Y8I
  static constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

  explicit Vcam(const VcamOptions& options);

  [[nodiscard]] const VcamOptions& options() const { return options_; }
  [[nodiscard]] UsbIdentity identity() const override;
  [[nodiscard]] std::vector<ModelEndpoint> endpoints() const override;
  [[nodiscard]] std::vector<std::byte> descriptors() const override;

  [[nodiscard]] std::optional<std::vector<std::byte>> control(std::uint8_t type, std::uint8_t request,
                                                              std::uint16_t value, std::uint16_t index,
                                                              std::uint16_t length, std::span<const std::byte> data,
                                                              std::int64_t now_ns) override;
  [[nodiscard]] bool ignores(std::uint8_t type, std::uint16_t value, std::uint16_t index) const override;
  void set_alternate(std::uint8_t interface, std::uint8_t alternate, std::int64_t now_ns) override;
  void clear_halt(std::uint8_t endpoint) override;
  [[nodiscard]] std::optional<Delivery> fill_transfer(std::uint8_t endpoint, std::span<std::byte> buffer,
                                                      std::int64_t now_ns) override;
  void nobody_asked(std::uint8_t endpoint, std::int64_t now_ns) override;
  [[nodiscard]] Delivery fill_packet(std::uint8_t endpoint, std::span<std::byte> packet, std::int64_t now_ns) override;

  /// The pixels of depth picture n: n % 4096 + i, as 16 bits. So each tells its number, and each pixel its place.
  /// `count` is at most 1280 x 720.
  [[nodiscard]] static std::span<const std::uint16_t> depth_pixels(std::uint64_t n, std::size_t count);

  std::map<std::uint64_t, Fault> depth_faults;  ///< by picture number, counting from 0 since the camera was made
  std::map<std::uint64_t, Fault> colour_faults;
  std::optional<LastingFault> lasting_fault;
  ControlFaults control_faults;
  /// Values of controls that were set, by index and value of the request.
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::vector<std::byte>> written;
  int commits = 0, halts_cleared = 0;
  int depth_format = 0;  ///< its index, as it was committed
  bool clock_is_frozen = false;
  std::uint64_t depth_waits_at = kNever;  ///< that picture is not made yet

 private:
  struct Payload {
    std::vector<std::byte> bytes;
    int status = 0;
  };
  struct Stream {
    bool is_active = false, is_halted = false, is_silent = false;
    bool is_compressed = false;
    std::uint32_t interval_100ns = 333333;
    std::size_t picture_bytes = 0, payload_bytes = 0;
    std::int64_t due_ns = 0;
    std::uint64_t number = 0;  // of the next picture
    bool frame_id = false;
    std::deque<Payload> payloads;
    std::size_t sent = 0;  // of the first payload
    std::vector<std::byte> probe;
  };

  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height);
  }
  [[nodiscard]] std::vector<std::byte> configuration() const;
  [[nodiscard]] bool is_isochronous(const Stream& stream) const {
    return &stream == &streams_[0] ? options_.is_isochronous : options_.has_isochronous_colour;
  }
  [[nodiscard]] bool has_metadata(const Stream& stream) const {
    return options_.has_metadata && !is_isochronous(stream);
  }
  [[nodiscard]] Stream& stream_of(std::uint8_t endpoint) { return streams_[endpoint == kColourEndpoint ? 1 : 0]; }
  [[nodiscard]] std::map<std::uint64_t, Fault>& faults_of(const Stream& stream) {
    return &stream == &streams_[0] ? depth_faults : colour_faults;
  }
  [[nodiscard]] std::optional<std::vector<std::byte>> streaming_control(Stream& stream, std::uint8_t request,
                                                                        std::uint16_t value, std::uint16_t length,
                                                                        std::span<const std::byte> data,
                                                                        std::int64_t now_ns);
  [[nodiscard]] std::optional<std::vector<std::byte>> unit_control(std::uint8_t request, std::uint16_t value,
                                                                   std::uint16_t index, std::uint16_t length,
                                                                   std::span<const std::byte> data);
  void answer_probe(Stream& stream);
  void begin(Stream& stream, std::int64_t now_ns);
  void make_picture(Stream& stream, std::int64_t now_ns);
  [[nodiscard]] std::vector<std::byte> picture(const Stream& stream) const;
  [[nodiscard]] std::vector<std::byte> header(const Stream& stream, bool is_last, bool has_time) const;
  void misbehave(Stream& stream, Fault fault);

  VcamOptions options_;
  std::array<Stream, 2> streams_;
  std::vector<std::byte> reply_;  // of the hardware monitor
  std::int64_t clock_offset_us_ = 0;
  std::uint32_t picture_us_ = 0;
};

}  // namespace scanknit::test
